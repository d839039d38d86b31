"""vizbot: a Roomba with an RGB-D camera that understands a home.

What is imported from here is public (docs/python.md); each name loads its module at its first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

if TYPE_CHECKING:
    from mapping.clip.reading import Reading as Reading
    from vizbot.config import Config as Config
    from vizbot.config import load_config as load_config
    from vizbot.core.errors import VizbotError as VizbotError
    from vizbot.core.observer import GoalReport as GoalReport
    from vizbot.core.observer import Step as Step
    from vizbot.operator.client.robot_client import RobotClient as RobotClient
    from vizbot.operator.session.saved_map import SavedMap as SavedMap
    from vizbot.rig import open_encoder as open_encoder

_MODULES = {
    "Config": "vizbot.config",
    "GoalReport": "vizbot.core.observer",
    "Reading": "mapping.clip.reading",
    "RobotClient": "vizbot.operator.client.robot_client",
    "SavedMap": "vizbot.operator.session.saved_map",
    "Step": "vizbot.core.observer",
    "VizbotError": "vizbot.core.errors",
    "load_config": "vizbot.config",
    "open_encoder": "vizbot.rig",
}
"""The module of each public name."""


if not TYPE_CHECKING:  # a checker would take every name for one of these

    def __getattr__(name: str) -> object:
        """A public name, from its module."""
        if name not in _MODULES:
            raise AttributeError(f"vizbot exports {', '.join(_MODULES)}, and no {name}")
        return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return [*globals(), *_MODULES]
