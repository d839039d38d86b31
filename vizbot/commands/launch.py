"""`vizbot launch`: on the robot, with what is typed done line by line."""

from __future__ import annotations

import threading
import time
from contextlib import ExitStack
from pathlib import Path

import typer

from mapping import map_bundle
from vizbot.commands.doctor import require_well
from vizbot.commands.progress import Progress
from vizbot.commands.serve import ServedRun
from vizbot.config import load_config
from vizbot.core.clock import WallClock
from vizbot.core.observer import Observer
from vizbot.core.types import Feedback
from vizbot.doctor import examine
from vizbot.operator.client.endpoint import Service
from vizbot.operator.report.report import Report
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.notifications import OutcomeFeedback
from vizbot.operator.session.session import OperatorSession, plain
from vizbot.operator.viewer.open_viewer import open_viewer, require_rerun
from vizbot.operator.voice.command_grammar import WhereIs, understand
from vizbot.operator.voice.dialogue import Dialogue
from vizbot.pipeline import Pipeline
from vizbot.recorder import Recorder, default_folder, require_empty
from vizbot.rig import Rig, open_encoder

_LONGEST = 200
"""Letters of a line that is typed."""


def run(
    *,
    map_folder: Path | None,
    clip: str | None,
    config_path: Path | None,
    out: Path | None,
    serve_at: Service,
    rerun: bool,
    force: bool,
) -> None:
    """Open camera and base, do what is asked for, keep the map when it ends.

    Raises:
        VizbotError: a setting cannot be used, or a device is missing or gone.
    """
    folder = out or default_folder()
    require_empty(folder)
    if rerun:
        require_rerun()
    config = load_config(config_path)
    if clip is not None:
        config = config.model_copy(update={"clip": clip})
    kept = None if map_folder is None else map_bundle.load(map_folder)
    if not force:
        require_well(examine(config, WallClock(), folder.parent))
    began = time.monotonic()
    with ExitStack() as opened:
        encoder = open_encoder(config.clip, config.device, config.half)
        rig = opened.enter_context(Rig(config, "realsense", "roomba", ""))
        if encoder.notice:
            typer.echo(encoder.notice, err=True)
        recorder = Recorder(folder, config)
        report = Report(recorder.folder, encoder.notice)
        observers: list[Observer] = [recorder, report, opened.enter_context(Progress())]
        attended = ServedRun.by_people(rig.devices, recorder)
        if rerun:
            observers.append(opened.enter_context(open_viewer(recorder.folder, attended.base)))
        observers.append(attended.desk)
        if attended.base is not None:
            observers.append(OutcomeFeedback(attended.base))
            attended.base.show(Feedback.LISTENING)
        pipeline = Pipeline(attended.devices, encoder, config, observers, saved_map=kept)
        recorder.keep_map(pipeline.bundle, rig.devices.clock)
        try:
            typer.echo("Where to? One sentence a line; an empty line or Ctrl-C ends.", err=True)
            threading.Thread(target=_take_dictation, args=(attended.desk,), daemon=True).start()
            attended.serve(pipeline, serve_at, [], config.objectnav)
        finally:
            rig.close()  # the robot stops first; the folder is written while it stands
            metrics = {
                "steps": recorder.steps,
                "path_length": round(recorder.path_length, 3),
                "wall_seconds": round(time.monotonic() - began, 1),
                "run": str(recorder.folder),
            }
            pipeline.finish()
            recorder.finish(pipeline.bundle(), metrics)
            report.finish(metrics)
        typer.echo(str(recorder.folder / "report.html"))


def _take_dictation(desk: OperatorSession) -> None:
    """Do what is typed; an empty line ends the run, the end of a file or a pipe does not."""
    sentences = Dialogue(desk, LiveMap(desk))
    for line in typer.get_text_stream("stdin", errors="replace"):
        if not line.strip():
            desk.closed.set()
            return
        text = plain(line, _LONGEST)
        if isinstance(understand(text), WhereIs):  # a robot that is busy answers late
            threading.Thread(target=_do, args=(sentences, text), daemon=True).start()
        else:
            _do(sentences, text)


def _do(sentences: Dialogue, text: str) -> None:
    try:
        said = "\n".join(sentences.typed(text, "the keyboard").said)
    except Exception as error:  # whatever it is, the next line may be a stop
        said = " ".join(str(error).split()) or type(error).__name__
    typer.echo(said, err=True)
