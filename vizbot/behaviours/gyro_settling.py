"""Standing still at first, so that the gyroscope's bias is learned."""

from __future__ import annotations

from vizbot.config import GyroSettlingConfig
from vizbot.core.types import RGBDFrame


class GyroSettling:
    """Keeps the robot at rest for some time and some frames, if its camera has a gyroscope."""

    def __init__(self, config: GyroSettlingConfig) -> None:
        self._config = config
        self._frames = 0
        self._since = 0.0

    def goes_on(self, frame: RGBDFrame) -> bool:
        """Whether the robot should stand still after `frame`; call once a frame."""
        if self._frames == 0:
            self._since = frame.stamp
        self._frames += 1
        if len(frame.imu.gyro_stamps) == 0:
            return False
        early = frame.stamp < self._since + self._config.seconds
        return early or self._frames <= self._config.frames
