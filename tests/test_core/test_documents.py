"""What the pages show exists: links, commands, settings, code and public names."""

import ast
import importlib
import re
import shlex
import tomllib

import pytest
import typer.main

from benchmarks.app import app as bench_app
from tests.helpers.checkout import ROOT
from vizbot.cli.app import app
from vizbot.config import Config

PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"|srcset=\"([^\"]+)\"")
on_every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def prose(page):
    """The page without its blocks of code."""
    return FENCE.sub("", page.read_text())


def blocks(page, language):
    return [body for name, body in FENCE.findall(page.read_text()) if name == language]


def anchors(page):
    """What GitHub calls the headings of a page."""
    titles = re.findall(r"^#+ +(.+)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def shell_lines(page):
    """Commands of the page's blocks, without comments and what they are piped into."""
    for block in blocks(page, ""):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            ends = [i for i, word in enumerate(words) if word in ("|", "&&", ">")]
            yield words[: ends[0]] if ends else words


def all_commands():
    """The commands, with the benchmarks in place of the command that hands its words on to them."""
    command = typer.main.get_command(app)
    command.commands["bench"] = typer.main.get_command(bench_app)
    return command


def command_of(words):
    """The command of vizbot that these words call, and what is left for it."""
    command = all_commands()
    while words and words[0] in getattr(command, "commands", {}):
        command, words = command.commands[words[0]], words[1:]
    return command, words


@on_every_page
def test_every_link_leads_somewhere(page):
    for target in ("".join(found) for found in LINK.findall(prose(page))):
        if re.match(r"https?:|mailto:", target):
            continue
        path, _, anchor = target.partition("#")
        linked = (page.parent / path).resolve() if path else page
        assert linked.exists(), f"{target} is nowhere"
        if anchor:
            assert anchor in anchors(linked), f"{target}: there is no such heading"


@on_every_page
def test_every_command_in_a_block_can_be_called(page, monkeypatch):
    monkeypatch.delenv("VIZBOT_URL", raising=False)
    for words in shell_lines(page):
        if words and words[0].rpartition("/")[2] == "vizbot":
            command, left = command_of(words[1:])
            called = not hasattr(command, "commands") or command.invoke_without_command
            assert called, f"{shlex.join(words)}: no such command"
            command.make_context(command.name, list(left))  # raises what a user would read


@on_every_page
def test_every_command_in_a_line_exists(page):
    for shown in re.findall(r"`vizbot ([^`]+)`", prose(page)):
        command, left = command_of(shlex.split(shown))
        known = {option for each in command.params for option in each.opts} | {"--help"}
        assert {word for word in left if word.startswith("--")} <= known, shown
        if hasattr(command, "commands"):
            assert not left or left[0].startswith("--"), f"vizbot {shown}: no such command"


@on_every_page
def test_every_target_of_make_exists(page):
    targets = set(re.findall(r"^([\w\- ]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    known = {target for line in targets for target in line.split()}
    for words in shell_lines(page):
        if words and words[0] == "make":
            assert {word for word in words[1:] if "=" not in word} <= known


@on_every_page
def test_settings_can_be_set(page):
    for block in blocks(page, "toml"):
        Config.model_validate(tomllib.loads(block))


@on_every_page
def test_imports_of_shown_code_exist(page):
    for block in blocks(page, "python"):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom):
                module = importlib.import_module(node.module)
                for name in node.names:
                    assert hasattr(module, name.name), f"{node.module} has no {name.name}"


def test_what_is_called_public_exists():
    page = (ROOT / "docs" / "python.md").read_text()
    table = page.partition("## What is public")[2].partition("\n## ")[0]
    for modules, offers in re.findall(r"^\| (`.*?) \| (.*) \|$", table, re.MULTILINE):
        paths = re.findall(r"`([\w.]+)`", modules)
        package = paths[0].rpartition(".")[0]
        loaded = [
            importlib.import_module(package + path if path.startswith(".") else path)
            for path in paths
        ]
        for name in re.findall(r"`(\w+)`", offers):
            assert any(hasattr(module, name) for module in loaded), f"{name} is in none of {paths}"


def test_the_readme_can_be_read_in_a_minute():
    text = (ROOT / "README.md").read_text()
    assert len(text) < 8000
    assert not re.search(r"\b(?=\w*\d)[0-9a-f]{7,40}\b", re.sub(r"\d{4}\.\d{5}", "", text))


def every_command(command, name=()):
    below = getattr(command, "commands", None)
    if below is None:
        return [(name, command)]
    return [each for word in below for each in every_command(below[word], (*name, word))]


def test_the_help_of_every_command_has_an_example_that_can_be_called():
    for name, command in every_command(all_commands()):
        words = shlex.split((command.epilog or "").partition("Example: ")[2])
        assert tuple(words[: len(name) + 1]) == ("vizbot", *name), shlex.join(name)
        command.make_context(command.name, words[len(name) + 1 :])
