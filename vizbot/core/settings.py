"""How every configuration model behaves: frozen, and a misspelt key is an error."""

from pydantic import ConfigDict

SETTINGS = ConfigDict(
    frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False
)
