"""Mutants of the instruments: small changes to benches, scorer, search and belief.

`python -m tests.tools.mutants RESULTS.jsonl` draws them in equal parts from all comparisons,
constants, conditions and returned verdicts, and runs the test files that match each one in a
temporary copy of the working tree. RESULTS.jsonl keeps what became of each; a later run goes on.
Each mutant is drawn by itself, so that a change of the sources leaves the other ones drawn.
"""

from __future__ import annotations

import ast
import itertools
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import pytest
import typer

FOLDERS = ("benchmarks", "sim_stubs/scoring", "vizbot/objectnav", "mapping/clip")
MODULES = ("vizbot", "sim_stubs", "mapping", "benchmarks")
"""Folders of the modules through which a test may meet a mutant."""
PICTURES = ("benchmarks/slam/drawing.py",)
"""Modules that only draw: people look at what they make, and no result depends on it."""
KINDS = ("comparison", "constant", "condition", "verdict")
MOST_FILES, LONGEST = 8, 300.0
"""Number of test files that a mutant meets, and longest time of one [s]."""
FAILED_AT_IMPORT = (pytest.ExitCode.INTERRUPTED, pytest.ExitCode.INTERNAL_ERROR)
"""What pytest ends with where an import raises, and where it ends the program."""
ALIVE = ("survived", "timed out", "unclear")
CAPTURED: dict[str, bool] = {"capture_output": True, "text": True}
OTHERS = {
    ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.GtE), ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE), ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
}  # fmt: skip
"""Operators that may replace each operator of a comparison."""
Change = tuple[str, ast.expr, str]
"""Kind, expression and replacement."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """A change to one expression of a file of the working tree.

    Attributes:
        path: The file, from the root of the tree.
        line: Where the expression begins.
        start, end: The bytes between which it lies.
        kind: One of `KINDS`.
        before, after: The expression and its replacement.
        number: How many equal changes come before it in the file.
    """

    path: str
    line: int
    start: int
    end: int
    kind: str
    before: str
    after: str
    number: int

    @property
    def name(self) -> str:
        """What remains the same when the file changes elsewhere."""
        return repr((self.path, self.kind, self.before, self.after, self.number))

    def apply(self, source: bytes) -> bytes:
        """The source with this change."""
        return source[: self.start] + f"({self.after})".encode() + source[self.end :]


def mutants_of(path: str, source: bytes, seed: int) -> list[Mutant]:
    """One mutant of each comparison, constant, condition and verdict that is more than text."""
    starts = [0, *itertools.accumulate(map(len, source.splitlines(keepends=True)))]
    found, seen = [], Counter[tuple[str, str, str]]()
    for kind, node, after in _changes(ast.parse(source), "", seed):
        start = starts[node.lineno - 1] + node.col_offset
        end = starts[(node.end_lineno or 0) - 1] + (node.end_col_offset or 0)
        change = kind, ast.unparse(node), after
        found.append(Mutant(path, node.lineno, start, end, *change, seen[change]))
        seen[change] += 1
    return found


def _changes(node: ast.AST, returns: str, seed: int) -> Iterator[Change]:
    """All changes below a node of a function that `returns` a type."""
    match node:
        case (  # these make text, or declare what no result depends on
            ast.JoinedStr()
            | ast.Call(func=ast.Attribute(value=ast.Name(id="log" | "logger")))
            | ast.FunctionDef(returns=ast.Name(id="str"))
            | ast.If(test=ast.Name(id="TYPE_CHECKING"))
            | ast.keyword(arg="frozen" | "slots" | "eq" | "strict")
        ):
            return
        case ast.Call(func=ast.Name(id="round"), args=[rounded, *_]):
            yield from _changes(rounded, returns, seed)
            return
        case ast.FunctionDef(returns=ast.expr() as annotation):
            returns = ast.unparse(annotation)
        case ast.Compare(ops=operators):
            rng = random.Random(f"{seed} {ast.unparse(node)}")
            at = rng.randrange(len(operators))
            other = rng.choice(OTHERS[type(operators[at])])()
            others = [*operators[:at], other, *operators[at + 1 :]]
            yield "comparison", node, ast.unparse(ast.Compare(node.left, others, node.comparators))
        case ast.Constant(value=bool() | int() | float() as value):
            yield "constant", node, repr(not value if isinstance(value, bool) else 2 * value or 1)
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test):
            yield "condition", test, f"not ({ast.unparse(test)})"
        case ast.comprehension(ifs=tests):
            yield from (("condition", test, f"not ({ast.unparse(test)})") for test in tests)
        case ast.Return(value=ast.expr() as value):
            types, rng = returns.split(" | "), random.Random(f"{seed} {ast.unparse(value)}")
            verdict = rng.choice(("True", "False")) if "bool" in types else "None"
            if verdict != ast.unparse(value) and {"bool", "None"} & set(types):
                yield "verdict", value, verdict
    for child in ast.iter_child_nodes(node):
        yield from _changes(child, returns, seed)


def drawn(root: Path, seed: int) -> list[Mutant]:
    """All mutants, in the order in which they are drawn."""
    mutants = list[Mutant]()
    for file in (file for folder in FOLDERS for file in sorted((root / folder).rglob("*.py"))):
        if (path := str(file.relative_to(root))) not in PICTURES:
            mutants += mutants_of(path, file.read_bytes(), seed)
    return sorted(mutants, key=lambda m: sha256(f"{seed} {m.name}".encode()).digest())


def matching_tests(root: Path, path: str) -> list[str]:
    """Test files that import a module, then those that import a module that imports it.

    Among either the file that has its name comes first, then those that name most of what the
    module defines.
    """
    source = (root / path).read_text()
    defined = set(re.findall(r"^(?: {4}def |def |class )?(\w+)(?:\(| =|:)", source, re.MULTILINE))
    tests = sorted((root / "tests").rglob("test_*.py"))
    near = set(_importing(root, path, tests))
    modules = [path for name in MODULES for path in (root / name).rglob("*.py")]
    users = (str(user.relative_to(root)) for user in _importing(root, path, modules))
    found = near.union(*(_importing(root, user, tests) for user in users))
    named = {t: len(defined.intersection(re.findall(r"\w+", t.read_text()))) for t in found}
    own = f"test_{Path(path).name}"
    ordered = sorted(found, key=lambda t: (t not in near, t.name != own, -named[t], t))
    return [str(test.relative_to(root)) for test in ordered]


def _importing(root: Path, path: str, files: list[Path]) -> list[Path]:
    """The files that import the module of a path."""
    package, _, name = path.removesuffix(".py").replace("/", r"\.").rpartition(r"\.")
    pattern = rf"\b{package}\.{name}\b|\bfrom {package} import [^()\n]*\b{name}\b"
    return [file for file in files if re.search(pattern, file.read_text())]


class Copy:
    """A temporary copy of the working tree, in which the tests of mutants run."""

    def __init__(self, root: Path, to: Path) -> None:
        self.root = to
        listed = ["git", "ls-files", "-co", "--exclude-standard"]
        found = subprocess.run(listed, cwd=root, check=True, **CAPTURED)
        for name in filter(lambda name: (root / name).exists(), found.stdout.splitlines()):
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, to / name)

    def outcome(self, mutant: Mutant) -> tuple[str, str]:
        """What became of a mutant, and the test that failed or the files of which none did.

        It is killed, survived, timed out, void where it fails at import, or unclear where the test
        fails without the mutant, too.
        """
        file, became = self.root / mutant.path, "survived"
        source = file.read_bytes()
        tests = matching_tests(self.root, mutant.path)[:MOST_FILES]
        for test in tests:
            file.write_bytes(mutant.apply(source))
            code, failed = self._run(test)
            file.write_bytes(source)
            if code in FAILED_AT_IMPORT:
                return "void", test
            if failed:
                alone = self._run(failed)[0]
                return ("killed" if alone == pytest.ExitCode.OK else "unclear"), failed
            became = "timed out" if code is None else became
        return became, " ".join(tests)

    def _run(self, test: str) -> tuple[int | None, str]:
        """Exit code of pytest, None after a time-out, and the test that failed, if one did."""
        command = [sys.executable, "-m", "pytest", "-qx", "--tb=no", "-p", "no:cacheprovider", test]
        env = os.environ | {"PYTHONPATH": str(self.root), "PYTHONDONTWRITEBYTECODE": "1"}
        try:
            ended = subprocess.run(command, cwd=self.root, env=env, timeout=LONGEST, **CAPTURED)
        except subprocess.TimeoutExpired:
            return None, ""
        failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", ended.stdout, re.MULTILINE)
        return ended.returncode, failed[1] if failed else ""


def main(
    results: Annotated[Path, typer.Argument(help="File in which results are kept.")],
    count: Annotated[int, typer.Option(help="Number of mutants.")] = 60,
    seed: Annotated[int, typer.Option(help="Seed of the draw.")] = 0,
    again: Annotated[bool, typer.Option(help="Run again what was not killed.")] = False,
) -> None:
    """Draw mutants, run their tests, and print what became of each."""
    root = Path(__file__).resolve().parents[2]
    results.touch()
    command = ["git", "describe", "--always", "--dirty=+"]
    at = subprocess.run(command, cwd=root, check=True, **CAPTURED).stdout.strip()
    lines = map(json.loads, results.read_text().splitlines())
    known = {Mutant(**kept["mutant"]).name: kept for kept in lines}
    left, places, alive = dict.fromkeys(KINDS, count // len(KINDS)), set[tuple[str, int, int]](), 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(root, Path(folder))
        for mutant in drawn(root, seed):
            place = mutant.path, mutant.start, mutant.end
            if left[mutant.kind] == 0 or place in places:
                continue
            kept = known.get(mutant.name)
            if kept is None or (again and kept["outcome"] in ALIVE):
                outcome, by = copy.outcome(mutant)
                kept = {"commit": at, "mutant": asdict(mutant), "outcome": outcome, "by": by}
                with results.open("a") as file:
                    file.write(json.dumps(kept) + "\n")
            places.add(place)
            left[mutant.kind] -= kept["outcome"] != "void"
            alive += kept["outcome"] in ALIVE
            change = f"{mutant.path}:{mutant.line}  {mutant.before} -> {mutant.after}"
            typer.echo(f"{kept['outcome']:9} {mutant.kind:10} {change}  [{kept['by']}]")
    typer.echo(f"{alive} of {count - sum(left.values())} are not killed")


if __name__ == "__main__":
    typer.run(main)
