import numpy as np
import pytest

from benchmarks.episodes.episode import Episode, EpisodeResult, GoalResult
from benchmarks.harness.scores import (
    NavigationScore,
    PairedCounts,
    Rate,
    expected_calibration_error,
    interval_over_homes,
    log_loss,
    spl,
)
from benchmarks.harness.tables import interval_text, markdown_table, percent, percent_range


def goal(text="sofa", success=True, driven=5.0, shortest=4.0, steps=100):
    return GoalResult(text, success, success, "" if success else "far", "seen", 1.0, steps, driven,
                      shortest, 20.0)  # fmt: skip


def episode(*goals, home=1000):
    asked = Episode(home, tuple(g.text for g in goals))
    return EpisodeResult(asked, goals, 1, 0.02, 30.0, ((0.0, 0.0),), (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("count", "of", "low", "high"),
    # Newcombe 1998, table I, and 0 and n of n by hand: z^2 / (n + z^2).
    [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (29, 29, 0.8830, 1),
    ],
)
def test_intervals_are_wilsons(count, of, low, high):
    assert Rate(count, of).interval() == pytest.approx((low, high), abs=5e-5)


def test_of_nothing_everything_is_possible():
    assert Rate(0, 0).value is None
    assert Rate(0, 0).interval() == (0.0, 1.0)


def trials(*homes):
    """Home and outcome of each trial, from successes and trials of each home."""
    return [
        (number, trial < successes)
        for number, (successes, of) in enumerate(homes)
        for trial in range(of)
    ]


@pytest.mark.parametrize(
    ("homes", "interval"),
    [
        # Two homes: 9 and 9, 9 and 5, or 5 and 5 of 10, with probabilities 1/4, 1/2, 1/4.
        (((9, 10), (5, 10)), (0.5, 0.9)),
        # The last home is drawn k times of 4: P(k = 4) = 1/256, P(k >= 3) = 13/256.
        (((1, 1), (1, 1), (1, 1), (0, 1)), (0.25, 1.0)),
        # A home with more trials weighs more: 1 of 10 where it is drawn three times.
        (((1, 1), (1, 1), (1, 1), (0, 3)), (0.1, 1.0)),
        (((3, 4), (3, 4), (3, 4)), (0.75, 0.75)),
    ],
)
def test_intervals_over_homes_draw_whole_homes_again(homes, interval):
    assert interval_over_homes(trials(*homes)) == pytest.approx(interval)


def test_one_home_says_nothing_about_homes():
    assert interval_over_homes(trials((3, 10))) is None
    assert interval_over_homes([]) is None
    assert percent_range(None) == "-"
    assert percent_range((0.25, 1.0)) == "25 to 100"


def test_the_interval_over_homes_is_the_same_every_time():
    several = trials((14, 15), (11, 15), (15, 16), (8, 15), (9, 15))
    assert interval_over_homes(several) == interval_over_homes(several)


def test_a_pair_counts_where_only_one_of_two_succeeded_in_a_trial_that_both_did():
    ours = {"bed": True, "sofa": True, "tv": False, "sink": False, "stairs": True}
    other = {"bed": True, "sofa": False, "tv": True, "sink": False, "window": True}
    assert PairedCounts.over(ours, other) == PairedCounts(1, 1)


@pytest.mark.parametrize(
    ("wins", "losses", "p", "better"),
    [
        (0, 0, 1.0, False),
        (5, 3, 186 / 256, False),  # 1 - C(8, 4) / 2^8, as 5 to 3 is next to the middle
        (5, 0, 2 / 2**5, False),
        (6, 0, 2 / 2**6, True),
        (0, 6, 2 / 2**6, False),
        (8, 1, 2 * (1 + 9) / 2**9, True),
    ],
)
def test_the_paired_test_is_exact_and_only_more_wins_are_better(wins, losses, p, better):
    pairs = PairedCounts(wins, losses)
    assert pairs.p == pytest.approx(p)
    assert pairs.shows_better is better


def test_spl_weighs_success_with_the_shortest_way():
    assert spl([goal(driven=8.0, shortest=4.0), goal(success=False)]) == 0.25
    assert spl([]) is None


def test_nobody_drives_less_than_the_shortest_way_and_who_is_there_has_no_way_to_go():
    assert spl([goal(driven=3.0, shortest=4.0)]) == 1.0
    assert spl([goal(driven=0.0, shortest=0.0)]) == 1.0
    assert spl([goal(driven=0.0, shortest=None)]) == 1.0
    assert spl([goal(driven=2.0, shortest=0.0)]) == 0.0


def test_a_score_tells_objects_in_coco_from_others():
    score = NavigationScore.from_results(
        [episode(goal("sofa")), episode(goal("tv", success=False)), episode(goal("kitchen"))]
    )
    assert score.success == Rate(2, 3)
    assert score.coco == Rate(1, 2)
    assert score.others == Rate(1, 1)
    assert score.success_over_homes is None
    assert score.collisions == 3
    assert score.steps == 100


def test_the_way_of_successes_stands_beside_the_way_that_would_have_done():
    score = NavigationScore.from_results(
        [
            episode(goal(driven=60.0, shortest=5.0)),
            episode(goal(driven=20.0, shortest=None), home=1001),
            episode(goal(success=False, driven=200.0, shortest=9.0), home=1002),
        ]
    )
    assert score.path_of_successes == 40.0
    assert score.shortest_of_successes == 2.5
    assert score.success_over_homes == pytest.approx((0.0, 1.0))


def test_tables_are_as_wide_as_their_cells_and_show_rates_in_percent():
    lines = markdown_table(
        ("goal", "SR", "m"), [["sofa", Rate(1, 8), 1.234], ["tv", None, "x"]]
    ).split("\n")
    assert lines == [
        "| goal |   SR |    m |",
        "| ---- | ---: | ---: |",
        "| sofa | 12.5 | 1.23 |",
        "| tv   |    - |    x |",
    ]


def test_a_column_of_single_characters_keeps_the_hyphen_without_which_there_is_no_table():
    assert markdown_table(("goal", "p"), [["tv", 1]]).split("\n") == [
        "| goal |  p |",
        "| ---- | -: |",
        "| tv   |  1 |",
    ]


def test_a_rate_and_its_interval_are_printed_as_the_paper_does():
    assert percent(47 / 54) == "87.0"
    assert interval_text(Rate(47, 54)) == "76 to 94"


def test_probabilities_are_right_where_that_share_of_them_comes_true():
    judged = [(0.25, i == 0) for i in range(4)] + [(0.75, i > 0) for i in range(4)]
    assert expected_calibration_error(judged) == pytest.approx(0.0)
    assert log_loss(judged) == pytest.approx(-0.75 * np.log(0.75) - 0.25 * np.log(0.25))
    sure = [(1.0, True), (1.0, False)]
    assert expected_calibration_error(sure) == pytest.approx(0.5)
    assert 5 < log_loss(sure) < 10
    assert expected_calibration_error([]) is None and log_loss([]) is None
