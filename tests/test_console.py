"""The console in a real browser, on a robot without a world."""

import shutil
import socket
import threading
import time

import httpx
import pytest

from tests.watched_robot import WatchedRobot
from vizbot.operator.address import Address
from vizbot.operator.server import Server

FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
]
PATIENCE = 30.0


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("there is no Chromium; apt-get install chromium")
    with api.sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield launched
        launched.close()


@pytest.fixture
def robot():
    robot = WatchedRobot()
    yield robot
    robot.close()


@pytest.fixture
def server(robot):
    with Server(robot.desk, Address(port=0)) as server:
        yield server


@pytest.fixture
def open_page(browser):
    contexts = []

    def open_page(url, **settings):
        contexts.append(browser.new_context(**settings))
        page = contexts[-1].new_page()
        page.set_default_timeout(1000 * PATIENCE)
        page.complaints = []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.goto(url)
        return page

    yield open_page
    for context in contexts:
        context.close()


@pytest.fixture
def page(open_page, server):
    page = open_page(server.url)
    page.locator("#link.live").wait_for()
    yield page
    assert page.complaints == []


def until(page, condition):
    """Wait; meanwhile the browser goes on."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        page.wait_for_timeout(20)


def says(page, selector, text):
    page.locator(selector, has_text=text).wait_for()


def take_wheel(page):
    page.get_by_role("button", name="Take the wheel").click()
    page.get_by_role("button", name="Give the wheel back").wait_for()


class Line:
    """A network between a browser and a robot: it carries bytes until it is cut."""

    def __init__(self, port):
        self._to = port
        self._cut = threading.Event()
        self._closed = False
        self._ends = []
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listening.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self):
        """What is sent arrives no more; neither end is told."""
        self._cut.set()

    def mend(self):
        """New connections are carried; the old ones stay dead."""
        for end in self._ends:
            end.close()
        self._ends = []
        self._cut = threading.Event()

    def close(self):
        self._listening.close()
        self.cut()
        self.mend()

    def _accept(self):
        while True:
            try:
                near, _ = self._listening.accept()
                far = socket.create_connection(("127.0.0.1", self._to))
            except OSError:
                return
            self._ends += [near, far]
            for source, sink in ((near, far), (far, near)):
                threading.Thread(
                    target=self._carry, args=(source, sink, self._cut), daemon=True
                ).start()

    @staticmethod
    def _carry(source, sink, cut):
        try:
            while carried := source.recv(65536):
                if not cut.is_set():
                    sink.sendall(carried)
            if not cut.is_set():
                sink.shutdown(socket.SHUT_WR)
        except OSError:
            return


def test_the_page_is_served_whole_and_may_load_nothing_from_elsewhere(server):
    with httpx.Client(base_url=server.url) as client:
        page = client.get("/")
        assert page.headers["content-type"] == "text/html; charset=utf-8"
        assert "default-src 'self'" in page.headers["content-security-policy"]
        assert "//" not in page.text
        assert "text/css" in client.get("/console.css").headers["content-type"]
        assert "text/javascript" in client.get("/console.js").headers["content-type"]
        assert "image/svg+xml" in client.get("/console.svg").headers["content-type"]


def test_a_person_asks_drives_and_stops(page, robot):
    page.wait_for_function("document.querySelector('figure.shown img').naturalWidth === 480")
    says(page, "#battery", "50 %")
    says(page, "#feels", "bump left")
    page.locator("#goal").fill("a <b>yellow</b> chair")
    page.keyboard.press("Enter")
    says(page, "#goals li.running b", "A <b>yellow</b> chair")
    says(page, "#activity", "Exploring: “a <b>yellow</b> chair”")

    take_wheel(page)
    says(page, "#activity", "You drive")
    assert robot.desk.wheel.holder == "a computer"
    page.keyboard.down("w")
    until(page, lambda: robot.twist.linear == 0.2)
    page.keyboard.down("ArrowLeft")
    until(page, lambda: robot.twist.linear == 0.2 and robot.twist.angular == 0.9)
    page.keyboard.up("w")
    until(page, lambda: robot.twist.linear == 0.0 and robot.twist.angular == 0.9)
    page.keyboard.up("ArrowLeft")
    until(page, lambda: robot.rests)

    page.keyboard.down("w")
    until(page, lambda: not robot.rests)
    page.keyboard.press("Space")
    until(page, lambda: robot.desk.stopped.is_set() and robot.desk.wheel.holder is None)
    assert robot.rests or robot.twist.linear == 0.2
    says(page, "#activity", "Stopped")
    says(page, "#goals li.poor span", "Not done: stopped by a computer")
    page.keyboard.up("w")
    until(page, lambda: robot.rests)
