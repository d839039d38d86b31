"""What cannot be used is one line that names the thing, the value and the remedy, and no more."""

import json
import shlex
import shutil
import socket
import sys
from io import StringIO

import pytest

from mapping import map_bundle
from tests.helpers.bundles import bundle_of

SETTINGS = {
    "torn": ('clip = "', "is not TOML", "correct it"),
    "yaml": ("height: 0.7", "is not TOML", "line 1"),
    "twice": ("half = true\nhalf = false", "is not TOML", "correct it"),
    "deep": ("clip = " + 900 * "[" + 900 * "]", "nested too deep"),
    "unknown": ("speed = 3", "no setting speed; use", "serial_port"),
    "misspelt": ("[mount]\nhieght = 1", "no setting mount.hieght; use height"),
    "words": ('[mount]\nheight = "high"', "mount.height = 'high'", "must be a number", "[m]"),
    "low": ("[mount]\nheight = -1", "mount.height = -1", "at least 0.1, in metres"),
    "tall": (
        "[mount]\nheight = 1.5",
        "the camera's top at 1.55 m",
        "set perception.depth_mapper.scan.max_height to 1.55",
    ),
    "steep": ("[mount]\ntilt = 1.5", "mount.tilt = 1.5", "less than 1.4"),
    "endless": ("[mount]\ntilt = inf", "mount.tilt = inf", "finite"),
    "half": ("[objectnav]\nmax_steps = 1.5", "objectnav.max_steps = 1.5", "whole number"),
    "none": ("[objectnav]\nmax_steps = 0", "objectnav.max_steps = 0", "at least 1"),
    "many": (
        "[objectnav]\nmax_steps = 1000001",
        "objectnav.max_steps = 1000001",
        "at most 1000000",
    ),
    "perhaps": ('half = "perhaps"', "half = 'perhaps'", "true or false"),
    "number": ("serial_port = 3", "serial_port = 3", "must be text"),
    "no-table": ("mount = 3", "mount = 3", "must be a table"),
    "no-list": ("[perception.clip_mapper]\nscales = 1", "scales = 1", "must be a list"),
    "empty-list": ("[perception.clip_mapper]\nscales = []", "scales = []", "at least 1"),
    "fine": ("[perception.depth_mapper]\nresolution = 1e-9", "resolution"),
    "method": (
        '[objectnav]\nmethod = "magic"',
        "objectnav.method = 'magic'",
        "'belief' or 'paper'",
    ),
    "sure": ("[objectnav.search]\narrival_probability_early = 1.0", "early = 1.0", "less than 1"),
    "reach": ("[[objectnav.waypoint_reaches]]\ndistance = 1", "extent", "must be given"),
}
"""Settings files by their names, and words of the line that refuses each."""
TABLE = """
    fly | 'fly' | --help
    dry-rn | 'dry-rn' | 'dry-run'
    --vrbose doctor | --vrbose | --verbose
    dry-run | no TEXT | --explore | --help
    dry-run '  ' | the goal '' is empty | 'yellow chair'
    dry-run 'where is the sofa' | 'where is the sofa' | 'go to the sofa' | double quotes
    dry-run sofa 'come back' | 'come back' | another command
    dry-run sofa --colour red | --colour. See: | --help
    dry-run sofa --wrld 3 | --wrld | --world
    dry-run sofa --world | '--world' requires | --help
    dry-run --faults | '--faults' requires | --help
    dry-run sofa --world atlantis | 'atlantis' | a seed
    dry-run sofa --world -5 | '-5' | a seed
    dry-run sofa --world 1.5 | '1.5' | .sh3d
    dry-run sofa --world 12345678901234567890 | 123456789... | 18 digits
    dry-run sofa --world nowhere.xml | nowhere.xml is not there | MJCF
    dry-run sofa --world nowhere.world | nowhere.world is not there | SDF
    dry-run sofa --world nowhere.sh3d | nowhere.sh3d is not there | .sh3d
    dry-run sofa --world nowhere.jar/home | nowhere.jar is not there | .sh3d
    dry-run sofa --world torn.xml | torn.xml | correct the file
    dry-run sofa --world torn.sh3d | torn.sh3d | save it again
    dry-run sofa --world bare.xml | bare.xml | --start X,Y
    dry-run sofa --world notes | 'notes' | a seed
    dry-run sofa --labels a.toml | a.toml | MJCF
    dry-run sofa --start 1,2 | '1,2' | X,Y,YAW_DEGREES
    dry-run sofa --start a,b,c | 'a,b,c' | X,Y,YAW_DEGREES
    dry-run sofa --start 1,2,nan | '1,2,nan' | X,Y,YAW_DEGREES
    dry-run sofa --start 1500,-2000,90 | '1500,-2000,90' | in metres, at most 1000
    dry-run sofa --start 1,2,1e9 | '1,2,1e9' | in degrees, at most 3600
    dry-run sofa --start 1,2,0 --camera realsense | --start | 'realsense' | --camera sim
    dry-run sofa --camera webcam | 'webcam' | realsense | .db3 | .bag | TUM
    dry-run sofa --camera notes | notes | camera.json | --intrinsics
    dry-run sofa --camera file | file | TUM | .db3
    dry-run sofa --camera torn.db3 | torn.db3 | copy it again
    dry-run sofa --camera walk --intrinsics 1,2 | '1,2' | fx,fy,cx,cy,scale
    dry-run sofa --camera walk --intrinsics 0,0,0,0,0 | '0,0,0,0,0' | fx,fy,cx,cy,scale
    dry-run sofa --camera walk --intrinsics 500,500,320,240,1000 | rgb/0.png | copy the sequence
    dry-run sofa --camera walk --base sim | walk cannot be driven | --base none
    dry-run sofa --camera torn.db3 --base sim | torn.db3 cannot be driven | --base none
    dry-run sofa --intrinsics 1,1,1,1,1000 | --intrinsics | 'sim'
    dry-run sofa --base tank | 'tank' | sim, roomba or none
    dry-run sofa --base roomba --config port.toml | serial port nowhere | name another port
    dry-run sofa --base roomba --config file.toml | serial port file | /dev/ttyUSB0
    dry-run --explore --base none | --explore | --base sim
    dry-run sofa --explore --serve | --explore | no TEXT
    dry-run sofa --faults flood@3 | 'flood' | bump | camera-frozen
    dry-run sofa --faults bump@soon | 'bump@soon' | bump@SECONDS
    dry-run sofa --faults bump@1e9 | 'bump@1e9' | 86400 s at most
    dry-run sofa --faults bump@3+1e9 | 'bump@3+1e9' | 86400 s at most
    dry-run sofa --faults bump@3 --base none | bump | --base sim
    dry-run sofa --faults encoder-slow --base none | encoder-slow | --base sim
    dry-run sofa --faults '' | '' in --faults | camera-frozen
    dry-run sofa --method magic | --method magic | 'belief', 'paper'
    dry-run sofa --clip nosuch | 'nosuch' | ViT-B/32
    dry-run sofa --clip '' | '' | a hub name
    dry-run sofa --clip nobody/no-such-model | nobody/no-such-model
    dry-run sofa --clip google/siglip-base | google/siglip-base | "model_type": "clip"
    dry-run sofa --clip notes | notes | hf download
    dry-run sofa --clip siglip | siglip model | ViT-B/32
    dry-run sofa --clip embedded-12345678 | 'embedded-12345678' | build the map again
    dry-run sofa --map nowhere | no map at nowhere | map list | map build
    dry-run sofa --map nowhere --out run | no map at nowhere
    dry-run sofa --map notes | notes is not a map | map build
    dry-run sofa --map file | no map at file | map build
    dry-run sofa --map torn | torn is damaged | map.safetensors | build it again
    dry-run sofa --map cut | cut is damaged | map.json | build it again
    dry-run sofa --map without-arrays | map.safetensors: No such file | build it again
    dry-run sofa --map future | schema 99, not | build it again
    dry-run sofa --map changed | changed is damaged | checksum
    dry-run sofa --out notes | notes is not a new or empty folder | --out
    dry-run sofa --out file | file is not a new or empty folder | --out
    dry-run sofa --out file/run | file/run: Not a directory | --out
    dry-run sofa --config nowhere.toml | nowhere.toml: No such file | give a TOML file
    dry-run sofa --config notes | notes: it is not a regular file | give a TOML file
    dry-run sofa --language xx | --language xx | de, en
    dry-run sofa --port 9000 | --port 9000 | add --serve
    dry-run sofa --host 0.0.0.0 | --host 0.0.0.0 | add --serve
    dry-run sofa --tls-key a.pem | --tls-key a.pem | add --serve
    dry-run sofa --serve --port PORT | :PORT: Address already in use | --port
    dry-run sofa --serve --port 70000 | --port 70000 | at most 65535
    dry-run sofa --serve --port -1 | --port -1 | at least 0
    dry-run sofa --serve --port http | --port http | whole number
    dry-run sofa --serve --host '' | --host '' | 0.0.0.0
    dry-run sofa --serve --port 0 --host 300.1.1.1 | 300.1.1.1 | --host
    dry-run sofa --serve --port 0 --tls-certificate a.pem | --tls-certificate a.pem | give both
    dry-run sofa --serve --port 0 --tls-key a.pem | --tls-key a.pem | give both
    dry-run sofa --serve --port 0 --tls-certificate x --tls-key a.pem | x is no file | PEM
    dry-run sofa --serve --port 0 --tls-certificate a.pem --tls-key a.pem | cannot be used | PEM
    dry-run sofa --serve --port 0 --speech nosuch | 'nosuch' | tiny.en
    dry-run sofa --serve --port 0 --speech notes | notes holds no model.bin | faster-whisper
    launch --port PORT --clip embedded | :PORT: Address already in use | --port
    launch --port 0 --tls-key a.pem --clip embedded | --tls-key a.pem | give both
    launch --port 0 --clip embedded --config port.toml | RealSense | nowhere
    launch --config nowhere.toml | nowhere.toml | give a TOML file
    launch --map nowhere | no map at nowhere | map list | map build
    launch --map nowhere --out run | no map at nowhere
    launch --clip nosuch | 'nosuch' | ViT-B/32
    launch --out notes | notes | --out
    launch --language xx | --language xx | de, en
    launch --world 3 | --world. See: | --help
    launch sofa | (sofa) | --help
    doctor --config low.toml | mount.height = -1 | at least 0.1, in metres
    doctor now | (now) | --help
    calibrate --base none | --base none | roomba or sim
    calibrate --base tank | 'tank' | roomba or sim
    calibrate --camera webcam | webcam | realsense or sim
    calibrate --camera sim --base sim --world atlantis | 'atlantis' | a seed
    calibrate --camera sim --config port.toml | serial port nowhere | name another port
    calibrate --camera sim --base sim --out notes | notes | another file
    calibrate --camera sim --base sim --out no/robot.toml | no/robot.toml: No such | another file
    config init --out file | file is there already | --force
    config init --out notes --force | notes is there | another file
    config show --config nowhere.toml | nowhere.toml | give a TOML file
    config show --config low.toml | mount.height = -1
    config init here | (here) | --help
    config forget | 'forget' | --help
    config schema --yaml | --yaml | --help
    config shw | 'shw' | 'show'
    map build nowhere --out map | nowhere: no such folder | TUM | .db3
    map build walk | '--out' | --help
    map build walk --out map | walk: no camera.json | --intrinsics
    map build blank --out map | 0.png
    map build walk --out notes | notes is not a map | another folder
    map build walk --out notes --force | notes is not a map | another folder
    map build walk --out home | home is a map already | --force
    map build walk --out torn | torn is a map already | --force
    map build walk --out file/map | file/map: Not a directory | another folder
    map build torn.db3 --out map | torn.db3 | copy it again
    map build torn.db3 --out map --intrinsics 1,1,1,1,1 | torn.db3 | has its own
    map build walk --out map --clip nosuch | 'nosuch' | ViT-B/32
    map info nowhere | no map at nowhere | map list | map build
    map info notes | notes is not a map | map build
    map info future | schema 99, not | build it again
    map info cut | cut is damaged | build it again
    map query home '' | '' is empty | 'sofa'
    map query notes sofa | notes
    map query home sofa --config nowhere.toml | nowhere.toml
    map query home sofa --language fr | --language fr: give one of de, en
    map query home | 'text' | --help
    map query home 'go to the sofa, then the lamp' | then the lamp' | 'where is the sofa?'
    map query home 'sofa, lamp' | map query takes a thing ('sofa') | 'sofa, lamp' | double quotes
    map query home dock | 'dock' | double quotes
    map query home 'where are the lamp and the sofa?' | 'where is the sofa?' | double quotes
    map query home 'how many chairs' --method paper | 'how many chairs' | counts nothing
    map query torn sofa | torn is damaged | build it again
    map query foreign sofa | 'another' | ViT-B/32
    map query own sofa | somebody's own, os:abort | name it: --clip os:abort
    map query home sofa --clip '' | '' | a hub name
    map list home | (home) | --help
    map rename home | 'NEW' | --help
    map rename ../a b | '../a' | letters, digits
    map rename attic b | 'attic' | those that there are
    map delete attic | 'attic' | those that there are
    map delete a/b --yes | 'a/b' | letters, digits
    map query home sofa --clip nosuch | 'nosuch' | ViT-B/32
    map query home sofa --method magic | --method magic | 'belief', 'paper'
    map query home sofa --config low.toml | mount.height = -1 | at least 0.1, in metres
    map export home --format obj --out a.obj | 'obj' | ply, npz, rrd, nav2, tum
    map export home --format ply | '--out' | --help
    map export home --format ply --out home/a.ply | home/a.ply | outside of it
    map export home --format ply --out no/a.ply | no/a.ply: No such | another file
    map export nowhere --format tum --out a.tum | no map at nowhere | map build
    map difference home torn | 'difference' | --help
    bench | which benchmark? | objectnav, multi
    bench speed | 'speed' | vizbot bench --help
    bench objectnav --seeds a,b | 'a,b' | 1000,1001
    bench objectnav --seeds 3 | home 3 of --seeds | --out
    bench objectnav --rows nosuch | 'nosuch' | default
    bench objectnav --hours 1 | --hours | vizbot bench objectnav --help
    bench objectnav walk | (walk) | vizbot bench objectnav --help
    bench objectnav --worlds a.xml --seeds 1000 | --worlds a.xml | one of them
    bench objectnav --worlds nowhere.xml | nowhere.xml is not there | .sh3d
    bench objectnav --clip ViT-B/32 | --clip | --out
    bench objectnav --out file | --out file | another folder
    bench objectnav --fast --seeds 1000 | home 1000 | from 1100 to 1199
    bench objectnav --method paper --rows default | --method paper | leave out --rows
    bench objectnav --encoder-scale big | --encoder-scale big | 'clip', 'offset'
    bench multi --fast | --fast | vizbot bench multi --help
    bench slam nowhere | nowhere: no such folder | TUM
    bench slam walk --stride 0 | --stride 0 | at least 1
    bench slam walk --seeds 1000 | --seeds | leave them out
    bench slam walk --stride 1001 | --stride 1001 | at most 1000
    bench slam --hours 1e9 | --hours 1e9 | at most 1000
    bench slam --hours 0 | --hours 0 | at least 0.001
    bench slam --hours 1 --seeds 1000,1001 | --seeds 1000,1001 | one
    bench questions walk | '--questions' | vizbot bench questions --help
    bench questions walk --questions nowhere.toml | nowhere.toml | give a TOML file
    bench faults --seeds 5 | home 5 of --seeds | 1000
    bench loop --out there | --out | vizbot bench loop --help
    bench objectnav --against HEAD | --against | vizbot bench objectnav --help
    bench --check --quick | --quick | vizbot bench --help
    bench --check objectnav | --check | leave out objectnav
    bench objectnav walk --check --json | --check | vizbot bench objectnav --help
    teleop --base tank | --base tank | roomba or sim
    goal | 'TEXT...' | --help
    goal '' | the goal '' is empty | 'yellow chair'
    goal sofa --language xx | --language xx: give one of de, en
    goal sofa --url robot | --url 'robot' is no address; give one like http://robot:8787
    goal sofa --url ftp://robot | --url 'ftp://robot' is no address; give one like http
    goal sofa --url http://robot:port | 'port' | http://robot:8787
    goal sofa --url http://127.0.0.1:9 | no robot answers at http://127.0.0.1:9 | vizbot launch
    goal sofa --token é | --token | as launch shows it
    say '' | is empty | 'yellow chair'
    explore now | (now) | --help
    explore --url '' | --url '' is no address; give one like http | http://robot:8787
    stop --url http://127.0.0.1:9 | http://127.0.0.1:9 | vizbot launch
    stop --url http://[::1 | http://[::1 | http://robot:8787
    status --url https://127.0.0.1:9 | https://127.0.0.1:9 | vizbot launch
    voice --wav nowhere.wav | nowhere.wav | .wav
    voice --json | --json | --wav FILE
    voice --wav file --wake robot | --wake | --wav
    voice --speech nosuch | 'nosuch' | tiny.en
    voice --speech notes | notes holds no model.bin | faster-whisper
    voice --language xx | --language xx | de, en
    stub toaster | 'toaster' | --help
    stub roomba --port 3 | --port | --help
    stub realsense | '--out' | --help
    stub realsense --out a.bag | a.bag | .db3
    stub realsense --out torn.db3 | torn.db3 | another name
    stub realsense --out no/a.db3 | no/a.db3 | make it first
    stub realsense --out a.db3 --seconds 0 | --seconds 0 | give 10
    stub realsense --out a.db3 --seconds 1e9 | --seconds 1e+09 | 3600 seconds at most
    stub realsense --out a.db3 --seconds nan | --seconds nan | give 10
    stub realsense --out a.db3 --seconds long | --seconds long | must be a number
    stub realsense --out a.db3 --world atlantis | 'atlantis' | a seed
"""
"""Each command, and words of the line that refuses it; PORT is one that is taken."""


def rows():
    """Each command with its words."""
    for line in TABLE.strip().splitlines():
        yield [part.strip() for part in line.split(" | ")]
    for name, (_, *words) in SETTINGS.items():
        yield [f"dry-run sofa --config {name}.toml", *words]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with what the commands name."""
    folder = tmp_path_factory.mktemp("place")
    for name, (content, *_) in SETTINGS.items():
        (folder / f"{name}.toml").write_text(content)
    (folder / "port.toml").write_text('serial_port = "nowhere"')
    (folder / "file.toml").write_text('serial_port = "file"')
    for name in ("file", "torn.sh3d", "torn.db3", "a.pem"):
        (folder / name).write_text("text")
    (folder / "torn.xml").write_text("<mujoco><worldbody>")
    (folder / "bare.xml").write_text("<mujoco/>")
    for name in ("notes", "siglip", "walk"):
        (folder / name).mkdir()
    (folder / "notes" / "a.txt").write_text("text")
    (folder / "siglip" / "config.json").write_text('{"model_type": "siglip"}')
    (folder / "walk" / "associations.txt").write_text("0.0 rgb/0.png 0.0 depth/0.png\n")
    shutil.copytree(folder / "walk", folder / "blank")
    for name in ("rgb", "depth"):
        (folder / "blank" / name).mkdir()
        (folder / "blank" / name / "0.png").write_bytes(b"no picture")
    camera = {"width": 64, "height": 48, "fx": 60, "fy": 60, "cx": 32, "cy": 24}
    (folder / "blank" / "camera.json").write_text(json.dumps(camera | {"depth_scale": 1000}))
    map_bundle.save(bundle_of(model_id="another"), folder / "foreign")
    map_bundle.save(bundle_of(model_id="os:abort"), folder / "own")
    map_bundle.save(bundle_of(), folder / "home")
    for name in ("torn", "cut", "without-arrays", "future", "changed"):
        shutil.copytree(folder / "home", folder / name)
    header = (folder / "home" / "map.json").read_text()
    with (folder / "torn" / "map.safetensors").open("r+b") as arrays:
        arrays.truncate(1000)
    (folder / "without-arrays" / "map.safetensors").unlink()
    (folder / "cut" / "map.json").write_text(header[:200])
    for name, change in (("future", {"schema_version": 99}), ("changed", {"model_id": "other"})):
        (folder / name / "map.json").write_text(json.dumps(json.loads(header) | change))
    return folder


@pytest.fixture(scope="module")
def taken():
    """A port that is taken."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]


@pytest.fixture
def refuse(place, taken, command_line, monkeypatch):
    """Run a command line; the one line that refuses it."""

    def command(line):
        before = sorted(place.rglob("*"))
        monkeypatch.chdir(place)
        monkeypatch.setattr(sys, "stdin", StringIO())
        code, out, err = command_line(*shlex.split(line.replace("PORT", str(taken))))
        assert (code, out, err.count("\n")) == (1, "", 1), err
        assert err.startswith("vizbot: ") and "Traceback" not in err
        assert sorted(place.rglob("*")) == before
        return err

    return command


@pytest.mark.slow
@pytest.mark.parametrize("row", [*rows()], ids=lambda row: row[0])
def test_what_cannot_be_used_is_refused_in_one_line(refuse, taken, row):
    command, *words = row
    line = refuse(command)
    for word in words:
        assert word.replace("PORT", str(taken)) in line


def test_the_table_is_long_and_says_no_command_twice():
    commands = [command for command, *_ in rows()]
    assert len(set(commands)) == len(commands) >= 110


def test_no_line_has_words_of_the_library_that_checks_settings(refuse):
    for name in SETTINGS:
        line = refuse(f"dry-run sofa --config {name}.toml")
        assert "Input should" not in line and "Value error" not in line
