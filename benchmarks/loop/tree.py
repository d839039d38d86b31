"""Trees of the sources: this one, and that of another commit to compare it with."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.harness.fingerprint import ROOT
from vizbot.core.errors import ConfigError
from vizbot.operator.printing import echo

_LOCKS = ("requirements.lock", "torch.lock")


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
