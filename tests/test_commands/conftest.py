"""A command line that is run in an empty folder."""

import pytest


@pytest.fixture
def run(command_line, monkeypatch, tmp_path):
    """Run a command line in an empty folder; return exit code, standard output, error output."""
    monkeypatch.chdir(tmp_path)
    return command_line
