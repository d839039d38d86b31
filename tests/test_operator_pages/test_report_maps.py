"""What a report proves where the run has left its map for another one."""

import re
from dataclasses import replace

import cv2
import numpy as np

from tests.helpers.two_maps import BOX, EMPTY, EMPTY_ON, KEPT, KEPT_ON, OLD
from vizbot.core.observer import Candidate, GoalReport, Outcome

WHITE, BLACK = np.full((24, 32, 3), 255, np.uint8), np.zeros((24, 32, 3), np.uint8)


def seen(step, rgb):
    return replace(step, frame=replace(step.frame, rgb=rgb))


def located(frame, x=0.2):
    place = Candidate(np.array([x, 0.1, 0.4]), 0.4, frame, BOX)
    return GoalReport("sofa", Outcome.LOCATED, "similar", (place,))


def proofs(report):
    """The pictures of the last answer, decoded."""
    shown = report._matches[max(report._matches)]
    return [cv2.imdecode(np.frombuffer(m.picture, np.uint8), cv2.IMREAD_COLOR) for m in shown]


OLD_WHITE = [seen(step, WHITE) for step in OLD]


def test_a_frame_of_a_new_map_is_not_shown_with_the_picture_of_the_old_one(report_of):
    first = [seen(EMPTY, BLACK), seen(EMPTY_ON, BLACK)]
    report = report_of(*OLD_WHITE, located(0), *first, located(0))
    (picture,) = proofs(report)
    assert picture[:, :5].max() < 30
    report = report_of(*OLD_WHITE, *first, located(9))
    assert not proofs(report)


def test_a_frame_of_a_kept_map_that_this_run_never_saw_has_no_picture(report_of):
    onward = [seen(KEPT, BLACK), seen(KEPT_ON, BLACK)]
    for frame in (0, 4, 9, 31):
        assert not proofs(report_of(*OLD_WHITE, *onward, located(frame)))
    assert len(proofs(report_of(*OLD_WHITE, *onward, located(40)))) == 1


def test_an_answer_on_the_old_map_keeps_its_proof(report_of):
    report = report_of(*OLD_WHITE, located(9), EMPTY)
    (picture,) = proofs(report)
    assert picture[:, :5].min() > 225
    assert report.finish({}).read_text().count("was found in") == 1


def test_the_last_map_has_only_what_happened_on_it(report_of):
    report = report_of(*OLD, located(9, x=-0.5), EMPTY, EMPTY_ON, located(0))
    page = report.finish({}).read_text()
    (track,) = re.findall(r'class="track" points="([^"]+)"', page)
    assert len(track.split()) == 2
    assert page.count('class="place"') == 1
    assert page.count("Found the sofa on the map") >= 2 and "another map begins" in page
