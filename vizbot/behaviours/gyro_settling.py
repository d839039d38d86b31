"""Standing still before anything else, so that the gyroscope's bias is learned."""

from __future__ import annotations

from vizbot.config import GyroSettlingConfig
from vizbot.core.types import RGBDFrame


class GyroSettling:
    """Goes on for some time and some frames, if the camera has a gyroscope at all."""

    def __init__(self, config: GyroSettlingConfig) -> None:
        """The robot has not stood yet."""
        self._config = config
        self._frames = 0
        self._since = 0.0

    def goes_on(self, frame: RGBDFrame) -> bool:
        """Whether the robot should stand still after `frame`; ask once a frame."""
        if self._frames == 0:
            self._since = frame.stamp
        self._frames += 1
        if len(frame.imu.gyro_stamps) == 0:
            return False
        young = frame.stamp < self._since + self._config.seconds
        return young or self._frames <= self._config.frames
