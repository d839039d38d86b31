"""Draws the bank of pictures: `python -m benchmarks.fast_world.picture_bank`.

Patches as the CLIP mapper cuts them, of training homes that neither the encoder nor its threshold
nor the belief has seen. Places, headings and patches are drawn by the home's seed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import typer
from numpy.typing import NDArray

from benchmarks.episodes.homes import open_benchmark_home
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.harness.workers import in_parallel
from mapping.clip.background.pictures import ACROSS, EDGE, FILE
from mapping.clip.patches import patch_boxes
from vizbot.core.files import write_whole
from vizbot.operator.printing import echo
from vizbot.rehearsal.belief_fit.places import Places
from vizbot.rehearsal.belief_fit.views import HEADINGS

HOMES = range(400, 432)
"""Training homes that nothing else uses."""
OF_HOME = 8
"""Pictures of each."""
_QUALITY = 92


def pictures_of(seed: int) -> list[NDArray[np.uint8]]:
    """Pictures (EDGE, EDGE, 3), RGB, of the home of this seed, each from another place."""
    rng = np.random.default_rng(seed)
    config = UNATTENDED.perception.clip_mapper
    with open_benchmark_home(seed, UNATTENDED) as world:
        places, pictures = Places.in_world(world).xy, []
        for place in rng.permutation(len(places))[:OF_HOME]:
            x, y = places[place].tolist()
            world.place(x, y, int(rng.integers(HEADINGS)) * 2 * np.pi / HEADINGS)
            image, _ = world.render()
            boxes = patch_boxes(image.shape[1], image.shape[0], config)
            u0, v0, u1, v1 = boxes[rng.integers(len(boxes))]
            patch = cv2.resize(image[v0:v1, u0:u1], (EDGE, EDGE), interpolation=cv2.INTER_AREA)
            pictures.append(np.asarray(patch, np.uint8))
    return pictures


def draw(
    out: Annotated[Path, typer.Option(help="The file of the pictures.")] = FILE,
) -> None:
    """Draw the pictures and write them, side by side."""
    found = dict(in_parallel(pictures_of, HOMES, "pictures", lambda seed, _: f"home {seed}"))
    tiles = [picture for seed in HOMES for picture in found[seed]]
    rows = [np.hstack(tiles[i : i + ACROSS]) for i in range(0, len(tiles), ACROSS)]
    sheet = cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR)
    write_whole(out, bytes(cv2.imencode(".jpg", sheet, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1]))
    echo(f"written: {out}", err=True)


if __name__ == "__main__":
    typer.run(draw)
