"""`vizbot bench loop`: what a tick takes; another commit, a rival program, a large map."""

from __future__ import annotations

import os
import re
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import cycle, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from pydantic_core import to_json

from benchmarks.harness.bench_plan import BenchResult
from benchmarks.harness.fingerprint import REFERENCE_KERNEL, commit, hardware, reference_ms
from benchmarks.harness.tables import markdown_table
from benchmarks.loop.rehearsal import HERE, Rehearsal, Tree, checked_out, rehearse, rival
from benchmarks.loop.startup import measure_startup
from benchmarks.loop.ticks import Ticks, TimedDrive, read_ticks
from benchmarks.loop.waits import PEACE, WaitingDrive, Waits, read_waits
from vizbot.core.errors import VizbotError
from vizbot.core.program.threads import keep_a_core_free, let_threads_sleep
from vizbot.operator.language.command_grammar import MOST_LETTERS, MOST_WORDS
from vizbot.operator.language.language import languages, load_language
from vizbot.operator.language.understanding import read_typed
from vizbot.operator.printing import echo

_BESIDE = {"answers", "doing", "names", "small", "spoken"}
"""Tables of a language whose words are in no pattern."""
_NOTATION = re.compile(r"[()\[\]|]|\{\w+\}|<\w+>")
_TRIES = 3
NAME = "loop"
GOAL = "sofa"
FEW, LARGE, MANY = 10_000, 400_000, 1_000_000
"""Numbers of elements of a usual map, of the largest that can be saved, and of a very large one."""


def worst_sentence() -> tuple[float, str]:
    """The processor time of the slowest sentence of all languages [s], and the words repeated.

    Of several readings of a sentence the median counts.
    """
    worst = (0.0, "")
    for code in languages():
        language = load_language(code)
        for words in rows_of_words(code):
            line = " ".join(islice(cycle(words.split()), MOST_WORDS))[:MOST_LETTERS]
            read_typed(line, language)  # makes its patterns
            worst = max(worst, (_reading(code, line), words))
    return worst


def rows_of_words(code: str) -> list[str]:
    """Rows of words, each once, that the patterns and lists of a language are made of."""
    return sorted(set(_words(load_language(code).entries)))


def _reading(code: str, line: str) -> float:
    language, times = load_language(code), list[float]()
    for _ in range(_TRIES):
        language.grammar.forget()
        began = time.thread_time()
        read_typed(line, language)
        times.append(time.thread_time() - began)
    return sorted(times)[_TRIES // 2]


def _words(entries: Any) -> Iterator[str]:
    """Rows of words without a choice in what a language's file holds."""
    if isinstance(entries, str):
        yield from (" ".join(row.split()) for row in _NOTATION.split(entries) if row.strip())
    elif isinstance(entries, dict):
        for key, value in entries.items():
            if key not in _BESIDE:
                yield from _words([key, value])
    elif isinstance(entries, list):
        for each in entries:
            yield from _words(each)


@dataclass(frozen=True, slots=True)
class LoopBench:
    """What is measured.

    Attributes:
        against: Commit to compare with; None for none.
        homes: Homes of the rehearsals.
        runs: How often each rehearsal is repeated.
        steps: Number of ticks of each.
    """

    against: str | None
    homes: tuple[str, ...] = ("1100", "1101", "1102", "1103", "1104")
    runs: int = 3
    steps: int = 125

    @classmethod
    def quick(cls, against: str | None) -> LoopBench:
        """A short one, which may be claimed nowhere."""
        return cls(against, ("1100",), 1, 50)


def run_loop(bench: LoopBench) -> BenchResult:
    """Measure and print the tables.

    Raises:
        VizbotError: there is no such commit, or a rehearsal fails.
    """
    kernel_ms = reference_ms()
    summary: dict[str, object] = {"reference_kernel_ms": round(kernel_ms, 1)}
    rows: list[dict[str, object]] = []
    text = [f"At commit {commit()}, on {hardware()}; {REFERENCE_KERNEL}: {kernel_ms:.1f} ms."]
    if bench.against is not None:
        with checked_out(bench.against) as tree:
            compared = _compare(bench, tree)
        rows += compared
        ratios = [float(str(row["speedup"])) for row in compared]
        summary["rehearsal_over_baseline"] = round(float(np.mean(ratios)), 3)
        summary["same_commands"] = all(row["same_commands"] for row in compared)
        text.append(_table(f"Rehearsals, here and at {bench.against}", compared))
    alone, beside = _beside_rival(bench)
    rows += [_row("alone", alone), _row("beside a rival", beside)]
    summary["beside_rival"] = _ratio(alone, beside, lambda each: each.wall)
    summary["rival_processor"] = _ratio(alone, beside, lambda each: each.processor)
    text.append(_table("Alone and beside a program that keeps a core busy", rows[-2:]))
    with TemporaryDirectory(prefix="vizbot-loop-") as folder:
        cold = drive_in_process(
            TimedDrive(bench.homes[0], GOAL, bench.steps), Path(folder) / "numba"
        )
        summary["longest_over_p95"] = longest_over_p95(cold)
        recorded = Path(folder) / "recorded"
        _record(bench, recorded)
        waits = measure_startup(recorded / "map", bench.runs)
        few, many = (
            drive_in_process(
                TimedDrive(bench.homes[0], GOAL, bench.steps, str(recorded / "map"), count)
            )
            for count in (FEW, MANY)
        )
        waited = _waits(bench)
    summary["longest_wait_ms"] = max(float(str(row["longest_ms"])) for row in waited)
    rows += waited
    text.append(_table("Waits for a growing map, a save, a console", waited))
    summary["tick_ratio_1m_over_10k"] = round(_median(many) / _median(few), 3)
    for name, ticks in (("10 k elements", few), ("1 M elements", many)):
        stages = _stage_rows(name, ticks)
        rows += stages
        text.append(_table(f"Stages of a tick, {name}", stages))
    for name, wait in waits.items():
        summary[name] = round(wait.wall, 2)
        if name == "stop_s":  # a busy machine makes a user wait for what it takes of a processor
            summary[name] = round(wait.processor, 3)
        rows.append(
            {"name": name, "processor_ms": _in_ms(wait.processor), "wall_ms": _in_ms(wait.wall)}
        )
    text.append(_table("Until an answer, a refusal, the first tick, a stop", rows[-len(waits) :]))
    seconds, words = worst_sentence()
    summary["sentence_ms"] = round(1000 * seconds, 1)
    text.append(f"Slowest sentence: {words!r}, repeated, {1000 * seconds:.1f} ms of processor.")
    text.append(_table("Summary", [summary]))
    return BenchResult(NAME, rows, summary, "\n\n".join(text))


def drive_in_process(drive: TimedDrive, cache: Path | None = None) -> Ticks:
    """Drive in a new process.

    Args:
        drive: What is driven.
        cache: Folder of numba's compiled kernels; None for the usual one.

    Raises:
        VizbotError: it failed.
    """
    return read_ticks(_printed("ticks", drive, cache))


def _waits(bench: LoopBench) -> list[dict[str, object]]:
    """One row for each size of the map: how long ticks waited, the median of all runs."""
    rows: list[dict[str, object]] = []
    for elements, saved in ((LARGE, True), (MANY, False)):
        drive = WaitingDrive(bench.homes[0], GOAL, PEACE + bench.steps, elements, saved)
        runs = [read_waits(_printed("waits", drive)) for _ in range(bench.runs)]
        row: dict[str, object] = {
            "elements": elements,
            "saves": min(run.saves for run in runs),
            "answers": min(run.answers for run in runs),
        }
        for name, of_run in _WAITS.items():
            row[name] = round(1000 * float(np.median([of_run(run) for run in runs])), 1)
        rows.append(row)
    return rows


_WAITS: dict[str, Callable[[Waits], float]] = {
    "longest_ms": lambda run: run.longest,
    "own_ms": lambda run: max(run.own),
    "held_ms": lambda run: run.held,
    "held_in_peace_ms": lambda run: run.held_in_peace,
}


def _printed(module: str, drive: TimedDrive | WaitingDrive, cache: Path | None = None) -> str:
    """What a module of this folder prints of a drive in a new process.

    Raises:
        VizbotError: it failed.
    """
    let_threads_sleep()
    keep_a_core_free()
    environment = dict(os.environ) | {"PYTHONPATH": str(HERE.path)}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    command = [HERE.python, "-m", f"benchmarks.loop.{module}", to_json(asdict(drive)).decode()]
    done = subprocess.run(
        command, cwd=HERE.path, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        said = done.stderr.strip().splitlines() or ["no reason given"]
        raise VizbotError(f"a drive in world {drive.world} failed: {said[-1]}")
    return done.stdout


def longest_over_p95(ticks: Ticks) -> float:
    """The longest tick after the first motion over their 95th percentile."""
    moving = [wall for wall, moved in zip(ticks.wall, ticks.moved, strict=True) if moved]
    return round(max(moving) / float(np.quantile(moving, 0.95)), 3)


def _compare(bench: LoopBench, other: Tree) -> list[dict[str, object]]:
    """One row a home: here and there in turns."""
    rows = []
    for home in bench.homes:
        here: list[Rehearsal] = []
        there: list[Rehearsal] = []
        for _ in range(bench.runs):
            here.append(rehearse(HERE, home, GOAL, bench.steps))
            there.append(rehearse(other, home, GOAL, bench.steps))
        speedups = [b.wall / a.wall for a, b in zip(here, there, strict=True)]
        row = {
            "home": home,
            "here_ms": _ms(here, lambda each: each.wall),
            "there_ms": _ms(there, lambda each: each.wall),
            "here_processor_ms": _ms(here, lambda each: each.processor),
            "there_processor_ms": _ms(there, lambda each: each.processor),
            "speedup": round(float(np.median(speedups)), 3),
            "slowest": round(min(speedups), 3),
            "fastest": round(max(speedups), 3),
            "same_commands": len({each.commands for each in here + there}) == 1,
        }
        echo(f"home {home}: {row['speedup']} times as fast", err=True)
        rows.append(row)
    return rows


def _beside_rival(bench: LoopBench) -> tuple[list[Rehearsal], list[Rehearsal]]:
    alone: list[Rehearsal] = []
    beside: list[Rehearsal] = []
    for _ in range(bench.runs):
        alone.append(rehearse(HERE, bench.homes[0], GOAL, bench.steps))
        with rival():
            beside.append(rehearse(HERE, bench.homes[0], GOAL, bench.steps))
    return alone, beside


def _record(bench: LoopBench, folder: Path) -> None:
    """Record a run whose map is then begun in."""
    command = [HERE.python, "-m", "vizbot", "dry-run", "--explore", "--world", bench.homes[0]]
    settings = folder.with_suffix(".toml")
    settings.write_text(f"[objectnav]\nmax_steps = {bench.steps}\n")
    done = subprocess.run(
        [*command, "--config", str(settings), "--out", str(folder)],
        cwd=HERE.path,
        env=dict(os.environ) | {"PYTHONPATH": str(HERE.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    if not (folder / "map").is_dir():
        said = done.stderr.strip().splitlines() or ["no reason given"]
        raise VizbotError(f"no map of world {bench.homes[0]} was recorded: {said[-1]}")


def _stage_rows(name: str, ticks: Ticks) -> list[dict[str, object]]:
    count = len(ticks.wall)
    whole = {
        "map": name,
        "name": "tick",
        "processor_ms": round(1000 * sum(ticks.processor) / count, 2),
        "wall_ms": round(1000 * sum(ticks.wall) / count, 2),
    }
    return [whole] + [
        {
            "map": name,
            "name": stage,
            "processor_ms": round(1000 * time.processor / count, 2),
            "wall_ms": round(1000 * time.wall / count, 2),
        }
        for stage, time in ticks.stages.items()
    ]


def _row(name: str, runs: Sequence[Rehearsal]) -> dict[str, object]:
    return {
        "name": name,
        "processor_ms": _ms(runs, lambda each: each.processor),
        "wall_ms": _ms(runs, lambda each: each.wall),
        "hz": round(1.0 / float(np.median([each.wall for each in runs])), 2),
    }


def _ms(runs: Sequence[Rehearsal], of_run: Callable[[Rehearsal], float]) -> float:
    return round(1000 * float(np.median([of_run(each) for each in runs])), 1)


def _ratio(
    alone: Sequence[Rehearsal], beside: Sequence[Rehearsal], of_run: Callable[[Rehearsal], float]
) -> float:
    ratios = [of_run(b) / of_run(a) for a, b in zip(alone, beside, strict=True)]
    return round(float(np.median(ratios)), 3)


def _in_ms(seconds: float) -> float:
    """Milliseconds."""
    return round(1000 * seconds)


def _median(ticks: Ticks) -> float:
    return float(np.median(ticks.wall))


def _table(title: str, rows: Sequence[dict[str, object]]) -> str:
    header = list(rows[0])
    cells = [[str(row.get(name, "-")) for name in header] for row in rows]
    return f"{title}\n\n{markdown_table(header, cells)}"
