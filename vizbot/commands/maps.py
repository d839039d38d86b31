"""`vizbot map`: build from recordings, ask, export, describe."""

from __future__ import annotations

from pathlib import Path

from drivers.sequence import parse_intrinsics
from mapping.trajectory_error import absolute_trajectory_error
from mapping.tum import read_trajectory

from mapping import map_bundle
from vizbot.config import load_config
from vizbot.core.errors import ConfigError
from vizbot.mission import watch
from vizbot.operator.progress import Progress
from vizbot.pipeline import Pipeline
from vizbot.rig import Rig, open_encoder


def build(
    sequence: Path,
    out: Path,
    clip: str | None,
    config_path: Path | None,
    intrinsics: str | None,
    as_json: bool,
) -> None:
    """Run a recording through pose estimator and mappers and save the map.

    Where the folder has a `groundtruth.txt`, the error against it is printed; nothing else reads
    that file.

    Raises:
        VizbotError: the recording or a setting cannot be used.
    """
    config = load_config(config_path)
    if clip is not None:
        config = config.model_copy(update={"clip": clip})
    # A recording is worked on frame by frame, however long a frame takes.
    perception = config.perception.model_copy(update={"embedding_latency": 0.0})
    config = config.model_copy(update={"perception": perception})
    encoder = open_encoder(config.clip, config.device)
    recording = None if intrinsics is None else parse_intrinsics(intrinsics)
    map_bundle.require_writable(out)
    with (
        Rig(config, str(sequence), "none", "", recording) as rig,
        Progress() as progress,
    ):
        pipeline = Pipeline(rig.devices, encoder, config, [progress])
        watch(pipeline, [], None)
    if pipeline.perception is None:
        raise ConfigError(f"{sequence} holds no frame; record one with colour and depth")
    bundle = pipeline.perception.bundle()
    map_bundle.save(bundle, out)
    summary = _summary(bundle)
    truth = sequence / "groundtruth.txt"
    if truth.exists():
        stamps, Ts_map_cam = map_bundle.online_trajectory(bundle)
        error = absolute_trajectory_error(stamps, Ts_map_cam, *read_trajectory(truth))
        stamps, Ts_map_cam = map_bundle.final_trajectory(bundle)
        final = absolute_trajectory_error(stamps, Ts_map_cam, *read_trajectory(truth))
        summary |= {"ate_rmse": round(error, 4), "ate_rmse_final": round(final, 4)}
    _print(summary | {"map": str(out)}, as_json)
