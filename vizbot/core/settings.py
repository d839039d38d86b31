"""How every configuration model behaves: frozen, and a misspelt key is an error."""

import difflib
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

SETTINGS = ConfigDict(
    frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False
)
_TOLD = 5
"""So many errors are told at most."""


def explained(error: ValidationError, model: type[BaseModel]) -> str:
    """What is wrong with each setting, its value, and what may have been meant, in one line."""
    told = []
    for wrong in error.errors()[:_TOLD]:
        *tables, last = wrong["loc"] or ("",)
        key = ".".join(map(str, wrong["loc"]))
        if wrong["type"] != "extra_forbidden":
            told.append(f"{key} = {wrong['input']!r}: {wrong['msg']}" if key else wrong["msg"])
            continue
        table: Any = model
        for part in tables:
            table = _fields(table)[part].annotation if part in _fields(table) else None
        known = list(_fields(table))
        meant = difflib.get_close_matches(str(last), known, n=1) or known
        told.append(f"there is no setting {key}; use {', '.join(meant) or 'none there'}")
    return "; ".join(told)


def _fields(table: Any) -> dict[str, Any]:
    return getattr(table, "model_fields", {})
