"""The console in a real browser, on the robot in a dry run."""

import os
import signal
import subprocess
import sys
from contextlib import closing

import httpx
import pytest

from tests.helpers.browsing import says, take_lease, until
from tests.helpers.checkout import ROOT
from tests.test_console.cut_line import Line
from tests.test_console.person import ask

pytestmark = pytest.mark.slow

DRY_RUN = [sys.executable, "-c", "from vizbot.cli.app import main; main()", "dry-run"]
CHAIR = "".join(
    f'<geom type="box" size="{size}" pos="{at}" rgba="0.95 0.8 0.05 1"/>'
    for size, at in [
        ("0.22 0.22 0.03", "0 0 0.45"),
        ("0.03 0.22 0.25", "0.2 0 0.73"),
        *(("0.02 0.02 0.21", f"{x} {y} 0.21") for x in (-0.2, 0.2) for y in (-0.2, 0.2)),
    ]
)
ROOM = f"""
<mujoco>
  <asset>
    <texture name="wood" type="2d" builtin="checker" rgb1="0.55 0.38 0.22" rgb2="0.45 0.3 0.18"
             width="64" height="64"/>
    <material name="floor" texture="wood" texrepeat="4 4" texuniform="true"/>
    <texture name="paper" type="2d" builtin="checker" rgb1="0.8 0.84 0.78" rgb2="0.72 0.78 0.72"
             width="64" height="64"/>
    <material name="wall" texture="paper" texrepeat="3 3" texuniform="true"/>
  </asset>
  <worldbody>
    <light pos="0 0 2.4"/>
    <geom type="plane" size="0 0 1" material="floor"/>
    <geom type="box" size="0.05 1.6 1.2" pos="2.4 0 1.2" material="wall"/>
    <geom type="box" size="0.05 1.6 1.2" pos="-2.4 0 1.2" material="wall"/>
    <geom type="box" size="2.4 0.05 1.2" pos="0 1.6 1.2" material="wall"/>
    <geom type="box" size="2.4 0.05 1.2" pos="0 -1.6 1.2" material="wall"/>
    <site name="start" pos="-1.2 -0.8 0" euler="0 0 20"/>
    <body name="yellow chair#1" pos="1.8 0.7 0">{CHAIR}</body>
    <body name="bookshelf#1" pos="-0.3 1.4 0">
      <geom type="box" size="0.4 0.14 0.6" pos="0 0 0.6" rgba="0.4 0.25 0.15 1"/>
    </body>
  </worldbody>
</mujoco>
"""
ALL_PICTURES = (
    "[...document.querySelectorAll('figure img')].every((one) => one.naturalWidth >= 480)"
)
STRAIGHT_AWAY = """
[objectnav]
look_around = false
[objectnav.gyro_settling]
seconds = 0.5
frames = 1
"""
"""What it starts out facing it goes to at once: this is about the person, not about the search."""


@pytest.fixture
def dry_run(tmp_path):
    (tmp_path / "room.xml").write_text(ROOM)
    (tmp_path / "config.toml").write_text(STRAIGHT_AWAY)
    command = [*DRY_RUN, "--serve", "--port", "0", "--out", "run"]
    command += ["--world", "room.xml", "--config", "config.toml"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True
    ) as run:
        said = iter(run.stderr.readline, "")
        yield next(line.split()[2] for line in said if line.startswith("serving at"))
        run.send_signal(signal.SIGINT)
        run.stderr.read()


def test_in_a_dry_run_a_person_asks_drives_loses_the_line_and_stops(open_page, dry_run, snapshot):
    with closing(Line(dry_run)) as line, httpx.Client(base_url=dry_run) as robot:
        page = open_page(line.url, viewport={"width": 1280, "height": 900})

        def state():
            return robot.get("/state").json()

        def moved(since, least):
            (x, y), (x0, y0) = state()["position"], since
            return (x - x0) ** 2 + (y - y0) ** 2 > least**2

        ask(page, "yellow chair")
        until(page, lambda: "position" in state() and moved((0.0, 0.0), 0.5))
        says(page, "#candidate-title", "I see something like a yellow chair")
        seen = page.locator("#candidate-picture")
        until(page, lambda: seen.evaluate("one => one.naturalWidth") > 100)
        snapshot(page, "asked")
        found = page.locator("#goals li.good", has_text="Found the yellow chair after")
        found.wait_for(timeout=120_000)

        says(page, "#arrival-title", "Found the yellow chair after ")
        reached = page.locator("#arrival-picture")
        until(page, lambda: reached.evaluate("one => one.naturalWidth") > 100)
        says(page, "#likeness", "to “yellow chair”")
        snapshot(page, "arrived")
        take_lease(page)
        before = state()["position"]
        page.keyboard.down("s")
        until(page, lambda: moved(before, 0.1))
        snapshot(page, "driving")
        line.cut()
        says(page, "#alarm", "The link to the robot is lost")
        rested = state()
        until(page, lambda: state()["step"] > rested["step"] + 4)
        assert not moved(rested["position"], 0.02)
        snapshot(page, "link-lost")

        line.restore()
        page.locator("#link.live").wait_for()
        page.keyboard.up("s")
        page.keyboard.press("Space")
        until(page, lambda: state()["stopped"])
        snapshot(page, "stopped")
        page.reload()
        says(page, "#activity", "Stopped")
        says(page, "#goals li.good b", "Found the yellow chair")
        until(page, lambda: page.evaluate(ALL_PICTURES))
        snapshot(page, "reloaded")
        assert page.complaints == []
