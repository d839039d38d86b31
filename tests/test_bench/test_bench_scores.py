import pytest

from vizbot.bench.episodes.episode import Episode, EpisodeResult, GoalResult
from vizbot.bench.harness.scores import NavigationScore, Rate, spl
from vizbot.bench.harness.tables import interval_text, markdown_table, percent


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


def test_spl_weighs_success_with_the_shortest_way():
    assert spl([goal(driven=8.0, shortest=4.0)]) == 0.5
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
    assert score.collisions == 3
    assert score.steps == 100


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


def test_a_rate_and_its_interval_are_printed_as_the_paper_does():
    assert percent(47 / 54) == "87.0"
    assert interval_text(Rate(47, 54)) == "76 to 94"
