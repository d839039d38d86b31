"""Options of the commands, each declared once: its name, type, default and help.

A command with more than a few takes a dataclass of them, which `vizbot.cli.flags` shows to Typer.
Nothing heavy is imported here, so that `--help` answers at once.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import typer

from vizbot.core.method import Method
from vizbot.operator.client.endpoint import LANGUAGE, SPEECH, Service
from vizbot.operator.client.stop import PORT

ConfigOption = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="Read the settings from this TOML file; else from VIZBOT_CONFIG, ./robot.toml or"
        " ~/.config/vizbot/robot.toml.",
    ),
]
ClipOption = Annotated[
    str | None,
    typer.Option(
        "--clip",
        help="Use this encoder: embedded (rehearsal model, trained on simulated homes), photos (a"
        " thousand names of things in real pictures), ViT-B/32, ViT-L/14, a hub name, a folder, or"
        " MODULE:CLASS for an encoder of your own.",
    ),
]
MethodOption = Annotated[
    Method | None,
    typer.Option(
        "--method",
        help="Search by probabilities of places (belief), or by the paper's Algorithm 1 alone"
        " (paper); else as the settings say.",
    ),
]
IntrinsicsOption = Annotated[
    str | None,
    typer.Option(
        "--intrinsics",
        help="Take these fx,fy,cx,cy,scale for a recorded folder without camera.json"
        " (scale: depth units in a metre).",
    ),
]
SpeechOption = Annotated[
    str,
    typer.Option(
        "--speech",
        metavar="NAME|FOLDER",
        help="Recognise speech by Whisper of this size (tiny.en, base.en, ...), or by a folder with"
        " a model of faster-whisper.",
    ),
]
LanguageOption = Annotated[
    str,
    typer.Option("--language", metavar="CODE", help="Hear and speak this language: en or de."),
]
MapArgument = Annotated[
    Path, typer.Argument(metavar="MAP", help="Use this map: its folder, a run's, or its name.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
VerboseOption = Annotated[
    bool, typer.Option("--verbose", help="Show key events on standard error, not warnings alone.")
]
TokenOption = Annotated[
    str | None,
    typer.Option(
        "--token",
        envvar="VIZBOT_TOKEN",
        help="Send this token; on the robot's own machine its user needs none.",
    ),
]


@dataclass(frozen=True, slots=True)
class RunOptions:
    """Options of every run, rehearsed or on the robot."""

    map_folder: Annotated[
        Path | None,
        typer.Option(
            "--map",
            help="Begin in this saved map (a folder, a run's, or its name); the robot turns on the"
            " spot until it knows where it is.",
        ),
    ] = None
    clip: ClipOption = None
    method: MethodOption = None
    config: ConfigOption = None
    out: Annotated[
        Path | None, typer.Option("--out", help="Write the run here; else into runs/TIME.")
    ] = None
    rerun: Annotated[
        bool,
        typer.Option(
            "--rerun",
            help="Record the run for the rerun viewer (run.rrd in its folder), and open it where"
            " there is a screen.",
        ),
    ] = False
    verbose: VerboseOption = False


@dataclass(frozen=True, slots=True)
class ServiceOptions:
    """Options of how people reach a running robot."""

    host: Annotated[
        str,
        typer.Option(
            "--host",
            help="Serve at this address: 0.0.0.0 also lets other machines in, which need a token.",
        ),
    ] = "127.0.0.1"
    port: Annotated[int, typer.Option("--port", help="Serve at this port.", min=0, max=65535)] = (
        PORT
    )
    certificate: Annotated[
        Path | None,
        typer.Option(
            "--tls-certificate", help="Serve by https, with the certificate in this PEM file."
        ),
    ] = None
    key: Annotated[
        Path | None,
        typer.Option("--tls-key", help="Read the key of the certificate from this file."),
    ] = None
    speech: SpeechOption = SPEECH
    language: LanguageOption = LANGUAGE

    def service(self) -> Service:
        """What the options ask for."""
        return Service(self.host, self.port, self.certificate, self.key, self.speech, self.language)


@dataclass(frozen=True, slots=True)
class DryRunOptions:
    """Options of `vizbot dry-run`."""

    goals: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="TEXT...",
            help="Go to these things, in this order; words in double quotes are literal.",
        ),
    ] = None
    camera: Annotated[
        str,
        typer.Option(
            "--camera",
            help="Use this camera: sim, realsense, or a recording (a TUM folder, .db3 or .bag).",
        ),
    ] = "sim"
    base: Annotated[
        str | None,
        typer.Option(
            "--base", help="Drive this base: sim, roomba or none; a recording drives none."
        ),
    ] = None
    world: Annotated[
        str,
        typer.Option(
            "--world",
            help="Simulate the home of a SEED, SEED+bare with bare walls and a mirror, office, a"
            " Sweet Home 3D file (.sh3d), JAR/NAME of one in sweethome3d.jar, a Gazebo world, or an"
            " MJCF file.",
        ),
    ] = "0"
    labels: Annotated[
        Path | None,
        typer.Option(
            "--labels",
            help="Read labels of what is in an MJCF file or a Gazebo world from this TOML file:"
            ' lines like kettle = "yellow kettle", by the name of a body, geom or model.',
        ),
    ] = None
    start: Annotated[
        str | None,
        typer.Option(
            "--start",
            metavar="X,Y,YAW",
            help="Start here in a simulated world [m, m, degrees]; else far from the first goal,"
            " or at the site named start of an MJCF file.",
        ),
    ] = None
    explore: Annotated[
        bool,
        typer.Option(
            "--explore",
            help="Drive until nothing is left to see; each TEXT is then looked up on the map,"
            " not driven to.",
        ),
    ] = False
    run: RunOptions = field(default_factory=RunOptions)
    intrinsics: IntrinsicsOption = None
    faults: Annotated[
        str | None,
        typer.Option(
            "--faults",
            metavar="LIST",
            help="Let these faults happen, for example bump@20,camera-frozen@40+3,lost-bytes~2"
            " (twice a minute); `list` shows them all.",
        ),
    ] = None
    serve: Annotated[
        bool,
        typer.Option(
            "--serve", help="Serve console and API until Ctrl-C: people may ask and drive by hand."
        ),
    ] = False
    service: ServiceOptions = field(default_factory=ServiceOptions)
    as_json: JsonOption = False


@dataclass(frozen=True, slots=True)
class LaunchOptions:
    """Options of `vizbot launch`."""

    run: RunOptions = field(default_factory=RunOptions)
    service: ServiceOptions = field(default_factory=ServiceOptions)
    force: Annotated[
        bool, typer.Option("--force", help="Launch even if the doctor finds something bad.")
    ] = False


@dataclass(frozen=True, slots=True)
class CalibrateOptions:
    """Options of `vizbot calibrate`."""

    config: ConfigOption = None
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Write into this settings file, whose other settings stay; else into the one in"
            " use.",
        ),
    ] = None
    camera: Annotated[str, typer.Option("--camera", help="Use this camera: realsense or sim.")] = (
        "realsense"
    )
    base: Annotated[str, typer.Option("--base", help="Drive this base: roomba or sim.")] = "roomba"
    world: Annotated[str, typer.Option("--world", help="Simulate this world, as in dry-run.")] = (
        "office"
    )
    yes: Annotated[bool, typer.Option("--yes", help="Start without asking.")] = False


@dataclass(frozen=True, slots=True)
class CalibrateEncoderOptions:
    """Options of `vizbot calibrate encoder`."""

    clip: ClipOption = None
    config: ConfigOption = None
    use: Annotated[
        Path | None,
        typer.Option(
            "--use",
            metavar="FILE",
            help="Fit nothing, and take this file, which was fitted elsewhere.",
        ),
    ] = None
    jar: Annotated[
        Path | None,
        typer.Option(
            "--jar",
            metavar="FILE",
            help="Look at the example homes in this sweethome3d.jar, too; else in the one that is"
            " installed.",
        ),
    ] = None


@dataclass(frozen=True, slots=True)
class TeleopOptions:
    """Options of `vizbot teleop`."""

    config: ConfigOption = None
    base: Annotated[
        str,
        typer.Option(
            "--base", help="Drive this base: roomba, or sim to rehearse on an empty floor."
        ),
    ] = "roomba"
    url: Annotated[
        str | None,
        typer.Option(
            "--url",
            envvar="VIZBOT_URL",
            help="Drive the robot that runs at this address, instead of a base.",
        ),
    ] = None
    token: TokenOption = None
    over: Annotated[
        bool, typer.Option("--over", help="Take over from whoever drives that robot.")
    ] = False


@dataclass(frozen=True, slots=True)
class MapBuildOptions:
    """Options of `vizbot map build`."""

    sequence: Annotated[
        Path, typer.Argument(metavar="SEQ", help="Read this recording: a TUM folder, .db3 or .bag.")
    ]
    out: Annotated[Path, typer.Option("--out", help="Write the map into this folder.")]
    clip: ClipOption = None
    config: ConfigOption = None
    intrinsics: IntrinsicsOption = None
    force: Annotated[bool, typer.Option("--force", help="Replace a map that is there.")] = False
    as_json: JsonOption = False


@dataclass(frozen=True, slots=True)
class MapQueryOptions:
    """Options of `vizbot map query`."""

    folder: MapArgument
    text: Annotated[str, typer.Argument(help='Look for this, or answer it: "where is the sofa?".')]
    clip: ClipOption = None
    method: MethodOption = None
    language: LanguageOption = LANGUAGE
    config: ConfigOption = None
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Draw the answer: a page and map.png in this new folder."),
    ] = None
    as_json: JsonOption = False
