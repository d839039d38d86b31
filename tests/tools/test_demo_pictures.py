"""The README's film and picture are those of a run of the demo, and of no other."""

import json

import numpy as np
import pytest
from PIL import Image

from sim_stubs.homes.goal_chair import GOAL
from tests.tools import demo_pictures
from tests.tools.demo_home import demo_home
from vizbot.operator.report.video import Video

SHADES = (40, 120, 220)


@pytest.fixture(scope="module")
def world():
    return str(demo_home())


@pytest.fixture
def keep_run(tmp_path, world):
    """Keeps a run whose video shows one shade after another."""

    def keep_run(**changes):
        metrics = {"success": True, "goals": [{"text": GOAL}], "world": world} | changes
        (tmp_path / "metrics.json").write_text(json.dumps(metrics))
        video = Video(tmp_path / "run.webm", 64, 48, 10)
        for shade in SHADES:
            video.add(np.full((48, 64, 3), shade, np.uint8))
        video.close()
        return tmp_path

    return keep_run


def shade_of(picture):
    return np.asarray(picture.convert("L")).mean()


def test_the_film_is_the_whole_video_and_the_picture_its_end(keep_run, tmp_path):
    demo_pictures.main(keep_run(), tmp_path)
    with Image.open(tmp_path / "run.webp") as film:
        assert film.n_frames == len(SHADES) and film.info["loop"] == 0
        shown = []
        for number, shade in enumerate(SHADES):
            film.seek(number)
            assert shade_of(film) == pytest.approx(shade, abs=6)
            shown.append(film.info["duration"])
    assert shown == [100, 100, 3000]
    with Image.open(tmp_path / "run.png") as picture:
        assert picture.size == (64, 48) and shade_of(picture) == pytest.approx(220, abs=6)


def test_the_film_is_as_good_as_its_size_allows(monkeypatch):
    rng = np.random.default_rng(0)
    noise = [Image.fromarray(rng.integers(0, 255, (48, 64, 3), np.uint8)) for _ in range(3)]
    best = len(demo_pictures.film(noise, 10.0))
    monkeypatch.setattr(demo_pictures, "MOST_BYTES", best - 1)
    assert best // 3 < len(demo_pictures.film(noise, 10.0)) < best
    monkeypatch.setattr(demo_pictures, "MOST_BYTES", 100)
    with pytest.raises(SystemExit, match="larger than 100 bytes"):
        demo_pictures.film(noise, 10.0)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"world": "5"}, "--world 5; run `make demo`"),
        ({"goals": [{"text": "sofa"}]}, 'of: vizbot dry-run "sofa"'),
        ({"success": False}, "did not reach the goal"),
    ],
    ids=["another home", "another goal", "not reached"],
)
def test_other_runs_are_refused(keep_run, tmp_path, changes, told):
    run = keep_run(**changes)
    with pytest.raises(SystemExit, match=told):
        demo_pictures.main(run, tmp_path)
    assert not (tmp_path / "run.png").exists()


def test_the_readme_shows_both():
    readme = (demo_pictures.ROOT / "README.md").read_text()
    for name in ("run.png", "run.webp"):
        assert f'"docs/pictures/{name}"' in readme
        assert (demo_pictures.PICTURES / name).stat().st_size <= demo_pictures.MOST_BYTES
