"""What a person does and waits for in a browser."""

import re
import shutil
import time
from contextlib import ExitStack, contextmanager

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


def until(page, condition):
    """Wait; meanwhile the browser goes on."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        page.wait_for_timeout(20)


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
