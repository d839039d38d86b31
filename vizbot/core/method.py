"""The methods of search, which settings and options name."""

from __future__ import annotations

from typing import Literal

Method = Literal["default", "belief", "paper"]
"""How a thing is searched for: as this program does, by beliefs of places, or as the paper does."""
