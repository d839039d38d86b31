"""Section of the scoreboard's page that shows pictures of failures and successes."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.episodes.episode import EpisodeResult
from benchmarks.harness.workers import in_parallel
from benchmarks.objectnav.episode_pictures import Picture, draw_episode
from vizbot.config import Config
from vizbot.core.files import write_whole

_PICTURES = 6
"""Most pictures of failures, and of successes."""


def pictured(results: Sequence[EpisodeResult]) -> list[EpisodeResult]:
    """Failures, then successes, chosen by a fixed seed, each in the order of the episodes.

    An episode without a track is never chosen.
    """
    rng = np.random.default_rng(0)
    chosen: set[int] = set()
    for success in (False, True):
        alike = [
            i for i, result in enumerate(results) if result.success is success and result.track
        ]
        chosen |= set(rng.permutation(alike)[:_PICTURES].tolist())
    return [results[i] for i in sorted(chosen, key=lambda i: (results[i].success, i))]


def drawn_pictures(
    config: Config, chosen: Sequence[EpisodeResult], page: Path, folder: Path
) -> list[str]:
    """Draw the chosen episodes into `folder` and return the lines of `page` that show them."""
    parts = [
        "## Pictures",
        "Left the true home from above, which the robot never sees, with its way in red from the"
        " blue dot to the red one and what was asked for in green; right its last look.",
    ]
    jobs = [(result, config) for result in chosen]
    drawn = {job[0].episode: picture for job, picture in in_parallel(
        _draw_job, jobs, "pictures", _picture_line
    )}  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.jpg"):
        old.unlink()
    for result in chosen:
        write_whole(folder / _picture_name(result), drawn[result.episode].jpeg)
        parts.append(_picture_link(result, page, folder))
    authors = sorted({author for picture in drawn.values() for author in picture.attributions})
    if authors:
        parts.append(f"The furniture in these pictures: {'; '.join(authors)}.")
    return parts


def kept_pictures(chosen: Sequence[EpisodeResult], page: Path, folder: Path) -> str:
    """The section of the page as it is, if it shows just the chosen episodes; else nothing."""
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    section = text.partition("## Pictures\n")[2].partition("\n## ")[0].strip()
    shown = [line for line in section.splitlines() if line.startswith("![")]
    if not shown or shown != [_picture_link(result, page, folder) for result in chosen]:
        return ""
    return f"## Pictures\n\n{section}"


def _picture_name(result: EpisodeResult) -> str:
    return f"{result.episode.home}-{result.episode.goals[0].replace(' ', '-')}.jpg"


def _picture_link(result: EpisodeResult, page: Path, folder: Path) -> str:
    verdict = "success" if result.success else "failure"
    alt = f"{verdict}: {result.episode.goals[0]} in home {result.episode.home}"
    return f"![{alt}]({os.path.relpath(folder / _picture_name(result), page.parent)})"


def _draw_job(job: tuple[EpisodeResult, Config]) -> Picture:
    return draw_episode(*job)


def _picture_line(job: tuple[EpisodeResult, Config], picture: Picture) -> str:
    return f"home {job[0].episode.home}, {job[0].episode.goals[0]}"
