"""Procedural cupboards, shelves and kitchen cabinets."""

from __future__ import annotations

import numpy as np

from sim_stubs.homes.furniture.shapes.appliances import casing
from sim_stubs.homes.furniture.shapes.curved_solids import (
    rod,
    sheet,
    shifted,
    tilted,
    translucent,
    turned,
)
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    GLASS,
    PAINTS,
    STEEL,
    Random,
    Shape,
    any_metal,
    any_paint,
    any_wood,
    cabinet,
    legs,
    pick,
    shade,
    wood_or_paint,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder, flat_panel
from sim_stubs.homes.textures import patterns

WORKTOPS = ((0.25, 0.25, 0.27), (0.80, 0.79, 0.77), (0.60, 0.42, 0.25), (0.55, 0.55, 0.57))


def wardrobe(rng: Random) -> Shape:
    """Tall, with hinged or sliding doors, perhaps with a mirror or drawers below."""
    material, wood = wood_or_paint(rng)
    front = wood if rng.random() < 0.6 else wood_or_paint(rng)[1]
    doors = int(rng.integers(1, 5))
    w, d, h = doors * rng.uniform(0.44, 0.6), rng.uniform(0.5, 0.65), rng.uniform(1.8, 2.25)
    below = rng.uniform(0.3, 0.5) if rng.random() < 0.3 else 0.06
    parts = [
        box((0, 0, 0), (w, d, h), wood),
        *cabinet(
            wood,
            (w, d, h - 0.02),
            (1, doors),
            front,
            any_metal(rng),
            knobs=bool(rng.random() < 0.3),
            base=below,
        ),
    ]
    if below > 0.1:
        parts += cabinet(wood, (w, d, below), (1, max(1, doors // 2)), front, STEEL)
    if rng.random() < 0.3:
        i = int(rng.integers(doors))
        x, y = (i + 0.5 - doors / 2) * w / doors, -d / 2 - 0.018
        size = ((w / doors - 0.1), 0, 0)
        parts.append(
            flat_panel(
                (x - size[0] / 2, y, below + 0.1),
                size,
                (0, 0, h - below - 0.25),
                (0.74, 0.82, 0.87),
            )
        )
    if rng.random() < 0.3:
        parts.append(box((0, -0.01, h), (w + 0.06, d + 0.06, 0.06), wood))
    return Shape(material, parts)


def chest_of_drawers(rng: Random) -> Shape:
    """Waist-high, with rows of drawers."""
    material, wood = wood_or_paint(rng)
    front = wood if rng.random() < 0.7 else wood_or_paint(rng)[1]
    columns = int(rng.integers(1, 4))
    w = rng.uniform(0.5, 0.8) if columns == 1 else rng.uniform(0.9, 1.6)
    d, h, rows = rng.uniform(0.4, 0.52), rng.uniform(0.7, 1.15), int(rng.integers(3, 6))
    raised = rng.random() < 0.4
    parts = cabinet(
        wood,
        (w, d, h),
        (rows, columns),
        front,
        any_metal(rng),
        knobs=bool(rng.random() < 0.5),
        base=0.12 if raised else 0.0,
    )
    if raised:
        parts += legs(w, d, 0.12, 0.05, wood)
    parts.append(box((0, -0.01, h), (w + 0.03, d + 0.04, 0.025), wood))
    return Shape(material, parts)


def nightstand(rng: Random) -> Shape:
    """Knee-high, with drawers or an open compartment."""
    material, wood = wood_or_paint(rng)
    w, d, h = rng.uniform(0.38, 0.52), rng.uniform(0.36, 0.46), rng.uniform(0.42, 0.6)
    rows = int(rng.integers(1, 4))
    base = float(rng.choice([0.0, 0.12, h * 0.5]))
    parts = cabinet(
        wood,
        (w, d, h - 0.02),
        (rows if base < 0.2 else 1, 1),
        wood,
        any_metal(rng),
        knobs=bool(rng.random() < 0.5),
        base=base,
    )
    if base:
        parts += legs(w, d, base, 0.04, wood)
        if base > 0.2:
            parts.append(box((0, 0, 0.1), (w - 0.02, d - 0.02, 0.02), wood))
    parts.append(box((0, -0.01, h - 0.02), (w + 0.02, d + 0.03, 0.022), wood))
    return Shape(material, parts)


def tv_stand(rng: Random) -> Shape:
    """Low and wide, with doors, drawers or open compartments."""
    material, wood = wood_or_paint(rng)
    front = wood if rng.random() < 0.5 else wood_or_paint(rng)[1]
    w, d, h = rng.uniform(1.1, 1.9), rng.uniform(0.36, 0.5), rng.uniform(0.38, 0.6)
    t, base = 0.03, float(rng.choice([0.0, 0.06, 0.14]))
    parts: list[Part] = []
    if base:
        parts += legs(w - 0.1, d - 0.06, base, 0.05, wood, round_=base > 0.1)
    if rng.random() < 0.5:
        parts += cabinet(
            wood,
            (w, d, h),
            (int(rng.integers(1, 3)), int(rng.integers(2, 5))),
            front,
            any_metal(rng),
            base=base,
        )
    else:
        columns = int(rng.integers(2, 4))
        parts += [box((0, 0, z), (w, d, t), wood) for z in (base, base + (h - base) * 0.5, h - t)]
        parts += [
            box((x, 0, base), (t, d, h - base), wood)
            for x in np.linspace(-(w - t) / 2, (w - t) / 2, columns + 1)
        ]
        parts.append(box((0, d / 2 - 0.01, base), (w, 0.015, h - base), wood))
        parts.append(box((0, -0.02, base + t), (w / columns * 0.7, d * 0.7, 0.07), BLACK))
        if rng.random() < 0.6:
            for s in (-1, 1):
                x = s * (w / 2 - w / columns / 2)
                parts.append(
                    box((x, -d / 2, base + t), (w / columns - 0.03, 0.02, h - base - 2 * t), front)
                )
    parts.append(box((0, 0, h), (w + 0.02, d + 0.02, 0.02), wood))
    return Shape(material, parts)


def filing_cabinet(rng: Random) -> Shape:
    """Steel drawers for hanging files."""
    paint = shade(rng, pick(rng, (STEEL, (0.75, 0.72, 0.62), (0.3, 0.32, 0.35), *PAINTS[:3])))
    rows = int(rng.integers(2, 5))
    w, d, h = rng.uniform(0.38, 0.48), rng.uniform(0.5, 0.62), rows * rng.uniform(0.3, 0.34)
    parts = cabinet(paint, (w, d, h), (rows, 1), paint, any_metal(rng))
    for row in range(rows):
        z = 0.02 + (row + 0.72) * (h - 0.04) / rows
        parts.append(box((0, -d / 2 - 0.018, z), (0.09, 0.006, 0.045), (0.93, 0.93, 0.9)))
    return Shape("metal", parts)


def changing_table(rng: Random) -> Shape:
    """A chest with a raised rim and a soft mat for a baby."""
    material, wood = wood_or_paint(rng)
    w, d, h = rng.uniform(0.8, 1.25), rng.uniform(0.48, 0.6), rng.uniform(0.82, 0.95)
    if rng.random() < 0.7:
        parts = cabinet(
            wood, (w, d, h), (3, int(rng.integers(1, 3))), wood, any_metal(rng), knobs=True
        )
    else:
        parts = [
            *legs(w, d, h, 0.05, wood),
            *[box((0, 0, z), (w, d, 0.03), wood) for z in (0.15, 0.45, h - 0.03)],
        ]
    parts += [box((s * (w - 0.03) / 2, 0, h), (0.03, d, 0.13), wood) for s in (-1, 1)]
    parts.append(box((0, (d - 0.03) / 2, h), (w, 0.03, 0.13), wood))
    mat = any_paint(rng)
    parts.append(cushion((0, 0, h), (w * 0.85, d * 0.85, 0.06), mat, 0.3))
    parts += [
        cushion((0, s * d * 0.34, h + 0.02), (w * 0.85, 0.1, 0.08), mat, 0.6) for s in (-1, 1)
    ]
    return Shape(material, parts)


def bookshelf(rng: Random) -> Shape:
    """Shelves with books and boxes, with a back or without, some of the boards empty."""
    material, wood = wood_or_paint(rng)
    shelves = int(rng.integers(3, 7))
    w, d, h = rng.uniform(0.4, 1.5), rng.uniform(0.28, 0.4), shelves * rng.uniform(0.31, 0.4)
    columns = max(1, round(w / 0.75))
    t, step = 0.025, (h - 0.05) / shelves
    frame = rng.random() < 0.2
    parts: list[Part] = []
    if frame:
        stand = any_metal(rng)
        parts += legs(w, d, h, 0.03, stand)
    else:
        parts += [
            box((x, 0, 0), (t, d, h), wood)
            for x in np.linspace(-(w - t) / 2, (w - t) / 2, columns + 1)
        ]
    backed = not frame and rng.random() < 0.7
    if backed:
        parts.append(box((0, d / 2 - 0.01, 0), (w, 0.015, h), wood))
    fullness = rng.choice([0.35, 0.8, 1.0])
    for level in range(shelves + 1):
        z = 0.04 + level * step
        parts.append(box((0, 0, z - t), (w, d, t), wood))
        for column in range(columns) if level < shelves else ():
            if rng.random() < fullness:
                x0 = -w / 2 + column * w / columns + t
                parts += _row_of_books(rng, x0, w / columns - 2 * t, d, z, step - t)
    return Shape(material, parts)


def _row_of_books(
    rng: Random, x: float, width: float, depth: float, z: float, room: float
) -> list[Part]:
    """Books as one block with their spines in front, or as a few single ones, or a box."""
    kind = rng.random()
    y = -depth / 2 + rng.uniform(0.03, 0.08)
    if kind < 0.7:
        filled, tall = width * rng.uniform(0.55, 1.0), room * rng.uniform(0.68, 0.9)
        spines = patterns.books(rng.texture(rng.integers(40)))
        back = (filled, depth / 2 - y - 0.03)
        block = box((x + filled / 2, y + back[1] / 2, z), (*back, tall), (0.85, 0.82, 0.75))
        face = flat_panel((x, y - 0.002, z), (filled, 0, 0), (0, 0, tall), spines, tile=0)
        return [block, face]
    if kind < 0.88:
        parts, at = [], x
        while at < x + width * 0.6:
            thick = rng.uniform(0.02, 0.05)
            size = (thick - 0.002, depth * 0.65, room * rng.uniform(0.5, 0.88))
            parts.append(box((at + thick / 2, 0, z), size, any_paint(rng)))
            at += thick
        return parts
    size = (width * 0.6, depth * 0.8, room * rng.uniform(0.4, 0.75))
    return [box((x + width / 2, -0.01, z), size, any_paint(rng))]


def shelf(rng: Random) -> Shape:
    """Boards on a wall with things on them."""
    material, wood = wood_or_paint(rng)
    w, d, count = rng.uniform(0.6, 1.1), rng.uniform(0.18, 0.26), int(rng.integers(1, 4))
    parts: list[Part] = []
    for level in range(count):
        z = 0.12 + level * 0.34
        parts += [
            box((0, 0, z), (w, d, 0.028), wood),
            *[
                box((s * w * 0.35, d / 2 - 0.06, z - 0.11), (0.025, 0.1, 0.11), wood)
                for s in (-1, 1)
            ],
        ]
        x = -w / 2 + 0.04
        while x < w / 2 - 0.12:
            wide, tall = rng.uniform(0.02, 0.05), rng.uniform(0.14, 0.25)
            if rng.random() < 0.8:
                parts.append(
                    box((x + wide / 2, 0, z + 0.028), (wide - 0.002, d * 0.7, tall), any_paint(rng))
                )
            else:
                wide = 0.1
                parts.append(
                    turned(
                        [(0.03, 0), (0.045, 0.06), (0.02, 0.12), (0.03, 0.15)],
                        any_paint(rng),
                        (x + 0.05, 0, z + 0.028),
                        10,
                    )
                )
            x += wide + (rng.uniform(0.02, 0.25) if rng.random() < 0.25 else 0.0)
    low = min(float(part.vertices[:, 2].min()) for part in parts)
    return Shape(material, [shifted(part, (0, 0, -low)) for part in parts])


def folding_screen(rng: Random) -> Shape:
    """Three to five hinged panels of paper or cloth in frames."""
    frame, count = any_wood(rng), int(rng.integers(3, 5))
    w, h = rng.uniform(0.4, 0.5), rng.uniform(1.65, 1.9)
    fill: Surface = (0.92, 0.90, 0.84) if rng.random() < 0.6 else any_paint(rng)
    muntins = rng.random() < 0.6
    parts, x, y = [], -count * w * 0.45, 0.0
    for i in range(count):
        turn = 0.4 if i % 2 else -0.4
        leaf = [box((w / 2, 0, z), (w, 0.025, 0.05), frame) for z in (0.04, h - 0.05)]
        leaf += [box((at, 0, 0), (0.04, 0.025, h), frame) for at in (0.02, w - 0.02)]
        leaf.append(box((w / 2, 0, 0.05), (w - 0.04, 0.006, h - 0.08), fill))
        if muntins:
            leaf += [
                box((w / 2, 0, z), (w, 0.012, 0.012), frame) for z in np.linspace(0.3, h - 0.2, 6)
            ]
            leaf.append(box((w / 2, 0, 0.05), (0.012, 0.012, h - 0.1), frame))
        parts += [shifted(part, (x, y, 0), turn) for part in leaf]
        x, y = x + w * np.cos(turn), y + w * np.sin(turn)
    return Shape("wooden", parts)


def clothes_rack(rng: Random) -> Shape:
    """A rail on feet with clothes on hangers."""
    metal = any_metal(rng)
    w, h = rng.uniform(0.9, 1.3), rng.uniform(1.3, 1.65)
    parts: list[Part] = []
    for s in (-1, 1):
        x = s * w / 2
        parts += [
            rod((x, -0.22, 0.03), (x, 0.22, 0.03), 0.014, metal),
            rod((x, 0, 0.03), (x, 0, h), 0.014, metal),
        ]
        parts += [cylinder((x, y, 0), 0.025, 0.03, BLACK, segments=8) for y in (-0.21, 0.21)]
    parts += [rod((-w / 2, 0, z), (w / 2, 0, z), 0.013, metal) for z in (h, 0.12)]
    x = -w / 2 + 0.12
    while x < w / 2 - 0.12 and rng.random() < 0.93:
        drop, colour = rng.uniform(0.55, 0.95), any_paint(rng)
        parts.append(rod((x, 0, h), (x, 0, h - 0.08), 0.004, metal, segments=4))
        parts.append(cushion((x, 0, h - 0.08 - drop), (0.055, 0.42, drop), colour, 0.45, 6))
        x += rng.uniform(0.06, 0.16)
    return Shape("metal", parts)


def kitchen_cabinet(rng: Random) -> Shape:
    """A lower cabinet with a worktop."""
    material, front = wood_or_paint(rng)
    body = front if rng.random() < 0.6 else (0.9, 0.9, 0.88)
    columns = int(rng.integers(1, 4))
    w, d, h = columns * rng.uniform(0.4, 0.6), rng.uniform(0.56, 0.62), rng.uniform(0.82, 0.88)
    handle, knobs = any_metal(rng), bool(rng.random() < 0.4)
    parts = [box((0, 0.04, 0), (w, d - 0.1, 0.1), BLACK)]
    style = rng.integers(3)
    if style == 0:
        parts += cabinet(body, (w, d, h), (1, columns), front, handle, knobs=knobs, base=0.1)
    elif style == 1:
        parts += cabinet(
            body,
            (w, d, h),
            (int(rng.integers(3, 5)), columns),
            front,
            handle,
            knobs=knobs,
            base=0.1,
        )
    else:
        parts += cabinet(body, (w, d, h - 0.17), (1, columns), front, handle, knobs=knobs, base=0.1)
        upper = cabinet(body, (w, d, 0.19), (1, columns), front, handle, knobs=knobs)
        parts += [shifted(part, (0, 0, h - 0.19)) for part in upper]
    top = (
        patterns.wood(rng.texture(1), (0.6, 0.42, 0.25))
        if rng.random() < 0.3
        else shade(rng, pick(rng, WORKTOPS))
    )
    parts.append(box((0, -0.01, h), (w + 0.01, d + 0.03, rng.uniform(0.025, 0.045)), top))
    return Shape(material, parts)


def wall_cabinet(rng: Random) -> Shape:
    """An upper cabinet with doors, of glass now and then."""
    material, front = wood_or_paint(rng)
    columns = int(rng.integers(1, 4))
    w, d, h = columns * rng.uniform(0.34, 0.5), rng.uniform(0.3, 0.4), rng.uniform(0.55, 0.8)
    handle = any_metal(rng)
    if rng.random() < 0.65:
        parts = cabinet(
            front, (w, d, h), (1, columns), front, handle, knobs=bool(rng.random() < 0.5)
        )
        return Shape(material, parts)
    t = 0.02
    parts = [box((0, 0, z), (w, d, t), front) for z in (0, h / 3, 2 * h / 3, h - t)]
    parts += [box((s * (w - t) / 2, 0, 0), (t, d, h), front) for s in (-1, 1)]
    parts.append(box((0, d / 2 - 0.01, 0), (w, t, h), front))
    for i in range(columns):
        x, cw = (i + 0.5 - columns / 2) * w / columns, w / columns - 0.01
        y = -d / 2 - 0.01
        parts += [box((x, y, z), (cw, t, 0.05), front) for z in (0, h - 0.05)]
        parts += [box((x + s * (cw - 0.05) / 2, y, 0), (0.05, t, h), front) for s in (-1, 1)]
        parts.append(translucent(box((x, y, 0.04), (cw - 0.08, 0.006, h - 0.08), GLASS), 0.3))
    for level in range(3):
        for x in np.linspace(-w / 2 + 0.08, w / 2 - 0.08, 3):
            cup = cylinder((x, 0.02, t + level * h / 3), 0.03, 0.09, any_paint(rng), segments=8)
            parts.append(cup)
    return Shape(material, parts)


def kitchen_island(rng: Random) -> Shape:
    """A free-standing block of cabinets with an overhanging worktop."""
    material, body = wood_or_paint(rng)
    w, d, h = rng.uniform(0.9, 1.6), rng.uniform(0.6, 0.9), 0.88
    top = pick(rng, ((0.25, 0.25, 0.27), (0.85, 0.84, 0.82), (0.6, 0.42, 0.25), (0.7, 0.7, 0.72)))
    parts = cabinet(
        body, (w, d, h), (int(rng.integers(1, 3)), int(rng.integers(2, 4))), body, any_metal(rng)
    )
    parts.append(box((0, 0.08, h), (w + 0.1, d + 0.25, 0.04), shade(rng, top)))
    return Shape(material, parts)


def range_hood(rng: Random) -> Shape:
    """A hood: a canopy under a chimney, or a flat box, or a slanted sheet of glass."""
    metal = casing(rng) if rng.random() < 0.5 else STEEL
    w, d = rng.uniform(0.6, 1.0), rng.uniform(0.4, 0.5)
    kind = rng.random()
    if kind < 0.6:
        h, low = rng.uniform(0.2, 0.3), 0.05
        rows = [
            np.array(
                [
                    (-w / 2, -d / 2, low),
                    (w / 2, -d / 2, low),
                    (w / 2, d / 2, low),
                    (-w / 2, d / 2, low),
                    (-w / 2, -d / 2, low),
                ]
            )
        ]
        top = np.array(
            [(-0.14, 0, h), (0.14, 0, h), (0.14, d / 2, h), (-0.14, d / 2, h), (-0.14, 0, h)]
        )
        faces = [sheet(np.array([rows[0][i : i + 2], top[i : i + 2]]), metal) for i in range(4)]
        parts = [
            box((0, 0, 0), (w, d, low), metal),
            *faces,
            box((0, d / 4, h - 0.02), (0.28, d / 2, rng.uniform(0.3, 0.6)), metal),
        ]
    elif kind < 0.85:
        parts = [
            box((0, 0, 0), (w, d, 0.14), metal),
            box((0, -d / 2 - 0.004, 0.04), (w * 0.4, 0.01, 0.05), BLACK),
        ]
    else:
        plate = box((0, 0, 0), (w, 0.04, 0.45), BLACK)
        parts = [tilted(plate, (-1, 0, 0), -0.6), box((0, 0.12, 0.1), (0.3, 0.26, 0.6), metal)]
    parts += [
        box((x, -d / 2 - 0.004 if kind < 0.85 else -0.03, 0.015), (0.02, 0.01, 0.02), BLACK)
        for x in (0.1, 0.15, 0.2)
    ]
    return Shape("metal", parts)
