"""A command line that is run in an empty folder."""

import sys

import pytest

from vizbot.cli import app as cli


@pytest.fixture
def run(monkeypatch, capfd, tmp_path):
    """Run a command line in an empty folder; return exit code, standard output, error output."""

    def run_command(*arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["vizbot", *arguments])
        try:
            cli.main()
            code = 0
        except SystemExit as end:
            code = end.code or 0
        out, err = capfd.readouterr()
        return code, out, err

    return run_command
