"""Settings of what is simulated, in two tables of the settings file."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ValidationError

from sim_stubs.realsense.config import SimulatedRealSenseConfig
from sim_stubs.world.body import WorldConfig
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.settings import SETTINGS, explained


class RehearsalConfig(BaseModel):
    """Settings of the simulated robot and its camera."""

    model_config = SETTINGS

    world: WorldConfig = WorldConfig()
    sim_camera: SimulatedRealSenseConfig = SimulatedRealSenseConfig()

    @classmethod
    def read(cls, config: Config) -> Self:
        """The settings that a robot's settings pass over.

        Raises:
            ConfigError: there is a wrong key or value.
        """
        given = {"world": config.world or {}, "sim_camera": config.sim_camera or {}}
        try:
            return cls.model_validate(given)
        except ValidationError as error:
            raise ConfigError(f"settings of the rehearsal: {explained(error, cls)}") from error

    def within(self, config: Config) -> Config:
        """A robot's settings with every one of these."""
        return config.model_copy(update=self.model_dump(mode="json"))
