"""`vizbot calibrate encoder`: fits, goes on after an interrupt, takes a file, refuses."""

import pytest

from mapping.clip.fitted.calibration import calibration_file, encoder_hash, read_calibration
from mapping.clip.fitted.encoder import CalibratedEncoder, calibrated
from sim_stubs.homes.home import home
from tests.helpers.bundles import calibration_for
from vizbot.commands import calibrate_encoder
from vizbot.core.errors import DeviceError
from vizbot.rehearsal.belief_fit import calibration, view_list
from vizbot.rehearsal.belief_fit.view_list import ListedHome
from vizbot.rig import open_encoder

VIEWS = 14
HOMES = [ListedHome("916"), ListedHome("917")]


@pytest.fixture(autouse=True)
def folders(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path


class CountedEncoder:
    """The embedded encoder by another name, which fails after some frames."""

    def __init__(self, last=10_000):
        self._own, self.frames, self._last = open_encoder("embedded", "cpu"), 0, last
        self.model_id, self.dimension = "counted", self._own.dimension
        self.threshold, self.log_odds, self.notice = 0.3, None, None
        self.embed_texts, self.reading = self._own.embed_texts, self._own.reading

    def embed_images(self, images):
        self.frames += 1
        if self.frames > self._last:
            raise DeviceError("no memory is left")
        return self._own.embed_images(images)


@pytest.fixture
def offer(monkeypatch):
    """Have the command open an encoder."""

    def offer(encoder):
        monkeypatch.setattr(calibrate_encoder, "open_encoder", lambda *_: encoder)
        return encoder

    return offer


@pytest.fixture(scope="module")
def house():
    """A home of plain shapes, whatever is installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim_stubs.homes.home._catalogue", tuple)
        return home(916)


@pytest.fixture
def tiny_list(monkeypatch, house):
    """Two walks of few views in that home."""
    monkeypatch.setattr(view_list, "home", lambda seed: house)
    monkeypatch.setattr(view_list, "VIEWS_OF_HOME", VIEWS)
    monkeypatch.setattr(calibration, "VIEWS_OF_HOME", VIEWS)
    monkeypatch.setattr(view_list, "list_homes", lambda jar: HOMES)
    monkeypatch.setattr(view_list, "require_simulator", lambda: None)


BANK, TIMED = 8, 2
"""Batches of the bank, which an encoder without known weights embeds in each run, and frames that
are embedded to time it."""


@pytest.mark.slow
def test_it_fits_goes_on_where_it_was_ended_and_is_taken(run, offer, tiny_list):
    offer(CountedEncoder(TIMED + BANK + VIEWS + 5))
    code, _, err = run("calibrate", "encoder")
    assert code == 1 and "no memory is left" in err.splitlines()[-1]
    assert "28 views of 2 homes, 0 of them drawn by others" in err and "kept from" not in err
    encoder = offer(CountedEncoder())
    assert not calibration_file(encoder_hash(encoder)).exists()
    code, out, err = run("calibrate", "encoder")
    assert code == 0
    assert f"{VIEWS + 5} are kept from before" in err
    assert encoder.frames == TIMED + BANK + VIEWS - 5
    file = calibration_file(encoder_hash(encoder))
    assert str(file) in out and file.with_suffix(".md").is_file()
    fitted = read_calibration(file)
    assert fitted.homes == ("916", "917") and fitted.scale > 0.0
    assert sum(each.places for each in fitted.reliability) > 100
    assert fitted.calibration_error < 0.2
    taken = calibrated(encoder)
    assert isinstance(taken, CalibratedEncoder) and taken.log_odds == fitted.log_odds


def test_a_file_that_was_fitted_elsewhere_is_taken(run, offer, mean_colours, folders):
    offer(mean_colours)
    shipped = folders / "shipped.json"
    shipped.write_bytes(calibration_for(mean_colours).content())
    code, out, _ = run("calibrate", "encoder", "--use", shipped)
    assert code == 0 and "mean-colours is calibrated" in out
    assert calibrated(mean_colours).log_odds == (50.0, -45.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"encoder_hash": "0" * 64}, "is for mean-colours (00000000), not for mean-colours"),
        ({"views": 0}, "is of list of views 0, not 1"),
        (None, "is torn"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_and_the_one_before_stays(
    run, offer, mean_colours, folders, changes, words
):
    offer(mean_colours)
    shipped = folders / "shipped.json"
    shipped.write_bytes(calibration_for(mean_colours).content())
    run("calibrate", "encoder", "--use", shipped)
    kept = calibration_file(encoder_hash(mean_colours)).read_bytes()
    content = shipped.read_bytes()[:99]
    if changes is not None:
        content = calibration_for(mean_colours, **changes).content()
    shipped.write_bytes(content)
    code, _, err = run("calibrate", "encoder", "--use", shipped)
    assert code == 1 and words in err and len(err.splitlines()) == 1
    assert calibration_file(encoder_hash(mean_colours)).read_bytes() == kept


@pytest.mark.parametrize(
    ("missing", "words"),
    [("mujoco", "pip install mujoco"), ("furniture", "apt install sweethome3d-furniture")],
)
def test_what_is_missing_is_said_before_the_encoder_is(run, monkeypatch, missing, words):
    if missing == "mujoco":
        monkeypatch.setattr(view_list, "find_spec", lambda name: None)
    else:
        monkeypatch.setattr(view_list, "read_catalogue", tuple)
    code, _, err = run("calibrate", "encoder", "--clip", "no/such")
    assert code == 1 and words in err and len(err.splitlines()) == 1


def test_a_jar_that_is_none_is_refused(run, monkeypatch, folders):
    monkeypatch.setattr(view_list, "require_simulator", lambda: None)
    code, _, err = run("calibrate", "encoder", "--jar", folders / "none.jar")
    assert code == 1 and "none.jar is no file" in err


def test_the_list_has_1200_views_at_most(folders):
    jar = folders / "sweethome3d.jar"
    jar.write_bytes(b"")
    assert len(view_list.list_homes(jar)) * view_list.VIEWS_OF_HOME <= 1200
    assert len({each.name for each in view_list.list_homes(jar)}) == 15


@pytest.mark.slow
def test_an_encoder_that_tells_nothing_apart_is_refused(run, offer, tiny_list, mean_colours):
    class Blind(type(mean_colours)):
        def embed_images(self, images):
            return super().embed_images([0 * each for each in images])

    offer(Blind("blind"))
    code, _, err = run("calibrate", "encoder")
    assert code == 1 and "blind does not tell what its pictures show" in err.splitlines()[-1]
