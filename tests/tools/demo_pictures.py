"""Makes the film and the picture on the README's top from a run of the demo.

`make demo`, then `python -m tests.tools.demo_pictures runs/TIME`. The film is the run's own video
as an animation that pages show without a player; the picture is its end. Look at both before they
are kept.
"""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path
from typing import Annotated

import av
import typer
from PIL import Image

from tests.helpers.checkout import ROOT

PICTURES = ROOT / "docs" / "pictures"
MOST_BYTES = 1_000_000
HELD = 3.0
"""How long the film shows the end of the run before it begins anew [s]."""
_QUALITIES = range(80, 10, -10)


def main(
    run: Annotated[Path, typer.Argument(help="The folder that `make demo` has named.")],
    folder: Annotated[Path, typer.Argument(help="Where both are left.")] = PICTURES,
) -> None:
    """Make both, and say how large they are."""
    require_demo(run)
    with av.open(str(run / "run.webm")) as video:
        pictures = [frame.to_image() for frame in video.decode(video=0)]
        rate = video.streams.video[0].average_rate
    assert rate is not None
    pictures[-1].save(folder / "run.png", optimize=True)
    (folder / "run.webp").write_bytes(film(pictures, float(rate)))
    for name in ("run.png", "run.webp"):
        typer.echo(f"{name:10} {(folder / name).stat().st_size:8} bytes")


def require_demo(run: Path) -> None:
    """Refuse what is no run of the demo as the Makefile has it, or did not reach the goal."""
    metrics = json.loads((run / "metrics.json").read_text())
    texts = " ".join(f'"{goal["text"]}"' for goal in metrics["goals"])
    command = f"vizbot dry-run {texts} --world {metrics.get('world')}"
    if f"{command}\n" not in (ROOT / "Makefile").read_text():
        raise SystemExit(f"{run} is no run of the demo but of: {command}; run `make demo`")
    if not metrics["success"]:
        raise SystemExit(f"the run in {run} did not reach the goal; the README shows none such")


def film(pictures: list[Image.Image], rate: float) -> bytes:
    """An animated WebP that is played again and again, as good as its size allows."""
    durations = [round(1000 / rate)] * (len(pictures) - 1) + [round(1000 * HELD)]
    for quality in _QUALITIES:
        content = BytesIO()
        pictures[0].save(
            content, "WEBP", save_all=True, append_images=pictures[1:], duration=durations,
            loop=0, quality=quality, method=4,
        )  # fmt: skip
        if content.tell() <= MOST_BYTES:
            return content.getvalue()
    raise SystemExit(f"the film of {len(pictures)} pictures is larger than {MOST_BYTES} bytes")


if __name__ == "__main__":
    typer.run(main)
