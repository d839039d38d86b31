"""One tick after another on scripted devices: what the robot does with what it is told."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.roomba.config import RoombaConfig
from mapping.clip.background.phrases import PHRASES
from mapping.clip.places.evidence import fitted_weights
from mapping.clip.reading import Reading
from tests.helpers.bundles import bundle_of
from tests.helpers.scripted_robot import PERIOD, ScriptedBase, ticks, until_it_ends
from vizbot.config import GyroSettlingConfig
from vizbot.core.errors import ConfigError, DeviceError, DeviceTimeoutError, MapError
from vizbot.core.observer import Outcome
from vizbot.core.types import STOP, ImuSamples, Twist
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Task
from vizbot.operator.session.place_answers import find_places
from vizbot.perception.perception import Perception


@pytest.mark.slow
def test_the_robot_first_turns_once_around(pipeline_on):
    base = ScriptedBase()
    steps = ticks(pipeline_on(base, look_around=True), 60)
    turning = [step.activity == "looking around" for step in steps]
    first_other = turning.index(False)
    assert {step.why for step in steps[:first_other]} == {reasons.AROUND}
    assert not any(turning[first_other:])
    turned = sum(twist.angular for twist in base.driven[:first_other]) * PERIOD
    assert 2 * np.pi - 0.1 < turned < 2 * np.pi + 0.6  # it brakes when it has been around


def test_with_a_gyroscope_the_robot_stands_still_first(pipeline_on):
    samples = ImuSamples(np.array([0.2, 0.205]), np.zeros((2, 3)), np.zeros(0), np.zeros((0, 3)))
    base = ScriptedBase()
    steps = ticks(pipeline_on(base, look_around=True, imu=samples), 14)
    standing = [step.activity.startswith("standing still") for step in steps]
    count = sum(standing)
    assert count == np.ceil(GyroSettlingConfig().seconds / PERIOD) and all(standing[:count])
    assert all(twist == STOP for twist in base.driven[:count])
    assert base.driven[-1].angular > 0.0


def test_a_step_along_a_path_takes_several_frames_of_which_one_is_embedded(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    for _ in range(40):
        before = base.T_odom_base
        pipeline.tick(Task.EXPLORE)
        assert np.linalg.norm((base.T_odom_base - before)[:2, 3]) <= 0.25
    assert pipeline.steps == 40
    frames = len(base.driven)
    assert frames > pipeline.steps
    pipeline.finish()
    assert len(np.unique(pipeline.bundle().elements.frames)) <= pipeline.steps < frames


def test_a_step_tells_frontiers_keyframes_and_the_frames_its_elements_are_of(pipeline_on):
    pipeline = pipeline_on(ScriptedBase())
    steps = [pipeline.tick(Task.EXPLORE) for _ in range(30)]
    taken = {step.frame_number for step in steps}
    last = steps[-1]
    assert last.frame_number > last.index  # a step may take several frames
    assert len(last.points) == len(last.frames) == len(last.boxes) > 0
    assert set(last.frames.tolist()) <= taken and last.frames.max() <= last.frame_number
    assert last.boxes[:, 2:].max(axis=0).tolist() <= [320, 240]
    assert last.estimate.keyframe in last.keyframe_poses
    assert last.keyframe_places.shape == (len(last.keyframe_poses), 3)
    assert last.closure_ends.shape == (len(last.closures), 2, 3)
    early = next(step for step in steps if len(step.frontiers))
    assert early.grid.contains(early.grid.to_cells(early.frontiers)).all()


def test_an_encoder_without_memory_costs_its_answers_and_not_the_run(pipeline_on, caplog):
    base = ScriptedBase()
    pipeline = pipeline_on(base, colour=(240, 220, 12))
    encoder = pipeline._encoder
    fails = SimpleNamespace(
        model_id=encoder.model_id,
        dimension=encoder.dimension,
        threshold=encoder.threshold,
        notice=None,
        embed_texts=encoder.embed_texts,
        reading=encoder.reading,
        embed_images=failing_at_first(encoder.embed_images, 4),
    )
    pipeline._encoder = fails
    steps = [pipeline.tick(Task.MAP) for _ in range(12)]
    pipeline.finish()
    assert len(steps[3].points) == 0
    assert len(steps[-1].points) > 0
    assert caplog.text.count("out of memory; going on without its answers") == 1
    assert caplog.text.count("the encoder works again") == 1


def failing_at_first(embed, times):
    left = [times]

    def embed_images(images):
        left[0] -= 1
        if left[0] >= 0:
            raise DeviceError("out of memory")
        return embed(images)

    return embed_images


def mapped(pipeline, frames):
    """Map from where the robot stands, until all is embedded; the map."""
    for _ in range(frames):
        assert pipeline.tick(Task.MAP).activity == "mapping"
    pipeline.finish()
    return pipeline.bundle()


def test_a_picture_that_is_burnt_out_is_not_mapped(pipeline_on):
    bundle = mapped(pipeline_on(None, colour=(255, 254, 255)), 3)
    assert len(bundle.elements.keyframes) == 0


def test_without_a_base_commands_are_computed_all_the_same(pipeline_on):
    pipeline = pipeline_on(None, look_around=True)
    steps = ticks(pipeline, 4)
    assert {step.activity for step in steps} == {"looking around"}
    assert steps[-1].command.angular > 0.5
    assert pipeline.tick(Task.MAP).command is None


def test_a_base_that_falls_silent_is_waited_for_and_not_for_ever(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    ticks(pipeline, 3)
    driven, base.silent_reads = len(base.driven), 20
    ticks(pipeline, 1)
    assert base.silent_reads == 0
    assert len(base.driven) == driven + 1
    base.silent_reads = 10_000
    with pytest.raises(DeviceTimeoutError, match="no answer"):
        ticks(pipeline, 1)
    waited = (10_000 - base.silent_reads) * PERIOD
    assert waited == pytest.approx(RoombaConfig().reconnect_timeout, abs=2 * PERIOD)


@pytest.mark.slow
def test_what_fills_the_view_is_found_confirmed_and_reported(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base, colour=(240, 220, 12))
    goal = pipeline.goal("yellow chair")
    for _ in range(3):
        began = pipeline.tick(Task.MAP).frame.stamp
    steps = until_it_ends(pipeline, goal)
    step, track = steps[-1], [each.T_map_base[:2, 3] for each in steps]
    assert step.ended[0] is Outcome.ARRIVED
    assert "making sure" in {each.activity for each in steps}
    assert base.driven[-1] == STOP
    report = pipeline.report(goal, *step.ended)
    driven = np.linalg.norm(np.diff(track, axis=0), axis=1).sum()
    assert report.effort.way == pytest.approx(driven, abs=1e-9)
    assert report.effort.seconds == pytest.approx(step.frame.stamp - began, abs=0.5)
    assert pipeline.look_up(pipeline.goal("yellow chair")).effort is None
    answer = report.candidates[0]
    assert answer.score > pipeline.config.objectnav.search.arrival_probability_last
    assert f"{answer.score:.0%} sure" in report.reason
    assert answer.score >= step.threshold == report.threshold
    assert np.linalg.norm(answer.position[:2] - step.T_map_base[:2, 3]) <= 1.5
    of_it = (step.frames == answer.frame) & (step.boxes == answer.box).all(axis=1)
    assert np.linalg.norm(step.points[of_it][:, :2] - answer.position[:2], axis=1) < 0.5


@pytest.mark.parametrize("colour", [(240, 220, 12), (120, 110, 100)])
def test_no_cosine_is_held_against_a_number(pipeline_on, mean_colours, colour):
    """Whatever the encoder calls its threshold, the search and the answers are the same."""
    runs = []
    for threshold in (-1.0, 0.95, 2.0):
        mean_colours.threshold = threshold
        pipeline = pipeline_on(ScriptedBase(), colour=colour)
        goal = pipeline.goal("yellow chair")
        steps = [pipeline.tick(goal) for _ in range(12)]
        asked = pipeline.look_up(pipeline.goal("yellow wall"))
        decided = [
            (step.activity, step.command, step.threshold, step.shown_score) for step in steps
        ]
        runs.append((decided, asked.outcome, asked.reason, asked.candidates[0].score))
    assert runs[0] == runs[1] == runs[2]


def give_other_cosines(encoder, slope, shift):
    """Scale and shift the cosines of an encoder of the fixture; what it knows of them follows."""
    images, texts = encoder.embed_images, encoder.embed_texts

    def other(rows):
        return np.column_stack([rows * np.sqrt(slope), np.full(len(rows), np.sqrt(shift))])

    encoder.embed_images = lambda pictures: other(images(pictures)).astype(np.float32)
    encoder.embed_texts = lambda words: other(texts(words)).astype(np.float32)
    encoder.dimension += 1
    encoder.threshold = slope * encoder.threshold + shift
    if encoder.log_odds is not None:
        factor = encoder.log_odds[0] / slope
        encoder.log_odds = factor, encoder.log_odds[1] - factor * shift


@pytest.mark.parametrize("slope", [0.2, 0.6])
@pytest.mark.parametrize("log_odds", [(100.0, -95.0), None])
def test_by_an_encoder_with_other_cosines_in_the_same_order_the_robot_does_the_same(
    pipeline_on, mean_colours, slope, log_odds
):
    """Even those that are far below any number that would suit the first one."""
    mean_colours.log_odds, mean_colours.belief_weights = log_odds, fitted_weights()
    runs = []
    for other in (False, True):
        if other:
            give_other_cosines(mean_colours, slope, 0.05)
        base = ScriptedBase()
        pipeline = pipeline_on(base, colour=(240, 220, 12))
        steps = ticks(pipeline, 12)
        goal = pipeline.goal("yellow wall")
        config = pipeline.config.objectnav
        pipeline.finish()
        kept = find_places(pipeline.bundle(), goal, config)
        done = [(step.activity, step.ended, step.candidate_xy is None) for step in steps]
        scores = [step.shown_score or 0.0 for step in steps] + [each.score for each in kept.places]
        runs.append((done, base.driven, kept.outcome, scores))
    *own, own_scores = runs[0]
    *others, others_scores = runs[1]
    assert own == others
    assert others_scores == pytest.approx(own_scores, rel=5e-3)
    assert max(others_scores) > 0.1


def test_by_belief_the_robot_stops_before_the_place_that_it_believes(pipeline_on, monkeypatch):
    asked, truly_believe = [], Perception.believe

    def believe(perception, belief):
        asked.append(belief)
        believed = truly_believe(perception, belief)
        rows, columns = np.nonzero(believed.seen)
        probabilities = np.zeros(believed.seen.shape)
        if len(rows):
            away = np.linalg.norm(believed.xy(rows, columns) - (1.375, 0.125), axis=1)
            probabilities[rows[away.argmin()], columns[away.argmin()]] = 0.99
        return replace(believed, probabilities=probabilities)

    monkeypatch.setattr(Perception, "believe", believe)
    base = ScriptedBase()
    pipeline = pipeline_on(base, colour=(240, 220, 12))
    goal = pipeline.goal("yellow chair")
    ended = until_it_ends(pipeline, goal, 80)[-1].ended
    assert ended[0] is Outcome.ARRIVED and "99%" in ended[1]
    assert base.driven[-1] == STOP
    assert len({id(belief) for belief in asked}) == 1
    answer = pipeline.report(goal, *ended).candidates[0]
    assert np.linalg.norm(answer.position[:2] - (1.375, 0.125)) <= 0.9


def test_without_a_base_nothing_is_driven_and_the_map_can_be_asked(pipeline_on):
    pipeline = pipeline_on(None, colour=(240, 220, 12))
    mapped(pipeline, 3)
    assert pipeline.look_up(pipeline.goal("yellow chair")).outcome is Outcome.LOCATED
    assert pipeline.look_up(pipeline.goal("blue chair")).outcome is Outcome.NOT_FOUND


def test_by_belief_the_robot_and_its_saved_map_give_the_same_answer(pipeline_on):
    pipeline = pipeline_on(None, colour=(240, 220, 12))
    goal = pipeline.goal("yellow chair")
    assert pipeline.look_up(goal).candidates == ()
    bundle, report = mapped(pipeline, 3), pipeline.look_up(goal)
    kept = find_places(bundle, goal, pipeline.config.objectnav)
    assert 0 < len(report.candidates) == len(kept.places)
    for candidate, place in zip(report.candidates, kept.places, strict=True):
        assert candidate.position == pytest.approx(place.position, abs=1e-3)
        assert candidate.score == pytest.approx(place.score, abs=1e-4)
    assert report.outcome is kept.outcome


def test_a_report_says_how_the_encoder_reads_the_words(pipeline_on, monkeypatch):
    pipeline = pipeline_on(ScriptedBase(), colour=(240, 220, 12))
    note = "lemon: a kind of yellow"
    encoder = type(pipeline._encoder)
    monkeypatch.setattr(encoder, "reading", lambda _, text: Reading("yellow chair", note))
    report = pipeline.look_up(pipeline.goal("lemon chair"))
    assert report.text == "lemon chair"
    assert report.reason.endswith(f"; {note}")


def test_a_robot_that_stands_still_with_nothing_to_do_does_not_add_to_its_map(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base, colour=(240, 220, 12))
    pipeline._parts = replace(pipeline._parts, every_picture=True)
    assert len(np.unique(mapped(pipeline, 30).elements.frames)) == 1
    base.drive(Twist(0.5, 0.0))  # by hand
    assert len(np.unique(mapped(pipeline, 5).elements.frames)) == 2


def test_a_new_map_begins_where_the_robot_stands_and_an_old_one_is_gone_on_with(pipeline_on):
    base = ScriptedBase()
    pipeline = pipeline_on(base)
    pipeline.keep_out = (np.array([[5.0, 5.0], [6.0, 5.0], [6.0, 6.0]], np.float32),)
    ticks(pipeline, 10)
    pipeline.finish()
    kept = pipeline.bundle()
    steps = pipeline.steps
    pipeline.begin_map(None)
    assert pipeline.bundle() is None and pipeline.keep_out == ()
    step = pipeline.tick(Task.MAP)
    assert (step.index, step.map_number) == (steps, 1)
    np.testing.assert_allclose(step.T_map_base[:2, 3], 0.0, atol=1e-6)
    pipeline.begin_map(kept)
    np.testing.assert_array_equal(pipeline.keep_out[0], kept.keep_out[0])
    assert pipeline.tick(Task.MAP).map_number == 2
    assert len(pipeline.bundle().keyframes.ids) >= len(kept.keyframes.ids)


def test_the_background_phrases_are_embedded_once_for_all_maps_of_a_run(
    pipeline_on, mean_colours, monkeypatch
):
    embedded, embed_texts = [], mean_colours.embed_texts

    def counting(texts):
        embedded.extend(texts)
        return embed_texts(texts)

    monkeypatch.setattr(mean_colours, "embed_texts", counting)
    pipeline = pipeline_on(ScriptedBase())
    ticks(pipeline, 3)
    pipeline.begin_map(None)
    ticks(pipeline, 3)
    assert all(embedded.count(phrase) == 1 for phrase in PHRASES)


def test_a_map_that_cannot_be_continued_is_refused_and_the_present_one_stays(pipeline_on):
    pipeline = pipeline_on(ScriptedBase())
    ticks(pipeline, 3)
    kept = pipeline.bundle()
    frame = pipeline.map.perception.frame
    for wrong in (
        replace(kept, model_id="another"),
        replace(kept, grid=replace(kept.grid, resolution=0.1)),
        bundle_of(frames=0, model_id="mean-colours"),  # no keyframe to know a place by
    ):
        with pytest.raises(MapError):
            pipeline.begin_map(wrong)
    assert pipeline.tick(Task.MAP).map_number == 0
    assert pipeline.map.perception.frame == frame + 1


def test_the_grid_that_is_shown_and_planned_on_holds_the_zones(pipeline_on):
    pipeline = pipeline_on(ScriptedBase())
    ahead = np.array([[0.5, -0.3], [1.0, -0.3], [1.0, 0.3], [0.5, 0.3]], np.float32)
    assert pipeline.tick(Task.MAP).grid.zones == ()
    pipeline.keep_out = (ahead,)
    assert pipeline.tick(Task.MAP).grid.zones == (ahead,)
    assert pipeline.bundle().keep_out == (ahead,)


@pytest.mark.slow
def test_what_is_refuted_is_believed_less_by_the_next_search_for_the_same_words(pipeline_on):
    pipeline = pipeline_on(ScriptedBase(), colour=(240, 220, 12))
    goal = pipeline.goal("yellow chair")
    place = pipeline.report(goal, *until_it_ends(pipeline, goal)[-1].ended).candidates[0]

    def believed_there(text):
        scores = pipeline.tick(pipeline.goal(text)).scores
        return float(scores.look_up(place.position[None])[0])

    pipeline.refute()
    assert believed_there("yellow chair") < 0.1 * place.score
    assert believed_there("yellow wall") > 0.5 * place.score


def test_the_method_of_the_paper_has_nothing_to_learn_of_a_place(pipeline_on):
    pipeline = pipeline_on(ScriptedBase(), method="paper")
    assert all(step.candidate_xy is None for step in ticks(pipeline, 3))
    for learn in (pipeline.refute, pipeline.affirm, pipeline.candidate):
        with pytest.raises(ConfigError, match="method 'paper' cannot learn"):
            learn(np.zeros(2))


@pytest.mark.slow
def test_a_step_tells_the_place_that_the_robot_goes_up_to_and_the_map_what_shows_it(pipeline_on):
    pipeline = pipeline_on(ScriptedBase(), colour=(240, 220, 12))
    assert pipeline.candidate(np.zeros(2)) is None, "nothing is searched for yet"
    goal = pipeline.goal("yellow chair")
    seen = []
    while not seen or seen[-1].ended is None:
        step = pipeline.tick(goal)
        seen += [step] if step.candidate_xy is not None else []
        assert step.index < 120
    assert len(seen) > 1 and all(step.target is not None for step in seen)
    place = pipeline.candidate(seen[0].candidate_xy)
    assert np.linalg.norm(place.position[:2] - seen[0].candidate_xy) < 0.5
    assert place.score == pytest.approx(float(seen[-1].scores.look_up(place.position[None])[0]))
    assert place.frame in seen[-1].frames and (place.box[2:] > place.box[:2]).all()
