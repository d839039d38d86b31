"""Makes every picture of the console in the documentation, with a robot that is simulated.

`python -m tests.tools.console_pictures` takes a quarter of an hour on two cores: the robot explores
a home first. Look at each picture before it is kept.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import httpx
import pytest
import typer

from tests.helpers.browsing import MapPicture, box_of, chromium, says, take_lease, until
from tests.helpers.checkout import ROOT

HOME = "5"
PICTURES = ROOT / "docs" / "pictures" / "console"
MOST_BYTES = 200_000
TEST = "tests/test_console/test_console_dry_run.py"
SCREEN = {"viewport": {"width": 1600, "height": 900}}
TOUCHED = {"device_scale_factor": 2, "is_mobile": True, "has_touch": True}
PHONE = {"viewport": {"width": 360, "height": 740}, **TOUCHED}
ACROSS = {"viewport": {"width": 740, "height": 360}, **TOUCHED}
ZONE = (508, 480), (576, 600)
CHOSEN = (282, 220)
"""Columns and rows in the picture of the map."""
_PATIENCE = 900.0
"""Longest wait for the robot [s]."""


def main(
    folder: Annotated[Path, typer.Argument(help="Where the pictures are left.")] = PICTURES,
    url: Annotated[
        str | None, typer.Option(help="Of a dry run in home 5 that is served already.")
    ] = None,
) -> None:
    """Make the pictures, and say how large they are."""
    picture_the_test(folder)
    with TemporaryDirectory() as scratch:
        running = served_robot(Path(scratch)) if url is None else nullcontext(url)
        try:
            with running as address, chromium() as browser:
                Studio(browser, address, folder).picture_all()
        except pytest.skip.Exception as skipped:
            raise SystemExit(f"no pictures without a browser: {skipped}") from skipped
    for picture in sorted(folder.iterdir()):
        size = picture.stat().st_size
        typer.echo(f"{picture.name:16} {size:8} bytes{' TOO LARGE' if size > MOST_BYTES else ''}")


def picture_the_test(folder: Path) -> None:
    """The pictures that the test of the console on a dry run leaves."""
    command = [sys.executable, "-m", "pytest", "-q", TEST, "--pictures", str(folder.absolute())]
    subprocess.run(command, cwd=ROOT, check=True)


@contextmanager
def served_robot(scratch: Path) -> Iterator[str]:
    """A dry run in a home, and the address of its console."""
    command = [sys.executable, "-c", "from vizbot.cli.app import main; main()", "dry-run"]
    command += ["--serve", "--port", "0", "--world", HOME, "--out", str(scratch / "run")]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "XDG_DATA_HOME": str(scratch)}
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as run:
        assert run.stderr is not None
        said = iter(run.stderr.readline, "")
        try:
            yield next(line.split()[2] for line in said if line.startswith("serving at"))
        finally:
            run.send_signal(signal.SIGINT)
            run.stderr.read()


class Studio:
    """A robot, a browser, and the folder of the pictures.

    Attributes:
        url: Address of the robot.
    """

    def __init__(self, browser: Any, url: str, folder: Path) -> None:
        """Take pictures of the console at this address."""
        self._browser, self.url, self._folder = browser, url, folder
        self._robot = httpx.Client(base_url=url, timeout=15.0)

    def picture_all(self) -> None:
        """Let the robot explore, search and be driven, and take pictures meanwhile."""
        self._robot.put("/map/keep-out", json={"zones": []}).raise_for_status()
        self._robot.delete("/tasks").raise_for_status()
        self._ask("/explore")
        self._wait("has explored", self._is_idle)
        self._robot.put("/maps/ground floor", json={"replace": True}).raise_for_status()
        with self._page(SCREEN) as page:
            floor = MapPicture(page, self)
            page.get_by_role("button", name="Keep-out zones").click()
            self._draw_zone(page, floor)
        self._ask("/goals", texts=["bookshelf", "yellow chair"])
        self._wait("has found two things", self._is_idle)
        self._search("bed", "lamp")
        with self._page(SCREEN) as page:
            self._wait_for_map(page)
            self._take(page, "desktop")
        self._search("kitchen")
        with self._page(PHONE) as page:
            self._take(page, "phone")
        self._search("bed")
        with self._page(PHONE) as page:
            page.get_by_role("button", name="Map", exact=True).tap()
            page.touchscreen.tap(*MapPicture(page, self).on_page(*CHOSEN))
            says(page, "#map-said", "Chosen:")
            self._wait_for_map(page)
            self._take(page, "map")
        for settings, name in ((PHONE, "drive"), (ACROSS, "across")):
            with self._page(settings | {"color_scheme": "dark"}) as page:
                self._drive(page, name)
        self._search("kitchen")
        with self._page(SCREEN | {"color_scheme": "dark"}) as page:
            self._wait_for_map(page)
            self._take(page, "night")

    @contextmanager
    def _page(self, settings: dict[str, Any]) -> Iterator[Any]:
        """The console as it is seen once all of its pictures have come."""
        context = self._browser.new_context(**settings)
        page = context.new_page()
        page.goto(self.url)
        page.locator("#link.live").wait_for()
        for image in page.locator("figure img:visible").all():
            until(page, lambda shown=image: shown.evaluate("one => one.naturalWidth") >= 480)
        if self._robot.get("/state").json()["candidate"] is not None:
            candidate = page.locator("#candidate-picture")
            candidate.wait_for()
            until(page, lambda: candidate.evaluate("one => one.naturalWidth") > 0)
        yield page
        context.close()

    def _wait_for_map(self, page: Any) -> None:
        """Wait for what the page asks the robot for: rooms and zones."""
        page.locator("#overlay .room").first.wait_for()
        page.locator("#overlay .zone").first.wait_for()

    def _draw_zone(self, page: Any, floor: MapPicture) -> None:
        start, end = (floor.on_page(*corner) for corner in ZONE)
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(*end, steps=4)
        page.mouse.up()
        says(page, "#zones", "Zone 1")

    def _drive(self, page: Any, name: str) -> None:
        take_lease(page)
        box = box_of(page.locator("#stick"))
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        touch = page.context.new_cdp_session(page)
        held = {"x": x + 12, "y": y - 50}
        for kind, point in (("touchStart", {"x": x, "y": y}), ("touchMove", held)):
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
        page.wait_for_timeout(600)
        self._take(page, name)
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        page.get_by_role("button", name="Give the wheel back").tap()

    def _take(self, page: Any, name: str) -> None:
        """Take a picture, as good as its size allows."""
        for quality in range(92, 40, -4):
            content = page.screenshot(type="jpeg", quality=quality, animations="disabled")
            if len(content) <= MOST_BYTES:
                break
        (self._folder / f"{name}.jpg").write_bytes(content)

    def _search(self, *texts: str) -> None:
        """Have the robot search for these things, and wait until it drives to the first."""
        self._ask("/goals", texts=texts, at_once=True)

        def far(state: dict[str, Any]) -> bool:
            return state["goal"] == texts[0] and (state["distance_to_go"] or 0.0) > 0.7

        self._wait(f"drives to {texts[0]}", far)

    def _ask(self, path: str, **content: Any) -> None:
        self._robot.post(path, json=content).raise_for_status()

    def _is_idle(self, state: dict[str, Any]) -> bool:
        return all(task["outcome"] is not None for task in state["goals"])

    def _wait(self, what: str, condition: Callable[[dict[str, Any]], bool]) -> None:
        """Wait for a state of the robot."""
        began = time.monotonic()
        while not condition(self._robot.get("/state").json()):
            if time.monotonic() - began > _PATIENCE:
                raise SystemExit(f"the robot never {what}; look at its console at {self.url}")
            time.sleep(0.3)


if __name__ == "__main__":
    typer.run(main)
