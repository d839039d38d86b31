"""Options of the commands that talk to a robot that is running."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from vizbot.cli_options import JsonOption

if TYPE_CHECKING:
    from vizbot.operator.client import RobotClient

UrlOption = Annotated[
    str, typer.Option(envvar="VIZBOT_URL", help="Of the robot, as launch shows it.")
]
TokenOption = Annotated[
    str | None,
    typer.Option(envvar="VIZBOT_TOKEN", help="Of the robot; its own user need not give it."),
]
WaitOption = Annotated[bool, typer.Option("--wait", help="Until it is over; then tell how.")]
_HERE = "http://127.0.0.1:8787"


def goal(
    texts: Annotated[list[str], typer.Argument(metavar="TEXT...", help="Where to, in this order.")],
    now: Annotated[
        bool, typer.Option("--now", help="What the robot is doing ends, instead of first.")
    ] = False,
    wait: WaitOption = False,
    url: UrlOption = _HERE,
    token: TokenOption = None,
) -> None:
    """Send a robot that is running to goals in words."""
    from vizbot.commands.remote import ask

    with _client(url, token) as client:
        raise typer.Exit(0 if ask(client, texts, now, wait) else 1)


def explore(wait: WaitOption = False, url: UrlOption = _HERE, token: TokenOption = None) -> None:
    """Have a robot that is running explore until nothing is left to see."""
    from vizbot.commands.remote import explore

    with _client(url, token) as client:
        raise typer.Exit(0 if explore(client, wait) else 1)


def stop(url: UrlOption = _HERE, token: TokenOption = None) -> None:
    """Stop a robot that is running, at once; what it was asked for is called off."""
    from vizbot.commands.remote import stop

    with _client(url, token) as client:
        stop(client)


def status(as_json: JsonOption = False, url: UrlOption = _HERE, token: TokenOption = None) -> None:
    """Tell what a robot that is running does, feels, and was asked for."""
    from vizbot.commands.remote import status

    with _client(url, token) as client:
        status(client, as_json)


def _client(url: str, token: str | None) -> RobotClient:
    from vizbot.operator.access import kept_token
    from vizbot.operator.client import RobotClient

    return RobotClient(url, token or kept_token())
