"""Fits the numbers that come along: `python -m benchmarks.fast_world.fit FOLDER`.

In training homes that neither the embedded encoder nor its threshold has seen, views are taken from
places drawn by the home's seed, at every heading. FOLDER keeps the views. With `--without` the
numbers are fitted to less, to see what the rest is worth.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from benchmarks.episodes.run import encoder_of
from benchmarks.fast_world.walk import FastHome
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.harness.workers import in_parallel
from mapping.clip.evidence import WEIGHTS_FILE
from mapping.clip.scores import Background
from vizbot.operator.printing import echo
from vizbot.rehearsal.belief_fit.fit import Omission, fitted
from vizbot.rehearsal.belief_fit.seen_home import SeenHome, seen_in, shown_from, spread_stations
from vizbot.rehearsal.belief_fit.view_list import OWN_HOMES

_PLACES = 80
"""Number of places in a home that views are taken from."""


def see_home(job: tuple[int, Path]) -> SeenHome:
    """Take the views of a home, or read them."""
    seed, folder = job
    with FastHome(seed, UNATTENDED, encoder_of(UNATTENDED), folder) as home:
        shown = shown_from(home.views, home.places, spread_stations(home.places, seed, _PLACES))
        background = Background.embedded_by(home.encoder)
        return seen_in(shown, home.encoder, background, home.encoder.log_odds)


def fit(
    folder: Annotated[Path, typer.Argument(help="Where views are kept.")],
    out: Annotated[Path, typer.Option(help="The file of the numbers.")] = WEIGHTS_FILE,
    without: Annotated[Omission | None, typer.Option(help="What to fit them without.")] = None,
) -> None:
    """Fit the numbers of the belief and write them."""
    jobs = [(seed, folder) for seed in OWN_HOMES]
    seen = dict(in_parallel(see_home, jobs, "views", lambda job, _: f"home {job[0]}"))
    weights = fitted([seen[job] for job in jobs], without)
    content = {
        "made_by": "python -m benchmarks.fast_world.fit",
        **({} if without is None else {"without": without}),
        "encoder": encoder_of(UNATTENDED).model_id,
        "homes": list(OWN_HOMES),
        "near": weights.near.round(5).tolist(),
        "far": weights.far.round(5).tolist(),
        "join": weights.join.round(5).tolist(),
    }
    out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    echo(f"written: {out}", err=True)


if __name__ == "__main__":
    typer.run(fit)
