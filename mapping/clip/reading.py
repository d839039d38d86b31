"""How an encoder understands a user's words."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Reading:
    """A text as an encoder understands it.

    Attributes:
        text: What is embedded for it.
        note: What the user should know about it, in one line, as "loveseat: a kind of sofa"; None
            where there is nothing to say.
    """

    text: str
    note: str | None = None
