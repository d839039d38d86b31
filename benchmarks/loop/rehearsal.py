"""Rehearsals in processes of their own: how long a tick takes, alone and beside a rival."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.harness.fingerprint import ROOT
from vizbot.core.errors import ConfigError, VizbotError
from vizbot.operator.printing import echo

_LOCKS = ("requirements.lock", "torch.lock")
_STEP = re.compile(r"step +(\d+) ")
_SETTINGS = "[objectnav]\nmax_steps = {}\n"


@dataclass(frozen=True, slots=True)
class Tree:
    """Sources, and the interpreter that has what they need."""

    path: Path
    python: str = sys.executable


HERE = Tree(ROOT)


@contextmanager
def checked_out(commit: str) -> Iterator[Tree]:
    """The sources of a commit in a folder of their own, with an environment of their own.

    Where it needs the same packages as this one it shares this environment.

    Raises:
        ConfigError: there is no such commit, no repository, or its packages cannot be installed.
    """
    with TemporaryDirectory(prefix="vizbot-against-") as folder:
        path = Path(folder) / "tree"
        _run(["git", "worktree", "add", "--detach", str(path), commit], ROOT, f"--against {commit}")
        try:
            yield Tree(path, _interpreter(path))
        finally:
            _run(["git", "worktree", "remove", "--force", str(path)], ROOT, str(path))


def _interpreter(path: Path) -> str:
    same = all(
        (path / lock).is_file() and (path / lock).read_bytes() == (ROOT / lock).read_bytes()
        for lock in _LOCKS
    )
    if same:
        return sys.executable
    echo(f"{path}: installing other packages than those here", err=True)
    _run(["make", "--silent", "install"], path, "make install")
    return str(path / ".venv/bin/python")


def _run(command: list[str], cwd: Path, what: str) -> None:
    try:
        done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    except OSError as error:
        raise ConfigError(f"{what}: {command[0]} cannot be run ({error.strerror})") from error
    if done.returncode != 0:
        reason = (done.stderr or done.stdout).strip().splitlines() or ["no reason given"]
        raise ConfigError(f"{what}: {reason[-1]}")


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """A `vizbot dry-run` as another program sees it.

    Attributes:
        wall: Mean time of a tick between the first and the last printed one [s].
        processor: Mean processor time of a tick, of all threads [s].
        steps: Number of ticks between them.
        commands: Digest of trajectory and commands.
    """

    wall: float
    processor: float
    steps: int
    commands: str


@dataclass(frozen=True, slots=True)
class PrintedStep:
    """A line of progress.

    Attributes:
        number: Of the step.
        wall: When it came [s].
        processor: Processor time of the process until then [s].
    """

    number: int
    wall: float
    processor: float


def rehearse(tree: Tree, world: str, goal: str, steps: int) -> Rehearsal:
    """Rehearse a search for at most so many steps.

    Raises:
        VizbotError: it ended before two lines of progress.
    """
    with TemporaryDirectory(prefix="vizbot-loop-") as name:
        folder = Path(name)
        (folder / "settings.toml").write_text(_SETTINGS.format(steps))
        command = [
            tree.python, "-m", "vizbot", "dry-run", goal, "--world", world,
            "--config", str(folder / "settings.toml"), "--out", str(folder / "run"),
        ]  # fmt: skip
        printed, said = _follow(command, tree)
        if len(printed) < 2:
            raise VizbotError(f"world {world}: the rehearsal in {tree.path} ended early: {said}")
        kept = [folder / "run" / name for name in ("trajectory.tum", "commands.csv")]
        digest = hashlib.sha256(b"".join(each.read_bytes() for each in kept)).hexdigest()[:12]
    return mean_tick(printed, digest)


def mean_tick(printed: Sequence[PrintedStep], digest: str) -> Rehearsal:
    """What the printed steps of a rehearsal say."""
    first, last = printed[0], printed[-1]
    steps = last.number - first.number
    return Rehearsal(
        (last.wall - first.wall) / steps,
        (last.processor - first.processor) / steps,
        steps,
        digest,
    )


@contextmanager
def rival() -> Iterator[None]:
    """Another program keeps one core busy meanwhile."""
    busy = "import os\nparent = os.getppid()\nwhile os.getppid() == parent: pass"
    process = subprocess.Popen([sys.executable, "-c", busy])
    try:
        yield
    finally:
        process.kill()
        process.wait()


def _follow(command: list[str], tree: Tree) -> tuple[list[PrintedStep], str]:
    """The printed steps of a program while it runs, and the last line that it said."""
    printed, said = [], ""
    environment = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")}
    environment.pop("OMP_WAIT_POLICY", None)
    process = subprocess.Popen(
        command,
        cwd=tree.path,
        env=environment | {"PYTHONPATH": str(tree.path)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    with process, process.stderr as lines:
        for line in lines:
            said = line.strip() or said
            if found := _STEP.match(line):
                used = processor_time(Path(f"/proc/{process.pid}/stat"))
                printed.append(PrintedStep(int(found[1]), time.monotonic(), used))
    return printed, said


def processor_time(stat: Path) -> float:
    """User and system time [s] in the file `stat` of a process (proc(5))."""
    fields = stat.read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
