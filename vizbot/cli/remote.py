"""Options of the commands by which people ask and drive a robot, mostly a running one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vizbot.cli.flags import with_options
from vizbot.commands.options import (
    JsonOption,
    LanguageOption,
    SpeechOption,
    TeleopOptions,
    TokenOption,
)
from vizbot.operator.client.endpoint import LANGUAGE, SPEECH
from vizbot.operator.client.stop import HERE, send_stop
from vizbot.operator.printing import echo

if TYPE_CHECKING:
    from vizbot.operator.client.robot_client import RobotClient

UrlOption = Annotated[
    str,
    typer.Option(
        envvar="VIZBOT_URL", help="Talk to the robot at this address, which launch shows."
    ),
]
UnusedTokenOption = Annotated[
    str | None, typer.Option("--token", help="This is not needed: everybody may stop the robot.")
]
NowOption = Annotated[
    bool, typer.Option("--now", help="End what the robot is doing, instead of waiting for it.")
]
WaitOption = Annotated[
    bool, typer.Option("--wait", help="Wait until the task is over, and say how it ended.")
]


def goal(
    texts: Annotated[
        list[str],
        typer.Argument(
            metavar="TEXT...",
            help="Ask for things or sentences, in this order; words in double quotes are literal.",
        ),
    ],
    now: NowOption = False,
    wait: WaitOption = False,
    language: LanguageOption = LANGUAGE,
    url: UrlOption = HERE,
    token: TokenOption = None,
) -> None:
    """Send a running robot to goals in words."""
    from vizbot.commands.remote import ask
    from vizbot.operator.language.language import load_language

    spoken = load_language(language)
    with _client(url, token) as client:
        raise typer.Exit(0 if ask(client, texts, now, wait, spoken) else 1)


def say(
    text: Annotated[str, typer.Argument(metavar="TEXT", help="Say this, as in the console.")],
    now: NowOption = False,
    wait: WaitOption = False,
    url: UrlOption = HERE,
    token: TokenOption = None,
) -> None:
    """Say a sentence to a running robot: what to do, a question, yes or no."""
    from vizbot.commands.remote import ask

    with _client(url, token) as client:
        raise typer.Exit(0 if ask(client, [text], now, wait) else 1)


def explore(
    now: NowOption = False,
    wait: WaitOption = False,
    url: UrlOption = HERE,
    token: TokenOption = None,
) -> None:
    """Have a running robot explore until nothing is left to see."""
    from vizbot.commands.remote import explore

    with _client(url, token) as client:
        raise typer.Exit(0 if explore(client, now, wait) else 1)


def stop(url: UrlOption = HERE, token: UnusedTokenOption = None) -> None:
    """Stop a running robot at once; all its tasks are called off."""
    send_stop(url)
    echo("stopped")


def status(as_json: JsonOption = False, url: UrlOption = HERE, token: TokenOption = None) -> None:
    """Show what a running robot does and senses, and what it was asked for."""
    from vizbot.commands.remote import status

    with _client(url, token) as client:
        status(client, as_json)


@with_options(TeleopOptions)
def teleop(options: TeleopOptions) -> None:
    """Drive by hand, with this terminal's keys; the robot stops when they are let go."""
    from vizbot.commands.teleop import run

    run(options)


def voice(
    wav: Annotated[
        Path | None, typer.Option(help="Read this sound file instead of the microphone.")
    ] = None,
    speech: SpeechOption = SPEECH,
    wake: Annotated[
        str | None,
        typer.Option(
            metavar="PHRASE",
            help="Listen all the time, for example for `hey robot`; else Enter starts and ends"
            " talking.",
        ),
    ] = None,
    url: Annotated[
        str | None,
        typer.Option(
            envvar="VIZBOT_URL",
            help="Command the running robot at this address; else that of this machine.",
        ),
    ] = None,
    token: TokenOption = None,
    as_json: JsonOption = False,
    language: LanguageOption = LANGUAGE,
) -> None:
    """Obey spoken words: `go to the kitchen, then the sofa`, `come back`, `stop`."""
    from vizbot.commands.voice import run

    done = run(
        wav=wav,
        model=speech,
        wake=wake,
        as_json=as_json,
        url=url,
        token=token,
        language=language,
    )
    raise typer.Exit(0 if done else 1)


def _client(url: str, token: str | None) -> RobotClient:
    from vizbot.operator.client.robot_client import RobotClient

    return RobotClient(url, token)
