"""One furnished flat: two bedrooms, bathroom, living room and kitchen around a hallway, 10 x 8 m.

The plan is the same for every seed. The seed draws the furniture's looks, the robot's start, and
the room and place of a yellow chair (what the rehearsal looks for) and of a decoy in another
saturated colour.
"""

from __future__ import annotations

import numpy as np

from sim_stubs import shapes, textures
from sim_stubs.furnishing import Slot, Source, fitted, furnished
from sim_stubs.goal_chair import with_goal
from sim_stubs.house import House
from sim_stubs.walls import Opening, RectangularRoom, build_structure

LIVING_ROOM = (
    Slot("sofa", 1.5, 0.03, "N", 2.0, 0.95),
    Slot("armchair", 4.95, 0.06, "N", 0.95, 0.95),
    Slot("coffee table", 1.5, 1.40, "N", 1.1, 0.6),
    Slot("carpet", 1.5, 0.95, "N", 2.2, 1.5, fill=True, height=0.012),
    Slot("tv stand", 1.3, 3.33, "S", 1.6, 0.42, fill=True),
    Slot("tv", 1.3, 3.28, "S", 1.1, 0.35, on="tv stand"),
    Slot("bookshelf", 3.4, 0.03, "N", 1.0, 0.35),
    Slot("plant", 5.25, 3.3, "S", 0.45, 0.45),
    Slot("floor lamp", 2.75, 0.05, "N", 0.4, 0.4),
    Slot("picture", 0.02, 1.7, "E", 0.9, 0.1, 1.2),
    Slot("picture", 4.5, 3.33, "S", 0.9, 0.1, 1.2),
    Slot("picture", 5.53, 0.8, "W", 0.9, 0.1, 1.2),
)
KITCHEN = (
    Slot("kitchen cabinet", 6.55, 0.02, "N", 1.2, 0.64, fill=True),
    Slot("oven", 7.5, 0.02, "N", 0.62, 0.64),
    Slot("kitchen cabinet", 8.45, 0.02, "N", 1.2, 0.64, fill=True),
    Slot("microwave", 8.6, 0.05, "N", 0.5, 0.4, on="kitchen cabinet"),
    Slot("refrigerator", 9.6, 0.03, "N", 0.7, 0.7),
    Slot("dining table", 9.0, 2.45, "S", 1.3, 0.8),
    Slot("chair", 8.7, 1.33, "N", 0.5, 0.5),
    Slot("chair", 9.3, 1.33, "N", 0.5, 0.5),
    Slot("chair", 8.7, 2.83, "S", 0.5, 0.5),
    Slot("chair", 9.3, 2.83, "S", 0.5, 0.5),
    Slot("trash can", 5.85, 0.1, "N", 0.3, 0.3),
    Slot("picture", 9.97, 2.05, "W", 0.9, 0.1, 1.2),
    Slot("picture", 5.68, 1.2, "E", 0.9, 0.1, 1.2),
)
HALLWAY = (
    Slot("chest of drawers", 9.97, 4.1, "W", 0.9, 0.4),
    Slot("plant", 6.2, 4.72, "S", 0.35, 0.35),
    Slot("carpet", 4.6, 3.75, "N", 3.0, 0.7, fill=True, height=0.012),
    Slot("picture", 3.1, 4.73, "S", 0.9, 0.1, 1.2),
    Slot("picture", 6.0, 4.73, "S", 0.9, 0.1, 1.3),
    Slot("picture", 8.9, 4.73, "S", 0.9, 0.1, 1.2),
    Slot("picture", 5.0, 3.47, "N", 0.9, 0.1, 1.2),
    Slot("picture", 1.4, 3.47, "N", 0.9, 0.1, 1.2),
    Slot("mirror", 9.3, 3.47, "N", 0.7, 0.1, 1.0),
)
BEDROOM = (
    Slot("bed", 1.05, 7.96, "S", 1.7, 2.1),
    Slot("nightstand", 2.2, 7.96, "S", 0.5, 0.45),
    Slot("table lamp", 2.2, 7.90, "S", 0.3, 0.3, on="nightstand"),
    Slot("wardrobe", 3.72, 7.0, "W", 1.7, 0.62),
    Slot("chest of drawers", 3.72, 5.45, "W", 0.95, 0.45),
    Slot("carpet", 1.3, 5.25, "N", 1.7, 1.0, fill=True, height=0.012),
    Slot("picture", 0.02, 6.3, "E", 0.9, 0.1, 1.3),
    Slot("picture", 3.72, 5.45, "W", 0.9, 0.1, 1.3),
    Slot("plant", 0.28, 4.9, "N", 0.42, 0.42),
)
BATHROOM = (
    Slot("bathtub", 4.9, 7.97, "S", 1.75, 0.78),
    Slot("toilet", 5.92, 6.75, "W", 0.45, 0.72),
    Slot("sink", 3.88, 6.4, "E", 0.65, 0.5),
    Slot("mirror", 3.87, 6.4, "E", 0.65, 0.1, 1.15),
    Slot("washing machine", 5.92, 5.75, "W", 0.62, 0.6),
    Slot("laundry basket", 4.15, 4.95, "N", 0.45, 0.45),
)
SECOND_BEDROOM = (
    Slot("single bed", 9.95, 7.25, "W", 1.05, 2.1),
    Slot("desk", 7.0, 7.96, "S", 1.25, 0.62),
    Slot("computer", 6.9, 7.90, "S", 0.6, 0.4, on="desk"),
    Slot("office chair", 7.0, 6.72, "N", 0.55, 0.55),
    Slot("bookshelf", 6.08, 6.3, "E", 1.0, 0.35),
    Slot("wardrobe", 9.97, 5.65, "W", 1.1, 0.58),
    Slot("carpet", 8.2, 5.4, "N", 1.6, 1.0, fill=True, height=0.012),
    Slot("picture", 6.08, 7.5, "E", 0.9, 0.1, 1.3),
    Slot("picture", 8.8, 4.87, "N", 0.9, 0.1, 1.3),
    Slot("plant", 9.65, 4.92, "N", 0.4, 0.4),
)
FURNITURE = (*LIVING_ROOM, *KITCHEN, *HALLWAY, *BEDROOM, *BATHROOM, *SECOND_BEDROOM)

LIGHTS = ((2.8, 1.7), (7.9, 1.7), (5.0, 4.1), (1.9, 6.4), (4.9, 6.4), (8.0, 6.4))


DOORWAYS = (
    Opening(2.6, 3.35, 3.5, 3.45),
    Opening(7.1, 3.35, 8.0, 3.45),
    Opening(5.55, 1.9, 5.65, 2.8),
    Opening(1.4, 4.75, 2.3, 4.85),
    Opening(4.5, 4.75, 5.4, 4.85),
    Opening(7.0, 4.75, 7.9, 4.85),
)


def flat(seed: int, source: Source = shapes.piece) -> House:
    """The flat as `seed` draws it; `source` gives the furniture."""
    rng = np.random.default_rng(seed)
    rooms = _rooms()
    structure = build_structure(rooms, _openings())
    furniture = furnished(FURNITURE, source, rng)
    doorways = [((door.x0 + door.x1) / 2, (door.y0 + door.y1) / 2) for door in DOORWAYS]
    empty = House(
        rooms=tuple(room.room for room in rooms),
        structure=structure,
        instances=furniture,
        lights=np.array([(x, y, 2.3) for x, y in LIGHTS]),
        start=(0.0, 0.0, 0.0),
    )
    return with_goal(empty, fitted(source("chair", rng), 0.6, 0.6), doorways, rng)


def _rooms() -> tuple[RectangularRoom, ...]:
    oak, walnut = textures.planks(1), textures.planks(2, (0.36, 0.24, 0.18))
    stone = textures.tiles(3, (0.82, 0.80, 0.79), (0.62, 0.50, 0.45))
    slate = textures.tiles(7, (0.70, 0.74, 0.76), (0.35, 0.44, 0.48), 8)
    paper = textures.wallpaper
    return (
        RectangularRoom("living room", 0, 0, 5.55, 3.35, oak, 2.0,
             paper(1, (0.80, 0.82, 0.80), (0.42, 0.55, 0.50))),
        RectangularRoom("kitchen", 5.65, 0, 10, 3.35, stone, 2.0,
             paper(4, (0.86, 0.85, 0.84), (0.70, 0.45, 0.40))),
        RectangularRoom("hallway", 0, 3.45, 10, 4.75, walnut, 2.0,
             paper(5, (0.84, 0.83, 0.83), (0.48, 0.50, 0.60))),
        RectangularRoom("bedroom", 0, 4.85, 3.75, 8, oak, 2.0,
             paper(6, (0.76, 0.82, 0.87), (0.38, 0.48, 0.62))),
        RectangularRoom("bathroom", 3.85, 4.85, 5.95, 8, slate, 2.0,
             textures.tiles(8, (0.90, 0.90, 0.88), (0.72, 0.82, 0.85), 10)),
        RectangularRoom("second bedroom", 6.05, 4.85, 10, 8, walnut, 2.0,
             paper(9, (0.86, 0.80, 0.81), (0.60, 0.42, 0.50))),
    )  # fmt: skip


def _openings() -> tuple[Opening, ...]:
    def window(x0: float, y0: float, x1: float, y1: float, seed: int) -> Opening:
        return Opening(x0, y0, x1, y1, 0.95, 2.1, textures.outdoors(seed))

    return (
        *DOORWAYS,
        Opening(-0.1, 3.65, 0, 4.55, 0.0, 2.05, textures.wood(3, (0.36, 0.22, 0.16))),
        window(0.7, -0.2, 2.3, 0, 1),
        window(6.2, -0.2, 7.2, 0, 2),
        window(0.5, 8, 1.7, 8.2, 3),
        window(8.4, 8, 9.6, 8.2, 4),
        window(4.5, 8, 5.3, 8.2, 5),
    )
