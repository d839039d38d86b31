"""Textures that are drawn once on a machine, and then found by what they were drawn from.

A texture depends on its function, on that function's arguments and on nothing else. Beside the
pictures, which are named by their content (`canvas.saved`), the user's cache has a small file for
each such call, with the picture's name. It is named by a digest of the call, of the sources of all
textures and of the libraries' versions, so that a change of any of them draws everything again.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ParamSpec

import cv2
import numpy as np

from sim_stubs.homes.textures.canvas import keep, texture_folder

P = ParamSpec("P")

_NAME = re.compile(r"[0-9a-f]{24}\.png")


def drawn_once(draw: Callable[P, Path]) -> Callable[P, Path]:
    """Have a function that draws a texture return the file of an earlier call like it, if any.

    Args:
        draw: Returns what `canvas.saved` does. Its arguments are numbers and colours, and None.
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
