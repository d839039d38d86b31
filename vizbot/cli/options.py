"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

ConfigOption = Annotated[Path | None, typer.Option("--config", help="TOML file with settings.")]
ClipOption = Annotated[
    str | None,
    typer.Option(
        "--clip",
        help="embedded (rehearsal model, trained on simulated homes), ViT-B/32, ViT-L/14, "
        "a hub name or a folder.",
    ),
]
MapOption = Annotated[
    Path | None,
    typer.Option(
        "--map", help="Begin in this kept map; the robot turns until it knows where it is in it."
    ),
]
IntrinsicsOption = Annotated[
    str | None,
    typer.Option(
        help="fx,fy,cx,cy,scale of a recorded folder without camera.json "
        "(scale: depth units in a metre)."
    ),
]
RerunOption = Annotated[
    bool,
    typer.Option(
        "--rerun",
        help="Record the run for the rerun viewer (run.rrd in its folder), and open it where there"
        " is a screen.",
    ),
]
HostOption = Annotated[
    str,
    typer.Option(
        "--host", help="Serve beyond this machine, for example at 0.0.0.0; asks for a token."
    ),
]
PortOption = Annotated[int, typer.Option("--port", help="To serve at.", min=0, max=65535)]
CertificateOption = Annotated[
    Path | None, typer.Option("--tls-certificate", help="PEM file, to serve by https.")
]
SpeechOption = Annotated[
    str,
    typer.Option(
        "--speech",
        metavar="NAME|FOLDER",
        help="Whisper's size (tiny.en, base.en, ...), or a folder with a model of faster-whisper.",
    ),
]
KeyOption = Annotated[Path | None, typer.Option("--tls-key", help="Its private key.")]
JsonOption = Annotated[bool, typer.Option("--json", help="One JSON object on standard output.")]
