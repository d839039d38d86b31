"""Contacts that last for one sensor frame alone are not lost."""

from dataclasses import fields, replace

import numpy as np
import pytest

from drivers.roomba.state import with_contacts
from vizbot.core.types import BaseMode, BaseState, Button

QUIET = BaseState(0.0, np.eye(4), False, False, (False,) * 4, (False,) * 2, None, BaseMode.SAFE)
CONTACTS = {
    "bump_left": True,
    "bump_right": True,
    "cliffs": (False, True, False, False),
    "wheel_drops": (False, True),
    "virtual_wall": True,
    "overcurrents": (True, False),
    "buttons": frozenset({Button.CLEAN}),
}


@pytest.mark.parametrize("contact", CONTACTS)
def test_what_one_frame_alone_has_told_is_in_the_next_state(contact):
    before = replace(QUIET, **{contact: CONTACTS[contact]})
    after = with_contacts(replace(QUIET, stamp=1.0), before)
    assert getattr(after, contact) == CONTACTS[contact]
    assert after.stamp == 1.0
    others = {each.name for each in fields(BaseState)} - {contact, "stamp", "T_odom_base"}
    assert all(getattr(after, name) == getattr(QUIET, name) for name in others)
