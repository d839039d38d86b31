"""What shows a run: its report, and its recording for rerun."""

import pytest

from vizbot.core.observer import GoalReport
from vizbot.operator.report.report import Report
from vizbot.operator.viewer.viewer import Viewer


def show(observer, news):
    for each in news:
        if isinstance(each, GoalReport):
            observer.on_goal(each)
        else:
            observer.on_step(each)


@pytest.fixture
def report_of(tmp_path):
    """Makes the report of a run from its steps and answers, in their order."""

    def report_of(*news, notice=None):
        report = Report(tmp_path, notice)
        show(report, news)
        return report

    return report_of


@pytest.fixture
def page_of(report_of):
    """Makes the page of a run from its steps and answers, in their order."""
    return lambda *news: report_of(*news).finish({}).read_text()


@pytest.fixture
def recorded(tmp_path):
    """Records a run from its steps and answers, in their order; the file."""

    def recorded(*news):
        with Viewer(tmp_path / "run.rrd") as viewer:
            show(viewer, news)
        return tmp_path / "run.rrd"

    return recorded
