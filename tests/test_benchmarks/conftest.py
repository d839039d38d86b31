import sys

import pytest

from vizbot.cli import app as cli


@pytest.fixture
def vizbot(monkeypatch, capfd):
    """Runs `vizbot bench` with arguments; exit code, standard output and error."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["vizbot", "bench", *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
        return end.value.code or 0, *capfd.readouterr()

    return run
