"""Furniture of each kind of room, and its places."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from sim_stubs.homes.furnishing.arrangement import (
    ahead,
    around,
    at_same_wall,
    beside,
    on_top,
    opposite,
)
from sim_stubs.homes.furnishing.placement import RoomLayout
from sim_stubs.homes.furniture.fitting import fitted
from sim_stubs.homes.furniture.sampler import ModelSampler
from sim_stubs.homes.geometry.bounding_block import facing_of
from sim_stubs.homes.geometry.house import Instance
from sim_stubs.homes.geometry.solids import Piece

CARPET_HEIGHT = 0.012
"""Height of carpets, which the robot drives over [m]."""
OVER_WORKTOP = 1.45
"""Height of the lower edge of wall cabinets [m]."""
Random = np.random.Generator
PICTURE_HEIGHT = 1.25
"""Height of the lower edge of a picture [m]."""
SHELF_HEIGHT = 0.95
"""Height of a shelf on the wall [m]."""


def dress_windows(name: str, layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    """Curtains beside the windows, a radiator below."""
    curtain = sampler("curtain") if rng.random() < 0.6 else None
    radiator = sampler("radiator") if rng.random() < 0.6 else None
    for window, facing in layout.windows:
        across = facing in "NS"
        start, end = (window.x0, window.x1) if across else (window.y0, window.y1)
        if curtain is not None and name != "kitchen":
            bottom = 0.06 if name in ("living room", "bedroom") else window.sill - 0.15
            strip = fitted(curtain, 0.32, 0.08, window.head + 0.12 - bottom, fill=True)
            for along in (start - 0.17, end + 0.17):
                layout.at_wall(strip, facing, along, bottom)
        if radiator is not None:
            below = fitted(radiator, end - start, 0.16, window.sill - 0.2)
            layout.at_wall(below, facing, (start + end) / 2, 0.1)


def over_worktops(layout: RoomLayout, sampler: ModelSampler, row: Sequence[Instance]) -> None:
    """Wall cabinets over the kitchen cabinets, a hood over the oven."""
    upper, hood = sampler("wall cabinet"), sampler("range hood")
    for it in row:
        width = float(it.piece.size[0])
        if it.label == "kitchen cabinet" and upper is not None:
            fit = fitted(upper, width, 0.4, fill=True)
            at_same_wall(layout, it, fit, 0.0, OVER_WORKTOP)
        if it.label == "oven" and hood is not None:
            at_same_wall(layout, it, fitted(hood, width, 0.5), 0.0, 1.55)


def dining_place(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    """A table with chairs around it, in the open or else at a wall."""
    chair = sampler("chair")
    for _ in range(3):
        table = sampler("dining table")
        if table is None:
            return
        placed = layout.in_the_open(table, 0.75) or layout.against_wall(table, spot="corner")
        if placed is None:
            continue
        if chair is not None:
            around(layout, placed, chair, int(rng.integers(3, 7)))
        if rng.random() < 0.6:
            something_on(layout, sampler, placed, ("vase", "flowers", "plant"), rng)
        return


def desk_place(
    layout: RoomLayout, sampler: ModelSampler, rng: Random, on_it: Sequence[str]
) -> None:
    """A desk with a chair before it and things on it."""
    desk = at_some_wall(layout, sampler, ("desk",), front=0.75)
    if desk is None:
        return
    seat = sampler("office chair") or sampler("chair")
    if seat is not None:
        ahead(layout, desk, seat, 0.02, turned=True)
    for label in on_it[: int(rng.integers(1, 3))]:
        if (small := sampler(label)) is not None:
            on_top(layout, desk, small)


def at_some_wall(
    layout: RoomLayout,
    sampler: ModelSampler,
    labels: Sequence[str],
    *,
    front: float = 0.0,
    spot: str = "any",
) -> Instance | None:
    """A piece at a wall, of the first class that there is and that fits; each is tried twice."""
    for label in (label for label in labels for _ in range(2)):
        piece = sampler(label)
        if piece is not None:
            placed = layout.against_wall(piece, front=front, spot=spot)
            if placed is not None:
                return placed
    return None


def something_on(
    layout: RoomLayout, sampler: ModelSampler, support: Instance, labels: Sequence[str], rng: Random
) -> None:
    """One of these on a piece of furniture."""
    small = sampler(labels[int(rng.integers(len(labels)))])
    if small is not None:
        on_top(layout, support, fitted(small, 1.2, 1.2, 0.7))


def hang(
    layout: RoomLayout, sampler: ModelSampler, label: str, elevation: float, count: int = 1
) -> None:
    """Pieces on the walls, their lower edges at `elevation` [m]."""
    for _ in range(count):
        if (piece := sampler(label)) is not None:
            layout.against_wall(piece, elevation=elevation)


def lay_carpet(layout: RoomLayout, sampler: ModelSampler, rng: Random, width: float) -> None:
    """A carpet about this wide on free floor, smaller ones where there is little [m]."""
    carpet = sampler("carpet")
    if carpet is None:
        return
    for share in (1.0, 0.8, 0.6):
        w = width * share * rng.uniform(0.85, 1.1)
        d = w * float(carpet.size[1] / carpet.size[0])
        w, d = (w, d) if d <= w else (w * w / d, w)
        flat = fitted(carpet, w, d, CARPET_HEIGHT, fill=True)
        if layout.on_floor(flat) is not None:
            return


def furnish(
    name: str, layout: RoomLayout, sampler: ModelSampler, height: float, rng: Random
) -> None:
    """Put furniture into an empty room whose ceiling has this `height` [m]."""
    dress_windows(name, layout, sampler, rng)
    _FURNISH[name](layout, sampler, rng)
    hang(layout, sampler, "picture", PICTURE_HEIGHT, int(rng.integers(1, 4)))
    lamp = sampler("ceiling lamp")
    if lamp is not None:
        layout.under_ceiling(lamp, height)


def _living_room(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    sofa = at_some_wall(layout, sampler, ("sofa",), front=0.7, spot="middle") or at_some_wall(
        layout, sampler, ("sofa",), front=0.3
    )
    if sofa is not None:
        if (table := sampler("coffee table")) is not None:
            placed = ahead(layout, sofa, table, 0.3)
            if placed is not None and rng.random() < 0.6:
                something_on(layout, sampler, placed, ("vase", "plant"), rng)
        stand = sampler("tv stand")
        place = None
        if stand is not None:
            # Where it cannot face the sofa, it stands at another wall than the sofa's.
            others = "NESW".replace(facing_of(sofa), "")
            place = opposite(layout, sofa, stand, 0.4) or layout.against_wall(
                stand, front=0.4, facings=others
            )
        if place is not None and (tv := sampler("tv")) is not None:
            on_top(layout, place, tv, spot="middle")
    if (armchair := sampler("armchair")) is not None:
        for _ in range(int(rng.integers(3))):
            layout.against_wall(armchair, front=0.5, spot="corner")
    at_some_wall(layout, sampler, ("bookshelf",), front=0.5)
    if rng.random() < 0.55:
        dining_place(layout, sampler, rng)
    for label, share in (("piano", 0.2), ("fireplace", 0.25), ("floor lamp", 0.7), ("plant", 0.8),
                         ("chest of drawers", 0.3), ("guitar", 0.2)):  # fmt: skip
        if rng.random() < share:
            spot = "corner" if label in ("floor lamp", "plant", "guitar") else "any"
            cabinet = at_some_wall(layout, sampler, (label,), spot=spot)
            if cabinet is not None and label == "chest of drawers":
                something_on(layout, sampler, cabinet, ("aquarium", "vase", "table lamp"), rng)
    if rng.random() < 0.7:
        lay_carpet(layout, sampler, rng, 2.2)


def _kitchen(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    cabinet = sampler("kitchen cabinet")
    main = [sampler(label) for label in ("refrigerator", "sink", "oven")]
    refrigerator, sink, oven = main
    plans = [
        (refrigerator, cabinet, sink, cabinet, oven, cabinet),
        (refrigerator, cabinet, sink, cabinet, oven),
        (refrigerator, sink, cabinet, oven),
        (sink, cabinet, oven),
        (sink, oven),
    ]
    row: tuple[Instance, ...] | None = None
    for plan in plans:
        pieces: Sequence[Piece] = [piece for piece in plan if piece is not None]
        pieces = pieces if rng.random() < 0.5 else pieces[::-1]
        row = layout.row(pieces, front=0.6, spot="corner")
        if row is not None:
            break
    placed = row or ()
    for piece in main:
        if piece is not None and not any(it.piece is piece for it in placed):
            alone = layout.against_wall(piece, front=0.5, spot="corner")
            placed = (*placed, alone) if alone is not None else placed
    over_worktops(layout, sampler, placed)
    tops = [it for it in placed if it.label == "kitchen cabinet"]
    for top, label in zip(tops, ("microwave", "coffee machine", "vase"), strict=False):
        if (small := sampler(label)) is not None:
            on_top(layout, top, small)
    dining_place(layout, sampler, rng)
    at_some_wall(layout, sampler, ("trash can",), spot="corner")
    if rng.random() < 0.4:
        at_some_wall(layout, sampler, ("plant",), spot="corner")
    if rng.random() < 0.3:
        lay_carpet(layout, sampler, rng, 1.3)


def _bathroom(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    tub = sampler("bathtub") if rng.random() < 0.85 else None
    # Where a large one finds no place, a smaller one of its kind may.
    sizes = [tub, fitted(tub, 1.6, 1.0)] if tub is not None else []
    if not any(layout.against_wall(piece, front=0.3, spot="corner") for piece in sizes):
        at_some_wall(layout, sampler, ("shower", "bathtub"), front=0.3, spot="corner")
    if at_some_wall(layout, sampler, ("toilet",), front=0.4) is None:
        at_some_wall(layout, sampler, ("toilet",), front=0.25)
    sink = at_some_wall(layout, sampler, ("sink",), front=0.4)
    mirror = sampler("mirror")
    if sink is not None and mirror is not None:
        at_same_wall(layout, sink, mirror, 0.0, max(1.1, float(sink.piece.size[2]) + 0.05))
    for label, share in (("washing machine", 0.5), ("bidet", 0.2), ("laundry basket", 0.6),
                         ("trash can", 0.4)):  # fmt: skip
        if rng.random() < share:
            at_some_wall(layout, sampler, (label,), spot="corner")
    if rng.random() < 0.4:
        lay_carpet(layout, sampler, rng, 0.9)


def _bedroom(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    bed = at_some_wall(layout, sampler, ("bed", "single bed"), front=0.4, spot="middle")
    if bed is not None:
        stand, lamp = sampler("nightstand"), sampler("table lamp")
        for _ in range(2):
            placed = beside(layout, bed, stand) if stand is not None else None
            if placed is not None and lamp is not None:
                on_top(layout, placed, lamp, spot="middle")
        if (picture := sampler("picture")) is not None:
            at_same_wall(layout, bed, picture, 0.0, 1.35)
    at_some_wall(layout, sampler, ("wardrobe",), front=0.5, spot="corner")
    if rng.random() < 0.6:
        chest = at_some_wall(layout, sampler, ("chest of drawers", "dressing table"), front=0.4)
        if chest is not None:
            mirror = sampler("mirror")
            if mirror is not None and rng.random() < 0.5:
                at_same_wall(layout, chest, mirror, 0.0, float(chest.piece.size[2]) + 0.15)
            something_on(layout, sampler, chest, ("vase", "tv", "flowers"), rng)
    for label, share in (("armchair", 0.3), ("chair", 0.25), ("plant", 0.5), ("suitcase", 0.2),
                         ("electric fan", 0.15), ("crib", 0.15)):  # fmt: skip
        if rng.random() < share:
            at_some_wall(layout, sampler, (label,), spot="corner")
    if rng.random() < 0.7:
        lay_carpet(layout, sampler, rng, 1.7)


def _kids_room(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    beds = [at_some_wall(layout, sampler, ("bunk bed",), front=0.3, spot="corner")] if (
        rng.random() < 0.5
    ) else []  # fmt: skip
    if not beds or beds[0] is None:
        single = sampler("single bed") or sampler("bed")
        if single is not None:
            beds = [layout.against_wall(single, front=0.3, spot="corner") for _ in range(2)]
    teddy = sampler("teddy bear")
    for bed in beds:
        if teddy is not None and bed is not None and on_top(layout, bed, teddy, uneven=0.12):
            teddy = None
    if teddy is not None:
        layout.against_wall(teddy, spot="corner")
    desk_place(layout, sampler, rng, ("laptop", "table lamp", "computer"))
    at_some_wall(layout, sampler, ("wardrobe",), front=0.5, spot="corner")
    at_some_wall(layout, sampler, ("bookshelf",), front=0.4)
    if rng.random() < 0.4:
        hang(layout, sampler, "shelf", SHELF_HEIGHT)
    for label, share in (("rocking horse", 0.4), ("ball", 0.5), ("backpack", 0.5), ("doll", 0.3),
                         ("guitar", 0.3), ("toy", 0.4), ("cardboard box", 0.3)):  # fmt: skip
        if rng.random() < share:
            at_some_wall(layout, sampler, (label,), spot="corner")
    if rng.random() < 0.8:
        lay_carpet(layout, sampler, rng, 1.5)


def _laundry_room(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    machines = [piece for label in ("washing machine", "dryer") if (piece := sampler(label))]
    if machines and layout.row(machines, front=0.5, spot="corner") is None:
        for piece in machines:
            layout.against_wall(piece, front=0.4, spot="corner")
    at_some_wall(layout, sampler, ("laundry basket",), spot="corner")
    at_some_wall(layout, sampler, ("bookshelf",), front=0.4, spot="corner")
    if rng.random() < 0.5:
        hang(layout, sampler, "shelf", SHELF_HEIGHT)
    for label, share in (("sink", 0.5), ("ironing board", 0.4), ("cardboard box", 0.5),
                         ("vacuum cleaner", 0.3), ("trash can", 0.3)):  # fmt: skip
        if rng.random() < share:
            at_some_wall(layout, sampler, (label,), spot="corner")


def _study(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    desk_place(layout, sampler, rng, ("computer", "table lamp", "laptop"))
    for _ in range(int(rng.integers(1, 3))):
        at_some_wall(layout, sampler, ("bookshelf",), front=0.4)
    stand, fan = sampler("nightstand"), sampler("electric fan")
    below = layout.against_wall(stand, spot="corner") if stand is not None else None
    if fan is not None and (below is None or on_top(layout, below, fan, spot="middle") is None):
        layout.against_wall(fan, spot="corner")
    for label, share in (("armchair", 0.4), ("filing cabinet", 0.4), ("trash can", 0.6),
                         ("plant", 0.6), ("guitar", 0.2), ("suitcase", 0.2)):  # fmt: skip
        if rng.random() < share:
            at_some_wall(layout, sampler, (label,), spot="corner")
    if rng.random() < 0.6:
        lay_carpet(layout, sampler, rng, 1.7)


def _hallway(layout: RoomLayout, sampler: ModelSampler, rng: Random) -> None:
    if (cabinet := sampler("chest of drawers")) is not None:
        narrow = fitted(cabinet, 1.2, 0.4)
        placed = layout.against_wall(narrow)
        if placed is not None:
            something_on(layout, sampler, placed, ("vase", "table lamp", "flowers"), rng)
            if (mirror := sampler("mirror")) is not None:
                at_same_wall(layout, placed, mirror, 0.0, float(narrow.size[2]) + 0.15)
    for label, share in (("coat rack", 0.5), ("plant", 0.6), ("bench", 0.3), ("suitcase", 0.2),
                         ("umbrella", 0.2)):  # fmt: skip
        if rng.random() < share:
            at_some_wall(layout, sampler, (label,), spot="corner")
    if rng.random() < 0.6:
        lay_carpet(layout, sampler, rng, 1.8)
    hang(layout, sampler, "picture", PICTURE_HEIGHT, 2)


_FURNISH: Mapping[str, Callable[[RoomLayout, ModelSampler, Random], None]] = {
    "living room": _living_room,
    "kitchen": _kitchen,
    "bathroom": _bathroom,
    "bedroom": _bedroom,
    "kid's room": _kids_room,
    "laundry room": _laundry_room,
    "study": _study,
    "hallway": _hallway,
}
