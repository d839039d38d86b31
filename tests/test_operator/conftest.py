"""A session that is served on this machine."""

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
