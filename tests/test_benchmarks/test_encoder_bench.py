"""`vizbot bench encoder`: how separation is counted, what marks show, what is kept and printed."""

import cv2
import numpy as np
import pytest
import torch

from benchmarks.encoder import bench, families
from benchmarks.encoder.bench import EncoderBench
from benchmarks.encoder.contact_sheet import TILE, contact_sheet, tile_of
from benchmarks.encoder.families import (
    FAMILIES_FILE,
    FamilyTable,
    Judged,
    Member,
    families_result,
)
from benchmarks.encoder.page import Asked, EncoderAnswers, encoder_page, homes_by_others
from benchmarks.encoder.recordings import shown_in
from benchmarks.encoder.separation import AskedPatches, Separation, reliability, separations
from benchmarks.harness.store import Store
from benchmarks.questions.marks import MarkedPlaces
from mapping.clip.photos import weights
from mapping.clip.photos.encoder import Classifier
from mapping.clip.photos.names import distribution
from sim_stubs.scoring.success import GOALS
from tests.test_benchmarks.printed_table import cells, rows_in
from training.evaluation import area_under_curve, zero_shot
from vizbot.config import Config
from vizbot.core.types import ImuSamples, Intrinsics, RGBDFrame

NAMES = ("sofa", "bed")


def asked(similarities, shown, edges=None, models=None):
    """Patches with similarities and strengths (P, C)."""
    count = len(similarities)
    return AskedPatches(
        np.array(similarities, np.float32).reshape(count, -1),
        np.array(shown, np.float32).reshape(count, -1),
        np.full(count, 224) if edges is None else np.array(edges),
        np.full(count, "") if models is None else np.array(models),
    )


def column(with_it, without, disputed=()):
    """Patches that were asked for one name."""
    shown = [1.0] * len(with_it) + [0.0] * len(without) + [np.nan] * len(disputed)
    return asked([*with_it, *without, *disputed], shown)


@pytest.mark.parametrize(
    ("with_it", "without", "area"),
    [([3, 4], [1, 2], 1.0), ([1], [2, 3], 0.0), ([2], [1, 2, 3], 0.5), ([1, 3], [2], 0.5)],
)
def test_the_area_is_the_share_of_pairs_in_order_and_a_tie_counts_half(with_it, without, area):
    assert area_under_curve(*(np.array(x, np.float32) for x in (with_it, without))) == area


def test_recall_lets_one_in_a_hundred_of_the_others_pass():
    without = np.arange(200) / 200  # two of them may pass: the bar is 0.985
    with_it = [0.98, 0.985, 0.986, 0.99, *[2.0] * 8]
    found = separations(column(with_it, without), NAMES[:1], threshold=1.0)["sofa"]
    assert found.clear == 12
    assert found.recall == pytest.approx(10 / 12)
    assert found.above_even == pytest.approx(8 / 12)


def test_what_is_disputed_or_shown_faintly_counts_neither_way():
    strict = separations(column([0.9] * 10, [0.1] * 100), NAMES[:1], 0.5)
    with_disputed = column([0.9] * 10, [0.1] * 100, disputed=[5.0] * 50)
    assert separations(with_disputed, NAMES[:1], 0.5) == strict
    faint = column([0.9] * 10, [0.1] * 100, disputed=[5.0] * 50)
    faint.shown[-50:] = 0.3
    assert separations(faint, NAMES[:1], 0.5) == strict


@pytest.mark.parametrize(("clear", "others"), [(9, 100), (10, 99)])
def test_a_name_that_too_few_patches_show_or_do_not_show_is_left_out(clear, others):
    assert separations(column([1.0] * clear, [0.0] * others), NAMES[:1], 0.5) == {}


def test_a_choice_of_patches_is_compared_with_the_same_others():
    patches = column([*[0.9] * 10, *[0.05] * 10], np.arange(100) / 1000)
    first = np.arange(len(patches)) < 10
    high, low = (separations(patches, NAMES[:1], 0.5, rows)["sofa"] for rows in (first, ~first))
    assert (high.clear, high.auc, high.recall) == (10, 1.0, 1.0)
    assert (low.clear, low.recall) == (10, 0.0)
    assert low.auc == pytest.approx(0.505)


def test_probabilities_are_held_to_what_is_shown_at_all():
    half = asked([0.0] * 8, [1.0, 0.3, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0])
    assert reliability(half, (10.0, 0.0)) == pytest.approx(0.0)
    assert reliability(asked([1.0] * 4, [0.0] * 4), (100.0, 0.0)) == pytest.approx(1.0)
    assert reliability(column([1.0], [0.0], disputed=[9.0]), (60.0, -30.0)) == pytest.approx(0.0)


def test_a_patch_is_named_rightly_by_anything_that_it_shows():
    shown = [[1.0, 0.0], [0.7, 0.3], [0.0, 1.0], [0.5, 0.0], [0.0, 0.0]]
    similarities = [[0.1, 0.2], [0.1, 0.2], [0.1, 0.2], [0.2, 0.1], [0.1, 0.2]]
    [found] = zero_shot(*(np.array(x, np.float32) for x in (similarities, shown)),
                        np.array([224] * 5), NAMES)  # fmt: skip
    assert (found.scale, found.patches, found.overall) == (0, 3, pytest.approx(2 / 3))


def test_a_contact_sheet_frames_each_thing_by_what_the_encoder_takes_it_for():
    patches = asked([[0.9, 0.1], [0.2, 0.1], [0.9, 0.1]], [[1.0, 0.0], [1.0, 0.3], [np.nan, 0.0]])
    tiles = [tile_of(np.full((30, 40, 3), shade, np.uint8)) for shade in (10, 120, 240)]
    png = contact_sheet("Studio", tiles, patches, NAMES, threshold=0.5)
    sheet = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    found = {
        shade: np.argwhere((sheet == shade).all(axis=2)).min(axis=0)
        for shade in (10, 120, 240)
        if (sheet == shade).all(axis=2).sum() > TILE**2 / 2
    }
    assert {*found} == {10, 120}  # what is disputed is not drawn, nor a thing that none shows
    colours = [sheet[y - 2, x - 2].tolist() for y, x in found.values()]
    assert colours == [[20, 150, 60], [215, 40, 35]]
    assert found[10][0] == found[120][0] and sheet.shape[0] < 2 * TILE


def test_patches_are_kept_as_they_are(tmp_path):
    patches = asked([[0.5, 0.25]], [[1.0, np.nan]], [99], ["eTeks#bed"])
    patches.save(tmp_path / "kept" / "home.npz")
    again = AskedPatches.load(tmp_path / "kept" / "home.npz")
    for name in ("similarities", "shown", "edges", "models"):
        np.testing.assert_array_equal(getattr(again, name), getattr(patches, name))


def frame_of_a_wall(hidden=False):
    """A frame of a wall 2 m ahead, 2.13 m wide, or with a screen 1 m ahead in its middle."""
    depth = np.full((480, 640), 2.0, np.float32)
    if hidden:
        depth[200:280, 280:360] = 1.0
    camera = Intrinsics(640, 480, 600.0, 600.0, 320.0, 240.0)
    return RGBDFrame(0.0, np.zeros((480, 640, 3), np.uint8), depth, camera, ImuSamples.none())


BOXES = np.array([(208, 128, 432, 352), (96, 16, 544, 464), (0, 0, 56, 56), (300, 230, 524, 454),
                  (416, 240, 640, 464)], np.int32)  # fmt: skip


@pytest.mark.parametrize(
    ("mark", "hidden", "shown"),
    [
        # The middle of the picture: in the first and second patch; at the border of the fourth one,
        # near the last, and 1 m from the corner.
        ((0.0, 0.0, 2.0), False, [1.0, 1.0, 0.0, np.nan, np.nan]),
        ((0.0, 0.0, 2.0), True, [np.nan, np.nan, 0.0, np.nan, np.nan]),
        ((0.0, 0.0, -2.0), False, [0.0] * 5),
        ((5.0, 0.0, 2.0), False, [0.0] * 5),
    ],
)
def test_a_patch_shows_what_is_marked_in_it_in_sight_and_large_enough(mark, hidden, shown):
    places = [MarkedPlaces(np.array([mark]), np.array([0.75]))]
    found = shown_in(frame_of_a_wall(hidden), BOXES, places, np.eye(4))
    np.testing.assert_array_equal(found[:, 0], shown)


def test_one_of_several_marks_is_enough():
    marks = np.array([(0.0, 0.0, 2.0), (5.0, 0.0, 2.0), (0.3, 0.0, 2.0)])
    found = shown_in(frame_of_a_wall(), BOXES[:1], [MarkedPlaces(marks, np.ones(3))], np.eye(4))
    assert found.tolist() == [[1.0]]


def answers(encoder, recall):
    names = {"sofa": Separation(20, 0.9, recall, 0.5)}
    others = Asked("homes by others", "others", True, 600, names, names, names, {0: 0.5}, 0.1)
    alone = Asked("Studio", "trained", False, 600, {}, {}, {}, {}, None, own_poses=True)
    return EncoderAnswers(encoder, 42.0, (others, alone))


def test_the_page_has_the_newest_answers_of_each_encoder(tmp_path):
    store = Store(tmp_path / "encoder.jsonl", EncoderAnswers)
    store.add("key", "c0ffee", "2 cores", answers("one", 0.2), answers("two", 0.3))
    store.add("key", "decade", "2 cores", answers("one", 0.4))
    page = encoder_page(tmp_path, tmp_path / "encoder.md")
    assert page.count("\n## ") == 2 and page.count("c0ffee") == page.count("decade") == 1
    one = page.split("## ")[1]
    assert rows_in(one)[3][0] == "- Studio, placed by our own SLAM"
    assert rows_in(one)[2][:5] == ["homes by others", "600", "1", "0.900", "0.40"]
    assert encoder_page(tmp_path / "none", tmp_path / "encoder.md") == ""
    own, before = Judged(0.1, 0.02), Judged(0.3, 0.05)
    families = Store(tmp_path / FAMILIES_FILE, FamilyTable)
    families.add("key", "aaaaaa", "2 cores", FamilyTable((Member("a", "a", before, own, own),)))
    families.add("key2", "bbbbbb", "2 cores", FamilyTable((Member("a", "a", own, own, own),)))
    assert encoder_page(tmp_path, tmp_path / "encoder.md").startswith(page.rstrip())
    section = encoder_page(tmp_path, tmp_path / "encoder.md").split("\n## ")[3]
    assert rows_in(section)[2] == ["a", *["0.1000"] * 3, *["0.0200"] * 3]
    assert "bbbbbb" in section and "aaaaaa" not in section


def test_the_section_of_homes_by_others_splits_each_thing_by_its_models(tmp_path):
    def of(recall, clear):
        return {"sofa": Separation(clear, 0.9, recall, 0.5)}

    bed = {"bed": Separation(30, 0.7, 0.8, 0.5)}
    split = of(0.2, 40) | bed, of(0.5, 10), of(0.1, 30)
    others = Asked("homes by others", "others", True, 6, *split, {}, None)
    trained = Asked("to train on", "trained", True, 6, of(0.6, 50), {}, {}, {}, None)
    own = Asked("own homes", "own", True, 6, of(0.9, 60), {}, {}, {}, None)
    store = Store(tmp_path / "encoder.jsonl", EncoderAnswers)
    store.add("key", "c0ffee", "2 cores", EncoderAnswers("neither", 1.0, (own,)))
    assert homes_by_others(tmp_path) == ""
    store.add("key", "c0ffee", "2 cores", EncoderAnswers("one", 1.0, (own, others, trained)))
    section = homes_by_others(tmp_path)
    assert "`one`, commit c0ffee" in section and "own homes" not in section.split("`one`")[1]
    assert cells(section, "sofa") == [
        "0.20 of 40", "0.900", "0.50 of 10", "0.900", "0.10 of 30", "0.900", "0.60 of 50", "0.900"
    ]  # fmt: skip
    assert cells(section, "bed") == ["0.80 of 30", "0.700", "-", "-", "-", "-", "-", "-"]
    assert [row[1:] for row in rows_in(section) if row[0] == "homes by others"] == [
        ["6", "2", "0.800", "0.50", "0.50", "-", "-", "-", "-"],
        ["to train on", "1", "0.900", "0.50"],
        ["others", "1", "0.900", "0.10"],
    ]


def test_a_home_is_asked_once_and_its_answers_are_kept(tmp_path, monkeypatch):
    plan = EncoderBench(Config(clip="embedded"), (1100,), (), (), 2, tmp_path)
    first = bench.run_encoder(plan)
    monkeypatch.setattr(bench, "_asked_in", lambda job: pytest.fail("asked again"))
    monkeypatch.setattr(
        bench, "in_parallel", lambda work, jobs, *_: [(job, work(job)) for job in jobs]
    )
    assert bench.run_encoder(plan).rows == first.rows
    assert [row["row"] for row in first.rows] == ["own homes", "1100"]
    assert first.rows[0]["patches"] == 20
    [kept], [sheet] = tmp_path.rglob("*.npz"), tmp_path.rglob("*.png")
    assert sheet == kept.with_suffix(".png") and cv2.imread(str(sheet)).shape[1] > 12 * TILE
    assert {*first.summary} == {"own_recall_at_1", "others_recall_at_1", "ms_a_frame"}
    assert first.summary["others_recall_at_1"] is None


def test_the_classes_of_photographs_are_asked_like_any_encoder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    torch.manual_seed(0)
    weights.keep_tensors({name: it.numpy() for name, it in Classifier().state_dict().items()})
    monkeypatch.setattr(bench, "_TIMED", 1)
    monkeypatch.setattr(
        bench, "in_parallel", lambda work, jobs, *_: [(job, work(job)) for job in jobs]
    )
    result = bench.run_encoder(EncoderBench(Config(clip="photos"), (1100,), (), (), 2, tmp_path))
    assert [(row["row"], row["patches"]) for row in result.rows] == [
        ("own homes", 20),
        ("1100", 20),
    ]
    assert result.text.startswith("`photos-") and result.summary["ms_a_frame"] > 0
    assert [name for name in GOALS if distribution(name) is None] == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--worlds", "1100"], "home 1100 of --worlds is ours; give it by --seeds"),
        (["--worlds", "nowhere.sh3d"], "nowhere.sh3d"),
        (["--sequence", "walk"], "1 --sequence and 0 --questions: give one file of marks"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(vizbot, options, said):
    code, _, err = vizbot("encoder", *options)
    assert code == 1
    assert said in err and err.count("\n") == 1


class JudgedMember:
    """Stands for a member of a family, and is judged by nothing but the weights that it gets."""

    fitted = ()

    def __init__(self, name, log_odds=None, *, fits=True):
        self.name, self.log_odds, self.fits = name, log_odds, fits
        self.known = log_odds is not None
        self.asked = lambda shown, log_odds: [name]
        self.judge = lambda weights, log_odds: weights
        self.judge_own = lambda: name


def test_a_family_is_judged_by_what_is_fitted_to_the_others(monkeypatch):
    monkeypatch.setattr(families, "_weights", list)
    known = (1.0, 0.0)
    a, b = (
        [
            JudgedMember(each, known),
            JudgedMember(f"{each}-unknown"),
            JudgedMember(f"{each}-offset", known, fits=False),
        ]
        for each in "ab"
    )
    found = families._judged([a, b, [JudgedMember("c")]])
    assert {each.member: each.by_others for each in found} == {
        "a": ["b"], "a-unknown": ["b-unknown", "c"], "a-offset": ["b"],
        "b": ["a"], "b-unknown": ["a-unknown", "c"], "b-offset": ["a"],
        "c": ["a-unknown", "b-unknown"],
    }  # fmt: skip


def test_the_figure_is_the_worst_family():
    own = Judged(0.1, 0.02)
    members = Member("a", "a", Judged(0.2, 0.03), own, own), Member("b", "b2", own, own, own)
    assert families_result(FamilyTable(members)).summary == {
        "worst_family": "a", "worst_log_loss": 0.2, "worst_calibration_error": 0.03,
        "worst_cost": 0.1,
    }  # fmt: skip
