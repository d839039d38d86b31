"""The methods of search, which settings and options name."""

from __future__ import annotations

from typing import Literal

Method = Literal["belief", "paper"]
"""How a thing is searched for: by beliefs of places, or as the paper does."""
