"""`vizbot doctor`: a table of what is good and what is not, with remedies."""

from __future__ import annotations

import json
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from vizbot.commands.config.discovery import load_settings
from vizbot.core.clock import WallClock
from vizbot.core.errors import DeviceError
from vizbot.doctor import Finding, Grade, examine
from vizbot.operator.printing import echo, printable
from vizbot.recorder import default_folder

_STYLES = {Grade.GOOD: "green", Grade.POOR: "yellow", Grade.BAD: "bold red"}


def run(config_path: Path | None, clip: str | None, as_json: bool) -> None:
    """Check everything; exit code 1 if anything is bad.

    Raises:
        ConfigError: the configuration cannot be used.
    """
    config = load_settings(config_path, clip)
    findings = examine(config, WallClock(), default_folder().parent)
    if as_json:
        found = [
            {
                "subject": finding.subject,
                "verdict": finding.verdict.value,
                "found": finding.found,
                "remedy": finding.remedy,
            }
            for finding in findings
        ]
        echo(json.dumps({"well": not _bad(findings), "findings": found}))
    else:
        _print(findings)
    if _bad(findings):
        raise typer.Exit(1)


def require_well(findings: list[Finding]) -> None:
    """Refuse to launch where a finding is bad.

    Raises:
        DeviceError: one is; the line names all that are.
    """
    bad = [f"{each.subject}: {each.found}; {each.remedy}" for each in _bad(findings)]
    if bad:
        raise DeviceError("; ".join([*bad, "launch all the same with --force"]))


def _bad(findings: list[Finding]) -> list[Finding]:
    return [finding for finding in findings if finding.verdict is Grade.BAD]


def _print(findings: list[Finding]) -> None:
    table = Table(box=None, pad_edge=False)
    for column in ("", "what", "found", "remedy"):
        table.add_column(column, overflow="fold")
    for finding in findings:
        verdict = Text(finding.verdict.value, _STYLES[finding.verdict])
        texts = (finding.subject, finding.found, finding.remedy)
        table.add_row(verdict, *(Text(printable(text)) for text in texts))
    Console().print(table)
