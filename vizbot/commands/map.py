"""`vizbot map`: build from recordings, ask, export, describe; list, rename and delete saved ones.

Building loads most of the robot's program, asking a part of it; neither is loaded before.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np
import typer

from mapping import map_bundle
from mapping.clip.fitted.encoder import calibrated
from mapping.tum import read_trajectory
from vizbot.commands.config.discovery import load_settings
from vizbot.commands.options import MapBuildOptions, MapQueryOptions
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.observer import GoalReport, Outcome, Step
from vizbot.operator.language.command import HowMany
from vizbot.operator.printing import echo, printable
from vizbot.operator.session.saved_maps import SavedMaps, find_map
from vizbot.rig import open_encoder, opened_devices, require_encoder


def build(options: MapBuildOptions) -> None:
    """Run a recording through pose estimator and mappers and save the map.

    Where the folder has a `groundtruth.txt`, the error against it is printed; nothing else reads
    that file.

    Raises:
        VizbotError: the recording or a setting cannot be used.
    """
    sequence, out, intrinsics = options.sequence, options.out, options.intrinsics
    config = load_settings(options.config, options.clip)
    require_encoder(config.clip, config.device)
    if intrinsics is not None and sequence.is_file():
        raise ConfigError(f"--intrinsics are not for {sequence}, which has its own")
    map_bundle.require_savable(out, replace=options.force)
    from drivers.tum_sequence import parse_intrinsics

    recording = None if intrinsics is None else parse_intrinsics(intrinsics)
    truth = sequence / "groundtruth.txt"
    known = read_trajectory(truth) if truth.exists() else None
    frames = _TrackedFrames()
    with opened_devices(config, str(sequence), "none", recording) as devices:
        from vizbot.commands.progress import Progress, parts_with_bank, say_calibration
        from vizbot.mission import watch
        from vizbot.perception.interfaces import PerceptionParts
        from vizbot.pipeline import Pipeline

        file = Path(config.clip_calibration) if config.clip_calibration else None
        encoder = calibrated(open_encoder(config.clip, config.device, config.half), file)
        say_calibration(encoder, config.clip)
        parts = parts_with_bank(encoder) or PerceptionParts()
        parts = replace(parts, every_pose=True)
        with Progress() as progress:
            pipeline = Pipeline(devices, encoder, config, [progress, frames], parts)
            watch(pipeline, [])
    bundle = pipeline.bundle()
    if bundle is None:
        raise ConfigError(f"{sequence} holds no frame; record one with colour and depth")
    map_bundle.save(bundle, out)
    tracked = frames.tracked / frames.total
    if tracked < 0.5 or len(bundle.elements.keyframes) == 0:
        echo(
            f"warning: {tracked:.0%} of the frames were tracked and"
            f" {len(bundle.elements.keyframes)} elements mapped; look at depth and intrinsics",
            err=True,
        )
    summary = _summary(bundle) | {"tracked": round(tracked, 4), "map": str(out)}
    if known is not None:
        from mapping.trajectory_error import absolute_trajectory_error

        stamps = bundle.trajectory.stamps
        for name, poses in (
            ("ate_rmse", bundle.trajectory.Ts_map_cam),
            ("ate_rmse_final", bundle.final_poses()),
        ):
            try:
                summary[name] = round(absolute_trajectory_error(stamps, poses, *known), 4)
            except ConfigError as error:
                summary[name] = None
                echo(f"warning: {truth}: {error}", err=True)
    _print(summary, encoder.notice, options.as_json)


@dataclass
class _TrackedFrames:
    """An observer that counts frames, and those posed from image matches."""

    total: int = 0
    tracked: int = 0

    def on_step(self, step: Step) -> None:
        self.total += 1
        self.tracked += step.estimate.tracking.by_images

    def on_goal(self, report: GoalReport) -> None:
        """No goals here."""


def query(options: MapQueryOptions) -> None:
    """Print the best places for a text, and whether they are likely enough.

    Raises:
        VizbotError: the map cannot be read, was made by another encoder, the text is no question,
            or the method cannot answer it.
    """
    from vizbot.commands.progress import BankProgress, say_calibration
    from vizbot.commands.sentences import parse_question
    from vizbot.operator.language.language import load_language

    question = parse_question(options.text, load_language(options.language))
    config = load_settings(options.config, options.clip, options.method)
    by_paper = config.objectnav.method == "paper"
    if by_paper and isinstance(question, HowMany):
        raise ConfigError(f"--method paper cannot answer {options.text!r}: it counts nothing")
    if options.out is not None:
        if by_paper:
            raise ConfigError("--method paper has no probabilities to draw; leave out --out")
        from vizbot.operator.report.map_page import require_page_folder

        require_page_folder(options.out)
    from vizbot.operator.session.saved_map import SavedMap

    saved = SavedMap(options.folder, config, options.clip)
    say_calibration(saved.encoder, options.clip or saved.encoder.model_id)
    notice = saved.encoder.notice
    answer = saved.find(question.goal, BankProgress(saved.encoder.model_id))
    count = saved.count(question.goal) if isinstance(question, HowMany) else None
    if options.out is not None:
        from vizbot.operator.report.map_page import write_map_page

        write_map_page(options.out, saved, answer, config.objectnav.answer_probability)
    if options.as_json:
        content = asdict(answer)
        content["candidates"] = content.pop("places")
        echo(json.dumps(content | {"count": count, "notice": notice}))
        return
    if notice:
        echo(notice, err=True)
    if answer.note:
        echo(answer.note, err=True)
    found = "located" if answer.outcome is Outcome.LOCATED else "not found"
    score = "similarity" if by_paper else "probability"
    least = f"a place counts with a {score} above {answer.threshold:.3g}"
    echo(f"{answer.text}: {found if count is None else f'{count} found'} ({least})")
    from vizbot.operator.session.place_answers import local_time

    for place in answer.places:
        x, y, z = place.position
        counts = "" if place.score > answer.threshold else "   does not count"
        seen = local_time(datetime.fromisoformat(place.seen_at))
        echo(f"  {x:7.2f} {y:7.2f} {z:7.2f} m   {score} {place.score:.3f}   seen {seen}{counts}")


def show(folder: Path, out: Path) -> None:
    """Draw a map without a question: a page and `map.png` in the folder `out`.

    Raises:
        VizbotError: the map or its encoder cannot be read, or the folder is not new or empty.
    """
    from vizbot.operator.report.map_page import require_page_folder, write_map_page
    from vizbot.operator.session.saved_map import SavedMap

    require_page_folder(out)
    config = Config()
    write_map_page(out, SavedMap(folder, config), None, config.objectnav.answer_probability)
    echo(str(out))


def describe(folder: Path, as_json: bool) -> None:
    """Print what a map holds.

    Raises:
        MapError: it cannot be read.
    """
    bundle = map_bundle.load(find_map(folder))
    _print(_summary(bundle), bundle.notice, as_json)


def list_saved(as_json: bool) -> None:
    """Print the saved maps of this user and their folders, newest first."""
    saved = SavedMaps()
    maps = saved.maps()
    if as_json:
        echo(json.dumps({"folder": str(saved.folder), "maps": [asdict(each) for each in maps]}))
        return
    names = [f"{each.name}{' (in use)' if each.in_use else ''}" for each in maps]
    longest = max(map(len, names), default=0)
    for each, name in zip(maps, names, strict=True):
        date = datetime.fromtimestamp(each.saved_at)
        echo(f"{date:%Y-%m-%d %H:%M}  {name:{longest}}  {saved.path(each.name)}")
    if not maps:
        echo(f"no saved maps in {saved.folder}; the console saves them by name", err=True)


def rename_saved(name: str, new: str) -> None:
    """Give a saved map another name.

    Raises:
        VizbotError: a name cannot be one, there is no such map, or another one has the name.
    """
    SavedMaps().rename(name, new)
    echo(f"{name!r} is called {new!r} now")


def delete_saved(name: str, sure: bool) -> None:
    """Delete a saved map; unless `sure`, a person is asked.

    Raises:
        VizbotError: the name cannot be one, there is no such map, a robot is in it, or nobody says
            yes.
    """
    saved = SavedMaps()
    saved.require(name)
    if not sure:
        if not sys.stdin.isatty():
            raise ConfigError(f"the map {name!r} is not deleted without a yes: add --yes")
        if not typer.confirm(f"Delete {printable(name)!r} for good?", err=True):
            raise ConfigError(f"the map {name!r} stays")
    saved.delete(name)
    echo(f"{name!r} is deleted")


_UNITS = {
    "path_length": "m",
    "camera_height": "m",
    "tracked": "of the frames",
    "ate_rmse": "m, as it was driven",
    "ate_rmse_final": "m, after the last correction",
}
"""What a value of a map's summary is counted in, for people."""


def _summary(bundle: map_bundle.MapBundle) -> dict[str, object]:
    steps = np.diff(bundle.trajectory.Ts_map_cam[:, :3, 3], axis=0)
    return {
        "model": bundle.model_id,
        "created": bundle.created.isoformat(timespec="seconds"),
        "mapped_frames": len(bundle.frames),
        "path_length": round(float(np.linalg.norm(steps, axis=1).sum()), 2),
        "keyframes": len(bundle.keyframes.ids),
        "elements": len(bundle.elements.keyframes),
        "cloud_points": len(bundle.cloud.rgb),
        "grid_cells": list(bundle.grid.occupancy.shape),
        "calibrated": bundle.calibration is not None,
        "camera_height": round(float(bundle.T_base_cam[2, 3]), 3),
    }


def _print(summary: dict[str, object], notice: str | None, as_json: bool) -> None:
    if as_json:
        echo(json.dumps(summary | {"notice": notice}))
        return
    if notice:
        echo(notice, err=True)
    for name, value in summary.items():
        unit = f" {_UNITS[name]}" if name in _UNITS and value is not None else ""
        echo(f"{name.replace('_', ' '):16} {value}{unit}")
