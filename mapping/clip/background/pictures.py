"""The bank of pictures, which says how high similarities to a question go.

Encoders give some texts higher similarities than others, whatever a picture shows. How high those
of a question to these pictures go is one of the numbers that its evidence is made of
(`mapping.clip.places.evidence`). They are patches of simulated homes in which neither an encoder
was trained nor a belief fitted (`benchmarks.fast_world.picture_bank` draws them).
"""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("pictures.jpg")
EDGE = 96
"""Edge of a picture [px]."""
ACROSS = 16
"""Number of pictures in a row of the file."""
PICTURES_ID = sha256(FILE.read_bytes()).hexdigest()[:12]
"""Names the bank: embeddings of another one must not be taken for these."""


@cache
def bank() -> tuple[NDArray[np.uint8], ...]:
    """The pictures, RGB (EDGE, EDGE, 3)."""
    import cv2  # imported late, so that a refusal need not wait for it

    sheet = cv2.cvtColor(cv2.imread(str(FILE)), cv2.COLOR_BGR2RGB)
    rows = np.split(sheet, len(sheet) // EDGE)
    tiles = [tile for row in rows for tile in np.split(row, ACROSS, axis=1)]
    return tuple(np.ascontiguousarray(tile, np.uint8) for tile in tiles)
