"""What stands in which room, and where in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from sim_stubs.furnishing import fitted
from sim_stubs.house import Instance
from sim_stubs.piece import Piece
from sim_stubs.placement import Layout
from sim_stubs.supply import Supply

Random = np.random.Generator

CARPET_HEIGHT = 0.012
"""Thin enough to be driven over [m]."""
OVER_WORKTOP = 1.45
"""Where wall cabinets begin [m]."""


def furnish(name: str, layout: Layout, supply: Supply, height: float, rng: Random) -> None:
    """Put furniture into an empty room.

    Args:
        name: Of the room.
        layout: The room.
        supply: Gives the pieces.
        height: Of the ceiling [m].
        rng: Draws what there is.
    """
    _windows(name, layout, supply, rng)
    _FURNISH[name](layout, supply, rng)
    _hang(layout, supply, "picture", 1.25, int(rng.integers(1, 4)))
    lamp = supply("ceiling lamp")
    if lamp is not None:
        layout.under_ceiling(lamp, height)


def _windows(name: str, layout: Layout, supply: Supply, rng: Random) -> None:
    """Curtains beside the windows, a radiator below."""
    curtain = supply("curtain") if rng.random() < 0.6 else None
    radiator = supply("radiator") if rng.random() < 0.6 else None
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


def _living_room(layout: Layout, supply: Supply, rng: Random) -> None:
    sofa = _first(layout, supply, ("sofa",), front=0.7, spot="middle")
    if sofa is not None:
        if (table := supply("coffee table")) is not None:
            placed = layout.ahead(sofa, table, 0.3)
            if placed is not None and rng.random() < 0.6:
                _top(layout, supply, placed, ("vase", "plant"), rng)
        stand = supply("tv stand")
        place = None
        if stand is not None:
            place = layout.opposite(sofa, stand, 0.4) or layout.against_wall(stand, front=0.4)
        if place is not None and (tv := supply("tv")) is not None:
            layout.on_top(place, tv, spot="middle")
    if rng.random() < 0.7 and (armchair := supply("armchair")) is not None:
        layout.against_wall(armchair, front=0.5, spot="corner")
    _first(layout, supply, ("bookshelf",), front=0.5)
    if rng.random() < 0.4:
        _dining(layout, supply, rng)
    for label, share in (("piano", 0.2), ("fireplace", 0.25), ("floor lamp", 0.7), ("plant", 0.8),
                         ("chest of drawers", 0.3), ("guitar", 0.2)):  # fmt: skip
        if rng.random() < share:
            spot = "corner" if label in ("floor lamp", "plant", "guitar") else "any"
            cabinet = _first(layout, supply, (label,), spot=spot)
            if cabinet is not None and label == "chest of drawers":
                _top(layout, supply, cabinet, ("aquarium", "vase", "table lamp"), rng)
    if rng.random() < 0.7:
        _carpet(layout, supply, rng, 2.2)


def _kitchen(layout: Layout, supply: Supply, rng: Random) -> None:
    cabinet = supply("kitchen cabinet")
    main = [supply(label) for label in ("refrigerator", "sink", "oven")]
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
    _over_worktops(layout, supply, placed)
    tops = [it for it in placed if it.label == "kitchen cabinet"]
    for top, label in zip(tops, ("microwave", "coffee machine", "vase"), strict=False):
        if (small := supply(label)) is not None:
            layout.on_top(top, small)
    _dining(layout, supply, rng)
    _first(layout, supply, ("trash can",), spot="corner")
    if rng.random() < 0.4:
        _first(layout, supply, ("plant",), spot="corner")
    if rng.random() < 0.3:
        _carpet(layout, supply, rng, 1.3)


def _over_worktops(layout: Layout, supply: Supply, row: Sequence[Instance]) -> None:
    """Wall cabinets over the kitchen cabinets, a hood over the oven."""
    upper, hood = supply("wall cabinet"), supply("range hood")
    for it in row:
        width = float(it.piece.size[0])
        if it.label == "kitchen cabinet" and upper is not None:
            fit = fitted(upper, width, 0.4, fill=True)
            layout.at_same_wall(it, fit, 0.0, OVER_WORKTOP)
        if it.label == "oven" and hood is not None:
            layout.at_same_wall(it, fitted(hood, width, 0.5), 0.0, 1.55)


def _dining(layout: Layout, supply: Supply, rng: Random) -> None:
    """A table with chairs around it, in the open or else at a wall."""
    chair = supply("chair")
    for _ in range(3):
        table = supply("dining table")
        if table is None:
            return
        placed = layout.in_the_open(table, 0.75) or layout.against_wall(table, spot="corner")
        if placed is None:
            continue
        if chair is not None:
            layout.around(placed, chair, int(rng.integers(3, 7)))
        if rng.random() < 0.6:
            _top(layout, supply, placed, ("vase", "flowers", "plant"), rng)
        return


def _bathroom(layout: Layout, supply: Supply, rng: Random) -> None:
    first, second = ("bathtub", "shower") if rng.random() < 0.75 else ("shower", "bathtub")
    if _first(layout, supply, (first,), front=0.3, spot="corner") is None:
        _first(layout, supply, (second,), front=0.3, spot="corner")
    _first(layout, supply, ("toilet",), front=0.4)
    sink = _first(layout, supply, ("sink",), front=0.4)
    mirror = supply("mirror")
    if sink is not None and mirror is not None:
        layout.at_same_wall(sink, mirror, 0.0, max(1.1, float(sink.piece.size[2]) + 0.05))
    for label, share in (("washing machine", 0.4), ("bidet", 0.2), ("laundry basket", 0.4),
                         ("trash can", 0.4)):  # fmt: skip
        if rng.random() < share:
            _first(layout, supply, (label,), spot="corner")
    if rng.random() < 0.4:
        _carpet(layout, supply, rng, 0.9)


def _bedroom(layout: Layout, supply: Supply, rng: Random) -> None:
    bed = _first(layout, supply, ("bed", "single bed"), front=0.4, spot="middle")
    if bed is not None:
        stand, lamp = supply("nightstand"), supply("table lamp")
        for _ in range(2):
            placed = layout.beside(bed, stand) if stand is not None else None
            if placed is not None and lamp is not None:
                layout.on_top(placed, lamp, spot="middle")
        if (picture := supply("picture")) is not None:
            layout.at_same_wall(bed, picture, 0.0, 1.35)
    _first(layout, supply, ("wardrobe",), front=0.5, spot="corner")
    if rng.random() < 0.6:
        chest = _first(layout, supply, ("chest of drawers", "dressing table"), front=0.4)
        if chest is not None:
            mirror = supply("mirror")
            if mirror is not None and rng.random() < 0.5:
                layout.at_same_wall(chest, mirror, 0.0, float(chest.piece.size[2]) + 0.15)
            _top(layout, supply, chest, ("vase", "tv", "flowers"), rng)
    for label, share in (("armchair", 0.3), ("chair", 0.25), ("plant", 0.5), ("suitcase", 0.2),
                         ("electric fan", 0.15), ("crib", 0.15)):  # fmt: skip
        if rng.random() < share:
            _first(layout, supply, (label,), spot="corner")
    if rng.random() < 0.7:
        _carpet(layout, supply, rng, 1.7)


def _kids_room(layout: Layout, supply: Supply, rng: Random) -> None:
    beds = [_first(layout, supply, ("bunk bed",), front=0.3, spot="corner")] if (
        rng.random() < 0.5
    ) else []  # fmt: skip
    if not beds or beds[0] is None:
        single = supply("single bed") or supply("bed")
        if single is not None:
            beds = [layout.against_wall(single, front=0.3, spot="corner") for _ in range(2)]
    teddy = supply("teddy bear")
    for bed in beds:
        if teddy is not None and bed is not None and layout.on_top(bed, teddy, uneven=0.12):
            teddy = None
    if teddy is not None:
        layout.against_wall(teddy, spot="corner")
    _desk(layout, supply, rng, ("laptop", "table lamp", "computer"))
    _first(layout, supply, ("wardrobe",), front=0.5, spot="corner")
    _first(layout, supply, ("bookshelf",), front=0.4)
    for label, share in (("rocking horse", 0.4), ("ball", 0.5), ("backpack", 0.5), ("doll", 0.3),
                         ("guitar", 0.3), ("toy", 0.4), ("cardboard box", 0.3)):  # fmt: skip
        if rng.random() < share:
            _first(layout, supply, (label,), spot="corner")
    if rng.random() < 0.8:
        _carpet(layout, supply, rng, 1.5)


def _laundry_room(layout: Layout, supply: Supply, rng: Random) -> None:
    machines = [piece for label in ("washing machine", "dryer") if (piece := supply(label))]
    if machines and layout.row(machines, front=0.5, spot="corner") is None:
        for piece in machines:
            layout.against_wall(piece, front=0.4, spot="corner")
    _first(layout, supply, ("laundry basket",), spot="corner")
    _first(layout, supply, ("shelf", "bookshelf"), front=0.4, spot="corner")
    for label, share in (("sink", 0.5), ("ironing board", 0.4), ("cardboard box", 0.5),
                         ("vacuum cleaner", 0.3), ("trash can", 0.3)):  # fmt: skip
        if rng.random() < share:
            _first(layout, supply, (label,), spot="corner")


def _study(layout: Layout, supply: Supply, rng: Random) -> None:
    _desk(layout, supply, rng, ("computer", "table lamp", "laptop"))
    for _ in range(int(rng.integers(1, 3))):
        _first(layout, supply, ("bookshelf",), front=0.4)
    stand, fan = supply("nightstand"), supply("electric fan")
    below = layout.against_wall(stand, spot="corner") if stand is not None else None
    if fan is not None and (below is None or layout.on_top(below, fan, spot="middle") is None):
        layout.against_wall(fan, spot="corner")
    for label, share in (("armchair", 0.4), ("filing cabinet", 0.4), ("trash can", 0.6),
                         ("plant", 0.6), ("guitar", 0.2), ("suitcase", 0.2)):  # fmt: skip
        if rng.random() < share:
            _first(layout, supply, (label,), spot="corner")
    if rng.random() < 0.6:
        _carpet(layout, supply, rng, 1.7)


def _hallway(layout: Layout, supply: Supply, rng: Random) -> None:
    if (cabinet := supply("chest of drawers")) is not None:
        narrow = fitted(cabinet, 1.2, 0.4)
        placed = layout.against_wall(narrow)
        if placed is not None:
            _top(layout, supply, placed, ("vase", "table lamp", "flowers"), rng)
            if (mirror := supply("mirror")) is not None:
                layout.at_same_wall(placed, mirror, 0.0, float(narrow.size[2]) + 0.15)
    for label, share in (("coat rack", 0.5), ("plant", 0.6), ("bench", 0.3), ("suitcase", 0.2),
                         ("umbrella", 0.2)):  # fmt: skip
        if rng.random() < share:
            _first(layout, supply, (label,), spot="corner")
    if rng.random() < 0.6:
        _carpet(layout, supply, rng, 1.8)
    _hang(layout, supply, "picture", 1.25, 2)


_FURNISH: Mapping[str, Callable[[Layout, Supply, Random], None]] = {
    "living room": _living_room,
    "kitchen": _kitchen,
    "bathroom": _bathroom,
    "bedroom": _bedroom,
    "kid's room": _kids_room,
    "laundry room": _laundry_room,
    "study": _study,
    "hallway": _hallway,
}


def _desk(layout: Layout, supply: Supply, rng: Random, on_it: Sequence[str]) -> None:
    """A desk with a chair before it and things on it."""
    desk = _first(layout, supply, ("desk",), front=0.75)
    if desk is None:
        return
    seat = supply("office chair") or supply("chair")
    if seat is not None:
        layout.ahead(desk, seat, 0.02, turned=True)
    for label in on_it[: int(rng.integers(1, 3))]:
        if (small := supply(label)) is not None:
            layout.on_top(desk, small)


def _first(
    layout: Layout, supply: Supply, labels: Sequence[str], *, front: float = 0.0, spot: str = "any"
) -> Instance | None:
    """A piece at a wall, of the first class that there is and that fits; each is tried twice."""
    for label in (label for label in labels for _ in range(2)):
        piece = supply(label)
        if piece is not None:
            placed = layout.against_wall(piece, front=front, spot=spot)
            if placed is not None:
                return placed
    return None


def _top(
    layout: Layout, supply: Supply, support: Instance, labels: Sequence[str], rng: Random
) -> None:
    """One of these on a piece of furniture."""
    small = supply(labels[int(rng.integers(len(labels)))])
    if small is not None:
        layout.on_top(support, fitted(small, 1.2, 1.2, 0.7))


def _hang(layout: Layout, supply: Supply, label: str, elevation: float, count: int) -> None:
    """Pieces of their own on the walls."""
    for _ in range(count):
        if (piece := supply(label)) is not None:
            layout.against_wall(piece, elevation=elevation)


def _carpet(layout: Layout, supply: Supply, rng: Random, width: float) -> None:
    """A carpet about this wide on free floor, smaller ones where there is little [m]."""
    carpet = supply("carpet")
    if carpet is None:
        return
    for share in (1.0, 0.8, 0.6):
        w = width * share * rng.uniform(0.85, 1.1)
        d = w * float(carpet.size[1] / carpet.size[0])
        w, d = (w, d) if d <= w else (w * w / d, w)
        flat = fitted(carpet, w, d, CARPET_HEIGHT, fill=True)
        if layout.on_floor(flat) is not None:
            return
