"""The house in order: what a newcomer relies on when looking for something by its name."""

import ast
from collections import Counter
from pathlib import Path

import pytest

from tests.helpers.checkout import ROOT

PACKAGES = ("drivers", "mapping", "nav", "sim_stubs", "vizbot")
MEANINGLESS = {"at", "by", "for_", "in_", "of", "on", "to", "told", "with_"}
"""Words that say nothing of what a function gives back."""


def sources(*folders):
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


@pytest.fixture(scope="module")
def definitions():
    """Each class and function in the five packages, and the file it is in."""
    kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    return [
        (node, path.relative_to(ROOT))
        for path in sources(*PACKAGES)
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, kinds)
    ]


def test_no_two_public_classes_have_one_name(definitions):
    classes = [node.name for node, _ in definitions if isinstance(node, ast.ClassDef)]
    names = Counter(name for name in classes if not name.startswith("_"))
    assert [name for name, count in names.items() if count > 1] == []


def test_functions_are_named_by_what_they_do(definitions):
    bad = [
        f"{path}:{node.lineno} {node.name}"
        for node, path in definitions
        if node.name in MEANINGLESS
    ]
    assert bad == []


def test_no_function_takes_more_than_seven_parameters_but_compiled_ones(definitions):
    long = {
        f"{path}:{node.lineno} {node.name}": len(names)
        for node, path in definitions
        if not isinstance(node, ast.ClassDef)
        and not any(ast.unparse(each).startswith("kernel(") for each in node.decorator_list)
        and len(names := _parameters(node.args)) > 7
    }
    assert long == {}


def _parameters(signature):
    every = [*signature.posonlyargs, *signature.args, *signature.kwonlyargs]
    return [each.arg for each in every if each.arg not in ("self", "cls")]


@pytest.mark.parametrize(
    ("packages", "most"), [((*PACKAGES, "docs", "examples"), 20), (("tests",), 26)]
)
def test_a_folder_can_be_taken_in_at_a_glance(packages, most):
    folders = [ROOT / package for package in packages if (ROOT / package).is_dir()]
    folders += [path for folder in folders for path in folder.rglob("*") if path.is_dir()]
    full = {
        str(folder.relative_to(ROOT)): count
        for folder in folders
        if folder.name != "__pycache__"
        and (count := sum(each.is_file() for each in folder.iterdir())) > most
    }
    assert full == {}


def test_every_package_says_what_it_is_for():
    silent = [
        str(path.relative_to(ROOT))
        for path in sources(*PACKAGES)
        if path.name == "__init__.py" and not ast.get_docstring(ast.parse(path.read_text()))
    ]
    assert silent == []


def test_no_source_lies_in_a_folder_that_is_no_package():
    stray = {str(path.parent.relative_to(ROOT)) for path in sources(*PACKAGES)
             if not (path.parent / "__init__.py").is_file()}  # fmt: skip
    assert stray == set()


def test_no_folder_of_tests_is_named_like_a_package():
    assert not {Path(package).name for package in PACKAGES} & {
        path.name for path in (ROOT / "tests").iterdir() if path.is_dir()
    }
