"""`vizbot bench encoder --families`: what an encoder costs that no number was fitted to.

The belief's weights are fitted to all families of encoders but one, in our homes of the list of
views, and judged by that one in other homes. A family is an encoder and its older versions, each as
it is and weaker, to which is fitted, and with its cosines scaled, shifted and off by text and by
pair. Encoders that tell scale and bias and those that do not have weights of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.encoder.weak_encoder import WeakEncoder
from benchmarks.episodes.other_encoders import OtherEncoder
from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_settings, key_of_sources
from benchmarks.harness.store import Store
from benchmarks.harness.tables import markdown_table
from benchmarks.harness.workers import in_parallel
from mapping.clip.places.evidence import Weights, shipped_weights
from mapping.clip.scores import Background
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.rehearsal.belief_fit.calibration import (
    along_the_views,
    fitted_to_walks,
    reliability_of,
    shown_in,
)
from vizbot.rehearsal.belief_fit.cosine_fit import fit_cosines
from vizbot.rehearsal.belief_fit.fit import believed, fitted
from vizbot.rehearsal.belief_fit.seen_home import SeenHome, ShownPlaces, seen_in
from vizbot.rehearsal.belief_fit.view_list import OWN_HOMES, ListedHome, require_simulator
from vizbot.rig import require_encoder

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import ClipEncoder

NAME = "encoder --families"
FAMILIES_FILE = "families.jsonl"
"""Where tables are kept."""
JUDGED = range(932, 938)
"""Training homes that judge: no encoder, threshold or number of the belief has seen them."""
_SOURCES = ("sim_stubs", "mapping/clip", "vizbot/rehearsal/belief_fit")
"""Sources that can change a view."""


@dataclass(frozen=True, slots=True)
class FamiliesBench:
    """What is compared.

    Attributes:
        families: Settings of the robot with each encoder of each family; two families at least.
        fitted: Homes to fit in.
        judged: Homes to judge in.
        folder: Folder of the results.
    """

    families: tuple[tuple[Config, ...], ...]
    fitted: tuple[ListedHome, ...]
    judged: tuple[ListedHome, ...]
    folder: Path


@dataclass(frozen=True, slots=True)
class Judged:
    """How well weights fit an encoder.

    Attributes:
        log_loss: Mean log loss of what is believed of places.
        calibration_error: Mean difference of what is believed and what is true, by places.
    """

    log_loss: float
    calibration_error: float


@dataclass(frozen=True, slots=True)
class Member:
    """A member of a family, judged.

    Attributes:
        family: Id of its first encoder.
        member: Id of the encoder with what was done to its cosines.
        by_others: By weights that were fitted to all other families.
        by_shipped: By the weights that come along.
        by_own: By scale, even odds and weights that were fitted to this member.
    """

    family: str
    member: str
    by_others: Judged
    by_shipped: Judged
    by_own: Judged


@dataclass(frozen=True, slots=True)
class FamilyTable:
    """All members of all families."""

    members: tuple[Member, ...]


class _SeenHomes(Sequence[SeenHome]):
    """Homes that are asked anew whenever they are needed: together they would fill the memory."""

    def __init__(self, asking: Sequence[Callable[[], SeenHome]]) -> None:
        self.asking = asking

    def __len__(self) -> int:
        return len(self.asking)

    def __getitem__(self, index: int) -> SeenHome:  # type: ignore[override]  # no slices
        return self.asking[index]()


@dataclass(frozen=True, slots=True, eq=False)
class _Encoder:
    """A member with what it is shown in both groups of homes, with scale and bias or without."""

    encoder: ClipEncoder
    log_odds: tuple[float, float] | None
    background: Background
    fitted: Sequence[ShownPlaces]
    judged: Sequence[ShownPlaces]

    @property
    def known(self) -> bool:
        """Whether scale and bias are known."""
        return self.log_odds is not None

    @property
    def fits(self) -> bool:
        """Whether others are judged by what is fitted to it, too."""
        return not isinstance(self.encoder, OtherEncoder)

    @property
    def name(self) -> str:
        """Id of the encoder, with what was done to it."""
        return self.encoder.model_id + ("" if self.known else "-unknown")

    def asked(
        self, shown: Sequence[ShownPlaces], log_odds: tuple[float, float] | None
    ) -> list[Callable[[], SeenHome]]:
        return [partial(seen_in, each, self.encoder, self.background, log_odds) for each in shown]

    def judge(self, weights: Weights, log_odds: tuple[float, float] | None) -> Judged:
        found = believed(_SeenHomes(self.asked(self.judged, log_odds)), weights, along_the_views)
        probabilities, outcomes, counts = found
        of_truth = np.where(outcomes == 1.0, probabilities, 1.0 - probabilities)
        loss = -np.average(np.log(of_truth), weights=counts)
        return Judged(float(loss), reliability_of(*found)[1])

    def judge_own(self) -> Judged:
        log_odds = fit_cosines(self.fitted, self.encoder).log_odds
        weights = fitted_to_walks(_SeenHomes(self.asked(self.fitted, log_odds)))
        return self.judge(weights, log_odds)


def families_bench(config: Config, text: str, quick: bool, folder: Path) -> FamiliesBench:
    """The bench of the encoders that `text` names: families by commas, versions by plus signs.

    Raises:
        ConfigError: there are fewer than two families, an encoder is named twice or is not on this
            machine, or the simulator or its furniture is not.
    """
    named = [family.split("+") for family in text.split(",")]
    every = [name for family in named for name in family]
    if len(named) < 2 or len(set(every)) < len(every) or "" in every:
        raise ConfigError(
            f"--families {text}: name two different encoders at least, for example embedded,photos"
        )
    require_simulator()
    for name in every:
        require_encoder(name, config.device)
    fitted_in, judged_in = (
        [ListedHome(str(seed)) for seed in seeds] for seeds in (OWN_HOMES, JUDGED)
    )
    return FamiliesBench(
        tuple(
            tuple(
                config.model_copy(update={"clip": name, "clip_calibration": ""}) for name in family
            )
            for family in named
        ),
        tuple(fitted_in[:2] if quick else fitted_in),
        tuple(judged_in[:1] if quick else judged_in),
        folder,
    )


def run_families(bench: FamiliesBench) -> BenchResult:
    """Fit to all families but one and judge by that one, each in turn, and print the table.

    Raises:
        VizbotError: a home or an encoder cannot be used.
    """
    families = [
        [member for config in family for member in _members(config, bench)]
        for family in bench.families
    ]
    table = FamilyTable(tuple(_judged(families)))
    settings = key_of_settings(*(config for family in bench.families for config in family))
    key = f"{key_of_sources(*_SOURCES, 'benchmarks')}-{settings}"
    Store(bench.folder / FAMILIES_FILE, FamilyTable).add(key, commit(), hardware(), table)
    return families_result(table)


def _members(config: Config, bench: FamiliesBench) -> Iterator[_Encoder]:
    """One version of an encoder, as it is and with its cosines changed."""
    encoder = encoder_of(config)
    key = f"{key_of_sources(*_SOURCES)}-{encoder.model_id}".replace("/", "_")
    homes = [*bench.fitted, *bench.judged]
    jobs = [_Job(each, config, bench.folder / "views" / key) for each in homes]
    taken = in_parallel(_shown, jobs, NAME, lambda job, _: f"home {job.home.name}")
    done = {job.home: shown for job, shown in taken}
    shown = [done[home] for home in homes]
    others: list[WeakEncoder | OtherEncoder] = [WeakEncoder(encoder)]
    if encoder.log_odds is not None:
        others.append(OtherEncoder(encoder, "offset"))
    versions: list[tuple[ClipEncoder, list[ShownPlaces]]] = [(encoder, shown)]
    for other in others:
        rows = (other.embeddings_of_pictures(each.embeddings) for each in shown)
        seen = [replace(each, embeddings=of) for each, of in zip(shown, rows, strict=True)]
        versions.append((other, seen))
    count = len(bench.fitted)
    for member, seen in versions:
        background = Background.embedded_by(member)
        for log_odds in dict.fromkeys((member.log_odds, None)):
            yield _Encoder(member, log_odds, background, seen[:count], seen[count:])


@dataclass(frozen=True, slots=True)
class _Job:
    """A home to take views of, and the folder that keeps what is finished."""

    home: ListedHome
    config: Config
    kept: Path


def _shown(job: _Job) -> ShownPlaces:
    return shown_in(job.home, encoder_of(job.config), job.kept)


def _judged(families: Sequence[Sequence[_Encoder]]) -> Iterator[Member]:
    for family in families:
        for known in (True, False):
            rest = [
                asked
                for other in families
                if other is not family
                for each in other
                if each.fits and each.known == known
                for asked in each.asked(each.fitted, each.log_odds)
            ]
            members = [each for each in family if each.known == known]
            if not rest or not members:
                continue
            weights = _weights(rest)
            for each in members:
                yield Member(
                    family[0].name,
                    each.name,
                    each.judge(weights, each.log_odds),
                    each.judge(shipped_weights(each.name, known), each.log_odds),
                    each.judge_own(),
                )


def _weights(asking: Sequence[Callable[[], SeenHome]]) -> Weights:
    return fitted(_SeenHomes(asking), walks=along_the_views)


def families_result(table: FamilyTable) -> BenchResult:
    """Rows, summary and table; the worst family is the figure."""
    rows: list[dict[str, object]] = [
        {
            "member": each.member,
            **{
                f"{what}_{name}": getattr(getattr(each, what), name)
                for name in ("log_loss", "calibration_error")
                for what in ("by_others", "by_shipped", "by_own")
            },
        }
        for each in table.members
    ]
    worst = max(table.members, key=lambda each: each.by_others.log_loss - each.by_own.log_loss)
    summary: dict[str, object] = {
        "worst_family": worst.family,
        "worst_log_loss": worst.by_others.log_loss,
        "worst_calibration_error": max(each.by_others.calibration_error for each in table.members),
        "worst_cost": worst.by_others.log_loss - worst.by_own.log_loss,
    }
    text = markdown_table(
        [name.replace("_", " ") for name in rows[0]],
        [
            [f"{cell:.4f}" if isinstance(cell, float) else cell for cell in row.values()]
            for row in rows
        ],
    )
    return BenchResult(NAME, rows, summary, text)
