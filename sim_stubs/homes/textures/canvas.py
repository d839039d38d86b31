"""The canvas of textures, and the PNG files that they become, drawn once on a machine.

A texture depends on its function, on that function's arguments and on nothing else. Beside the
pictures, which are named by their content (`saved`), the user's cache has a small file for each
call, with the picture's name. It is named by a digest of the call, of the sources of all textures
and of the libraries' versions, so that a change of any of them draws everything again.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import ParamSpec

import cv2
import numpy as np
from numpy.typing import NDArray

from vizbot.core.files import user_folder

Colour = Sequence[float] | NDArray[np.float64]
"""Red, green, blue in [0, 1]."""
Image = NDArray[np.float32]
"""(H, W, 3) red, green, blue in [0, 1], or (H, W) of one value a pixel."""

P = ParamSpec("P")

SIDE = 512
"""Edge of most textures [px]."""
_NAME = re.compile(r"[0-9a-f]{24}\.png")


def plain_square(colour: Colour) -> Image:
    """A square of one colour."""
    return np.full((SIDE, SIDE, 3), np.asarray(colour, np.float32), np.float32)


def clouds(rng: np.random.Generator) -> Image:
    """Smooth noise at three scales, about -1 to 1, that wraps around."""
    total = np.zeros((SIDE, SIDE), np.float32)
    for size, weight in ((8, 0.6), (24, 0.35), (80, 0.2)):
        coarse = rng.uniform(-1, 1, (size, size)).astype(np.float32)
        padded = np.pad(coarse, 2, mode="wrap")
        scale = SIDE / size
        fine = cv2.resize(padded, None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
        margin = round(2 * scale)
        total += weight * fine[margin : margin + SIDE, margin : margin + SIDE]
    return total


def grain(rng: np.random.Generator, depth: float) -> Image:
    """Factor of about 1 with streaks along the rows."""
    noise = rng.normal(0.0, 1.0, (SIDE, SIDE // 16)).astype(np.float32)
    streaks = cv2.resize(noise, (SIDE, SIDE), interpolation=cv2.INTER_LINEAR)
    return np.asarray(np.clip(1 + depth * 0.5 * streaks, 0.4, 1.4), np.float32)


def wrapped_ellipse(
    image: Image,
    centre: tuple[int, int],
    axes: tuple[int, int],
    angle: float,
    colour: Colour,
) -> None:
    """An ellipse that goes on at the other side where it crosses an edge."""
    for dx in (-SIDE, 0, SIDE):
        for dy in (-SIDE, 0, SIDE):
            at = (int(centre[0]) + dx, int(centre[1]) + dy)
            cv2.ellipse(image, at, axes, angle, 0, 360, tuple(colour), -1, cv2.LINE_AA)


def texture_folder() -> Path:
    """Folder of the textures in the user's cache."""
    return user_folder("XDG_CACHE_HOME", ".cache") / "textures"


def saved(image: NDArray[np.floating]) -> Path:
    """PNG file of an (H, W, 3) RGB image in [0, 1], in the user's cache, named by its content."""
    rgb = np.clip(image * 255, 0, 255).astype(np.uint8)
    path = texture_folder() / f"{hashlib.sha256(rgb.tobytes()).hexdigest()[:24]}.png"
    if not path.exists():
        encoded, png = cv2.imencode(".png", np.ascontiguousarray(rgb[..., ::-1]))
        assert encoded
        keep(path, png.tobytes())
    return path


def keep(path: Path, content: bytes) -> None:
    """Write a file of the cache, whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # Another process may draw the same texture: each writes its own file and renames it.
    scratch = path.with_suffix(f".{os.getpid()}")
    scratch.write_bytes(content)
    scratch.replace(path)


def drawn_once(draw: Callable[P, Path]) -> Callable[P, Path]:
    """Have a function that draws a texture return the file of an earlier call like it, if any.

    Args:
        draw: Returns what `saved` does. Its arguments are numbers and colours, and None.
    """

    @functools.wraps(draw)
    def found_or_drawn(*args: P.args, **kwargs: P.kwargs) -> Path:
        call = repr((_drawing(), draw.__module__, draw.__name__, _plain(args), _plain(kwargs)))
        note = texture_folder() / "drawn" / hashlib.sha256(call.encode()).hexdigest()[:24]
        path = _noted(note)
        if path is None:
            with _in_stripes():
                path = draw(*args, **kwargs)
            keep(note, path.name.encode())
        return path

    return found_or_drawn


@contextmanager
def _in_stripes() -> Iterator[None]:
    """Have OpenCV work in several threads, which gives other last bits than one thread does.

    However many there are, they share the same stripes of a picture.
    """
    threads = cv2.getNumThreads()
    cv2.setNumThreads(2)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _noted(note: Path) -> Path | None:
    """The picture that a note names; None without one, or where either is torn."""
    try:
        name = note.read_text(encoding="ascii")
    except (OSError, ValueError):
        return None
    path = texture_folder() / name
    return path if _NAME.fullmatch(name) and path.is_file() else None


def _plain(value: object) -> object:
    """A key of a call, which differs where any bit of its numbers does."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, tuple | list | np.ndarray):
        return [_plain(each) for each in value]
    return value if value is None else float(value).hex()  # type: ignore[arg-type]


@functools.cache
def _drawing() -> str:
    """Digest of all that textures are drawn by."""
    digest = hashlib.sha256(f"{np.__version__} {cv2.__version__}".encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()
