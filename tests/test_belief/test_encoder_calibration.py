"""Numbers that were fitted to one encoder: their files, and who takes them."""

import json
import logging
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.episodes.run import encoder_of
from benchmarks.harness.bench_plan import UNATTENDED
from benchmarks.harness.fingerprint import key_of_settings
from benchmarks.options import with_calibration
from mapping import map_bundle
from mapping.clip.fitted import calibration as files
from mapping.clip.fitted.calibration import (
    calibration_file,
    encoder_hash,
    keep_calibration,
    kept_calibration,
    read_calibration,
)
from mapping.clip.fitted.encoder import (
    CalibratedEncoder,
    calibrated,
    calibration_of,
    calibration_to_ask_with,
    weights_of,
)
from mapping.clip.fitted.phrasings import BARE, ENSEMBLE
from mapping.clip.places.evidence import fitted_weights
from sim_stubs.faults.faulty_program import FaultyEncoder
from tests.fuzz.spoilt_maps import seal
from tests.helpers.bundles import bundle_of, calibration_for
from vizbot.core.errors import ConfigError, MapError
from vizbot.objectnav.candidates import question_of
from vizbot.objectnav.tasks import goal_of
from vizbot.rehearsal.belief_fit.cosine_fit import fit_cosines
from vizbot.rehearsal.belief_fit.seen_home import ShownPlaces
from vizbot.rig import calibration_line


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    return tmp_path / "share" / "vizbot" / "encoders"


def test_what_is_kept_is_read_again(mean_colours, folder):
    fitted = calibration_for(mean_colours)
    assert kept_calibration(mean_colours) is None
    file = keep_calibration(fitted)
    assert file.parent == folder and read_calibration(file) == fitted
    assert kept_calibration(mean_colours) == (fitted, file)
    assert "| 10.0% | 12.5% | 40 |" in file.with_suffix(".md").read_text()


def test_an_encoder_has_what_was_fitted_to_it(mean_colours):
    assert calibrated(mean_colours) is mean_colours
    assert weights_of(mean_colours) is fitted_weights()
    fitted = calibration_for(mean_colours)
    keep_calibration(fitted)
    encoder = calibrated(mean_colours)
    assert (encoder.threshold, encoder.log_odds) == (0.9, (50.0, -45.0))
    assert (encoder.embed_texts(["red"]) == mean_colours.embed_texts(["red"])).all()
    disturbed = FaultyEncoder(encoder, None)
    for each in (encoder, disturbed):
        goal = goal_of(each, "yellow chair")
        question = question_of(goal)
        assert (goal.threshold, question.log_odds) == (0.9, (50.0, -45.0))
        assert question.weights.join[-1] == -1.0 != fitted_weights().join[-1]
        assert calibration_of(each) == fitted


def test_the_belief_asks_by_phrasings_and_the_paper_by_bare_words(mean_colours):
    fitted = calibration_for(mean_colours, phrasings=ENSEMBLE)
    goal = goal_of(CalibratedEncoder(mean_colours, fitted, "here"), "a kitchen")
    rows = mean_colours.embed_texts(["a kitchen", "a photo of a kitchen", "a kitchen in a room"])
    np.testing.assert_array_equal(goal.embedding, rows[0])
    mean = rows.mean(axis=0) / np.linalg.norm(rows.mean(axis=0))
    np.testing.assert_allclose(question_of(goal).embedding, mean, rtol=1e-6)
    plain = question_of(goal_of(mean_colours, "a kitchen"))
    np.testing.assert_array_equal(plain.embedding, rows[0])


def worded(bare, phrased):
    """An encoder to which a sofa is one vector, and any sentence about it another one."""
    return SimpleNamespace(
        embed_texts=lambda texts: np.array([bare if text == "sofa" else phrased for text in texts])
    )


@pytest.mark.parametrize("helps", [True, False])
def test_phrasings_are_fitted_where_they_help_in_both_halves_of_the_homes(helps):
    right, wrong = np.float32([1.0, 0.0, 0.0]), np.float32([0.6, 0.8, 0.0])
    bare, phrased = (wrong, right) if helps else (right, wrong)
    rng, rows = np.random.default_rng(0), np.arange(400)
    homes = []
    for there in rng.random((2, 1, 400)) < 0.2:
        vectors = np.float32([0.05, 0.2, 0.2]) * rng.normal(size=(400, 3)).astype(np.float32)
        vectors[:, 0] += 0.2 * there[0]
        shown, places = np.stack([rows] * 3, axis=1), np.stack([rows, 0 * rows], axis=1)
        true = {"sofa": (there, np.zeros(2, np.int64))}
        homes.append(ShownPlaces(vectors, shown, *[rows] * 2, places, *[rows] * 4, true))
    found = fit_cosines(homes, worded(bare, phrased))
    assert found.phrasings == (ENSEMBLE if helps else BARE) and found.log_odds[0] > 0.0
    of_bare = fit_cosines(homes, worded(bare, np.float32([0.0, 0.0, 1.0])))
    assert of_bare.phrasings == BARE and found.threshold == of_bare.threshold


def test_a_map_is_asked_with_its_own_numbers_where_there_are_no_others(mean_colours, tmp_path):
    of_map = calibration_for(mean_colours, threshold=0.7)
    assert calibration_to_ask_with(mean_colours, None, None) is None
    assert calibration_to_ask_with(mean_colours, None, of_map) == (of_map, "the map")
    of_another = calibration_for(mean_colours, encoder_hash="0" * 64)
    assert calibration_to_ask_with(mean_colours, None, of_another) is None
    file = tmp_path / "of_another.json"  # of the robot's encoder, which is not that of this map
    file.write_bytes(of_another.content())
    assert calibration_to_ask_with(mean_colours, file, of_map) == (of_map, "the map")
    kept = calibration_for(mean_colours)
    where = str(keep_calibration(kept))
    assert calibration_to_ask_with(mean_colours, file, of_map) == (kept, where)
    file.write_bytes(of_map.content())
    assert calibration_to_ask_with(mean_colours, file, None) == (of_map, str(file))


@pytest.mark.parametrize("named", ["red-only", "mean-colours"])
def test_another_encoder_has_none_of_it(mean_colours, named):
    keep_calibration(calibration_for(mean_colours))
    mean_colours.model_id = named
    assert (calibrated(mean_colours) is mean_colours) == (named == "red-only")


def test_a_line_says_what_the_belief_fits(mean_colours):
    assert "not calibrated for this encoder; `vizbot calibrate encoder --clip mine`" in (
        calibration_line(mean_colours, "mine")
    )
    file = keep_calibration(calibration_for(mean_colours))
    line = calibration_line(calibrated(mean_colours), "mine")
    assert line == f"mean-colours is calibrated for this encoder by {file}"
    mean_colours.model_id = "embedded-0123"
    assert calibration_line(mean_colours, "embedded") is None


def test_a_file_that_cannot_be_used_is_refused_in_a_line(mean_colours, tmp_path):
    file = tmp_path / "fitted.json"
    with pytest.raises(ConfigError, match="No such file"):
        read_calibration(file)
    whole = calibration_for(mean_colours).content()
    for content, words in (
        (whole[: len(whole) // 2], "is torn"),
        (b"\x00\xff", "is torn"),
        (b"[]", "is no calibration"),
        (json.dumps(json.loads(whole) | {"scale": 60.0}).encode(), "was changed by hand"),
        (json.dumps(json.loads(whole) | {"views": 0}).encode(), "of list of views 0, not 1"),
    ):
        file.write_bytes(content)
        with pytest.raises(ConfigError, match=words) as refused:
            read_calibration(file)
        assert len(str(refused.value).splitlines()) == 1 and str(file) in str(refused.value)


@pytest.mark.parametrize(
    "changes", [{"near": (0.0,) * 19}, {"scale": -1.0}, {"threshold": 1.5}, {"homes": "916"}]
)
def test_numbers_that_none_can_be_are_refused(mean_colours, tmp_path, changes):
    raw = calibration_for(mean_colours).model_dump(mode="json") | changes
    (tmp_path / "fitted.json").write_text(json.dumps(raw | {"sha256": files._checksum(raw)}))
    with pytest.raises(ConfigError, match="is damaged"):
        read_calibration(tmp_path / "fitted.json")


def test_a_torn_file_in_the_folder_is_left_out_with_a_line(mean_colours, caplog):
    file = keep_calibration(calibration_for(mean_colours))
    file.write_bytes(file.read_bytes()[:100])
    with caplog.at_level(logging.WARNING):
        assert calibrated(mean_colours) is mean_colours
    assert f"calibration {file} is torn" in caplog.text


def test_the_file_that_settings_name_comes_before_the_folder(mean_colours, tmp_path):
    keep_calibration(calibration_for(mean_colours))
    file = tmp_path / "fitted.json"
    file.write_bytes(calibration_for(mean_colours, threshold=0.8).content())
    assert calibrated(mean_colours, file).threshold == 0.8
    file.write_bytes(calibration_for(mean_colours, encoder_hash="0" * 64).content())
    with pytest.raises(ConfigError, match="is for mean-colours \\(00000000\\), not for mean-col"):
        calibrated(mean_colours, file)


def test_nothing_is_hashed_where_nothing_is_kept(mean_colours, monkeypatch):
    monkeypatch.setattr(files, "encoder_hash", lambda encoder: pytest.fail("it takes long"))
    assert calibrated(mean_colours) is mean_colours


def test_a_map_keeps_the_numbers_that_it_was_made_with(mean_colours, tmp_path):
    fitted = calibration_for(mean_colours)
    map_bundle.save(replace(bundle_of(), calibration=fitted), tmp_path / "home")
    assert map_bundle.load(tmp_path / "home").calibration == fitted
    map_bundle.save(bundle_of(), tmp_path / "other")
    assert "calibration" not in json.loads((tmp_path / "other" / "map.json").read_text())
    assert map_bundle.load(tmp_path / "other").calibration is None


def test_a_map_is_read_without_numbers_of_another_list_of_views(mean_colours, tmp_path):
    map_bundle.save(bundle_of(), tmp_path / "home")
    seal(tmp_path / "home", calibration={"views": 0, "of": "another vizbot"})
    assert map_bundle.load(tmp_path / "home").calibration is None
    raw = calibration_for(mean_colours).model_dump(mode="json")
    for changes, words in (
        ({"calibration": raw | {"scale": -1.0}}, "damaged \\(map.json: calibration.scale"),
        (
            {"calibration": raw | {"hue": 1}},
            "of another vizbot, its map.json has 'calibration.hue'",
        ),
        ({"calibration": None, "hue": 1}, "of another vizbot, its map.json has 'hue': open it"),
    ):
        seal(tmp_path / "home", **changes)
        with pytest.raises(MapError, match=words):
            map_bundle.load(tmp_path / "home")


def test_a_bench_takes_what_its_options_name_and_nothing_that_a_user_has_fitted(tmp_path):
    encoder = encoder_of(UNATTENDED)
    assert not isinstance(encoder, CalibratedEncoder)
    fitted = calibration_for(encoder)
    keep_calibration(fitted)
    assert kept_calibration(encoder) is not None
    encoder_of.__globals__["_encoder"].cache_clear()
    assert not isinstance(encoder_of(UNATTENDED), CalibratedEncoder)
    file = tmp_path / "fitted.json"
    file.write_bytes(fitted.content())
    config = with_calibration(UNATTENDED, file)
    assert encoder_of(config).log_odds == (50.0, -45.0)
    encoder_of.__globals__["_encoder"].cache_clear()


def test_the_key_of_a_result_has_the_numbers_and_not_where_they_are(mean_colours, tmp_path):
    keys = []
    for name, threshold in (("a", 0.9), ("b", 0.9), ("c", 0.8)):
        file = tmp_path / name
        file.write_bytes(calibration_for(mean_colours, threshold=threshold).content())
        keys.append(key_of_settings(with_calibration(UNATTENDED, file)))
    assert keys[0] == keys[1] != keys[2]
    assert key_of_settings(UNATTENDED) not in keys
    (tmp_path / "a").write_bytes(b"{")
    with pytest.raises(ConfigError, match="is torn"):
        with_calibration(UNATTENDED, tmp_path / "a")


def test_equal_ids_have_equal_hashes(mean_colours):
    assert encoder_hash(mean_colours) == encoder_hash(mean_colours)
    assert calibration_file(encoder_hash(mean_colours)).name.endswith(".json")
    assert np.array_equal(calibration_for(mean_colours).weights.near, fitted_weights().near)
