"""Mutants are drawn from what can change a result, and what became of them is kept."""

import json
import subprocess
from dataclasses import replace

import pytest

from tests.tools import mutants
from tests.tools.mutants import KINDS, Copy, drawn, matching_tests, mutants_of

SOURCE = b'''"""A module of 2 functions."""
import logging
from dataclasses import dataclass

log = logging.getLogger(__name__)
SHARE = (0.1, 0.9)[1]


@dataclass(frozen=True)
class Score:
    count: int

    def line(self) -> str:
        return f"{100 * self.count:.1f} %" if self.count > 0 else "none"


def late(seconds: float, limit: float = 0.5) -> bool:
    """\xc3\x9cber die Zeit."""
    log.info("%d", 3)
    if round(seconds, 2) <= limit:
        return False
    return any(part for part in (seconds,) if part)


def unused(seconds: float) -> float | None:
    return seconds
'''
TEST = """
from benchmarks.late import late

def test_half_a_second_is_not_late():
    assert not late(0.5) and late(0.6)
"""


@pytest.fixture
def tree(tmp_path):
    """A working tree with one module, what uses it, and tests."""
    for path, text in (
        ("vizbot/__init__.py", ""),
        ("benchmarks/__init__.py", ""),
        ("benchmarks/late.py", SOURCE.decode()),
        ("benchmarks/user.py", "from benchmarks.late import late\n"),
        ("tests/test_late.py", TEST),
        ("tests/test_a_user.py", "import benchmarks.user\n\ndef test_late():\n    assert True\n"),
        ("tests/test_other.py", "def test_late():\n    raise AssertionError\n"),
    ):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)
    for command in (
        ("init", "-q"),
        ("add", "."),
        ("-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "A tree"),
    ):
        subprocess.run(["git", *command], cwd=tmp_path, check=True)
    return tmp_path


def test_what_is_drawn_changes_more_than_text():
    found = mutants_of("late.py", SOURCE, 0)
    # Where a verdict is drawn that the source returns, there is nothing to change.
    assert {(m.kind, m.line, m.before) for m in found} - {("verdict", 21, "False")} == {
        ("constant", 6, "0.1"),
        ("constant", 6, "0.9"),
        ("constant", 6, "1"),
        ("constant", 17, "0.5"),
        ("comparison", 20, "round(seconds, 2) <= limit"),
        ("condition", 20, "round(seconds, 2) <= limit"),
        ("constant", 21, "False"),
        ("verdict", 22, "any((part for part in (seconds,) if part))"),
        ("condition", 22, "part"),
        ("verdict", 26, "seconds"),
    }
    for mutant in found:
        changed = mutant.apply(SOURCE)
        compile(changed, "late.py", "exec")
        assert mutant.after.encode() in changed.splitlines()[mutant.line - 1]


def test_a_seed_draws_the_same_mutants_again(tree):
    assert drawn(tree, 0) == drawn(tree, 0) != drawn(tree, 1)


def test_a_change_of_the_sources_leaves_the_other_mutants_drawn(tree):
    before = [mutant.name for mutant in drawn(tree, 0)]
    path = tree / "benchmarks/late.py"
    path.write_bytes(SOURCE.replace(b"0.5", b"12.25").replace(b'"%d", 3', b'"%d of %d", 3, 4'))
    after = [mutant.name for mutant in drawn(tree, 0)]
    changed = set(before) ^ set(after)
    assert len(changed) == 2 and all("'0.5'" in name or "'12.25'" in name for name in changed)
    left = [name for name in before if name not in changed]
    assert left == [name for name in after if name not in changed]


def test_tests_of_the_module_come_before_those_of_its_users(tree):
    found = matching_tests(tree, "benchmarks/late.py")
    assert found == ["tests/test_late.py", "tests/test_a_user.py"]
    (tree / "tests/test_all.py").write_text(f"{TEST}\nlogging = seconds = limit = unused = late\n")
    found = matching_tests(tree, "benchmarks/late.py")
    assert found == ["tests/test_late.py", "tests/test_all.py", "tests/test_a_user.py"]


def test_a_mutant_is_killed_survives_fails_at_import_or_meets_a_test_that_fails_anyway(
    tree, tmp_path_factory
):
    copy = Copy(tree, tmp_path_factory.mktemp("copy"))
    found = {(m.kind, m.before): m for m in drawn(tree, 0)}
    failing = "tests/test_late.py::test_half_a_second_is_not_late"
    for change, became in (
        (("condition", "round(seconds, 2) <= limit"), ("killed", failing)),
        (("verdict", "seconds"), ("survived", "tests/test_late.py tests/test_a_user.py")),
        (("constant", "1"), ("void", "tests/test_late.py")),
    ):
        assert copy.outcome(found[change]) == became
    ends = replace(found["constant", "1"], after="__import__('sys').exit(2)")
    assert copy.outcome(ends) == ("void", "tests/test_late.py")
    (copy.root / "tests/test_late.py").write_text(TEST.replace("not ", ""))
    killed = found["condition", "round(seconds, 2) <= limit"]
    assert copy.outcome(killed) == ("unclear", failing)
    assert (copy.root / "benchmarks/late.py").read_bytes() == SOURCE


def test_a_later_run_draws_again_what_is_void_and_runs_only_what_is_not_known(
    tree, capsys, monkeypatch
):
    ran = []

    def outcome(copy, mutant):
        ran.append(mutant)
        return ("void" if mutant.before == "1" else "survived"), ""

    monkeypatch.setattr(Copy, "outcome", outcome)
    monkeypatch.setattr(mutants, "__file__", str(tree / "tests/tools/mutants.py"))
    results = tree / "results.jsonl"
    for kept in (4, 0):
        mutants.main(results, count=4)
        counted = [m.kind for m in ran if m.before != "1"]
        assert sorted(counted) == (sorted(KINDS) if kept else [])
        assert capsys.readouterr().out.endswith("4 of 4 are not killed\n")
        ran.clear()
    mutants.main(results, count=4, again=True)
    assert len(ran) == 4
    assert all(json.loads(line)["outcome"] for line in results.read_text().splitlines())
