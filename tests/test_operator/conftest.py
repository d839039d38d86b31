"""A session that is served on this machine."""

import pytest

from tests.helpers.documented_api import DocumentedClient
from tests.helpers.served import served
from vizbot.operator.session.session import OperatorSession


@pytest.fixture
def desk():
    return OperatorSession()


@pytest.fixture
def server(desk):
    with served(desk) as server:
        yield server


@pytest.fixture
def http(server):
    with DocumentedClient(server.url) as http:
        yield http
