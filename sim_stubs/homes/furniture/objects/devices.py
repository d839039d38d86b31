"""Procedural devices: screens, computers, clocks and others."""

from __future__ import annotations

from itertools import pairwise
from math import pi

from sim_stubs.homes.furniture.shapes.curved_solids import facing, rod, shifted, tilted, turned
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    STEEL,
    Random,
    Shape,
    any_metal,
    any_paint,
    any_white,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.solids import Part, Surface, box, cushion, cylinder, flat_panel
from sim_stubs.homes.textures import patterns

GREY = (0.35, 0.36, 0.38)


def printer(rng: Random) -> Shape:
    """A low box with paper in a tray."""
    body = shade(rng, pick(rng, (BLACK, GREY, (0.9, 0.9, 0.9), (0.82, 0.8, 0.74))))
    w, d, h = rng.uniform(0.38, 0.48), rng.uniform(0.3, 0.4), rng.uniform(0.16, 0.28)
    paper = tilted(
        box((0, d / 2 - 0.06, h - 0.03), (0.21, 0.008, 0.2), (0.95, 0.95, 0.95)),
        (-1, 0, 0),
        0.35,
        (0, d / 2 - 0.06, h),
    )
    parts = [
        cushion((0, 0, 0), (w, d, h), body, 0.12),
        box((0, 0, h - 0.012), (w * 0.94, d * 0.9, 0.02), shade(rng, body)),
        box((0, -d / 2, 0.04), (w * 0.7, 0.02, h * 0.35), BLACK),
        box((0, -d / 2 - 0.06, 0.035), (w * 0.62, 0.16, 0.012), GREY),
        box((0, -d / 2 - 0.05, 0.047), (0.21, 0.14, 0.008), (0.95, 0.95, 0.95)),
        paper,
        box((w * 0.3, -d / 2 + 0.02, h - 0.005), (0.1, 0.05, 0.02), (0.15, 0.3, 0.45)),
    ]
    return Shape("", parts)


def speaker(rng: Random) -> Shape:
    """A box with two or three round membranes."""
    body: Surface = pick(rng, (BLACK, BLACK, any_wood(rng), any_white(rng)))
    tall = rng.random() < 0.5
    w, h = rng.uniform(0.18, 0.26), rng.uniform(0.75, 1.1) if tall else rng.uniform(0.3, 0.5)
    d, cone = (
        w * rng.uniform(1.0, 1.3),
        shade(rng, pick(rng, ((0.2, 0.2, 0.22), (0.45, 0.45, 0.47), (0.75, 0.6, 0.2)))),
    )
    parts = [
        box((0, 0, 0), (w, d, h), body),
        box((0, -d / 2, 0.01), (w - 0.02, 0.008, h - 0.02), (0.12, 0.12, 0.13)),
    ]
    spots = [(0.25, 0.4), (0.52, 0.4), (0.82, 0.2)] if tall else [(0.36, 0.38), (0.8, 0.18)]
    for z, share in spots:
        r = share * w
        rim = facing(
            turned([(0, 0.0), (r, 0.0), (r, 0.015), (r * 0.85, 0.018)], STEEL), (0, -d / 2, z * h)
        )
        dish = facing(
            turned([(r * 0.85, 0.018), (r * 0.35, 0.004), (0, 0.012)], cone),
            (0, -d / 2 - 0.001, z * h),
        )
        parts += [rim, dish]
    return Shape("", parts)


def clock(rng: Random) -> Shape:
    """A round or square dial, in a house with a pendulum now and then."""
    rim: Surface = pick(rng, (any_wood(rng), any_metal(rng), any_paint(rng)))
    r, kind = rng.uniform(0.13, 0.2), rng.random()
    parts: list[Part] = []
    z = r
    if kind < 0.4:
        h = rng.uniform(0.5, 0.75)
        z = h - r * 1.1
        parts = [
            box((0, 0.05, 0.12), (2.3 * r, 0.1, h - 0.12), rim),
            box((0, 0.03, 0.0), (0.03, 0.02, 0.14), BLACK),
            cylinder((0, 0.03, 0.0), 0.045, 0.012, (0.7, 0.55, 0.2)),
            tilted(
                box((0.45 * r, 0.03, h - 0.02), (1.9 * r, 0.17, 0.025), rim),
                (0, 1, 0),
                0.6,
                (0, 0, h),
            ),
            tilted(
                box((-0.45 * r, 0.03, h - 0.02), (1.9 * r, 0.17, 0.025), rim),
                (0, -1, 0),
                0.6,
                (0, 0, h),
            ),
            *[
                rod((x, 0.02, 0.12), (x, 0.02, -0.05 + 0.05 * (x > 0)), 0.004, (0.7, 0.55, 0.2))
                for x in (-0.05, 0.05)
            ],
        ]
    square = rng.random() < 0.2
    plate: Surface = (0.94, 0.94, 0.92) if rng.random() < 0.8 else BLACK
    hand: Surface = (0.05, 0.05, 0.05) if plate != BLACK else (0.9, 0.9, 0.9)
    if square:
        parts += [
            box((0, 0, z - r), (2 * r, 0.03, 2 * r), rim),
            box((0, -0.016, z - 0.86 * r), (1.72 * r, 0.006, 1.72 * r), plate),
        ]
    else:
        parts += [
            facing(cylinder((0, 0, -0.02), r, 0.035, rim, segments=28), (0, 0, z)),
            facing(cylinder((0, 0, 0.012), r * 0.86, 0.006, plate, segments=28), (0, 0, z)),
        ]
    for k in range(12):
        mark = box((0, 0, r * 0.66), (0.012, 0.004, r * (0.14 if k % 3 == 0 else 0.07)), hand)
        parts.append(shifted(tilted(mark, (0, 1, 0), k * pi / 6), (0, -0.021, z)))
    for length, angle in ((0.6, rng.uniform(0, 6.28)), (0.42, rng.uniform(0, 6.28))):
        needle = box((0, 0, 0), (0.014, 0.004, r * length), hand)
        parts.append(shifted(tilted(needle, (0, 1, 0), angle), (0, -0.024, z)))
    low = min(float(part.vertices[:, 2].min()) for part in parts)
    return Shape("", [shifted(part, (0, 0, -low)) for part in parts])


def whiteboard(rng: Random) -> Shape:
    """A board on a stand with wheels, on an easel, or for the wall; written on now and then."""
    w, h = rng.uniform(0.9, 1.5), rng.uniform(0.7, 1.0)
    frame, low = any_metal(rng), 0.0
    parts: list[Part] = []
    kind = rng.random()
    if kind < 0.6:
        low = rng.uniform(0.45, 0.8)
        for s in (-1, 1):
            x = s * (w / 2 + 0.02)
            parts += [
                rod((x, 0.02, 0.05), (x, 0.02, low + h), 0.018, frame),
                rod((x, -0.25, 0.05), (x, 0.3, 0.05), 0.018, frame),
            ]
            parts += [cylinder((x, y, 0), 0.03, 0.05, BLACK, segments=8) for y in (-0.24, 0.29)]
        parts.append(rod((-w / 2, 0.02, 0.25), (w / 2, 0.02, 0.25), 0.014, frame))
    parts += [
        box((0, 0, low), (w, 0.025, h), frame),
        box((0, -0.012, low + 0.025), (w - 0.05, 0.012, h - 0.05), (0.95, 0.95, 0.95)),
        box((0, -0.05, low), (w * 0.5, 0.08, 0.012), frame),
    ]
    for _ in range(int(rng.integers(0, 7))):
        ink = pick(rng, ((0.1, 0.2, 0.7), (0.75, 0.1, 0.1), (0.05, 0.05, 0.05), (0.1, 0.5, 0.2)))
        x, z, long = (
            rng.uniform(-w * 0.3, w * 0.2),
            low + rng.uniform(0.15, 0.85) * h,
            rng.uniform(0.1, 0.4) * w,
        )
        parts.append(box((x, -0.019, z), (long, 0.002, 0.012), ink))
    return Shape("", parts)


def fire_extinguisher(rng: Random) -> Shape:
    """A red bottle with a hose."""
    red, h, r = shade(rng, (0.78, 0.08, 0.08)), rng.uniform(0.38, 0.5), rng.uniform(0.07, 0.09)
    hose = [
        (0.02, 0, h + 0.06),
        (r + 0.05, 0, h + 0.02),
        (r + 0.05, 0, h * 0.5),
        (r + 0.02, -0.02, h * 0.2),
    ]
    parts = [
        turned([(0, 0), (r, 0.0), (r, h * 0.85), (r * 0.7, h * 0.96), (0.02, h)], red),
        cylinder((0, 0, h), 0.022, 0.06, BLACK),
        box((-0.03, 0, h + 0.04), (0.15, 0.02, 0.02), BLACK),
        box((-0.03, 0, h + 0.08), (0.15, 0.02, 0.015), BLACK),
        *[rod(a, b, 0.012, BLACK, segments=6) for a, b in pairwise(hose)],
        box((0, -r, h * 0.35), (r * 1.1, 0.012, h * 0.3), (0.93, 0.93, 0.88)),
    ]
    return Shape("metal", parts)


def any_screen(rng: Random) -> Surface:
    """A picture of a screen, which is mostly off."""
    kind = rng.random()
    if kind < 0.65:
        return shade(rng, pick(rng, ((0.03, 0.03, 0.035), (0.10, 0.11, 0.13), (0.16, 0.18, 0.2))))
    return (
        patterns.outdoors(rng.texture(rng.integers(9)))
        if kind < 0.85
        else patterns.painting(rng.texture(rng.integers(30)))
    )


def tv(rng: Random) -> Shape:
    """A flat television on a foot or two, or for the wall; seldom an old one with a tube."""
    if rng.random() < 0.12:
        return _tube_tv(rng)
    frame = shade(rng, pick(rng, (BLACK, BLACK, BLACK, GREY, STEEL, (0.9, 0.9, 0.9))))
    w = rng.uniform(0.6, 1.35)
    h, rim, t = w * rng.uniform(0.56, 0.62), rng.uniform(0.012, 0.045), rng.uniform(0.03, 0.07)
    style = rng.integers(4)
    lift = 0.0 if style == 3 else rng.uniform(0.05, 0.12)
    parts = [box((0, 0, lift), (w, t, h), frame)]
    if rng.random() < 0.4:
        parts.append(box((0, t / 2 + 0.02, lift + h * 0.15), (w * 0.6, 0.05, h * 0.6), BLACK))
    if rng.random() < 0.3:
        parts.append(box((0, -t / 2 - 0.002, lift), (w, 0.006, rng.uniform(0.02, 0.06)), GREY))
    bottom = lift + rim * rng.uniform(1.0, 2.5)
    face = flat_panel(
        (-w / 2 + rim, -t / 2 - 0.006, bottom),
        (w - 2 * rim, 0, 0),
        (0, 0, lift + h - rim - bottom),
        any_screen(rng),
        tile=0,
    )
    parts.append(face)
    if style == 0:
        parts += [
            box((0, 0, 0), (w * rng.uniform(0.3, 0.55), 0.24, 0.018), frame),
            box((0, 0.02, 0.01), (0.09, 0.03, lift), frame),
        ]
    elif style == 1:
        parts += [
            cylinder((0, 0, 0), 0.15, 0.018, frame, segments=24),
            cylinder((0, 0, 0.01), 0.03, lift, frame),
        ]
    elif style == 2:
        for s in (-1, 1):
            parts += [
                rod((s * w * 0.32, 0, lift + 0.01), (s * w * 0.36, y, 0.008), 0.009, frame)
                for y in (-0.12, 0.12)
            ]
    return Shape("", parts)


def _tube_tv(rng: Random) -> Shape:
    body: Surface = pick(rng, (shade(rng, BLACK), shade(rng, STEEL), any_wood(rng)))
    w = rng.uniform(0.45, 0.75)
    h = w * 0.82
    parts = [
        box((0, -0.02, 0), (w, 0.16, h), body),
        cushion((0, 0.14, 0.03), (w * 0.85, 0.36, h * 0.85), body, 0.4),
        facing(
            cushion((0, 0, -0.05), (w * 0.78, h * 0.68, 0.09), any_screen(rng), 0.25),
            (0, -0.09, h * 0.55),
        ),
        *[
            facing(cylinder((0, 0, 0), 0.015, 0.02, GREY, segments=8), (x, -0.1, h * 0.08))
            for x in (-0.08, 0.0, 0.08)
        ],
    ]
    if rng.random() < 0.5:
        parts += [
            rod((0, 0.05, h), (s * 0.22, 0.05, h + 0.3), 0.004, STEEL, segments=4) for s in (-1, 1)
        ]
    return Shape("", parts)


def computer(rng: Random) -> Shape:
    """A screen with keyboard and mouse, a case beside it now and then; or all in one old one."""
    if rng.random() < 0.2:
        return _tube_computer(rng)
    frame = shade(rng, pick(rng, (BLACK, STEEL, (0.9, 0.9, 0.9))))
    w = rng.uniform(0.42, 0.62)
    h, lift = w * rng.uniform(0.58, 0.7), rng.uniform(0.08, 0.14)
    chin = 0.06 if rng.random() < 0.4 else 0.015
    screen: Surface = pick(
        rng,
        (
            any_screen(rng),
            patterns.painting(rng.texture(rng.integers(9))),
            (0.15, 0.35, 0.65),
            (0.88, 0.89, 0.9),
        ),
    )
    parts = [
        box((0, 0.08, lift), (w, 0.03, h), frame),
        flat_panel(
            (-w / 2 + 0.015, 0.063, lift + chin),
            (w - 0.03, 0, 0),
            (0, 0, h - chin - 0.015),
            screen,
            tile=0,
        ),
        box((0, 0.11, 0.0), (0.06, 0.02, lift + 0.1), frame),
        box((0, 0.09, 0), (0.22, 0.18, 0.012), frame)
        if rng.random() < 0.5
        else cylinder((0, 0.09, 0), 0.11, 0.012, frame),
        *_keyboard(rng, frame),
    ]
    if rng.random() < 0.45:
        x, tall = w / 2 + 0.16, rng.uniform(0.36, 0.44)
        parts += [
            box((x, 0.05, 0), (0.18, 0.4, tall), frame),
            box((x, -0.152, tall - 0.09), (0.14, 0.006, 0.035), GREY),
            box((x, -0.152, tall - 0.2), (0.03, 0.006, 0.03), STEEL),
        ]
    return Shape("", parts)


def _keyboard(rng: Random, frame: Surface) -> list[Part]:
    keys: Surface = (0.2, 0.2, 0.22) if frame == BLACK else (0.85, 0.85, 0.86)
    parts = [
        box((0, -0.17, 0), (0.43, 0.14, 0.015), frame),
        cushion((0.29, -0.17, 0), (0.06, 0.1, 0.035), frame, 0.6, 6),
    ]
    parts += [box((0, -0.215 + 0.03 * row, 0.015), (0.4, 0.022, 0.008), keys) for row in range(4)]
    return parts


def _tube_computer(rng: Random) -> Shape:
    body = pick(rng, (shade(rng, (0.82, 0.79, 0.70)), any_paint(rng), any_white(rng)))
    w = rng.uniform(0.36, 0.42)
    parts = [
        cushion((0, 0.02, 0.03), (w, 0.14, w), body, 0.2),
        cushion((0, 0.18, 0.05), (w * 0.9, 0.36, w * 0.85), body, 0.45),
        box((0, 0.02, 0), (w * 0.6, 0.2, 0.04), body),
        facing(
            cushion((0, 0, -0.03), (w * 0.78, w * 0.6, 0.05), (0.12, 0.16, 0.18), 0.2),
            (0, -0.04, 0.03 + w * 0.56),
        ),
        *_keyboard(rng, body),
    ]
    return Shape("", parts)


def laptop(rng: Random) -> Shape:
    """Open, its lid leaning back."""
    body = shade(rng, pick(rng, (BLACK, STEEL, STEEL, (0.9, 0.9, 0.9), GREY)))
    w, d = rng.uniform(0.28, 0.4), rng.uniform(0.2, 0.27)
    h = d * rng.uniform(0.85, 1.0)
    screen: Surface = pick(
        rng, (any_screen(rng), (0.15, 0.35, 0.65), patterns.painting(rng.texture(rng.integers(9))))
    )
    lid = [
        box((0, d / 2, 0.015), (w, 0.012, h), body),
        flat_panel(
            (-w / 2 + 0.015, d / 2 - 0.008, 0.035),
            (w - 0.03, 0, 0),
            (0, 0, h - 0.04),
            screen,
            tile=0,
        ),
    ]
    keys: Surface = (0.12, 0.12, 0.13) if rng.random() < 0.6 else (0.8, 0.8, 0.82)
    parts = [
        box((0, 0, 0), (w, d, 0.02), body),
        box((0, -d * 0.33, 0.02), (w * 0.3, d * 0.2, 0.002), GREY),
    ]
    parts += [
        box((0, -d * 0.12 + row * d * 0.12, 0.02), (w * 0.9, d * 0.09, 0.003), keys)
        for row in range(4)
    ]
    parts += [tilted(part, (-1, 0, 0), rng.uniform(0.15, 0.45), (0, d / 2, 0.015)) for part in lid]
    return Shape("", parts)
