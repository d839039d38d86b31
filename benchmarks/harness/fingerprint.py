"""What results depend on: a key of sources, weights, furniture and settings; and the machine."""

from __future__ import annotations

import hashlib
import json
import platform
import subprocess
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydantic import BaseModel

import sim_stubs
from benchmarks.episodes.episode import Variant
from mapping.clip.fitted.calibration import read_calibration
from sim_stubs.homes.furniture.catalogue import read_catalogue
from vizbot.config import Config

_PACKAGES = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")
_COMMITTED = (*_PACKAGES, "benchmarks", "training")
_HOMES = ("sim_stubs", "vizbot/core")
_EPISODES = "benchmarks/episodes"
_ORACLES = "benchmarks/episodes/oracles.py"
_ABLATIONS = "benchmarks/ablations"
_NO_PART_OF_A_RUN = (
    "vizbot/calibration",
    "vizbot/cli",
    "vizbot/commands",
    "vizbot/operator",
)
"""Folders whose sources change no run. Training makes the weights, which count themselves. Every
other folder counts without being named here, so that a new one is never left out."""
_SUFFIXES = (".py", ".json", ".tsv", ".txt", ".safetensors")
_SIZE, _RUNS = 1024, 15
REFERENCE_KERNEL = f"product of two {_SIZE} x {_SIZE} matrices of 32-bit numbers"
"""A fixed piece of work, timed beside a benchmark, so that machines can be compared."""

ROOT = Path(sim_stubs.__file__).parents[1]
"""The folder that holds the import packages."""


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """What results depend on, computed once when a benchmark begins.

    Two fingerprints are equal where the results would be.

    Attributes:
        clip: The encoder that the plan names.
        homes: Key of the homes alone.
        episodes: Key of all that can change an episode except the settings: sources, weights,
            homes.
        oracles: Key of the oracles and the ablations.
        commit: The checked out commit, as `commit()` returns it.
        hardware: The machine in a few words.
    """

    clip: str
    homes: str
    episodes: str
    oracles: str
    commit: str = field(compare=False)
    hardware: str = field(compare=False)

    @staticmethod
    def taken(clip: str) -> Fingerprint:
        """The fingerprint of the files as they are now."""
        homes = _short([_digest(_robot_sources(*_HOMES)), *_furniture()])
        running = [path for path in _sources(_EPISODES) if path != ROOT / _ORACLES]
        sources = _digest([*_robot_sources(*_PACKAGES), *running])
        episodes = _short([homes, sources, _weights(clip)])
        oracles = _digest([ROOT / _ORACLES, *_sources(_ABLATIONS)])
        return Fingerprint(clip, homes, episodes, oracles, commit(), hardware())

    @property
    def clean(self) -> bool:
        """Whether the commit alone says what the sources were."""
        return self.commit != "unknown" and not self.commit.endswith("+")

    def still_holds(self) -> bool:
        """Whether the files are still those of this fingerprint."""
        return self == Fingerprint.taken(self.clip)

    def key_of(self, variant: Variant) -> str:
        """The key of a variant: twelve hexadecimal digits.

        Results of different keys must never be mixed in one row. The key of a variant with an
        oracle, or an ablation, is that of the same robot without it, and twelve more digits.
        """
        others = [] if variant.encoder_scale is None else [variant.encoder_scale]
        key = _short([self.episodes, _canonical_json(variant.config), *others])
        changed = variant.oracle or variant.ablated
        return key if changed is None else f"{key}-{_short([changed, self.oracles])}"


def commit() -> str:
    """The last commit that changed the sources, with a `+` when the files differ from it.

    `unknown` outside of a git checkout.
    """
    try:
        head = _git("log", "-1", "--format=%h", "--", *_COMMITTED)
        changed = _git("status", "--porcelain", "--", *_COMMITTED)
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return head + ("+" if changed else "")


def key_of_sources(*names: str) -> str:
    """Key (twelve hexadecimal digits) of folders and files, named from `ROOT`."""
    return _short([_digest(path for name in names for path in _sources(name))])


def key_of_settings(*settings: BaseModel) -> str:
    """Key (twelve hexadecimal digits) of settings."""
    return _short(_canonical_json(part) for part in settings)


def key_of_robot(*names: str) -> str:
    """Key (twelve hexadecimal digits) of all that can change a run except its settings.

    More folders and files that count are named from `ROOT`.
    """
    more = [path for name in names for path in _sources(name)]
    return _short([_digest([*_robot_sources(*_PACKAGES), *more]), *_furniture()])


def hardware() -> str:
    """This machine in a few words."""
    cpu = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return cpu
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{len(names)} cores of {names[0]}" if names else cpu


def reference_ms() -> float:
    """Median time of the reference kernel on this machine now [ms]."""
    matrix = np.random.default_rng(0).standard_normal((_SIZE, _SIZE), np.float32)
    times = []
    for _ in range(_RUNS):
        began = time.perf_counter()
        matrix @ matrix
        times.append(time.perf_counter() - began)
    return 1000.0 * float(np.median(times))


def _robot_sources(*folders: str) -> list[Path]:
    """The sources in these folders that can change a run, with the embedded encoder's weights."""
    aside = [ROOT / folder for folder in _NO_PART_OF_A_RUN]
    found = [path for folder in folders for path in _sources(folder)]
    return [path for path in found if not any(path.is_relative_to(each) for each in aside)]


def _furniture() -> list[str]:
    return [entry.id for entry in read_catalogue()]


def _sources(name: str) -> list[Path]:
    """A file, or all sources in a folder.

    Raises:
        FileNotFoundError: there are none. A folder that has moved must not empty a key.
    """
    path = ROOT / name
    if path.is_file():
        return [path]
    found = [each for each in sorted(path.rglob("*")) if each.suffix in _SUFFIXES]
    if not found:
        raise FileNotFoundError(f"no sources at {path}")
    return found


def _weights(clip: str) -> str:
    """A digest of the weights in a folder; else the name, which stands for the weights."""
    folder = Path(clip).expanduser()
    if not folder.is_dir():
        return clip
    return _digest(sorted([*folder.glob("*.safetensors"), *folder.glob("*.bin")]))


def _digest(paths: Iterable[Path]) -> str:
    """A digest of names and contents; names of sources are relative to `ROOT`."""
    digest = hashlib.sha256()
    for path in paths:
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        name = path.relative_to(ROOT) if path.is_relative_to(ROOT) else path.name
        digest.update(f"{name} {content}\n".encode())
    return digest.hexdigest()


def _canonical_json(settings: BaseModel) -> str:
    """Settings as text, with a digest of the file that one of them names."""
    content = settings.model_dump(mode="json")
    if isinstance(settings, Config) and settings.clip_calibration:
        content["clip_calibration"] = read_calibration(Path(settings.clip_calibration)).digest
    return json.dumps(content, sort_keys=True)


def _short(parts: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:12]


def _git(*arguments: str) -> str:
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()
