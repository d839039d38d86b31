"""Driving over a proxy that delays, reorders, drops and falls silent, on the wall clock."""

import asyncio
import time
from itertools import pairwise

import pytest
from websockets.asyncio.client import connect
from websockets.asyncio.server import serve

from tests.helpers.roomba_rig import DEADLINE
from tests.helpers.served import Proxy, drive_for, served, websocket_url
from vizbot.core.types import STOP, Twist
from vizbot.operator.session.drive_lease import OLDEST
from vizbot.operator.session.session import OperatorSession

pytestmark = pytest.mark.alone


def driven(proxy_settings, course):
    """Drive through a proxy; sequence and age of what counted, and the wheel over time."""
    session = OperatorSession()
    counted, stood = [], []
    accept = session.lease.accept

    def accepting(link, sequence, heard, twist):
        counts = accept(link, sequence, heard, twist)
        if counts:
            counted.append((sequence, session.lease.time() - heard))
        return counts

    session.lease.accept = accepting

    async def watch():
        while True:
            stood.append((time.monotonic(), session.lease.twist()))
            await asyncio.sleep(0.005)

    async def run(url):
        proxy = Proxy(url, **proxy_settings)
        watching = asyncio.ensure_future(watch())
        async with serve(proxy, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            async with connect(f"ws://127.0.0.1:{port}") as socket:
                await course(proxy, socket)
        watching.cancel()

    with served(session) as server:
        asyncio.run(asyncio.wait_for(run(websocket_url(server, "/drive?who=ann")), DEADLINE))
    return counted, stood


def rolling(stood):
    return [at for at, twist in stood if twist not in (None, STOP)]


@pytest.mark.parametrize(
    "bad", [{}, {"delay": 0.05}, {"swaps": True}, {"drops": 3}, {"delay": 0.05, "swaps": True}]
)
def test_a_bad_link_may_be_driven_over_and_nothing_old_or_out_of_order_counts(bad):
    for _ in range(3):  # a machine that is busy elsewhere may hold the robot up for a whole second
        counted, stood = driven(bad, lambda _, socket: drive_for(socket, 1.0, 0.2))
        assert all(first < second for (first, _), (second, _) in pairwise(counted))
        assert all(age <= OLDEST for _, age in counted)
        if len(counted) >= 3:
            break
    assert len(counted) >= 3
    assert Twist(0.2, 0.0) in [twist for _, twist in stood]


def test_over_a_link_that_is_too_slow_the_robot_does_not_move():
    there_and_back = {"delay": 0.2}  # 0.4 s
    counted, stood = driven(there_and_back, lambda _, socket: drive_for(socket, 1.2, 0.2))
    assert counted == []
    assert rolling(stood) == []


def test_a_link_that_falls_silent_stops_the_wheels_and_nothing_is_replayed():
    silent_at, back_at = [], []

    async def course(proxy, socket):
        sequence = await drive_for(socket, 1.5, 0.2)
        proxy.silent = True
        silent_at.append(time.monotonic())
        sequence = await drive_for(socket, 0.8, 0.2, sequence)
        proxy.silent = False
        back_at.append(time.monotonic())
        await drive_for(socket, 0.3, 0.0, sequence)

    _, stood = driven({}, course)
    assert any(at < silent_at[0] for at in rolling(stood))
    assert max(rolling(stood)) < silent_at[0] + OLDEST + 0.1
    assert not any(at > back_at[0] for at in rolling(stood))


def test_a_page_that_is_closed_stops_the_wheels_at_once():
    closed_at = []

    async def course(proxy, socket):
        await drive_for(socket, 1.5, 0.2)
        await socket.close()
        closed_at.append(time.monotonic())
        await asyncio.sleep(0.3)

    _, stood = driven({}, course)
    assert any(at < closed_at[0] for at in rolling(stood))
    assert max(rolling(stood)) < closed_at[0] + 0.2
