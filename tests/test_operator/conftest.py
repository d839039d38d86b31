"""A session that is served on this machine."""

from contextlib import ExitStack

import pytest

from tests.helpers.documented_api import DocumentedClient
from tests.helpers.served import served


@pytest.fixture
def server(session):
    with served(session) as server:
        yield server


@pytest.fixture
def http(server):
    with DocumentedClient(server.url) as http:
        yield http


@pytest.fixture
def opened():
    """What is closed at the end of a test."""
    with ExitStack() as opened:
        yield opened
