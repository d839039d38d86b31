"""How every configuration model behaves: frozen, and a misspelt key is an error."""

import difflib
import reprlib
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

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
    for wrong in error.errors()[:_MOST_ERRORS]:
        *tables, last = wrong["loc"] or ("",)
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


def _fields(table: Any) -> dict[str, Any]:
    return getattr(table, "model_fields", {})
