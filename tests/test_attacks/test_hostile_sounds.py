"""What strangers send as speech opens nothing, ends in a line, and keeps nobody from the robot."""

import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from statistics import median

import numpy as np
import pytest

from tests.fuzz.sounds import RECORDED, recorded_by
from tests.helpers.beside import beside
from tests.helpers.documented_api import DocumentedClient
from tests.helpers.roomba_rig import DEADLINE, wait_for
from tests.helpers.served import refusal, served
from vizbot.operator.language.command import GoTo
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.voice import recordings, sound
from vizbot.operator.voice.intent import Utterance

_AT_ONCE, _HEARD, _WAIT = 60, 1, 2
_PERIOD = 0.02
"""Of a robot's loop [s]."""
_PATIENCE = 2.0
"""Most that any request for the state may take meanwhile [s]; recordings that hold the threads that
answer make one wait for as long as they wait themselves."""
SDP = b"""v=0
o=- 0 0 IN IP4 0.0.0.0
s=x
c=IN IP4 0.0.0.0
t=0 0
m=audio 45678 RTP/AVP 0
a=rtpmap:0 PCMU/8000
m=audio 45680 RTP/AVP 97
a=rtpmap:97 opus/48000/2
"""
PLAYLISTS = {
    "HLS": b"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n#EXT-X-ENDLIST\n",
    "concat": b"ffconcat version 1.0\nfile /etc/hostname\nfile tcp://127.0.0.1:9\n",
    "ASX": b'<asx version="3.0"><entry><ref href="http://127.0.0.1:9/a.wav"/></entry></asx>',
    "DASH": b'<?xml version="1.0"?><MPD xmlns="urn:mpeg:dash:schema:mpd:2011"></MPD>',
    "SDP": SDP,
}
DISGUISES = {
    "plain": b"",
    "WAV": b"RIFF\xff\xff\xff\xffWAVE",
    "WebM": b"\x1a\x45\xdf\xa3",
    "Ogg": b"OggS",
    "MP4": b"\0\0\0\x14ftypisom\0\0\0\0isom",
}


@pytest.fixture(scope="module")
def robot():
    """A client of a robot that understands "go to the sofa" whatever is said."""
    understood = Utterance("go to the sofa", GoTo(("sofa",)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LiveMap, "vocabulary", lambda live_map: [])
        patch.setattr(recordings.Recogniser, "__init__", lambda *_, **__: None)
        patch.setattr(recordings.Recogniser, "learn", lambda *_: None)
        patch.setattr(recordings.Recogniser, "hear", lambda *_: understood)
        with served() as server, DocumentedClient(server.url, timeout=60.0) as http:
            yield http


def refused(robot, content):
    told = refusal(robot.post("/heard", content=content), 422)
    assert "\n" not in told
    return told


def process_tree():
    """This process and all below it."""
    family = {"self"} | {each.name for each in Path("/proc/self/task").iterdir()}
    while True:
        below = set()
        for process in family:
            for children in Path("/proc", process, "task").glob("*/children"):
                try:
                    below |= set(children.read_text().split())
                except OSError:  # it has ended
                    continue
        if below <= family:
            return family
        family |= below


def sockets_of_tree(port):
    """How many sockets the process tree has that are of no connection with a port of its own."""
    held = set()
    for process in process_tree():
        for descriptor in Path("/proc", process, "fd").glob("*"):
            try:
                held.add(descriptor.readlink().name)
            except OSError:
                continue
    lines = [
        line.split()
        for protocol in ("tcp", "tcp6", "udp", "udp6")
        for line in Path("/proc/net", protocol).read_text().splitlines()[1:]
    ]
    end = f":{port:04X}"
    return sum(
        f"socket:[{line[9]}]" in held
        for line in lines
        if not line[1].endswith(end) and not line[2].endswith(end)
    )


@contextmanager
def most_sockets(port):
    """The most sockets at any time of a block, in a list of one."""
    counts = [0]

    def watch(over):
        while not over.is_set():
            counts[0] = max(counts[0], sockets_of_tree(port))

    with beside(watch):
        yield counts


def test_the_sockets_of_a_program_below_this_one_are_counted():
    before = sockets_of_tree(1)
    opens = (
        "import socket, sys; s = socket.socket(type=socket.SOCK_DGRAM); s.bind(('', 0));"
        " print('open', flush=True); sys.stdin.read()"
    )
    with (
        most_sockets(1) as most,
        subprocess.Popen(
            [sys.executable, "-c", opens], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as program,
    ):
        program.stdout.readline()
        wait_for(lambda: most[0] == before + 1)
        program.stdin.close()


@pytest.mark.slow
def test_a_description_of_streams_opens_no_socket(robot):
    port = robot.base_url.port
    robot.get("/state")  # the first answer is looked up in a description from another server
    before = sockets_of_tree(port)
    with most_sockets(port) as most:
        began = time.monotonic()
        for disguise in DISGUISES.values():
            refused(robot, disguise + SDP)
        took = time.monotonic() - began
    assert most[0] == before
    assert took < DEADLINE


@pytest.mark.sampled
@pytest.mark.parametrize("disguise", DISGUISES)
@pytest.mark.parametrize("playlist", PLAYLISTS)
def test_a_list_of_other_things_is_no_sound(robot, playlist, disguise):
    assert refused(robot, DISGUISES[disguise] + PLAYLISTS[playlist]).startswith("what was sent ")


@pytest.mark.parametrize("who", RECORDED)
def test_what_browsers_record_is_understood(robot, who):
    answer = robot.post("/heard", content=recorded_by(who))
    assert answer.json()["said"] == ["asked for: go to sofa"]


@pytest.mark.parametrize("who", RECORDED)
def test_a_recording_that_is_cut_short_or_damaged_is_one_line(robot, who):
    whole = recorded_by(who)
    assert "is cut short" in refused(robot, whole[: len(whole) // 2])
    noise = np.random.default_rng(0).bytes(len(whole) - 40)
    assert refused(robot, whole[:40] + noise).startswith("what was sent ")


def test_a_decoder_that_hangs_is_killed_and_the_next_one_is_heard(robot, monkeypatch, tmp_path):
    hangs = "import os, sys, time; open(sys.argv[1], 'w').write(str(os.getpid())); time.sleep(99)"
    started = tmp_path / "pid"
    with monkeypatch.context() as slow:
        command = [sys.executable, "-c", hangs, str(started)]
        slow.setattr(sound, "interpreter_command", lambda *_: command)
        slow.setattr(sound, "_TIMEOUT", 1.0)
        told = refused(robot, recorded_by("a program"))
    assert "could not be decoded within 1 s; record it again" in told
    assert not Path("/proc", started.read_text()).exists()
    assert robot.post("/heard", content=recorded_by("a program")).status_code == 200


def answer_times(robot, count):
    """How long each of some requests for the state takes [s]."""
    times = []
    for _ in range(count):
        began = time.monotonic()
        assert robot.get("/state").status_code == 200
        times.append(time.monotonic() - began)
    return times


@contextmanager
def loop_lateness():
    """How late each turn of a loop begins that runs beside a block, as a robot's does [s]."""
    late = []

    def drive(over):
        due = time.monotonic()
        while not over.is_set():
            due = max(due + _PERIOD, time.monotonic())
            over.wait(due - time.monotonic())
            late.append(time.monotonic() - due)

    with beside(drive):
        yield late


@pytest.mark.slow
def test_of_sixty_recordings_two_wait_and_state_and_motion_go_on(robot, monkeypatch):
    over = threading.Event()
    monkeypatch.setattr(recordings, "_PATIENCE", DEADLINE)
    hear = recordings.Recogniser.hear
    monkeypatch.setattr(
        recordings.Recogniser, "hear", lambda *given: over.wait(DEADLINE) and hear(*given)
    )
    content = recorded_by("a program", seconds=5.0)
    assert len(content) > 900_000
    idle = answer_times(robot, 15)
    answers = []
    with ThreadPoolExecutor(_AT_ONCE) as people:
        with loop_lateness() as late:
            for _ in range(_AT_ONCE):
                asked = people.submit(robot.post, "/heard", content=content)
                asked.add_done_callback(lambda done: answers.append(done.result()))
            busy = answer_times(robot, 15)
            wait_for(lambda: len(answers) == _AT_ONCE - _HEARD - _WAIT)
        waiting = answer_times(robot, 15)
        over.set()
    codes = sorted(each.status_code for each in answers)
    assert codes == [200] * (_HEARD + _WAIT) + [429] * (_AT_ONCE - _HEARD - _WAIT)
    lines = {each.json()["detail"] for each in answers if each.status_code == 429}
    assert lines == {"2 recordings wait already; say it again in a moment, or type it"}
    assert median(waiting) < 10 * median(idle) + 0.1
    assert max(busy + waiting) < _PATIENCE
    assert median(late) < 0.1
