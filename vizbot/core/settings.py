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

    A list that is left empty by its one wrong item is too short besides. Messages of our own
    validators come without pydantic's words before them.
    """
    around = {wrong["loc"][:depth] for wrong in errors for depth in range(len(wrong["loc"]))}
    told = [wrong.copy() for wrong in errors if wrong["loc"] not in around]
    for wrong in told:
        if wrong["type"] == "value_error":
            wrong["msg"] = str(wrong["ctx"]["error"])
    return told


def _fields(table: Any) -> dict[str, Any]:
    return getattr(table, "model_fields", {})
