"""Scores of a map for a goal."""

from types import SimpleNamespace

import numpy as np
import pytest

from mapping.clip.places.belief import PlaceBelief
from mapping.clip.places.footprint import PLACE
from nav.config import NavigatorConfig
from vizbot.core.place_scores import UNSEEN
from vizbot.objectnav.candidates import scores_of
from vizbot.objectnav.paper_search import PaperSearch, RunningScores
from vizbot.objectnav.tasks import Goal
from vizbot.perception.sightings import Sightings

EAST, NORTH = (
    Goal(text, side, 0.3)
    for text, side in zip(("sofa", "bed"), np.eye(2, dtype=np.float32), strict=True)
)


def seen_by_elements(points, similarities):
    """A stand-in for perception: elements at points (N, 3) with similarities to `EAST`."""
    embeddings = np.outer(similarities, EAST.embedding)
    return SimpleNamespace(
        clip_map=SimpleNamespace(embeddings=embeddings),
        sightings=lambda scores: Sightings(points, scores, points[:, :2]),
    )


def test_people_are_shown_the_probabilities_that_the_search_decides_by():
    seen = np.array([[True, True, False], [True, False, False]])
    probabilities = np.where(seen, [[0.2, 0.9, 0.0], [0.1, 0.0, 0.0]], 0.0)
    low, ones = np.array([-3, 5]), np.ones((2, 3), np.float32)
    cameras_xy = np.zeros((*seen.shape, 2))
    scores = scores_of(PlaceBelief(low, probabilities, ones, seen, cameras_xy, ones))
    assert scores.best == pytest.approx(0.9)
    corner = low * PLACE
    at = corner + PLACE * np.array([(1.5, 0.5), (0.5, 1.5), (1.5, 1.5), (9.0, 0.5)])
    assert scores.look_up(at) == pytest.approx([0.9, 0.1, UNSEEN, UNSEEN])
    assert scores.xy(np.array([0]), np.array([1]))[0] == pytest.approx(at[0])


def test_by_the_papers_method_a_place_has_the_highest_similarity_of_what_it_shows():
    points = np.array([[0.1, 0.1, 1.0], [0.2, 0.2, 0.0], [-0.3, 0.6, 0.5]])
    similarities = np.array([0.2, 0.5, -0.1], np.float32)
    scores = PaperSearch(NavigatorConfig()).observe(EAST, seen_by_elements(points, similarities))
    assert scores.best == pytest.approx(0.5)
    assert scores.look_up(points) == pytest.approx([0.5, 0.5, -0.1])
    nothing = PaperSearch(NavigatorConfig()).observe(
        EAST, seen_by_elements(points[:0], similarities[:0])
    )
    assert nothing.best is None and nothing.look_up(points).tolist() == [UNSEEN] * 3


def test_similarities_are_computed_once_for_a_goal_and_anew_for_another():
    embeddings = np.array([[1.0, 0.0], [0.6, 0.8], [0.0, 1.0]], np.float32)
    scores = RunningScores()
    assert scores.similarities_to(EAST, embeddings[:0]).tolist() == []
    assert scores.similarities_to(EAST, embeddings[:2]) == pytest.approx([1.0, 0.6])
    changed = np.concatenate([np.zeros((2, 2), np.float32), embeddings[2:]])
    assert scores.similarities_to(EAST, changed) == pytest.approx([1.0, 0.6, 0.0])
    assert scores.similarities_to(NORTH, embeddings) == pytest.approx([0.0, 0.8, 1.0])
