"""`vizbot bench encoder`: how well an encoder tells things apart, in homes and in real pictures.

Patches whose contents are known are asked for things by their bare names: in homes of ours, in
homes drawn by others, and in recordings in which a person marked the things. Some of the patches of
each home and recording are drawn, beside what is kept of them.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from benchmarks.encoder.contact_sheet import contact_sheet, tile_of
from benchmarks.encoder.page import (
    TITLES,
    Asked,
    EncoderAnswers,
    Kind,
    answers_store,
    answers_text,
)
from benchmarks.encoder.recordings import patches_of_recording
from benchmarks.encoder.separation import AskedPatches, mean_over_names, reliability, separations
from benchmarks.episodes.episode import Home, seed_of_home
from benchmarks.episodes.homes import house_of
from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import commit, hardware, key_of_settings, key_of_sources
from benchmarks.harness.workers import in_parallel
from benchmarks.questions.poses import TRUTH
from mapping.clip.encoder import ClipEncoder
from mapping.clip.patches import embed_frame
from sim_stubs.scoring.success import GOALS
from training.evaluation import shown_on, zero_shot
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
_SOURCES = ("sim_stubs", "training", "mapping/clip", "benchmarks/encoder", "benchmarks/questions")
"""Sources that can change what is asked, or how it is answered."""
_TIMED = 5
"""Frames whose median time counts."""


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
    groups = {kind: [home for home in homes if _kind_of(home) == kind] for kind in TITLES}
    trained = {model for home in groups["trained"] for model in found[home].models if model}
    sources = []
    for kind, members in groups.items():
        if members:
            split = trained if kind == "others" else set()
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
    answers_store(bench.folder).add(key, commit(), hardware(), answers)
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
    seen = np.isin(patches.models, sorted(trained))
    of = partial(separations, patches, names, encoder.threshold)
    shares = zero_shot(patches.similarities, patches.shown, patches.edges, names)
    return Asked(
        source,
        kind,
        whole,
        len(patches),
        of(),
        of(seen) if trained else {},
        of((patches.models != "") & ~seen) if trained else {},
        {it.scale: round(it.overall, 4) for it in shares},
        encoder.log_odds and reliability(patches, encoder.log_odds),
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
    return BenchResult(NAME, rows, summary, answers_text(answers))
