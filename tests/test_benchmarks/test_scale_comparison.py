import pytest

from benchmarks.objectnav.scale_comparison import ScaleComparison
from tests.test_benchmarks.printed_table import rows_in


def outcomes(right, of=10):
    return {trial: trial in right for trial in range(of)}


def test_three_scales_are_shown_better_only_when_they_are_against_every_single_one():
    three = outcomes(range(9))
    compared = ScaleComparison.over(three, {"scale 1": outcomes((0,)), "scale 0": outcomes((9,))})
    assert (compared.pairs["scale 1"].wins, compared.pairs["scale 1"].losses) == (8, 0)
    assert compared.summary()["three_scales_better"] is True
    near = {"scale 1": outcomes((0,)), "scale 0": outcomes(range(4, 9))}
    compared = ScaleComparison.over(three, near)
    assert compared.best == "scale 0"
    assert compared.summary() == {
        "three_scale_wins": 4, "three_scale_losses": 0,
        "three_scale_p": pytest.approx(2 / 2**4), "three_scales_better": False,
    }  # fmt: skip


def test_a_single_scale_that_wins_more_is_never_worse_than_three():
    compared = ScaleComparison.over(outcomes(()), {"scale 1": outcomes(range(10))})
    assert compared.summary("by_rule_")["by_rule_three_scale_p"] == pytest.approx(2 / 2**10)
    assert compared.summary("by_rule_")["by_rule_three_scales_better"] is False


def test_of_equally_good_single_scales_the_one_that_is_less_surely_beaten_counts_as_best():
    # Against six right: 4 to 2 with p = 0.69, and 2 to 0 with p = 0.5.
    singles = {"scale 0": outcomes((0, 1, 2, 3)), "scale 1": outcomes((0, 1, 7, 8))}
    compared = ScaleComparison.over(outcomes(range(6)), singles)
    assert compared.best == "scale 1"
    assert compared.pairs["scale 1"].p == pytest.approx(44 / 64)


def test_only_trials_that_all_have_done_are_compared():
    compared = ScaleComparison.over(
        outcomes((0, 1)), {"scale 1": outcomes((1,), of=4), "scale 0": outcomes((), of=3)}
    )
    assert (compared.three.count, compared.three.trials) == (2, 3)
    assert compared.best_single == pytest.approx(1 / 3)


def test_without_a_common_trial_there_is_no_comparison():
    compared = ScaleComparison.over(outcomes((0,)), {"scale 1": {}})
    assert compared.best is None and compared.best_single is None
    assert set(compared.summary().values()) == {None}
    assert compared.table("success") == ""


def test_the_table_shows_discordant_pairs_and_p_for_each_single_scale():
    singles = {"scale 1": outcomes((0, 9)), "scale 0": outcomes(range(9))}
    rows = rows_in(ScaleComparison.over(outcomes(range(9)), singles).table("success"))
    assert rows[2] == ["scale 1", "90.0", "20.0", "8", "1", "0.039", "yes"]
    assert rows[3] == ["scale 0", "90.0", "90.0", "0", "0", "1", "not shown"]
