"""`vizbot launch`: on the robot, with what is typed done line by line."""

from __future__ import annotations

import threading
from contextlib import suppress

from vizbot.commands.doctor import require_well
from vizbot.commands.open_run import OpenRun, open_run
from vizbot.commands.options import LaunchOptions
from vizbot.commands.run_plan import DeviceChoice, RunPlan
from vizbot.commands.serve import ServedRun
from vizbot.core.clock import WallClock
from vizbot.core.errors import ConfigError
from vizbot.core.normal_text import seen_text
from vizbot.core.program.interrupts import first_error, one_line
from vizbot.core.types import Feedback
from vizbot.doctor import examine
from vizbot.operator.client.endpoint import Service
from vizbot.operator.language.command import MISSIONS, Stop
from vizbot.operator.language.command_grammar import MOST_LETTERS
from vizbot.operator.language.dialogue import Dialogue
from vizbot.operator.language.language import ENGLISH, Language, load_language
from vizbot.operator.printing import echo
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession, printable
from vizbot.operator.typed_lines import typed_lines
from vizbot.rig import require_devices

_DEVICES = DeviceChoice("realsense", "roomba")
_LONGEST = MOST_LETTERS + 1
"""Most letters of a typed line that count: a longer one is refused."""


def run(plan: RunPlan, options: LaunchOptions) -> None:
    """Open camera and base, do what people ask for, and save the map at the end.

    Raises:
        VizbotError: a setting cannot be used, or a device is missing or gone.
    """
    language = load_language(options.service.language)
    if options.force:
        require_devices(plan.config, _DEVICES.camera, _DEVICES.base)
    else:
        asked = options.run.clip is not None  # the rehearsal encoder is refused but by its name
        require_well(examine(plan.config, WallClock(), plan.folder.parent, asked))
    with open_run(plan, _DEVICES, serve=True, score=False) as opened:
        if opened.notice:
            echo(opened.notice, err=True)
        assert opened.served is not None
        _serve(opened, opened.served, options.service.service(), language)
        echo(str(opened.folder / "report.html"))


def _serve(opened: OpenRun, served: ServedRun, service: Service, language: Language) -> None:
    """Serve until somebody ends the run; its folder is written in any case."""

    def serve() -> None:
        if served.base is not None:
            served.base.show(Feedback.LISTENING)
        echo("Where to? One sentence a line; an empty line or Ctrl-C ends.", err=True)
        threading.Thread(
            target=_take_dictation, args=(served.session, language), daemon=True
        ).start()
        served.serve(opened.pipeline, service, [], opened.config.objectnav)

    # The robot stops first; the folder is written while it stands.
    failure = first_error(serve, opened.close, opened.pipeline.finish)
    ending = {"error": None if failure is None else one_line(failure)}
    _, lost = opened.write(opened.totals() | ending)
    if (error := failure or lost) is not None:
        raise error


def _take_dictation(session: OperatorSession, language: Language = ENGLISH) -> None:
    """Do what is typed; an empty line ends the run, the end of a file or a pipe does not."""
    dialogue = Dialogue(session, LiveMap(session), language=language)
    for line in typed_lines():
        if not line.strip():
            session.closed.set()
            return
        text = printable(seen_text(line), _LONGEST)
        if _moves(text, language):
            _do(dialogue, text)
        else:  # a robot that is busy answers late
            threading.Thread(target=_do, args=(dialogue, text), daemon=True).start()


def _moves(text: str, language: Language) -> bool:
    """Whether a line asks the robot to drive or to stop, so that its place in order counts."""
    with suppress(ConfigError):  # what is too long is refused once it is done
        return isinstance(language.grammar.typed(text), (*MISSIONS, Stop))
    return False


def _do(dialogue: Dialogue, text: str) -> None:
    try:
        reply = dialogue.typed(text, "the keyboard")
        said = "\n".join([*reply.said, *filter(None, [reply.question])])
    except Exception as error:  # whatever it is, the next line may be a stop
        said = " ".join(str(error).split()) or type(error).__name__
    echo(said, err=True)
