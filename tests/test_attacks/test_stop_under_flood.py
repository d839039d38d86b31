"""Everybody can stop the robot while strangers flood its API, also from the address they use."""

import json
import subprocess
import sys

import pytest

from tests.helpers.flood import ADDRESSES, CONNECTIONS, KINDS
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


@pytest.mark.parametrize("tries", [12, pytest.param(200, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", KINDS)
def test_stop_is_obeyed_at_once_under(kind, tries):
    own_network = has_own_network()
    if kind == "unread-answers" and not own_network:
        pytest.skip("no network namespace can be made here, and large buffers take unread answers")
    program = [sys.executable, "-m", "tests.helpers.stop_under_flood", kind, str(tries)]
    if own_network:
        program = [*OWN_NETWORK, *program, "--own-network"]
    done = subprocess.run(program, stdout=subprocess.PIPE, text=True, check=True)
    measured = json.loads(done.stdout.splitlines()[-1])
    assert measured["opened"] >= len(ADDRESSES) * CONNECTIONS > MOST
    assert measured["unanswered"] == []
    assert measured["stops"] == len(measured["times"]) + len(measured["typed"]) == tries
    late = [round(each, 3) for each in measured["times"] if each > SOON]
    late += [round(each, 3) for each in measured["typed"] if each > TYPED]
    assert late == []
