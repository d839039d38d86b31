"""Procedural televisions and computers."""

from __future__ import annotations

from sim_stubs.homes.furniture.shapes.curved_solids import facing, rod, tilted
from sim_stubs.homes.furniture.shapes.materials import (
    BLACK,
    STEEL,
    Random,
    Shape,
    any_paint,
    any_white,
    any_wood,
    pick,
    shade,
)
from sim_stubs.homes.geometry.piece import Part
from sim_stubs.homes.geometry.solids import Surface, box, cushion, cylinder, flat_panel
from sim_stubs.homes.textures import patterns

GREY = (0.35, 0.36, 0.38)


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
