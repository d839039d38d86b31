"""`docs/results/slam.md`: the page of the pose benchmarks, written from their kept rows."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.harness.store import Store, StoredResult
from benchmarks.slam.homes import AS_RECORDED, FAULTS
from benchmarks.slam.hours import DrivenHours, hours_result
from benchmarks.slam.lap_scores import LapResult, consistent_nees, laps_result
from benchmarks.slam.recordings import RESULTS
from benchmarks.slam.relocalisation import StartResult
from benchmarks.slam.sequence_scores import sequence_table

OFFICE = "hololens_office"
"""Name of the recorded walk; its rows lie in a folder of this name."""
_PICTURE = Path("docs/pictures/poses.png")
_TITLE = "# Poses"
_OFFICE = """The rules and thresholds of our estimator were set by looking at this recording, so its
own figure is one of development; the peers run with the settings of their examples. Plain features
with PnP are the peer to look at: the others are off by metres. ORB-SLAM3 had the rate of the
recording, and a vocabulary learned from this walk (`python -m tests.tools.orb_vocabulary`): with
its own it may do better.

`vizbot bench slam SEQ` runs our pose estimator and its peers over a recording in TUM layout,
prints the error against its `groundtruth.txt`, and writes the trajectories for `evo`, with a
picture. Plain ORB features with PnP and OpenCV's RGB-D odometry always take part, Open3D's where it
is installed, ORB-SLAM3 with `pip install pyorbslam3` and `--vocabulary ORBvoc.txt`."""
_UNCOMMITTED = "The plus says that its sources were changed after that commit and are in none."
_HOMES = """Without SEQ the robot drives laps through all rooms of simulated homes. Each drive is
recorded once under `runs/laps`, and the estimator follows it with all sensors, in the dark, before
a white wall, with wheels that slip or count nothing, without its gyroscope or with one that lies,
carried elsewhere, and in two homes that look the same. Then the robot is put down at random in each
saved map, on floor that the map holds, turns once, and must say where it is. The true robot differs
from what its program believes by what a calibration leaves, drawn for each home.

The white wall is 0.6 m away and has uneven light, a shadow, a light switch and a skirting board.
It stands still until the camera has moved by 0.25 m or turned by 0.5 rad; then another one stands
before it, because the recorded path leads on. Between the two homes lie 4 m of dark corridor, in
which the wheels have the simulator's errors of scale and slip; each image of the corridor and of
the second home has the camera's noise once more, so that none repeats bit for bit. Two rules of
relocalisation were made after reading home 1008. In the corridor the mount is as believed."""


def slam_page(folder: Path, page: Path) -> str:
    """The page of all pose benchmarks; empty before any home was driven."""
    laps = Store(folder / "homes.jsonl", LapResult).fullest()
    if not laps:
        return ""
    parts = [_TITLE]
    office = folder / OFFICE / RESULTS
    if office.exists():
        kept = json.loads(office.read_text(encoding="utf-8"))
        picture = os.path.relpath(_PICTURE, page.parent)
        parts += [
            "## A walk through an office kitchen",
            f"![The walk as {len(kept['rows'])} programs saw it]({picture})",
            sequence_table(kept["rows"], kept["summary"]),
            f"Commit {kept['commit']}, {kept['hardware']}."
            + (f" {_UNCOMMITTED}" if kept["commit"].endswith("+") else ""),
            _OFFICE,
        ]
    starts = Store(folder / "starts.jsonl", StartResult).stored_with_key(laps[0].key)
    parts += _laps_section(laps, starts)
    hours = Store(folder / "hours.jsonl", DrivenHours).all()[-1:]
    for line in hours:
        parts += ["## Hours in one home", hours_result(line.result).text, _made_with(hours)]
    return "\n\n".join([*parts, ""])


def _laps_section(
    laps: Sequence[StoredResult[LapResult]], starts: Sequence[StoredResult[StartResult]]
) -> list[str]:
    results = [line.result for line in laps]
    recorded = [result for result in results if result.fault == AS_RECORDED]
    frames, length = sum(r.frames for r in recorded), sum(r.path_length for r in recorded)
    text = laps_result(tuple(FAULTS), results, [line.result for line in starts], quick=False).text
    parts = [
        f"## {len(recorded)} simulated homes",
        text,
        _consistency(recorded),
        f"The recordings have {length / 1000:.1f} km and {frames} frames. {_made_with(laps)}",
        _HOMES,
    ]
    if left := [fault for fault in FAULTS if fault not in {r.fault for r in results}]:
        parts.append(f"No rows are kept of: {', '.join(left)}.")
    return parts


def _consistency(recorded: Sequence[LapResult]) -> str:
    """In how many homes the covariances are true, as recorded."""
    outside = []
    for result in sorted(recorded, key=lambda result: result.home):
        low, high = consistent_nees(result.measured_in)
        if not low <= result.nees <= high:
            outside.append(f"{result.home} ({result.nees:.2f}, {low:.2f} to {high:.2f})")
    if not outside:
        return f"In each of the {len(recorded)} homes NEES lies within its own bounds, as recorded."
    return (
        f"As recorded, NEES lies outside of its own bounds in {len(outside)} of {len(recorded)}"
        f" homes: {', '.join(outside)}. Covariances cover the noise of images; what a"
        " calibration leaves of mount, focal length and wheels is not in them."
    )


def _made_with(lines: Sequence[StoredResult[Any]]) -> str:
    commits = dict.fromkeys(line.commit for line in lines)
    machines = dict.fromkeys(line.hardware for line in lines)
    return f"Commit {' and '.join(commits)}, {', '.join(machines)}."
