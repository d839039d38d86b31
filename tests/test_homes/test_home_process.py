"""A home that another process draws is the one that this process would draw."""

import os
import sys

import pytest

from sim_stubs.homes import home_process
from sim_stubs.homes.home import home_and_space
from sim_stubs.homes.home_process import HomeProcess
from tests.test_homes.test_home_digests import digest_of
from vizbot.commands.run_plan import DeviceChoice, home_beside


def test_it_is_the_same_home():
    with HomeProcess(3) as drawn:
        house, space = drawn.home_and_space()
    own, own_space = home_and_space(3)
    assert digest_of(house) == digest_of(own)
    assert (space.clear == own_space.clear).all() and (space.blocked == own_space.blocked).all()


def test_where_the_process_fails_the_home_is_drawn_here(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    here = object(), object()
    monkeypatch.setattr("sim_stubs.homes.home.home_and_space", lambda seed: (seed, here))
    with HomeProcess(7) as drawn:
        assert drawn.home_and_space() == (7, here)


def test_nothing_is_left_of_a_process_that_nobody_waits_for():
    with HomeProcess(3) as drawn:
        pid = drawn._process.pid
    drawn.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize(
    ("camera", "world", "is_drawn"),
    [("sim", "1100", True), ("sim", "office", False), ("realsense", "1100", False)],
)
def test_only_the_home_of_a_seed_is_drawn_beside(camera, world, is_drawn, monkeypatch):
    begun = []
    monkeypatch.setattr(
        home_process.subprocess, "Popen", lambda command, **_: begun.append(command)
    )
    monkeypatch.setattr(HomeProcess, "close", lambda self: None)
    with home_beside(DeviceChoice(camera, "sim", world, None, "", None, None, [])) as home:
        assert (home is not None) is is_drawn
    assert [command[-1] for command in begun] == [world] * is_drawn
