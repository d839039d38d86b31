"""Fits the numbers that come along: `python -m benchmarks.encoder.fit KIND FOLDER`.

`known` serves every encoder that nothing was fitted to and that tells its scale and bias, `unknown`
one that does not. So they are fitted to several encoders at once: to the embedded one, to what it
would be if it were weaker, and to the classes of photographs. `embedded` is for the embedded one,
and fitted to it alone. Homes are training homes that neither the embedded encoder nor its threshold
has seen, on the walks of the list of views. FOLDER keeps the views. With `--without` the numbers
are fitted to less, to see what the rest is worth.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchmarks.encoder.weak_encoder import WeakEncoder
from benchmarks.episodes.run import encoder_of
from benchmarks.harness.workers import in_parallel
from mapping.clip.places.evidence import EMBEDDED_FILE, UNKNOWN_SCALE_FILE, WEIGHTS_FILE
from mapping.clip.scores import Background
from vizbot.config import Config
from vizbot.operator.printing import echo
from vizbot.rehearsal.belief_fit.calibration import along_the_views, shown_in
from vizbot.rehearsal.belief_fit.fit import Omission, fitted
from vizbot.rehearsal.belief_fit.seen_home import SeenHome, ShownPlaces, seen_in
from vizbot.rehearsal.belief_fit.view_list import OWN_HOMES, ListedHome

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

Job = tuple[str, int, Path]
"""An encoder, the seed of a home, and the folder of the views."""


class Kind(StrEnum):
    """Whom the numbers are for."""

    KNOWN, UNKNOWN, EMBEDDED = "known", "unknown", "embedded"

    @property
    def encoders(self) -> tuple[str, ...]:
        """The encoders that they are fitted to."""
        return ("embedded",) if self is Kind.EMBEDDED else ("embedded", "photos")

    @property
    def file(self) -> Path:
        """Where they are kept."""
        files = {Kind.UNKNOWN: UNKNOWN_SCALE_FILE, Kind.EMBEDDED: EMBEDDED_FILE}
        return files.get(self, WEIGHTS_FILE)


def see_home(job: Job) -> ShownPlaces:
    """Take the views of a home that an encoder has to see, or read them."""
    clip, seed, folder = job
    encoder = encoder_of(Config(clip=clip))
    return shown_in(ListedHome(str(seed)), encoder, folder / encoder.model_id)


def ask_all(shown: Mapping[Job, ShownPlaces], kind: Kind) -> list[SeenHome]:
    """What each encoder says of each home, with its scale and bias or without."""
    homes = []
    for clip in kind.encoders:
        own = encoder_of(Config(clip=clip))
        seen = [each for job, each in shown.items() if job[0] == clip]
        homes += _ask(seen, own, kind)
        if clip == "embedded" and kind is not Kind.EMBEDDED:
            weak = WeakEncoder(own)
            noisy = (weak.embeddings_of_pictures(each.embeddings) for each in seen)
            less = [replace(each, embeddings=of) for each, of in zip(seen, noisy, strict=True)]
            homes += _ask(less, weak, kind)
    return homes


def _ask(shown: Sequence[ShownPlaces], encoder: ClipEncoder, kind: Kind) -> list[SeenHome]:
    background = Background.embedded_by(encoder)
    log_odds = None if kind is Kind.UNKNOWN else encoder.log_odds
    return [seen_in(each, encoder, background, log_odds) for each in shown]


def fit(
    kind: Annotated[Kind, typer.Argument(help="Whom the numbers are for.")],
    folder: Annotated[Path, typer.Argument(help="Where views are kept.")],
    out: Annotated[Path | None, typer.Option(help="Another file for them.")] = None,
    without: Annotated[Omission | None, typer.Option(help="What to fit them without.")] = None,
) -> None:
    """Fit the numbers of the belief and write them."""
    jobs = [(clip, seed, folder) for clip in kind.encoders for seed in OWN_HOMES]
    taken = dict(in_parallel(see_home, jobs, "views", lambda job, _: f"{job[0]}, home {job[1]}"))
    homes = ask_all({job: taken[job] for job in jobs}, kind)
    weights = fitted(homes, without, along_the_views)
    content = {
        "made_by": f"python -m benchmarks.encoder.fit {kind}",
        **({} if without is None else {"without": without}),
        "encoders": [encoder_of(Config(clip=clip)).model_id for clip in kind.encoders],
        "homes": list(OWN_HOMES),
        "near": weights.near.round(5).tolist(),
        "far": weights.far.round(5).tolist(),
        "join": weights.join.round(5).tolist(),
    }
    written = out or kind.file
    written.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    echo(f"written: {written}", err=True)


if __name__ == "__main__":
    typer.run(fit)
