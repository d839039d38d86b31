"""The methods of search, which settings and options name."""

from __future__ import annotations

from typing import Literal

Method = Literal["default", "paper"]
"""How a thing is searched for and looked up: as this program does, or as the paper does."""
