"""A saved map as one page and one picture: `map query --out` and `map show --out`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, select_autoescape

from vizbot.core.errors import ConfigError
from vizbot.core.files import require_folder, write_whole
from vizbot.core.home_vocabulary import ROOMS
from vizbot.core.observer import Outcome
from vizbot.objectnav.candidates import scores_of
from vizbot.operator.figures.image_encoding import data_uri, png
from vizbot.operator.figures.panels import map_drawing
from vizbot.operator.session.place_answers import Answer, local_time
from vizbot.operator.session.room_areas import RoomArea, room_areas
from vizbot.operator.session.saved_map import SavedMap

PAGE, PICTURE = "index.html", "map.png"


@dataclass(frozen=True, slots=True)
class _Row:
    """A place as the page lists it."""

    number: int
    x: float
    y: float
    z: float
    score: str
    seen: str
    counts: bool


def require_page_folder(folder: Path) -> None:
    """Refuse a folder for a page before anything is opened.

    Raises:
        ConfigError: it is not new or empty, or cannot be written.
    """
    try:
        if folder.exists() and any(folder.iterdir()):
            raise ConfigError(f"{folder} is not a new or empty folder; give another with --out")
        require_folder(folder)
    except OSError as error:
        raise ConfigError(
            f"cannot write to {folder}: {error.strerror}; give another folder with --out"
        ) from error


def write_map_page(folder: Path, saved: SavedMap, answer: Answer | None, least: float) -> None:
    """Write the page and the picture of a map, with the answer to a question.

    A room is named where it is more probable than `least`.

    Raises:
        ConfigError: they cannot be written.
    """
    rooms = _rooms(saved, least)
    bundle = saved.bundle
    grid = replace(bundle.grid, zones=bundle.keep_out)
    scores, places_xy, rows = None, np.zeros((0, 2)), []
    if answer is not None:
        scores = scores_of(saved.belief(answer.text))
        places_xy = np.array([each.position[:2] for each in answer.places]).reshape(-1, 2)
        rows = [
            _Row(
                number,
                *_coordinates(each.position),
                f"{each.score:.0%}",
                local_time(datetime.fromisoformat(each.seen_at)),
                each.score > answer.threshold,
            )
            for number, each in enumerate(answer.places, 1)
        ]
    named = [(room.name, room.position) for room in rooms]
    picture = png(map_drawing(grid, scores, places_xy, named))
    page = _TEMPLATES.get_template("map.html").render(
        question=None if answer is None else answer.text,
        located=answer is not None and answer.outcome is Outcome.LOCATED,
        least=None if answer is None else f"{answer.threshold:.0%}",
        note=None if answer is None else answer.note,
        rows=rows,
        picture=data_uri("image/png", picture),
        rooms=[room.name for room in rooms],
        created=local_time(bundle.created),
        model=bundle.model_id,
        notice=bundle.notice,
    )
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / PICTURE, picture)
    write_whole(folder / PAGE, page.encode())


def _coordinates(position: tuple[float, float, float]) -> tuple[float, float, float]:
    """x, y, z in centimetres, without a sign before nought [m]."""
    x, y, z = (round(value, 2) + 0.0 for value in position)
    return x, y, z


def _rooms(saved: SavedMap, least: float) -> list[RoomArea]:
    """The rooms that the map shows, as far as its encoder has names for them."""
    beliefs = {}
    for room in ROOMS:
        try:
            beliefs[room] = saved.belief(room)
        except ConfigError:
            continue
    return room_areas(beliefs, least)


_TEMPLATES = Environment(
    loader=PackageLoader("vizbot.operator", "page"), autoescape=select_autoescape()
)
