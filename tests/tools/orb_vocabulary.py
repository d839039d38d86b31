"""A vocabulary for ORB-SLAM3 from the images of recordings, where its own can't be fetched.

    python -m tests.tools.orb_vocabulary OUT.txt SEQUENCE...

Written in the text format of DBoW2 (Galvez-Lopez and Tardos 2012): the branching factor, depth,
scoring and weighting, then a line for each node: its parent, whether it is a leaf, its 32 bytes and
its weight. Nodes are found by k-medians in Hamming space; weights are inverse document frequencies.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

BRANCHES, DEPTH, ROUNDS = 10, 4, 6
FEATURES = 600
"""Features of an image."""

Bytes = NDArray[np.uint8]


def main() -> None:
    out, *sequences = map(Path, sys.argv[1:])
    images = sorted(path for folder in sequences for path in (folder / "rgb").iterdir())
    detector = cv2.ORB.create(nfeatures=FEATURES)
    found = []
    for path in images:
        grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        assert grey is not None, path
        found.append(detector.detectAndCompute(grey, np.empty(0, np.uint8))[1])
    descriptors = np.concatenate(found)
    of_image = np.repeat(np.arange(len(found)), [len(each) for each in found])
    lines = [f"{BRANCHES} {DEPTH} 0 0"]
    _grow(descriptors, of_image, 0, DEPTH, lines, len(found), np.random.default_rng(0))
    out.write_text("\n".join(lines) + "\n")
    sys.stdout.write(
        f"{len(lines) - 1} nodes of {len(descriptors)} features in {len(images)} images: {out}\n"
    )


def _grow(
    descriptors: Bytes,
    of_image: NDArray[np.int64],
    parent: int,
    levels: int,
    lines: list[str],
    images: int,
    rng: np.random.Generator,
) -> None:
    """Add the nodes below `parent`, in the order of their numbers: each before what is below it."""
    centres, nearest = _k_medians(descriptors, rng)
    for i, centre in enumerate(centres):
        inside = nearest == i
        leaf = levels == 1 or inside.sum() <= BRANCHES
        weight = np.log(images / max(1, len(np.unique(of_image[inside])))) if leaf else 0.0
        lines.append(f"{parent} {int(leaf)} {' '.join(map(str, centre))} {weight:.6f}")
        if not leaf:
            number = len(lines) - 1
            _grow(descriptors[inside], of_image[inside], number, levels - 1, lines, images, rng)


def _k_medians(descriptors: Bytes, rng: np.random.Generator) -> tuple[Bytes, NDArray[np.int64]]:
    count = min(BRANCHES, len(descriptors))
    centres = descriptors[rng.choice(len(descriptors), count, replace=False)]
    bits = np.unpackbits(descriptors, axis=1).astype(np.float32)
    nearest = np.zeros(len(descriptors), np.int64)
    for _ in range(ROUNDS):
        of_centres = np.unpackbits(centres, axis=1).astype(np.float32)
        apart = bits.sum(1)[:, None] + of_centres.sum(1) - 2 * bits @ of_centres.T
        nearest = apart.argmin(axis=1)
        for i in range(count):
            if (nearest == i).any():
                centres[i] = np.packbits(bits[nearest == i].mean(axis=0) >= 0.5)
    return centres, nearest


if __name__ == "__main__":
    main()
