"""What a person does and waits for in a browser."""

import re
import shutil
import time
from contextlib import ExitStack, contextmanager

import httpx
import numpy as np
import pytest

PATIENCE = 30.0
MICROPHONE = ("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream")
"""A simulated one, which the page may use."""
_FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
)


@contextmanager
def chromium(*flags):
    """A browser, started with more flags."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        pytest.skip("there is no Chromium; apt-get install chromium")
    with ExitStack() as opened:
        try:
            playwright = opened.enter_context(api.sync_playwright())
            browser = playwright.chromium.launch(executable_path=program, args=[*_FLAGS, *flags])
        except Exception as error:  # its driver, a node of its own, does not say more than this
            reason = str(error).partition("\n")[0]
            pytest.skip(f"the browser does not start: {reason}; apt-get install libatomic1")
        opened.callback(browser.close)
        yield browser


class KeptBrowser:
    """A browser that is started once for all tests in a row that want one with the same flags.

    Tests that want none do not meet it: while it runs, this thread has a running event loop.
    """

    def __init__(self):
        self._opened, self._flags, self._browser = ExitStack(), (), None

    def started(self, *flags):
        """The browser with these flags."""
        if self._browser is None or flags != self._flags:
            self.close()
            self._browser, self._flags = self._opened.enter_context(chromium(*flags)), flags
        return self._browser

    def close(self):
        """End it; twice is fine."""
        self._browser = None
        self._opened.close()


KEPT_BROWSER = KeptBrowser()


def touch_screen(width, height):
    """Settings of a page on a phone or a tablet of this size [px]."""
    return {"viewport": {"width": width, "height": height}, "is_mobile": True, "has_touch": True}


def until(page, condition):
    """Wait; meanwhile the browser goes on."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        page.wait_for_timeout(20)


def box_of(locator):
    """Where an element lies on the page; while it is drawn anew, it is nowhere for a moment."""
    began = time.monotonic()
    while (box := locator.bounding_box()) is None:
        assert time.monotonic() - began < PATIENCE
    return box


def says(page, selector, text):
    page.locator(selector, has_text=text).wait_for()


def take_lease(page):
    page.get_by_role("button", name="Take the wheel").click()
    page.get_by_role("button", name="Give the wheel back").wait_for()


def understood(*lines, question=None, meant=None, place=None, **more):
    """What the robot answers to a sentence."""
    return {"said": lines, "question": question, "meant": meant, "place": place, **more}


def stand_in(page, path, answer):
    """Answer the page's requests in the robot's place.

    Args:
        path: Of the requests.
        answer: Makes an answer of a request.
    """
    address = re.compile(rf"{path}(\?|$)")
    page.route(address, lambda route: route.fulfill(json=answer(route.request)))


def found_by_axe(page):
    """What axe finds on a page, a line for each violation."""
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright", reason="axe is not installed"
    )
    violations = axe.Axe().run(page).response["violations"]
    return [
        f"{each['id']}: {node['html'][:80]} {node.get('failureSummary', '')}"
        for each in violations
        for node in each["nodes"]
    ]


class MapPicture:
    """The picture of the map on a page.

    Attributes:
        pixel: What one of its pixels is on the floor [m].
    """

    def __init__(self, page, server):
        says(page, "#zones-open", "Keep-out zones")
        until(page, lambda: httpx.get(f"{server.url}/state").json()["map_view"] is not None)
        page.locator("#overlay[viewBox]").wait_for()
        self._page, self._server = page, server
        self.update()

    def update(self):
        """Read again how the map lies in the picture."""
        self._view = httpx.get(f"{self._server.url}/state").json()["map_view"]
        self.pixel = self._view["metres_per_pixel"]

    @property
    def turn(self):
        """Direction of its rows on the floor [rad]."""
        return self._view["turn"]

    def on_page(self, column, row):
        """Where a pixel of the whole picture is on the page, enlarged or not."""
        self._page.locator("#map").scroll_into_view_if_needed()
        box = box_of(self._page.locator("#map img"))
        return (
            box["x"] + column / self._view["width"] * box["width"],
            box["y"] + row / self._view["height"] * box["height"],
        )

    def on_floor(self, column, row):
        """The place x, y in `map` that a pixel of the whole picture shows [m]."""
        up = self._view["height"] - row
        return np.array(self._view["corner"]) + self.along(column * self.pixel, up * self.pixel)

    def along(self, right, up):
        """A way to the right and up in the picture, on the floor [m]."""
        cos, sin = np.cos(self.turn), np.sin(self.turn)
        return np.array([cos * right - sin * up, sin * right + cos * up])

    def seen_at(self, x, y):
        """The place that is seen at a point of the page [m]."""
        box = box_of(self._page.locator("#map img"))
        share = np.array([(x - box["x"]) / box["width"], (y - box["y"]) / box["height"]])
        return self.on_floor(*share * [self._view["width"], self._view["height"]])
