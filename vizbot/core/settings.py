"""How every configuration model behaves: frozen, and a misspelt key is an error.

The description of a number names its unit in brackets, `[m]`. The page of settings and the errors
take it from there.
"""

import difflib
import math
import re
import reprlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, get_args

from pydantic import BaseModel, ConfigDict, JsonValue, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

BASIC: dict[str, JsonValue] = {"advanced": False}
"""The `json_schema_extra` of a setting that people change; all others are advanced."""


def _mark_advanced(schema: dict[str, Any], model: type[BaseModel]) -> None:
    """Mark each setting in a schema that is not for people; tables have no mark."""
    for name, setting in model.model_fields.items():
        if _table_of(setting) is None:
            schema["properties"][name].setdefault("advanced", True)


SETTINGS = ConfigDict(
    frozen=True,
    extra="forbid",
    use_attribute_docstrings=True,
    allow_inf_nan=False,
    json_schema_extra=_mark_advanced,
)


class Settings(BaseModel):
    """A table of settings: frozen, and a misspelt key is an error."""

    model_config = SETTINGS


UNIT = re.compile(r" \[([^\]]+)\]")
"""The unit in a description."""


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of settings.

    Attributes:
        name: In plain words; empty for a plain number.
        mistaken: Units that people give instead, and what one of them is in this one.
    """

    name: str
    mistaken: Mapping[str, float] = field(default_factory=dict)


_LENGTHS = {"mm": 0.001, "cm": 0.01}
_ANGLES = {"degrees": math.pi / 180}
UNITS = {
    "1": Unit("", {"%": 0.01}),
    "m": Unit("metres", _LENGTHS),
    "m, rad": Unit("metres and radians", _LENGTHS),
    "m^2": Unit("square metres", {"cm^2": 1e-4}),
    "rad": Unit("radians", _ANGLES),
    "s": Unit("seconds", {"ms": 0.001}),
    "m/s": Unit("metres per second", {"mm/s": 0.001, "cm/s": 0.01, "km/h": 1 / 3.6}),
    "m/s^2": Unit("metres per second squared", {"mm/s^2": 0.001, "cm/s^2": 0.01}),
    "rad/s": Unit("radians per second", {"degrees/s": math.pi / 180}),
    "rad/m": Unit("radians per metre"),
    "1, rad/m": Unit("radians per metre"),
    "rad/s/sqrt(s)": Unit("radians per second and root of a second"),
    "rad/s/sqrt(Hz)": Unit("radians per second and root of a hertz"),
    "1/s": Unit("times a second"),
    "1/m": Unit("one per metre"),
    "1/m^2": Unit("one per square metre"),
    "m/m^2": Unit("metres per square metre"),
    "m/rad": Unit("metres per radian"),
    "px": Unit("pixels"),
    "1/32 px of disparity": Unit("32nds of a pixel of disparity"),
    "grey levels": Unit("grey levels"),
}
"""Every unit that settings have, as their descriptions write it."""
_BEYOND = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
"""Pydantic's kinds of errors for a number outside its bounds."""
_MOST_ERRORS = 5
"""More errors than these are not listed."""
_PLAIN = {
    "greater_than": "it must be greater than {gt}",
    "greater_than_equal": "it must be at least {ge}",
    "less_than": "it must be less than {lt}",
    "less_than_equal": "it must be at most {le}",
    "finite_number": "it must be a finite number",
    "float_type": "it must be a number",
    "float_parsing": "it must be a number",
    "int_type": "it must be a whole number",
    "int_parsing": "it must be a whole number",
    "int_from_float": "it must be a whole number",
    "bool_type": "it must be true or false",
    "bool_parsing": "it must be true or false",
    "string_type": "it must be text",
    "string_too_short": "it must have at least {min_length} letters",
    "string_too_long": "it must have at most {max_length} letters",
    "string_unicode": "it must be text",
    "tuple_type": "it must be a list",
    "list_type": "it must be a list",
    "too_short": "it has {actual_length} entries and must have at least {min_length}",
    "too_long": "it must have no more than {max_length} entries",
    "literal_error": "it must be {expected}",
    "enum": "it must be {expected}",
    "missing": "it must be given",
    "model_type": "it must be a table",
    "model_attributes_type": "it must be a table",
    "dataclass_type": "it must be a table",
    "dict_type": "it must be a table",
    "date_type": "it must be a date, such as 2026-11-24",
    "datetime_type": "it must be a date and time, such as 2026-11-24T12:00:00Z",
    "json_invalid": "it is not JSON: {error}",
    "value_error": "{error}",
}
"""What pydantic's kinds of errors mean, in plain words; all others keep pydantic's words."""
_LONGEST_KEY = 100
"""A name with more letters is cut off."""


def explained(error: ValidationError, model: type[BaseModel]) -> str:
    """One line on each wrong setting: its value, what it means, and what may have been meant."""
    errors = []
    for wrong in causes(error.errors())[:_MOST_ERRORS]:
        *tables, last = wrong["loc"] or ("",)
        if isinstance(last, int):  # an item means what its list does
            *tables, last = tables
        key = ".".join(map(str, wrong["loc"]))
        key = key if len(key) <= _LONGEST_KEY else f"{key[:_LONGEST_KEY]}..."
        table: Any = model
        for part in tables:
            if not isinstance(part, int):  # an entry of a list of tables
                table = _table_of(_fields(table).get(str(part)))
        if wrong["type"] != "extra_forbidden":
            setting = _fields(table).get(str(last))
            about = "" if setting is None else _line(setting.description).replace(" [1]", "")
            meaning = f" ({about})" if about else ""
            value = f"{key} = {reprlib.repr(wrong['input'])}: " if key else ""
            beyond = setting is not None and wrong["type"] in _BEYOND
            unit = _in_unit(setting, wrong["input"]) if setting and beyond else ""
            errors.append(value + wrong["msg"] + unit + meaning)
            continue
        known = list(_fields(table))
        meant = difflib.get_close_matches(str(last), known, n=1) or known
        errors.append(f"there is no setting {key}; use {', '.join(meant) or 'none there'}")
    return "; ".join(errors)


def causes(errors: Sequence[ErrorDetails]) -> list[ErrorDetails]:
    """Errors of a validation without those of a list or table that only follow from one in it.

    A list that is left empty by its one wrong item is too short besides. Messages are in plain
    words, without pydantic's.
    """
    around = {wrong["loc"][:depth] for wrong in errors for depth in range(len(wrong["loc"]))}
    causing = [wrong.copy() for wrong in errors if wrong["loc"] not in around]
    for wrong in causing:
        if wrong["type"] in _PLAIN:
            wrong["msg"] = _PLAIN[wrong["type"]].format(**wrong.get("ctx", {}))
    return causing


def unit_of(setting: FieldInfo) -> Unit | None:
    """The unit of a setting; None if its description names none of `UNITS`."""
    found = UNIT.search(_line(setting.description))
    return None if found is None else UNITS.get(found[1])


def bounds_of(setting: FieldInfo) -> tuple[float, float]:
    """Least and largest value of a setting, or of an entry; infinite where it has none."""
    least, most = -math.inf, math.inf
    for bound in _constraints(setting.annotation, setting.metadata):
        least = max(least, getattr(bound, "ge", getattr(bound, "gt", -math.inf)))
        most = min(most, getattr(bound, "le", getattr(bound, "lt", math.inf)))
    return least, most


def _constraints(annotation: Any, metadata: Sequence[Any]) -> Iterator[Any]:
    """What limits a setting and its entries."""
    for each in metadata:
        yield from each.metadata if isinstance(each, FieldInfo) else (each,)
    arguments = get_args(annotation)
    for each in arguments:
        yield from _constraints(each, getattr(each, "__metadata__", ()))


def _in_unit(setting: FieldInfo, given: Any) -> str:
    """The unit that a value outside its bounds must have, and what may have been meant by it."""
    unit, (least, most) = unit_of(setting) or Unit(""), bounds_of(setting)
    try:
        value = float(given)
    except OverflowError:  # a whole number of hundreds of digits
        value = math.inf
    meant = [
        f"{value:g} {other} are {value * factor:.4g}"
        for other, factor in unit.mistaken.items()
        if least <= value * factor <= most and setting.annotation is not int
    ]
    name = f", in {unit.name}" if unit.name else ""
    return name + (f": {' or '.join(meant)}" if meant else "")


def _line(description: str | None) -> str:
    return " ".join((description or "").split())


def _table_of(setting: FieldInfo | None) -> Any:
    """The model of a table, perhaps of one that may be missing or of each in a list."""
    kinds = [] if setting is None else [setting.annotation, *get_args(setting.annotation)]
    return next((kind for kind in kinds if _fields(kind)), None)


def _fields(table: Any) -> dict[str, Any]:
    return getattr(table, "model_fields", {})
