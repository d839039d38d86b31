"""Models of several makers and lessons from photographs: converted, turned, cut out and asked."""

import subprocess
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import torch

from sim_stubs.homes.furniture.appearance import mean_colour
from training import lessons, models
from training.homes import Mixture, TrainingHome
from training.lessons import NAMES, read_lessons
from training.models import read_models
from training.training import lesson_loss
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import THINGS

OBJ = """mtllib converted.mtl
v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 -2\nv 2 0 -2\nv 2 1 -2\nv 0 1 -2
usemtl front\nf 1 2 3 4
usemtl rest\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 4 3 7 8\nf 5 6 2 1
"""
"""A box 2 wide, 1 high and 2 deep, whose front at z = 0 has a colour of its own."""
MTL = "newmtl front\nKd 0.5 0 0\nnewmtl rest\nKd 0.1 0.1 0.1\n"


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A table with one model, its file, and an `assimp` that answers with a box."""

    def of(maker="Kenney", turn=0, assimp=True):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
        (tmp_path / "models.tsv").write_text(
            f"maker\tfile\tlabel\tturn\n{maker}\trepository/box.fbx\tsofa\t{turn}\n"
        )
        monkeypatch.setattr(models, "TABLE", tmp_path / "models.tsv")
        (tmp_path / "repository").mkdir(exist_ok=True)
        (tmp_path / "repository" / "box.fbx").write_text("not read here")

        def run(command, **_):
            if not assimp:
                raise FileNotFoundError("assimp")
            Path(command[-1]).write_text(OBJ)
            Path(command[-1]).with_suffix(".mtl").write_text(MTL)
            return SimpleNamespace(stdout="")

        monkeypatch.setattr(subprocess, "run", run)
        read_models.cache_clear()
        return tmp_path

    yield of
    read_models.cache_clear()


def front_of(piece):
    """Mean of the corners of the part in the front's colour."""
    [front] = [part for part in piece.parts if part.rgba[0] > 2 * part.rgba[1]]
    return front.vertices.mean(axis=0)


@pytest.mark.parametrize(("turn", "front"), [(0, (0, -1)), (180, (0, 1)), (-90, (-1, 0))])
def test_a_model_stands_turned_as_the_table_says(checkout, turn, front):
    [sofa] = read_models(checkout(turn=turn))["sofa"]
    np.testing.assert_allclose(front_of(sofa)[:2], front, atol=1e-5)
    np.testing.assert_allclose(sofa.size, (2, 2, 1), atol=1e-5)
    assert sofa.attribution == "Kenney, Furniture Pack 1.0, CC0"


def test_colours_in_linear_light_become_those_of_screens(checkout):
    [plain] = read_models(checkout())["sofa"]
    read_models.cache_clear()
    [linear] = read_models(checkout(maker="Pascal"))["sofa"]
    darkest = [min(mean_colour(part)[1] for part in each.parts) for each in (plain, linear)]
    reddest = [max(mean_colour(part)[0] for part in each.parts) for each in (plain, linear)]
    assert darkest[0] == darkest[1] == 0.0
    assert reddest == pytest.approx([0.5, 0.5 ** (1 / 2.2)], abs=0.01)


def test_a_missing_file_or_program_is_told_in_one_line(checkout):
    folder = checkout(assimp=False)
    with pytest.raises(ConfigError, match=r"models need assimp: apt install assimp-utils"):
        read_models(folder)
    (folder / "repository" / "box.fbx").unlink()
    with pytest.raises(ConfigError, match=r"box\.fbx is missing: check out its repository"):
        read_models(folder)
    with pytest.raises(ConfigError, match=r"makers-0001 needs models; give them by --models"):
        TrainingHome(Mixture.MAKERS, 1).house()


def test_the_table_names_known_makers_classes_and_turns():
    rows = [line.split("\t") for line in models.TABLE.read_text().splitlines()[1:]]
    assert len(rows) > 150 and {maker for maker, *_ in rows} == set(models.MAKERS)
    assert {label for _, _, label, _ in rows} <= set(THINGS)
    assert {turn for *_, turn in rows} <= {"0", "180", "-90"}
    assert len({file for _, file, *_ in rows}) == len(rows)


@pytest.fixture
def teacher(monkeypatch):
    """Says of each patch how red it is, of every name alike."""
    asked = []

    def embed_images(patches):
        asked.extend(patches)
        red = np.array([patch[..., 0].mean() / 255 for patch in patches])
        return np.stack([red, np.sqrt(1 - red**2)], axis=1)

    answers = SimpleNamespace(
        embed_images=embed_images,
        embed_texts=lambda names: np.tile([1.0, 0.0], (len(names), 1)),
        log_odds=(10.0, -5.0),
    )
    monkeypatch.setattr(lessons, "open_photo_classes", lambda _: answers)
    return asked


def test_photographs_are_cut_asked_once_and_kept(tmp_path, teacher):
    for name, red in (("a.png", 255), ("b.jpg", 0)):
        assert cv2.imwrite(str(tmp_path / name), np.full((60, 90, 3), (0, 0, red), np.uint8))
    first = read_lessons([tmp_path], tmp_path / "kept.npz")
    assert first.pixels.shape == (20, 96, 96, 3) and first.beliefs.shape == (20, len(NAMES))
    np.testing.assert_allclose(first.beliefs[:10], 1 / (1 + np.exp(-5)), rtol=0.01)
    np.testing.assert_allclose(first.beliefs[10:], 1 / (1 + np.exp(5)), rtol=0.1)
    assert {patch.shape[0] == patch.shape[1] for patch in teacher} == {True}
    assert min(len(patch) for patch in teacher) < 70 and max(len(patch) for patch in teacher) >= 400
    again = read_lessons([tmp_path], tmp_path / "kept.npz")
    assert len(teacher) == 20 and np.array_equal(again.pixels, first.pixels)


def test_folders_without_pictures_are_refused(tmp_path, teacher):
    with pytest.raises(ConfigError, match="holds no pictures"):
        read_lessons([tmp_path], tmp_path / "kept.npz")
    (tmp_path / "torn.jpg").write_bytes(b"\xff\xd8")
    with pytest.raises(ConfigError, match=r"torn\.jpg is no picture; delete it"):
        read_lessons([tmp_path], tmp_path / "kept.npz")
    assert not (tmp_path / "kept.npz").exists() and not teacher


def test_a_lesson_is_learned_where_the_odds_are_those_of_the_teacher():
    beliefs = torch.tensor([[0.9, 0.1], [0.5, 0.02]])
    right = torch.logit(beliefs)
    least = lesson_loss(right, beliefs)
    assert all(lesson_loss(right + change, beliefs) > least for change in (-0.5, 0.5))
