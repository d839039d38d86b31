"""What the doctor finds, on simulated devices and on machines that lack them."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from typer.testing import CliRunner

from drivers.realsense_examination import CameraIdentity, cameras, examine_camera
from drivers.roomba_examination import examine_base
from drivers.roomba_oi import Opcode
from drivers.roomba_packets import Packet
from drivers.serial_port import open_serial
from sim_stubs.clock import SimulatedClock
from sim_stubs.free_floor import FreeFloor
from sim_stubs.realsense_device import SoftwareD435i
from sim_stubs.roomba import SimulatedRoomba
from sim_stubs.roomba_dock import Dock
from tests.roomba_rig import NoisyPort
from vizbot import cli, doctor
from vizbot.commands.doctor import require_well
from vizbot.config import Config
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError
from vizbot.core.geometry import planar
from vizbot.core.types import BaseMode, BaseState, Charging, ImuSamples, Intrinsics, RGBDFrame
from vizbot.doctor import Finding, Verdict, examine


@pytest.fixture
def examined():
    """Examine a simulated base, changed by `change`, through a port."""

    def run(change=lambda stub: None, wrap=lambda port: port, **settings):
        clock, floor = SimulatedClock(), FreeFloor()
        with SimulatedRoomba(floor, **settings) as stub:
            clock.attach(stub)
            change(stub)
            port = stub.lockstep_port(open_serial(stub.path))
            found = examine_base(wrap(port), clock)
            clock.sleep(0.1)
            assert floor.wheel_travel == (0.0, 0.0)
            assert stub.mode in (BaseMode.OFF, BaseMode.PASSIVE)
            port.close()
        return found

    return run


def test_a_sound_base_is_described_and_never_moved(examined):
    found = examined(charge=0.6)
    assert found.rate == pytest.approx(66.7, abs=1.0)
    assert found.spoilt == 0.0
    assert found.state.mode is BaseMode.PASSIVE
    assert found.state.battery == pytest.approx(0.6, abs=0.01)
    assert found.mode_offset == 0
    assert found.firmware == "release-3.8.2"


def test_a_line_that_spoils_bytes_is_measured(examined):
    found = examined(wrap=lambda port: NoisyPort(port, seed=1))
    assert 0.1 < found.spoilt < 0.6
    assert 20.0 < found.rate < 60.0


def test_firmware_that_reports_its_mode_one_too_high_is_named(examined):
    def shift(stub):
        stub.overrides[Packet.OI_MODE] = BaseMode.PASSIVE + 1

    assert examined(shift).mode_offset == 1


def test_a_base_that_says_nothing_has_no_state(examined):
    def silence(stub):
        stub.publish = lambda: None

    found = examined(silence)
    assert found.state is None and found.rate == 0.0 and found.firmware is None


def test_a_base_on_its_dock_is_not_reset(examined):
    sent = []

    def listen(port):
        write = port.write
        port.write = lambda command: (sent.append(command), write(command))[1]
        return port

    dock = Dock(planar(0.15, 0.0, np.pi))
    found = examined(wrap=listen, dock=dock, charge=0.5)
    assert found.state.docked and found.firmware is None
    assert bytes([Opcode.RESET]) not in sent


@dataclass
class StillCamera:
    """Ten frames a second that look at a wall with holes, and an IMU."""

    clock: SimulatedClock
    imu: bool = True
    filter_cost: float = 0.0

    def close(self):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self.close()

    def read(self, timeout=1.0):
        self.clock.sleep(0.1)
        depth = np.full((4, 8), 1.5, np.float32)
        depth[:, :2] = 0.0
        now, samples = self.clock.now(), np.arange(20)
        stamps = now - samples[::-1] / 200.0
        gyro, accel = np.tile([0.0, 0.003, 0.004], (20, 1)), np.tile([0.0, -9.8, 0.0], (20, 1))
        imu = ImuSamples(stamps, gyro, stamps, accel) if self.imu else ImuSamples.none()
        camera = Intrinsics(8, 4, 6.0, 6.0, 3.5, 1.5)
        return RGBDFrame(now, np.zeros((4, 8, 3), np.uint8), depth, camera, imu)


def test_a_camera_is_described_by_what_it_gives():
    clock = SimulatedClock()
    found = examine_camera(StillCamera(clock), clock)
    assert found.rate == pytest.approx(10.0, rel=0.1)
    assert found.holes == 0.25
    assert found.gyro_rate == pytest.approx(200.0, rel=0.1)
    assert found.gyro_bias == pytest.approx(0.005)
    assert found.gravity == pytest.approx(9.8)
    assert examine_camera(StillCamera(clock, imu=False), clock).gyro_rate == 0.0


@pytest.mark.parametrize(
    ("cost", "found"),
    [(0.0, []), (0.005, [(Verdict.GOOD, "5.0 ms a frame, 15 % of its time")]),
     (0.02, [(Verdict.POOR, "20.0 ms a frame, 60 % of its time")])],
)  # fmt: skip
def test_what_depth_filters_cost_is_measured_and_told(monkeypatch, cost, found):
    def still_camera(_settings, clock):
        return StillCamera(clock, filter_cost=cost)

    monkeypatch.setattr("drivers.realsense.RealSense", still_camera)
    findings = list(doctor._camera(Config(), SimulatedClock()))
    told = [(each.verdict, each.found) for each in findings if each.subject == "depth filters"]
    assert told == found


@pytest.mark.parametrize(
    ("battery", "felt", "verdicts"),
    [
        (0.9, {}, {"battery": Verdict.GOOD}),
        (0.9, {"docked": True}, {"battery": Verdict.POOR}),
        (0.15, {}, {"battery": Verdict.POOR}),
        (0.02, {}, {"battery": Verdict.BAD}),
        (0.02, {"docked": True, "charging": Charging.FULL_CHARGING}, {"battery": Verdict.BAD}),
        (
            0.02,
            {"docked": True, "charging": Charging.FAULT},
            {"charger": Verdict.POOR, "battery": Verdict.BAD},
        ),
        (None, {}, {"battery": Verdict.POOR}),
    ],
)
def test_a_battery_that_is_nearly_empty_is_bad_on_its_charger_too(battery, felt, verdicts):
    floor = (False,) * 4, (False,) * 2
    state = BaseState(
        0.0, np.eye(4), False, False, *floor, battery, BaseMode.PASSIVE, voltage=14.2, **felt
    )
    findings = list(doctor._battery(state))
    assert {each.subject: each.verdict for each in findings} == verdicts
    assert all(each.remedy for each in findings if each.verdict is not Verdict.GOOD)


def test_cameras_that_are_plugged_in_are_listed():
    device = SoftwareD435i(serial="0123")
    [found] = cameras(device.plug_in())
    assert isinstance(found, CameraIdentity)
    assert found.serial == "0123" and found.usb.startswith("3")


def test_a_machine_without_devices_gets_one_remedy_each(tmp_path):
    config = Config(serial_port="/dev/ttyNONE", clip="ViT-B/32")
    findings = {each.subject: each for each in examine(config, WallClock(), tmp_path / "runs")}
    for subject, remedy in (("serial port", "cable"), ("camera", "USB 3"), ("CLIP", "hf download")):
        assert findings[subject].verdict is Verdict.BAD
        assert remedy in findings[subject].remedy
    assert findings["disk"].verdict is not Verdict.BAD


def test_what_hangs_does_not_keep_the_rest_from_being_told(tmp_path, monkeypatch):
    clock = WallClock()

    def hang(config, clock):
        clock.sleep(30.0)
        yield

    monkeypatch.setattr("vizbot.doctor._camera", hang)
    monkeypatch.setattr("vizbot.doctor.TIMEOUT", 0.5)
    began = clock.now()
    findings = examine(Config(serial_port="/dev/ttyNONE"), clock, tmp_path)
    assert clock.now() - began < 15.0
    [hung] = [each for each in findings if each.subject == "camera"]
    assert hung.verdict is Verdict.BAD and "no answer" in hung.found


def test_what_raises_does_not_either(tmp_path, monkeypatch):
    def broken():
        raise RuntimeError("xioctl failed,\n errno=5")
        yield

    monkeypatch.setattr("vizbot.doctor._time", broken)
    findings = examine(Config(serial_port="/dev/ttyNONE"), WallClock(), tmp_path)
    [clock] = [each for each in findings if each.subject == "clock"]
    assert clock.verdict is Verdict.BAD and clock.found == "xioctl failed, errno=5"
    assert {"disk", "serial port"} <= {each.subject for each in findings}


def test_launch_refuses_what_is_bad_in_one_line():
    poor = Finding("microphone", Verdict.POOR, "none", "plug one in")
    require_well([poor])
    with pytest.raises(DeviceError, match=r"^camera: none found; plug it in; launch .* --force$"):
        require_well([poor, Finding("camera", Verdict.BAD, "none found", "plug it in")])


@pytest.mark.parametrize("verdict", Verdict)
def test_the_command_prints_a_table_or_json_and_exits_by_what_is_bad(monkeypatch, verdict):
    finding = Finding("disk", verdict, "3 GB free", "delete old runs")
    monkeypatch.setattr("vizbot.commands.doctor.examine", lambda *_: [finding])
    table = CliRunner().invoke(cli.app, ["doctor"])
    assert verdict.value in table.output and "delete old runs" in table.output
    told = CliRunner().invoke(cli.app, ["doctor", "--json"])
    well = verdict is not Verdict.BAD
    assert json.loads(told.output)["well"] == well
    assert json.loads(told.output)["findings"][0]["found"] == "3 GB free"
    assert (table.exit_code == 0) == (told.exit_code == 0) == well
