"""How every configuration model behaves: frozen, and a misspelt key is an error."""

import difflib
import reprlib
from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

SETTINGS = ConfigDict(
    frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False
)
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
"""What pydantic's kinds of errors mean, in plain words; all others are told in its own."""
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
            table = _fields(table)[part].annotation if part in _fields(table) else None
        if wrong["type"] != "extra_forbidden":
            field = _fields(table).get(str(last))
            meaning = "" if field is None or not field.description else f" ({field.description})"
            value = f"{key} = {reprlib.repr(wrong['input'])}: " if key else ""
            errors.append(value + wrong["msg"] + " ".join(meaning.split("\n")))
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
    told = [wrong.copy() for wrong in errors if wrong["loc"] not in around]
    for wrong in told:
        if wrong["type"] in _PLAIN:
            wrong["msg"] = _PLAIN[wrong["type"]].format(**wrong.get("ctx", {}))
    return told


def _fields(table: Any) -> dict[str, Any]:
    return getattr(table, "model_fields", {})
