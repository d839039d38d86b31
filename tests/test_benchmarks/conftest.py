from functools import partial

import pytest


@pytest.fixture
def vizbot(command_line):
    """Runs `vizbot bench` with arguments; exit code, standard output and error."""
    return partial(command_line, "bench")
