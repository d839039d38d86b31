"""Everybody can stop the robot while strangers flood its API, also from the address they use."""

import json
import subprocess
import sys

import pytest

from tests.helpers.flood import ADDRESSES, CONNECTIONS, KINDS
from tests.helpers.stop_under_flood import PIPES
from vizbot.operator.api.connections.connection_limits import MOST

pytestmark = pytest.mark.alone
SOON = 0.3
"""From the request until the base has read the speed 0 [s]."""
TYPED = 2.0
"""The same of a typed "stop", which waits for the 200 requests that a flood may begin with [s]."""
OWN_NETWORK = ("unshare", "--map-root-user", "--net")


def has_own_network():
    """Whether a network namespace can be made here."""
    try:
        return subprocess.run([*OWN_NETWORK, "true"], capture_output=True).returncode == 0
    except OSError:
        return False


@pytest.fixture(scope="module")
def robot():
    program = [sys.executable, "-u", "-m", "tests.helpers.stop_under_flood"]
    if has_own_network():
        program = [*OWN_NETWORK, *program, "--own-network"]
    with subprocess.Popen(program, text=True, bufsize=1, **PIPES) as running:
        yield running


@pytest.mark.parametrize("tries", [20, pytest.param(200, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", KINDS)
def test_stop_is_obeyed_at_once_under(kind, tries, robot):
    if kind == "unread-answers" and not has_own_network():
        pytest.skip("no network namespace can be made here, and large buffers take unread answers")
    robot.stdin.write(f"{kind} {tries}\n")
    measured = json.loads(robot.stdout.readline())
    assert measured["opened"] >= len(ADDRESSES) * CONNECTIONS > MOST
    assert measured["unanswered"] == []
    assert measured["stops"] == len(measured["times"]) + len(measured["typed"]) == tries
    late = [round(each, 3) for each in measured["times"] if each > SOON]
    late += [round(each, 3) for each in measured["typed"] if each > TYPED]
    assert late == []
