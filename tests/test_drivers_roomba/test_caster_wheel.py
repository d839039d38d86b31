"""A front wheel that does not roll while the driven wheels do."""

import pytest

from drivers.roomba.packets import Packet, Stasis
from sim_stubs.world.body import Contacts
from vizbot.core.types import Twist

AHEAD = Twist(0.2, 0.0)


def warnings_in(caplog):
    return [line for line in caplog.messages if "the front wheel does not" in line]


def test_it_is_logged_once_until_it_rolls_again(rig, caplog):
    rig.drive(AHEAD, 2.0)
    assert warnings_in(caplog) == []
    for times in (1, 2):
        rig.stub.overrides[Packet.STASIS] = 0
        rig.drive(AHEAD, 0.9)
        assert len(warnings_in(caplog)) == times - 1
        rig.drive(AHEAD, 3.0)
        assert len(warnings_in(caplog)) == times
        del rig.stub.overrides[Packet.STASIS]
        rig.drive(AHEAD, 0.5)
    assert "they slip, or it is stuck or missing; look under the robot" in warnings_in(caplog)[0]


@pytest.mark.parametrize(
    ("twist", "stasis", "contacts"),
    [
        (Twist(-0.2, 0.0), 0, Contacts()),
        (Twist(0.0, 1.0), 0, Contacts()),
        (Twist(0.2, 0.5), 0, Contacts()),
        (Twist(0.0, 0.0), 0, Contacts()),
        (AHEAD, Stasis.DISABLED, Contacts()),  # it is too dirty
        (AHEAD, 0, Contacts(bump_left=True)),  # which holds the robot
    ],
)
def test_it_watches_nothing_but_driving_straight_ahead(rig, caplog, twist, stasis, contacts):
    rig.stub.overrides[Packet.STASIS] = stasis
    rig.floor.contacts = contacts
    rig.drive(twist, 3.0)
    assert warnings_in(caplog) == []
