"""The page of all settings, docs/settings.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vizbot.commands.config.settings_table import Setting, Table

COMMAND = "vizbot config schema --markdown > docs/settings.md"
"""What writes the page."""
_BEGINNING = f"""\
# Settings

Every setting of the TOML file that `--config` names: its default, its unit, and what it may be. A
file needs only what differs from the defaults. `vizbot config init` writes one with the settings
for people, `vizbot config show` prints those in use, and `vizbot config schema` prints this page as
a JSON schema, for editors. Wrong settings are refused in one line that names the setting, its value
and what it means. [Which file is used](robot.md#settings) where `--config` is not given.

This page is made of the settings' own descriptions: `{COMMAND}`.
"""


def settings_page(tables: Sequence[Table]) -> str:
    """The page in Markdown: settings for people, then the others, by the headings of the file."""
    parts = [_BEGINNING]
    for title, advanced in (("Settings for people", False), ("Advanced settings", True)):
        parts.append(f"## {title}\n")
        for table in tables:
            if shown := tuple(each for each in table.settings if each.advanced is advanced):
                parts.append(_section(replace(table, settings=shown)))
    return "\n".join(parts)


def _section(table: Table) -> str:
    title = f"`{table.heading}`" if table.heading else "Before any heading"
    lines = [f"### {title}", "", table.description]
    if table.caution:
        lines += ["", table.caution]
    lines += ["", "| setting | default | unit | values | what it is |", "|---|---|---|---|---|"]
    return "\n".join([*lines, *map(_row, table.settings), ""])


def _row(setting: Setting) -> str:
    default = "none" if setting.default is None else f"`{setting.default}`"
    columns = (f"`{setting.name}`", default, setting.unit, setting.values, setting.meaning)
    return f"| {' | '.join(text.replace('|', '&#124;') for text in columns)} |"
