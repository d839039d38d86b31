"""A D435i in software, on the SDK's software device: what is pushed into it, the SDK streams.

Plugged into a context it is opened like a camera; recorded, it gives a `.db3` that any RealSense
program plays.

A `.db3` is a rosbag2 database: a table of topics and one of messages, with times in nanoseconds.
The SDK's recorder leaves out some metadata of a software device.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.realsense.sdk import rs
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import invert
from vizbot.core.types import SE3, Intrinsics

_STAMP = re.compile(rb"(?<=[;\0])timestamp=([-+.0-9]+)")
COLOR = Intrinsics(width=640, height=480, fx=610.0, fy=610.0, cx=322.0, cy=243.0)
"""Typical intrinsics of a D435i's colour camera at 640x480."""
DEPTH = Intrinsics(width=640, height=480, fx=385.0, fy=385.0, cx=320.5, cy=240.5)
"""Typical intrinsics of a D435i's depth camera at 640x480."""
GYRO_RATE = 200
ACCEL_RATE = 100
_DEPTH_UNITS = 0.001
Controls = tuple[tuple[Any, float, float, float], ...]
STEREO_CONTROLS: Controls = (
    (rs.option.visual_preset, 0, 5, 0),
    (rs.option.emitter_enabled, 0, 2, 1),
    (rs.option.laser_power, 0, 360, 150),
    (rs.option.enable_auto_exposure, 0, 1, 1),
    (rs.option.auto_exposure_limit, 1, 200_000, 200_000),
    (rs.option.auto_exposure_limit_toggle, 0, 1, 0),
    (rs.option.global_time_enabled, 0, 1, 1),
)
"""Option, least and greatest value, default."""
COLOUR_CONTROLS: Controls = (
    (rs.option.auto_exposure_priority, 0, 1, 1),
    (rs.option.enable_auto_exposure, 0, 1, 1),
    (rs.option.global_time_enabled, 0, 1, 1),
)
"""As `STEREO_CONTROLS`."""
MOTION_CONTROLS: Controls = ((rs.option.global_time_enabled, 0, 1, 1),)
"""As `STEREO_CONTROLS`."""


@contextmanager
def naming(recording: Path) -> Iterator[None]:
    """Turn errors of SQLite and the SDK into one that names the recording.

    Raises:
        ConfigError: the recording could not be written.
    """
    try:
        yield
    except (sqlite3.Error, RuntimeError) as error:
        raise ConfigError(
            f"cannot write {recording}: {error}; make room on its disk, or record to another"
        ) from error


def require_all(recording: Path, count: int) -> None:
    """Check the number of images and samples: the recorder drops those that find no room.

    Raises:
        sqlite3.Error: there are fewer.
    """
    with closing(sqlite3.connect(recording)) as database:
        (there,) = database.execute(
            "SELECT COUNT(*) FROM messages JOIN topics ON topics.id = topic_id"
            " WHERE name LIKE '%/image/data/%' OR name LIKE '%/imu/data'"
        ).fetchone()
    if there < count:
        raise sqlite3.OperationalError(f"{count - there} of {count} images and samples are lost")


def add_imu_extrinsics(recording: Path, T_imu_depth: SE3) -> None:
    """Write where the IMU is, as a recording of a real camera does; the SDK's recorder leaves it.

    The message is a `std_msgs/msg/String` in CDR (little endian, length with the closing zero).
    It maps from the reference, which is the depth camera, to the stream.
    """
    rotation = ",".join(f"{x:f}" for x in T_imu_depth[:3, :3].T.ravel())
    translation = ",".join(f"{x:f}" for x in T_imu_depth[:3, 3])
    text = f"rotation={rotation};translation={translation}".encode() + b"\0"
    message = b"\x00\x01\x00\x00" + len(text).to_bytes(4, "little") + text
    with closing(sqlite3.connect(recording)) as database, database:
        for stream in ("Gyro", "Accel"):
            topic = database.execute(
                "INSERT INTO topics (name, type, serialization_format, offered_qos_profiles)"
                " VALUES (?, 'std_msgs/msg/String', 'cdr', '')",
                (f"/device_0/sensor_2/{stream}_0/tf/ref_1",),
            ).lastrowid
            database.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, 0, ?)",
                (topic, message),
            )


def set_pace(recording: Path) -> None:
    """Give each message the time of its stamp, by which real-time playback goes.

    The recorder writes when it was pushed. The messages of one image or sample have one time, and
    one of them, the metadata, holds its stamp [ms].
    """
    with closing(sqlite3.connect(recording)) as database, database:
        rows = database.execute(
            "SELECT timestamp, data FROM messages JOIN topics ON topics.id = topic_id"
            " WHERE name LIKE '%/metadata' ORDER BY messages.id"
        ).fetchall()
        stamps = {
            pushed: float(found[1]) for pushed, text in rows if (found := _STAMP.search(text))
        }
        first = min(stamps.values(), default=0.0)
        for pushed, stamp in stamps.items():
            # What has no stamp, as the description of the device, is at 0 and comes first. Negative
            # times are those that are set already, since old and new ones may coincide.
            due = -round(1e6 * (stamp - first)) - 1
            database.execute("UPDATE messages SET timestamp = ? WHERE timestamp = ?", (due, pushed))
        database.execute("UPDATE messages SET timestamp = -timestamp WHERE timestamp < 0")


def add_controls(sensor: Any, controls: Controls) -> None:
    """Let a sensor of a software device (`rs.software_sensor`) have these settings."""
    for option, least, greatest, default in controls:
        allowed = rs.option_range()
        allowed.min, allowed.max, allowed.step, allowed.default = least, greatest, 1.0, default
        sensor.add_option(option, allowed, True)


@dataclass(frozen=True, slots=True, eq=False)
class SensorPoses:
    """Where the sensors of a camera are to one another; by default all in one place.

    Attributes:
        T_color_depth: Depth camera in the colour camera.
        R_depth_imu: (3, 3) axes of the IMU in those of the depth camera.
    """

    T_color_depth: SE3 = field(default_factory=lambda: np.eye(4))
    R_depth_imu: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))


class SoftwareD435i:
    """Colour, depth, gyro and accelerometer that stream what is pushed.

    Data that are pushed without a stream are dropped, as by the SDK.

    Args:
        color: Intrinsics of the colour camera.
        depth: Intrinsics of the depth camera; those of the colour camera if not given.
        fps: Images per second.
        serial: Serial number.
        usb: Version of the connection.
        controls: Whether its sensors have the settings of a D435i's; a recorder keeps them.
        poses: Where the sensors are to one another.

    Attributes:
        domain: Clock that what is pushed next says it is stamped by (`rs.timestamp_domain`).
    """

    def __init__(
        self,
        color: Intrinsics = COLOR,
        depth: Intrinsics | None = None,
        fps: int = 30,
        serial: str = "900000000001",
        usb: str = "3.2",
        controls: bool = False,
        poses: SensorPoses | None = None,
    ) -> None:
        poses = poses or SensorPoses()
        T_depth_imu = np.eye(4)
        T_depth_imu[:3, :3] = poses.R_depth_imu
        self._T_imu_depth = invert(T_depth_imu)
        self.domain = rs.timestamp_domain.global_time
        self._fps = fps
        self._counts = {"depth": 0, "color": 0, "gyro": 0, "accel": 0}
        self._arrivals: list[Any] = []
        self._device = rs.software_device()
        for key, value in (
            (rs.camera_info.name, "Software D435I"),
            (rs.camera_info.serial_number, serial),
            (rs.camera_info.product_line, "D400"),
            (rs.camera_info.product_id, "0B3A"),
            (rs.camera_info.firmware_version, "5.16.0.1"),
            (rs.camera_info.usb_type_descriptor, usb),
            (rs.camera_info.physical_port, f"software-{serial}"),
        ):
            self._device.register_info(key, value)
        self._stereo = self._device.add_sensor("Stereo Module")
        # The SDK takes a sensor for a depth sensor once it has a depth unit.
        self._stereo.add_read_only_option(rs.option.depth_units, _DEPTH_UNITS)
        self._stereo.add_read_only_option(rs.option.stereo_baseline, 50.0)
        self._rgb = self._device.add_sensor("RGB Camera")
        self._motion = self._device.add_sensor("Motion Module")
        if controls:
            add_controls(self._stereo, STEREO_CONTROLS)
            add_controls(self._rgb, COLOUR_CONTROLS)
            add_controls(self._motion, MOTION_CONTROLS)
        z16 = _video_stream(rs.stream.depth, 1, depth or color, fps, rs.format.z16, 2)
        rgb8 = _video_stream(rs.stream.color, 2, color, fps, rs.format.rgb8, 3)
        gyro = _motion_stream(rs.stream.gyro, 3, GYRO_RATE)
        accel = _motion_stream(rs.stream.accel, 4, ACCEL_RATE)
        self._depth_profile = self._stereo.add_video_stream(z16, True).as_video_stream_profile()
        self._color_profile = self._rgb.add_video_stream(rgb8, True).as_video_stream_profile()
        self._gyro_profile = self._motion.add_motion_stream(gyro, True).as_motion_stream_profile()
        self._accel_profile = self._motion.add_motion_stream(accel, True).as_motion_stream_profile()
        to_color, to_imu = _extrinsics(poses.T_color_depth), _extrinsics(self._T_imu_depth)
        self._depth_profile.register_extrinsics_to(self._color_profile, to_color)
        self._depth_profile.register_extrinsics_to(self._gyro_profile, to_imu)
        self._depth_profile.register_extrinsics_to(self._accel_profile, to_imu)

    def push_frame(
        self, rgb: NDArray[np.uint8], depth_mm: NDArray[np.uint16], stamp: float
    ) -> None:
        """Push a pair of images taken at `stamp` [s]: (H, W, 3) RGB and (H, W) depth [mm]."""
        self.push_depth(depth_mm, stamp)
        self.push_color(rgb, stamp)

    def push_depth(self, depth_mm: NDArray[np.uint16], stamp: float) -> None:
        """Push a depth image alone."""
        self._push_video("depth", self._stereo, self._depth_profile, depth_mm, stamp)

    def push_color(self, rgb: NDArray[np.uint8], stamp: float) -> None:
        """Push a colour image alone."""
        self._push_video("color", self._rgb, self._color_profile, rgb, stamp)

    def push_gyro(self, rate: NDArray[np.float64], stamp: float) -> None:
        """Push an angular rate (3,) [rad/s] in the axes of the IMU, at `stamp` [s]."""
        self._push_motion("gyro", self._gyro_profile, rate, stamp)

    def push_accel(self, force: NDArray[np.float64], stamp: float) -> None:
        """Push a specific force (3,) [m/s^2] in the axes of the IMU, at `stamp` [s]."""
        self._push_motion("accel", self._accel_profile, force, stamp)

    def plug_in(self, context: Any = None) -> Any:
        """Add the camera to an `rs.context`; to a new one if none is given."""
        if context is None:
            context = rs.context()
            # The context itself would forget the device at once; the list of arrivals keeps it.
            context.set_devices_changed_callback(
                lambda change: self._arrivals.append(change.get_new_devices())
            )
        self._device.add_to(context)
        return context

    def unplug(self) -> None:
        """Leave the context once no program streams; a streaming program gets no error."""
        self._arrivals.clear()

    def setting(self, option: Any) -> float:
        """Value of an `rs.option` of the depth sensor, or of the colour sensor if it has none."""
        sensor = self._stereo if self._stereo.supports(option) else self._rgb
        return float(sensor.get_option(option))

    @contextmanager
    def record(self, path: Path) -> Iterator[None]:
        """Record what is pushed in the `with` block to `path`, a `.db3`.

        The file is there when the block ends, or not at all if it fails. Played in real time it
        keeps the pace of its stamps, however fast it was pushed.

        Raises:
            ConfigError: the file cannot be written, or not all of it.
        """
        unfinished = path.with_name(f".unfinished-{path.name}")
        unfinished.unlink(missing_ok=True)
        before = sum(self._counts.values())
        try:
            with naming(path):
                recorder = rs.recorder(str(unfinished), self._device)
            sensors = recorder.query_sensors()
            for sensor in sensors:
                sensor.open(sensor.get_stream_profiles())
                sensor.start(lambda _frame: None)
            yield
            for sensor in sensors:
                sensor.stop()
                sensor.close()
            # The file is complete once the recorder and all its sensors are gone.
            del sensor, sensors, recorder
            with naming(path):
                require_all(unfinished, sum(self._counts.values()) - before)
                add_imu_extrinsics(unfinished, self._T_imu_depth)
                set_pace(unfinished)
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)

    def _push_video(
        self, stream: str, sensor: Any, profile: Any, pixels: NDArray[Any], stamp: float
    ) -> None:
        # A struct of its own for each frame: the SDK keeps it, and crashes when it is used again.
        frame = rs.software_video_frame()
        frame.bpp = pixels.itemsize * (pixels.shape[2] if pixels.ndim == 3 else 1)
        frame.stride = frame.bpp * pixels.shape[1]
        frame.timestamp = stamp * 1000.0
        frame.frame_number = self._count(stream)
        frame.domain = self.domain
        frame.profile = profile
        frame.depth_units = _DEPTH_UNITS
        frame.pixels = np.ascontiguousarray(pixels)
        # The SDK derives the rate from stamps since 1970; with others it would not pair frames.
        sensor.set_metadata(rs.frame_metadata_value.actual_fps, 1000 * self._fps)
        sensor.on_video_frame(frame)

    def _push_motion(
        self, stream: str, profile: Any, value: NDArray[np.float64], stamp: float
    ) -> None:
        vector = rs.vector()
        vector.x, vector.y, vector.z = (float(component) for component in value)
        frame = rs.software_motion_frame()
        frame.data = vector
        frame.timestamp = stamp * 1000.0
        frame.frame_number = self._count(stream)
        frame.domain = self.domain
        frame.profile = profile
        self._motion.on_motion_frame(frame)

    def _count(self, stream: str) -> int:
        number = self._counts[stream]
        self._counts[stream] += 1
        return number


def _video_stream(kind: Any, uid: int, camera: Intrinsics, fps: int, fmt: Any, bpp: int) -> Any:
    intrinsics = rs.intrinsics()
    intrinsics.width, intrinsics.height = camera.width, camera.height
    intrinsics.fx, intrinsics.fy = camera.fx, camera.fy
    intrinsics.ppx, intrinsics.ppy = camera.cx, camera.cy
    intrinsics.model = rs.distortion.brown_conrady
    intrinsics.coeffs = [0.0] * 5
    stream = rs.video_stream()
    stream.type, stream.index, stream.uid = kind, 0, uid
    stream.width, stream.height, stream.fps = camera.width, camera.height, fps
    stream.bpp, stream.fmt, stream.intrinsics = bpp, fmt, intrinsics
    return stream


def _motion_stream(kind: Any, uid: int, rate: int) -> Any:
    intrinsics = rs.motion_device_intrinsic()
    intrinsics.data = np.eye(3, 4).tolist()
    intrinsics.noise_variances = intrinsics.bias_variances = [0.0] * 3
    stream = rs.motion_stream()
    stream.type, stream.index, stream.uid, stream.fps = kind, 0, uid, rate
    stream.fmt, stream.intrinsics = rs.format.motion_xyz32f, intrinsics
    return stream


def _extrinsics(T_to_from: SE3) -> Any:
    extrinsics = rs.extrinsics()
    # The SDK stores rotations column by column.
    extrinsics.rotation = T_to_from[:3, :3].T.ravel().tolist()
    extrinsics.translation = T_to_from[:3, 3].tolist()
    return extrinsics
