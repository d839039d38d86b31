"""`vizbot bench encoder`: how well an encoder tells things apart, in homes and in real pictures.

Patches whose contents are known are asked for things by their bare names: in homes of ours, in
homes drawn by others, and in recordings in which a person marked the things. Some of the patches of
each home and recording are drawn, beside what is kept of them.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from benchmarks.encoder.contact_sheet import contact_sheet, tile_of
from benchmarks.encoder.recordings import patches_of_recording
from benchmarks.encoder.separation import (
    AskedPatches,
    Separation,
    mean_over_names,
    reliability,
    separations,
)
from benchmarks.episodes.episode import Home, seed_of_home
from benchmarks.episodes.homes import house_of
from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_settings, key_of_sources
from benchmarks.harness.store import Store, StoredResult
from benchmarks.harness.tables import markdown_table
from benchmarks.harness.workers import in_parallel
from benchmarks.questions.poses import TRUTH
from mapping.clip.encoder import ClipEncoder
from mapping.clip.patches import embed_frame
from sim_stubs.scoring.success import GOALS
from training.evaluation import SCALES, shown_on, zero_shot
from training.views import ViewsConfig, pictures
from vizbot.config import Config
from vizbot.core.files import write_whole
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame
from vizbot.rehearsal.belief_fit.view_list import SEEN_WORLDS

NAME = "encoder"
HOMES = (1100, 1101, 1102, 1103, 1104, 1105)
"""Homes of development, whose furniture no training has."""
PICTURES = 60
"""Pictures of each home; ten patches are cut from each."""
QUICK_PICTURES = 10
Kind = Literal["own", "others", "trained", "recording"]
TITLES: dict[Kind, str] = {
    "own": "own homes",
    "others": "homes by others",
    "trained": "homes by others, to train on",
}
"""Names of the groups of homes."""
_SOURCES = ("sim_stubs", "training", "mapping/clip", "benchmarks/encoder", "benchmarks/questions")
"""Sources that can change what is asked, or how it is answered."""
_TIMED = 5
"""Frames whose median time counts."""
_TEXT = """`vizbot bench encoder` asks patches of pictures for the paper's goals by bare names. A
patch shows a thing clearly, does not show it, or is left out as disputable. AUC is the
probability that a patch that shows a thing clearly is more similar to its name than one that does
not; recall is the share of the former above the similarity that one in a hundred of the latter
exceeds; both are means over names, and chance gives 0.5 and 0.01. Right at a scale is the share of
patches that are named rightly among all names. In recordings patches are those of the mapper, and
what they show follows from a person's marks."""


@dataclass(frozen=True, slots=True)
class EncoderBench:
    """What an encoder is asked.

    Attributes:
        config: Settings of the robot, with the encoder.
        seeds: Homes of ours.
        worlds: Homes drawn by others.
        sequences: Recordings, each with the file of its marks.
        pictures: Pictures of each home.
        folder: Folder of the results.
    """

    config: Config
    seeds: tuple[int, ...]
    worlds: tuple[str, ...]
    sequences: tuple[tuple[Path, Path], ...]
    pictures: int
    folder: Path


@dataclass(frozen=True, slots=True)
class Asked:
    """What an encoder said of the patches of one home or recording, or of several together.

    Attributes:
        source: Name of the home, the recording, or the group of homes.
        kind: Who drew it, and whether it is to train on.
        whole: Whether it is a group, or a recording.
        patches: Number of patches.
        names: How well each name is told apart, by the name.
        seen_models: In homes by others the same by patches of a model that is also in a home to
            train on.
        new_models: The same by patches of any other model.
        zero_shot: Share of patches named rightly among the names, by the scale.
        calibration_error: Of the encoder's own probabilities; None where it has none.
        own_poses: Whether marks were placed by poses of our own SLAM, as none were recorded.
    """

    source: str
    kind: Kind
    whole: bool
    patches: int
    names: dict[str, Separation]
    seen_models: dict[str, Separation]
    new_models: dict[str, Separation]
    zero_shot: dict[int, float]
    calibration_error: float | None
    own_poses: bool = False


@dataclass(frozen=True, slots=True)
class EncoderAnswers:
    """All that one encoder said.

    Attributes:
        encoder: Id of the weights.
        ms_a_frame: Median time of a frame of 640 x 480 pixels on this machine [ms].
        sources: Homes, groups of homes, and recordings.
    """

    encoder: str
    ms_a_frame: float
    sources: tuple[Asked, ...]


def run_encoder(bench: EncoderBench) -> BenchResult:
    """Ask an encoder, keep its answers and print their tables.

    Raises:
        VizbotError: a home, a recording or the encoder cannot be used.
    """
    config = bench.config
    encoder = encoder_of(config)
    homes: list[Home] = [*bench.seeds, *bench.worlds]
    key = f"{key_of_sources(*_SOURCES)}-{key_of_settings(config)}"
    kept = bench.folder / "patches" / f"{key}-{encoder.model_id}-{bench.pictures}".replace("/", "_")
    jobs = [_Job(home, config, bench.pictures, kept) for home in homes]
    found = {job.home: asked for job, asked in in_parallel(_ask_home, jobs, NAME, _home_line)}
    groups: dict[Kind, list[Home]] = {"own": [], "others": [], "trained": []}
    for home in homes:
        groups[_kind_of(home)].append(home)
    trained = {model for home in groups["trained"] for model in found[home].models if model}
    sources = []
    for kind, members in groups.items():
        split = trained if kind == "others" else set()
        if members:
            together = AskedPatches.joined([found[home] for home in members])
            sources.append(_asked(TITLES[kind], kind, True, together, GOALS, encoder, split))
            sources += [
                _asked(_title(home), kind, False, found[home], GOALS, encoder, set())
                for home in members
            ]
    for sequence, questions in bench.sequences:
        patches, names, tiles = patches_of_recording(sequence, questions, encoder, config)
        name = sequence.resolve().name
        _draw(kept / f"{name}.png", tiles, patches, names, encoder)
        asked = _asked(name, "recording", True, patches, names, encoder, set())
        sources.append(replace(asked, own_poses=not (sequence / TRUTH).is_file()))
    answers = EncoderAnswers(encoder.model_id, _ms_a_frame(encoder, config), tuple(sources))
    Store(bench.folder / f"{NAME}.jsonl", EncoderAnswers).add(key, commit(), hardware(), answers)
    return encoder_result(answers)


@dataclass(frozen=True, slots=True)
class _Job:
    """A home to take pictures of, and the folder that keeps what is finished."""

    home: Home
    config: Config
    pictures: int
    kept: Path

    @property
    def file(self) -> Path:
        """What is kept of the home."""
        content = Path(str(self.home))
        edition = f"-{crc32(content.read_bytes()):08x}" if content.is_file() else ""
        return self.kept / f"{_title(self.home)}{edition}.npz"


def _home_line(job: _Job, asked: AskedPatches) -> str:
    return f"home {job.home}, drawn in {job.file.with_suffix('.png')}"


def _ask_home(job: _Job) -> AskedPatches:
    """Take the pictures of a home, ask their patches and draw some, or read what was kept."""
    if job.file.exists():
        return AskedPatches.load(job.file)
    asked, tiles = _asked_in(job)
    _draw(job.file.with_suffix(".png"), tiles, asked, GOALS, encoder_of(job.config))
    asked.save(job.file)
    return asked


def _draw(
    file: Path,
    tiles: Sequence[NDArray[np.uint8]],
    asked: AskedPatches,
    names: Sequence[str],
    encoder: ClipEncoder,
) -> None:
    title = f"{file.stem}, {encoder.model_id}"
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, contact_sheet(title, tiles, asked, names, encoder.threshold))


def _asked_in(job: _Job) -> tuple[AskedPatches, list[NDArray[np.uint8]]]:
    """What an encoder says of a home, and its patches as they are drawn."""
    house, config = house_of(job.home), job.config
    encoder = encoder_of(config)
    texts = encoder.embed_texts(list(GOALS))
    models = np.array([_model(it.piece.attribution) for it in house.instances] + [""])
    several: list[AskedPatches] = []
    tiles: list[NDArray[np.uint8]] = []
    for picture in pictures(house, seed_of_home(job.home), ViewsConfig(pictures=job.pictures)):
        patches = [picture.rgb[v0:v1, u0:u1] for u0, v0, u1, v1 in picture.boxes]
        tiles += map(tile_of, patches)
        several.append(
            AskedPatches(
                encoder.embed_images(patches) @ texts.T,
                shown_on(picture.facts, GOALS),
                picture.boxes[:, 2].astype(np.int64) - picture.boxes[:, 0],
                models[picture.things],  # -1, walls and floor, is the last
            )
        )
    return AskedPatches.joined(several), tiles


def _model(attribution: str) -> str:
    """The id of a model in its catalogue ("Scopia#captains-bed"); empty for shapes of our own."""
    inside = attribution.partition("(")[2].partition(")")[0]
    return inside if "#" in inside else ""


def _kind_of(home: Home) -> Kind:
    if isinstance(home, int):
        return "own"
    return "trained" if _title(home) in SEEN_WORLDS else "others"


def _title(home: Home) -> str:
    return str(home) if isinstance(home, int) else Path(home).stem


def _asked(
    source: str,
    kind: Kind,
    whole: bool,
    patches: AskedPatches,
    names: Sequence[str],
    encoder: ClipEncoder,
    trained: set[str],
) -> Asked:
    """What the encoder said; `trained` are models of homes to train on."""
    chosen = {
        "names": None,
        "seen_models": np.isin(patches.models, sorted(trained)),
        "new_models": (patches.models != "") & ~np.isin(patches.models, sorted(trained)),
    }
    odds = encoder.log_odds
    return Asked(
        source,
        kind,
        whole,
        len(patches),
        **{
            part: separations(patches, names, encoder.threshold, rows)
            if trained or rows is None
            else {}
            for part, rows in chosen.items()
        },
        zero_shot={
            it.scale: round(it.overall, 4)
            for it in zero_shot(patches.similarities, patches.shown, patches.edges, names)
        },
        calibration_error=None if odds is None else reliability(patches, odds),
        own_poses=False,
    )


def _ms_a_frame(encoder: ClipEncoder, config: Config) -> float:
    """Median time of the patches of a frame of noise, 2 m away [ms]."""
    rgb = np.random.default_rng(0).integers(0, 256, (480, 640, 3), np.uint8)
    camera = Intrinsics(640, 480, 600.0, 600.0, 320.0, 240.0)
    frame = RGBDFrame(0.0, rgb, np.full((480, 640), 2.0, np.float32), camera, ImuSamples.none())
    times = []
    for _ in range(_TIMED + 1):
        began = time.perf_counter()
        embed_frame(frame, encoder, config.perception.clip_mapper)
        times.append(time.perf_counter() - began)
    return round(1000 * float(np.median(times[1:])), 1)


def encoder_result(answers: EncoderAnswers) -> BenchResult:
    """Rows, summary and tables of what an encoder said."""
    rows: list[dict[str, object]] = [
        {
            "row": source.source,
            "kind": source.kind,
            "patches": source.patches,
            "auc": mean_over_names(source.names, "auc"),
            "recall_at_1": mean_over_names(source.names, "recall"),
            "above_even": mean_over_names(source.names, "above_even"),
            "zero_shot": source.zero_shot,
            "calibration_error": source.calibration_error,
        }
        for source in answers.sources
    ]
    recall = {row["row"]: row["recall_at_1"] for row in rows}
    summary: dict[str, object] = {
        "own_recall_at_1": recall.get(TITLES["own"]),
        "others_recall_at_1": recall.get(TITLES["others"]),
        "ms_a_frame": answers.ms_a_frame,
    }
    parts = [
        f"`{answers.encoder}`, {answers.ms_a_frame:.0f} ms a frame on this machine.",
        _sources_table(answers.sources),
        _names_table([source for source in answers.sources if source.whole]),
    ]
    parts += _split_tables(answers.sources)
    return BenchResult(NAME, rows, summary, "\n\n".join(parts))


def _sources_table(sources: Sequence[Asked]) -> str:
    """A row for each source, the homes of a group below it."""
    header = ("where", "patches", "names", "AUC", "recall", "above even odds",
              *(f"right at scale {scale}" for scale in SCALES), "calibration error")  # fmt: skip
    return markdown_table(
        header,
        [
            [
                ("" if source.whole else "- ")
                + source.source
                + (", placed by our own SLAM" if source.own_poses else ""),
                source.patches,
                len(source.names),
                _three(mean_over_names(source.names, "auc")),
                mean_over_names(source.names, "recall"),
                mean_over_names(source.names, "above_even"),
                *(source.zero_shot.get(scale) for scale in SCALES),
                _three(source.calibration_error),
            ]
            for source in sources
        ],
    )


def _names_table(sources: Sequence[Asked]) -> str:
    """Recall of each name in each source, and how many patches that is of."""
    names = dict.fromkeys(name for source in sources for name in source.names)
    header = ("recall of", *(source.source for source in sources))
    rows = [
        [
            name,
            *(
                f"{source.names[name].recall:.2f} of {source.names[name].clear}"
                if name in source.names
                else None
                for source in sources
            ),
        ]
        for name in names
    ]
    return markdown_table(header, rows)


def _split_tables(sources: Sequence[Asked]) -> list[str]:
    """Names of which both models of homes to train on and others are there; none without any."""
    if not (split := [source for source in sources if source.seen_models]):
        return []
    header = ("homes", "models", "names", "AUC", "recall")
    rows = []
    for source in split:
        both = source.seen_models.keys() & source.new_models.keys()
        for title, found in (("to train on", source.seen_models), ("others", source.new_models)):
            kept = {name: found[name] for name in sorted(both)}
            auc, recall = (mean_over_names(kept, of) for of in ("auc", "recall"))
            rows.append([source.source, title, len(kept), _three(auc), recall])
    return [markdown_table(header, rows)]


def _three(value: float | None) -> str | None:
    return None if value is None else f"{value:.3f}"


def homes_by_others(folder: Path) -> str:
    """A section with the newest answers of each encoder in homes by others, by classes of things.

    The models of furniture of those that judge are split by whether a home to train on has them,
    where the encoder was asked in both together. Empty where no encoder was asked there.
    """
    parts = []
    for line in _newest(folder):
        sources = [each for each in line.result.sources if each.kind in ("others", "trained")]
        if sources:
            parts += [
                f"`{line.result.encoder}`, commit {line.commit}:",
                _sources_table(sources),
                *_split_tables(sources),
                _classes_table([each for each in sources if each.whole]),
            ]
    text = "[What recall and AUC are](encoder.md) of patches, by bare names."
    return "\n\n".join(["## Patches of homes by others", text, *parts]) if parts else ""


def _classes_table(groups: Sequence[Asked]) -> str:
    """Recall at 1 % false, with the number of patches, and AUC of each thing, by its models."""
    columns = {}
    for group in groups:
        columns[group.source] = group.names
        if group.seen_models or group.new_models:
            columns["their models that homes to train on have"] = group.seen_models
            columns["their other models"] = group.new_models
    names = dict.fromkeys(name for column in columns.values() for name in column)
    header = ["thing", *(f"{title}: {of}" for title in columns for of in ("recall", "AUC"))]
    rows: list[list[object]] = []
    for name in names:
        found = [column.get(name) for column in columns.values()]
        figures = [
            (f"{it.recall:.2f} of {it.clear}", _three(it.auc)) if it else (None, None)
            for it in found
        ]
        rows.append([name, *(cell for pair in figures for cell in pair)])
    return markdown_table(header, rows)


def _newest(folder: Path) -> list[StoredResult[EncoderAnswers]]:
    """The newest answers of each encoder."""
    return Store(folder / f"{NAME}.jsonl", EncoderAnswers).newest(lambda each: each.encoder)


def encoder_page(folder: Path, page: Path) -> str:
    """The page of the newest answers of each encoder; empty without any."""
    newest = _newest(folder)
    if not newest:
        return ""
    parts = ["# Encoders", _TEXT]
    for line in newest:
        parts += [
            f"## {line.result.encoder}",
            encoder_result(line.result).text,
            f"Commit {line.commit}, {line.hardware}.",
        ]
    return "\n\n".join([*parts, ""])
