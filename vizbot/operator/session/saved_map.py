"""A saved map that answers questions from Python and `vizbot map query`.

Answers need OpenCV and compiled kernels, which are loaded once there is a map and an encoder.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mapping import map_bundle
from vizbot.config import Config
from vizbot.objectnav.tasks import Goal, goal_of
from vizbot.operator.session.saved_maps import find_map
from vizbot.rig import open_map_encoder

if TYPE_CHECKING:
    from mapping.clip.places.belief import PlaceBelief
    from mapping.clip.scores import Query
    from vizbot.operator.session.place_answers import Answer


class SavedMap:
    """A saved map and the encoder that it is asked with.

    Attributes:
        bundle: All that the map holds.
        encoder: Embeds the questions.
    """

    def __init__(
        self, folder: str | Path, config: Config | None = None, clip: str | None = None
    ) -> None:
        """Load the map and open the encoder that made it.

        A class of the user's own is opened only where `config` or `clip` names it: a class is code,
        and a map may come from anywhere.

        Args:
            folder: The folder of a map or of a run, or the name of a saved map.
            config: Settings: the encoder's device, the method, and the probability that is enough.
            clip: The encoder, as `--clip` names it; None for the map's own.

        Raises:
            ConfigError: there are no weights for the encoder here.
            MapError: there is no map, it cannot be read, or another encoder made it.
        """
        self._config = Config() if config is None else config
        self.bundle = map_bundle.load(find_map(Path(folder)))
        if clip is None and self._config.clip == self.bundle.model_id:
            clip = self._config.clip
        self.encoder = open_map_encoder(self.bundle, self._config, clip)

    def find(
        self, text: str, on_progress: Callable[[int, int], None] = lambda done, of: None
    ) -> Answer:
        """Where a thing or a room is.

        Args:
            text: The thing or the room.
            on_progress: Called with how many pictures of the background are embedded, and of how
                many, where the map has none and the first question waits for them.
        """
        from vizbot.operator.session.place_answers import find_places

        goal = goal_of(self.encoder, text)
        if self._config.objectnav.method != "paper":
            self.bundle = map_bundle.with_background(self.bundle, self.encoder, on_progress)
        return find_places(self.bundle, goal, self._config.objectnav)

    def count(self, text: str) -> int:
        """How many of a thing there are, those within a metre of each other as one."""
        from vizbot.operator.session.place_answers import count_places, least_score

        goal = goal_of(self.encoder, text)
        least = least_score(goal, self._config.objectnav)
        return count_places(self.bundle, self._query(goal), least)

    def belief(self, text: str) -> PlaceBelief:
        """How probable each place of the map is to be a thing or a room."""
        from vizbot.operator.session.place_answers import belief_in

        return belief_in(self.bundle, self._query(goal_of(self.encoder, text)))

    def _query(self, goal: Goal) -> Query:
        from vizbot.objectnav.candidates import question_of

        self.bundle = map_bundle.with_background(self.bundle, self.encoder)
        return question_of(goal)
