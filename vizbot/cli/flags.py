"""Shows the fields of a dataclass to Typer as the options of a command."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, TypeVar, get_type_hints

T = TypeVar("T")


def with_options(kind: type[T]) -> Callable[[Callable[[T], None]], Callable[..., None]]:
    """Have a command take a dataclass whose fields are its options.

    Args:
        kind: Its fields are annotated as Typer has it, `Annotated[type, typer.Option(...)]`; one
            that is a dataclass itself stands for the fields of that.

    Returns:
        A decorator. What it makes takes every option by its own name, which Typer reads, and
        hands `kind` to the command.
    """
    parameters = list(_parameters(kind))

    def decorate(command: Callable[[T], None]) -> Callable[..., None]:
        @functools.wraps(command)
        def taking_each(**values: Any) -> None:
            command(_filled(kind, values))

        taking_each.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        taking_each.__annotations__ = {each.name: each.annotation for each in parameters}
        return taking_each

    return decorate


def _parameters(kind: type[Any]) -> Iterator[inspect.Parameter]:
    for option, hint in _hinted_fields(kind):
        if isinstance(hint, type) and is_dataclass(hint):
            yield from _parameters(hint)
            continue
        default = inspect.Parameter.empty if option.default is MISSING else option.default
        yield inspect.Parameter(
            option.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint
        )


def _filled(kind: type[T], values: dict[str, Any]) -> T:
    taken = dict[str, Any]()
    for option, hint in _hinted_fields(kind):
        nested = isinstance(hint, type) and is_dataclass(hint)
        taken[option.name] = _filled(hint, values) if nested else values[option.name]
    return kind(**taken)


def _hinted_fields(kind: type[Any]) -> Iterator[tuple[Field[Any], Any]]:
    hints = get_type_hints(kind, include_extras=True)
    for option in fields(kind):
        yield option, hints[option.name]
