"""The names of the classes of photographs, and the numbers that are fitted for them."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from mapping.clip.config import ClipMapperConfig
from mapping.clip.patches import patch_boxes
from mapping.clip.photos.fit import photo_fit
from mapping.clip.photos.names import CLASSES, TABLE, table
from training.photo_fit import PhotographPatches, fitted, patches_indoors, with_names_seen
from training.photo_names import BY_HAND, photo_synsets, rows_of_table
from training.wordnet import WordNet

WORDNET = Path("/usr/share/wordnet")


def test_the_table_that_ships_is_the_one_that_is_made():
    if not (WORDNET / "data.noun").is_file():
        pytest.skip("wordnet-base is not installed")
    assert TABLE.read_text(encoding="utf-8") == rows_of_table(WordNet.read(WORDNET))


def test_there_is_a_synset_for_each_class_and_they_are_in_order():
    synsets = photo_synsets()
    assert len(set(synsets)) == CLASSES
    assert list(synsets) == sorted(synsets)


def test_every_class_has_a_name_of_its_own():
    alone = {it.classes[0] for it in table().values() if len(it.classes) == 1}
    assert len(alone) >= 990  # a crane is a bird and a machine


def test_names_by_hand_come_before_those_of_wordnet():
    lines = [line for line in BY_HAND.read_text().splitlines() if line[0] != "#"]
    for name, relation, _ in (line.split("\t") for line in lines):
        assert bool(table()[name].near) == (relation == "near"), name
        assert (table()[name].remark is None) == (relation in ("is", "near")), name
    assert len(table()["sofa"].classes) == 1 and len(table()["dog"].classes) == 118


def drawn_patches(rng, count=400):
    """Patches of which the first tenth are sofas, by their logits and by their labels."""
    logits = rng.normal(size=(count, CLASSES)).astype(np.float32)
    shown = np.zeros((count, 2), np.int8)
    shown[: count // 10, 0] = 1
    shown[::7, 1] = 1
    logits[: count // 10, table()["sofa"].classes[0]] += 7.0
    return PhotographPatches(["sofa", "desk"], logits, shown)


def test_names_that_the_classifier_does_not_see_say_nothing_of_the_others():
    assert with_names_seen(drawn_patches(np.random.default_rng(0))).names == ["sofa"]


def test_the_fitted_odds_are_as_frequent_as_they_say():
    patches = with_names_seen(drawn_patches(np.random.default_rng(0)))
    found = fitted(patches, 1.0)
    assert found.auc > 0.95 and found.scale > 0.0 > found.bias
    assert found.cross_entropy < 0.2


class CountingClassifier:
    """It says the same of every patch, and counts how often it is asked."""

    asked = 0

    def logits(self, images):
        CountingClassifier.asked += 1
        return np.full((len(images), CLASSES), 2.0, np.float32)


def test_pictures_inside_homes_are_classified_once_and_their_boxes_counted(tmp_path, monkeypatch):
    folder = tmp_path / "photographs"
    names = "".join(f"  {i}: {name}\n" for i, name in enumerate(("sheep", "couch", "suitcase")))
    labels = {"in": "1 0.25 0.5 0.5 1.0\n2 0.9 0.9 0.1 0.1\n", "out": "0 0.5 0.5 1 1\n", "none": ""}
    for part in ("images/train2017", "object_detection/labels/train2017"):
        (folder / part).mkdir(parents=True)
    (folder / "object_detection/config.yaml").write_text(f"path: .\n\nnames:\n{names}")
    for name, text in labels.items():
        (folder / f"object_detection/labels/train2017/{name}.txt").write_text(text)
        picture = np.zeros((480, 640, 3), np.uint8)
        cv2.imwrite(str(folder / f"images/train2017/{name}.jpg"), picture)
    monkeypatch.setattr("training.photo_fit.open_photo_classes", lambda _: CountingClassifier())
    for _ in range(2):
        patches = patches_indoors(folder, tmp_path / "kept")
    assert CountingClassifier.asked == 1
    assert patches.names == ["sheep", "couch"]  # there is no name for the suitcase
    boxes = patch_boxes(640, 480, ClipMapperConfig())
    left, right = boxes[:, 2] <= 320, boxes[:, 0] >= 320
    assert patches.logits.shape == (len(boxes), CLASSES) and left.any() and right.any()
    assert not patches.shown[:, 0].any() and not patches.shown[right, 1].any()
    assert (patches.shown[left, 1] == 1).all()


def test_the_numbers_that_ship_can_be_used():
    fit = photo_fit()
    assert fit.temperature > 0.0 and fit.scale > 0.0 and 0.0 < fit.threshold < 1.0
