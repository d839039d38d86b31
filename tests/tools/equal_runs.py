"""Whether the robot does at this commit what it did at another one, byte for byte.

`python -m tests.tools.equal_runs COMMIT [--sequence FOLDER]` runs the same commands with the
sources of both: dry runs in several worlds with faults, a saved map and the paper's method,
questions to the map, and each benchmark once, small. It compares trajectories, commands, the arrays
of saved maps and the JSON that is printed, without times on the wall clock and names of folders,
and ends with 1 where anything differs. What has ended is kept in the folder of --out, by commit,
and is not run again.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from tests.helpers.checkout import ROOT

AT_ONCE = 2
"""Number of processes."""
COMPARED = ("trajectory.tum", "commands.csv", "map/map.safetensors")
"""Files of a run that are compared byte for byte, where they are there."""
NOT_COMPARED = re.compile(
    r"^(.*_ms|(.*_)?ms_.*|.*_cpu|wall_.*|created|run|map|commit|key|hardware|duration|stop_s"
    r"|.*seconds_a_.*)$"
)
"""Keys of JSON that say times on the wall clock, folders, or which sources and machine it was."""


@dataclass(frozen=True)
class Call:
    """A command line.

    Attributes:
        name: Of what it writes: a folder by that name, or none.
        arguments: Of `vizbot`; they may name folders of calls before it in its chain.
        times: Whether its rows are times on the wall clock: then the keys alone are compared.
    """

    name: str
    arguments: tuple[str, ...]
    times: bool = False


def drive(name: str, *arguments: str) -> Call:
    """A dry run that writes the folder `name`."""
    return Call(name, ("dry-run", *arguments, "--out", name, "--json"))


def ask(name: str, *arguments: str) -> Call:
    """A question to the map of the run `sofa`."""
    return Call(name, ("map", "query", "sofa", *arguments, "--json"))


def bench(name: str, *arguments: str, times: bool = False) -> Call:
    """A benchmark that keeps its rows in the folder `rows`."""
    return Call(name, ("bench", *arguments, "--json"), times)


CHAINS: tuple[tuple[Call, ...], ...] = (
    (
        drive("sofa", "sofa", "--world", "0"),
        drive("saved map", "refrigerator", "--world", "0", "--map", "sofa"),
        ask("sofa asked", "sofa"),
        ask("red cushion asked", "red cushion"),
        ask("kitchen asked", "where is the kitchen?"),
        ask("bench asked in German", "Bank", "--language", "de"),
        ask("lamp asked by the paper", "lamp", "--method", "paper"),
    ),
    (drive("camera", "bed", "--world", "3", "--faults", "bump@5,camera-frozen@12"),),
    (drive("lifted", "toilet", "--world", "5", "--faults", "wheel-drop@8+2,lost-bytes@2"),),
    (drive("two goals", "toilet", "table", "--world", "7"),),
    (drive("paper", "tv", "--world", "1", "--method", "paper"),),
    (drive("bare", "sofa", "--world", "12+bare"),),
    (drive("office", "chair", "--world", "office"),),
    (drive("port", "wardrobe", "--world", "1100", "--faults", "port-vanishes@6,virtual-wall@15"),),
    (drive("encoder", "sink", "--world", "1103", "--faults", "encoder-out-of-memory@9,imu-gap@4"),),
    (
        bench("objectnav", "objectnav", "--seeds", "3", "--goals", "1", "--rows", "default",
              "--out", "rows"),
        bench("multi", "multi", "--quick", "--seeds", "3", "--out", "rows"),
        bench("retrieval", "retrieval", "--quick", "--seeds", "3", "--out", "rows"),
        bench("absent", "absent", "--quick", "--seeds", "3", "--out", "rows"),
    ),
    (bench("faults", "faults", "--quick", "--seeds", "1100", "--out", "rows of faults"),),
    (bench("slam", "slam", "--quick", "--seeds", "1100", "--out", "rows of slam"),),
    (bench("planner", "planner", "--quick", times=True),),
    (bench("loop", "loop", "--quick", times=True),),
)  # fmt: skip
"""Calls that follow each other; chains run beside each other."""


def of_recording(sequence: Path) -> tuple[Call, ...]:
    """Calls on a recording in TUM layout."""
    return (
        Call("built", ("map", "build", f"{sequence}", "--out", "built", "--json")),
        bench("recording", "slam", f"{sequence}", "--quick", "--stride", "6", "--out", "poses"),
    )


def without_times(value: Any) -> Any:
    """JSON without what differs from run to run and from folder to folder."""
    if isinstance(value, dict):
        kept = {key: each for key, each in value.items() if not NOT_COMPARED.match(key)}
        return {key: without_times(each) for key, each in kept.items()}
    return [without_times(each) for each in value] if isinstance(value, list) else value


def keys_alone(value: Any) -> Any:
    """The keys of JSON, and of a list its first element's."""
    if isinstance(value, dict):
        return {key: keys_alone(each) for key, each in value.items()}
    return [keys_alone(value[0])] if isinstance(value, list) and value else None


def digest_of(call: Call, folder: Path, code: int, printed: str) -> dict[str, Any]:
    """What is compared of a call that has ended, by name."""
    answer = json.loads(printed) if printed.strip() else None
    files = {name: folder / call.name / name for name in COMPARED}
    return {
        "exit code": code,
        "answer": keys_alone(answer) if call.times else without_times(answer),
    } | {
        name: hashlib.sha256(path.read_bytes()).hexdigest()
        for name, path in files.items()
        if path.is_file()
    }


def differences(before: dict[str, Any], after: dict[str, Any]) -> list[str]:
    """What differs of a call, one line each."""
    return [
        f"{name}: {shown(before.get(name))} before, {shown(after.get(name))} now"
        for name in sorted({*before, *after})
        if before.get(name) != after.get(name)
    ]


def shown(value: Any) -> str:
    """A value in one line of a screen or two."""
    return json.dumps(value)[:300]


class Sources:
    """The sources of a commit, and what the calls gave with them."""

    def __init__(self, commit: str, out: Path) -> None:
        """Check a commit out beneath a folder, or go on with what is there."""
        self.commit = git("rev-parse", "--short=12", f"{commit}^{{commit}}")
        self.folder = out.resolve() / self.commit
        self.source = self.folder / "source"
        if not self.source.exists():
            git("worktree", "add", "--quiet", "--detach", f"{self.source}", self.commit)

    def results(self, calls: Sequence[Call]) -> dict[str, dict[str, Any]]:
        """What calls gave, in their order, each of which is run unless it is kept."""
        return {call.name: self._result(call) for call in calls}

    def _result(self, call: Call) -> dict[str, Any]:
        kept = self.folder / f"{call.name}.json"
        if not kept.exists():
            done = subprocess.run(
                [sys.executable, "-P", "-m", "vizbot", *call.arguments],
                cwd=self.folder,
                env=os.environ | {"PYTHONPATH": f"{self.source}", "HOME": f"{self.folder}"},
                capture_output=True,
                text=True,
                check=False,
            )
            (self.folder / f"{call.name}.err").write_text(done.stderr)
            result = digest_of(call, self.folder, done.returncode, done.stdout)
            kept.write_text(json.dumps({"arguments": call.arguments, **result}))
            typer.echo(f"{self.commit} {call.name}: exit code {done.returncode}", err=True)
        result = json.loads(kept.read_text())
        assert result.pop("arguments") == [*call.arguments], f"{kept} is of another call"
        return dict(result)


def git(*arguments: str) -> str:
    """What git prints in this checkout."""
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def main(
    commit: str,
    sequence: Annotated[Path | None, typer.Option(help="A recording in TUM layout.")] = None,
    only: Annotated[str | None, typer.Option(help="Names of calls, with commas.")] = None,
    before_alone: Annotated[bool, typer.Option(help="Run the calls at COMMIT alone.")] = False,
    out: Annotated[Path, typer.Option(help="Keeps what has ended.")] = Path("runs/equal"),
) -> None:
    """Compare this commit with COMMIT; end with 1 where a call differs."""
    chains = [*CHAINS, *([] if sequence is None else [of_recording(sequence.resolve())])]
    if only is not None:
        names = {name.strip() for name in only.split(",")}
        chains = [chain for chain in chains if names & {call.name for call in chain}]
    if sequence is None:
        typer.echo("no --sequence: nothing is compared on a recording", err=True)
    sides = [Sources(each, out) for each in ([commit] if before_alone else [commit, "HEAD"])]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        jobs = [[pool.submit(side.results, chain) for side in sides] for chain in chains]
        results = [[job.result() for job in pair] for pair in jobs]
    if before_alone:
        return
    equal = 0
    for before, after in results:
        for name, result in before.items():
            lines = differences(result, after[name])
            equal += not lines
            for line in lines:
                typer.echo(f"{name}: {line}")
    calls = sum(map(len, chains))
    typer.echo(f"{equal} of {calls} calls give the same at {sides[0].commit} and {sides[1].commit}")
    raise typer.Exit(0 if equal == calls else 1)


if __name__ == "__main__":
    typer.run(main)
