"""Every setting with description, unit, default and bounds, and the page of them."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from vizbot.commands.config.discovery import rehearsal_settings, with_rehearsal
from vizbot.config import Config
from vizbot.core.settings import UNIT
from vizbot.operator.printing import printable

_BOUNDS = {
    "exclusiveMinimum": "> {}",
    "minimum": ">= {}",
    "exclusiveMaximum": "< {}",
    "maximum": "<= {}",
    "minItems": "at least {}",
}
Node: TypeAlias = Mapping[str, Any]
"""A part of a JSON schema."""


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting.

    Attributes:
        description: Its description in one line, with the unit in brackets.
        default: Its value where no file has its table, as TOML has it; None if it then has none.
        values: What it may be, in words.
        advanced: Whether only those who work on the robot's program change it.
    """

    name: str
    description: str
    default: str | None
    values: str
    advanced: bool

    @property
    def unit(self) -> str:
        """Unit of its value; empty if it has none."""
        found = UNIT.search(self.description)
        return "" if found is None else found[1]

    @property
    def meaning(self) -> str:
        """Its description without the unit."""
        return UNIT.sub("", self.description)


@dataclass(frozen=True, slots=True)
class Table:
    """Settings that stand below one heading.

    Attributes:
        heading: The heading as TOML has it, `[mount]`; empty for what stands above all headings.
            `[[...]]` is an entry of a list.
        description: What it is about, in one line.
        settings: Those in it.
        caution: What changes by the heading alone; empty if nothing does.
    """

    heading: str
    description: str
    settings: tuple[Setting, ...]
    caution: str = ""


def all_tables() -> list[Table]:
    """All settings in the order of the models, tables after the settings that stand before them."""
    schema, defaults = settings_schema(), with_rehearsal(Config())
    return list(_tables("", schema, defaults.model_dump(mode="json"), schema["$defs"]))


def settings_schema() -> dict[str, Any]:
    """The JSON schema of all settings; of rehearsals too, where there is a simulator."""
    schema, rehearsal = Config.model_json_schema(), rehearsal_settings()
    if rehearsal is not None:
        for part, content in rehearsal.model_json_schema().items():
            if part in ("$defs", "properties"):
                schema[part] |= content
    return schema


def toml_value(value: Any) -> str:
    """A value of JSON on one line of TOML."""
    if isinstance(value, dict):
        entries = (f"{key} = {toml_value(each)}" for key, each in value.items())
        return f"{{{', '.join(entries)}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(toml_value, value))}]"
    return printable(json.dumps(value, ensure_ascii=False))


def _tables(
    key: str, model: Node, defaults: Node | None, definitions: Node, description: str = ""
) -> Iterator[Table]:
    """The table of a model and those below it; no `defaults` where no file has it by default."""
    settings, below, changes = [], list[Table](), []
    for name, field in model["properties"].items():
        path = f"{key}.{name}" if key else name
        node, required = _resolved(field, definitions), name in model.get("required", ())
        default = field.get("default") if defaults is None else defaults[name]
        about = _line(field.get("description") or node.get("description", ""))
        if required:
            changes.append(f"`{name}` must be given")
        elif field.get("default") != default:
            changes.append(f"`{name}` is {toml_value(field['default'])} unless given")
        if "properties" in node:
            below += _tables(path, node, default, definitions, about)
            continue
        items = _resolved(node.get("items", {}), definitions)
        written = None if default is None else toml_value(default)
        advanced = field.get("advanced", True)
        settings.append(Setting(name, about, written, _values(node, definitions), advanced))
        if "properties" in items:
            text = f"An entry of `{name}`: {_line(items['description'])}"
            below += _tables(f"[{path}]", items, None, definitions, text)
    cautions = [f"Once a file has this table, {', '.join(changes)}."] if changes else []
    if defaults is None and not key.startswith("["):
        cautions.append("Without this table it is off; the heading alone switches it on.")
    heading = f"[{key}]" if key else ""
    about = description or _line(model["description"])
    yield Table(heading, about, tuple(settings), " ".join(cautions))
    yield from below


def _resolved(node: Node, definitions: Node) -> Node:
    """What a reference or an alternative to null stands for."""
    for each in node.get("anyOf", ()):
        if each.get("type") != "null":
            return _resolved(each, definitions)
    if "$ref" in node:
        target: Node = definitions[node["$ref"].rpartition("/")[2]]
        return target
    return node


def _values(node: Node, definitions: Node) -> str:
    """What a value may be, in words."""
    if "enum" in node:
        return ", ".join(map(toml_value, node["enum"]))
    bounds = [words.format(node[name]) for name, words in _BOUNDS.items() if name in node]
    match node["type"]:
        case "boolean":
            return "true, false"
        case "integer":
            return ", ".join(["whole", *bounds])
        case "object":
            return "a table"
        case "number":
            return ", ".join(bounds) or "any number"
        case "array" if "prefixItems" in node:
            first, *_ = items = node["prefixItems"]
            return f"{len(items)} numbers ({_values(first, definitions)})"
        case "array":
            items = _resolved(node["items"], definitions)
            inner = "tables" if "properties" in items else f"({_values(items, definitions)})"
            return ", ".join([f"list of {inner}", *bounds])
    return "text"


def _line(text: str) -> str:
    return " ".join(text.split())


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
