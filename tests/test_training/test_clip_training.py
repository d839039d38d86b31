"""Training of the embedded CLIP on a handful of made-up patches."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from mapping.clip.embedded.encoder import load_embedded_clip, to_ids, to_pixels, to_values
from mapping.clip.embedded.text_encoder import DIMENSION, LONGEST_TEXT
from mapping.clip.embedded.towers import Clip
from training.captions.captions import Caption, draw_texts, target, truth_of
from training.captions.facts import FACT_INDEX, Facts
from training.lessons import NAMES, Lessons
from training.text_stage import TextStageConfig, export_model, train_text_tower
from training.training import (
    VOCABULARY,
    PatchPool,
    StepsConfig,
    augmented,
    chosen_threshold,
    contrastive_loss,
    lesson_loss,
    swap_channels,
    train,
    train_tokenizer,
)
from training.views import LabelledPatches
from training.wide_stage import between
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import EVALUATION_CLASSES

COLOURS = {"sofa": (200, 30, 30), "bed": (30, 30, 200), "plant": (30, 180, 30)}


@pytest.fixture(scope="module")
def pool(tmp_path_factory):
    """A hundred patches: what is red is a sofa, what is blue a bed, what is green a plant."""
    names = np.random.default_rng(0).choice(list(COLOURS), 100)
    pixels = np.stack([np.full((96, 96, 3), COLOURS[name], np.uint8) for name in names])
    columns = np.array([FACT_INDEX[name] for name in COLOURS])
    shown = np.array([[1.0 if name == other else 0.0 for other in COLOURS] for name in names])
    facts = Facts.from_dense(shown.astype(np.float32), columns)
    path = tmp_path_factory.mktemp("views") / "0000.npz"
    LabelledPatches(pixels, np.full(100, 224, np.int32), facts).save(path)
    return PatchPool([path])


@pytest.fixture(scope="module")
def tokenizer(pool):
    return train_tokenizer(pool.facts, 0)


def config(**changes):
    return StepsConfig(**{"steps": 4, "batch": 8, "warmup": 1, "checkpoint": 2} | changes)


def untrained(tokenizer):
    """A model with random weights, always the same."""
    torch.manual_seed(0)
    return Clip(tokenizer.get_vocab_size())


@pytest.mark.long
def test_a_run_that_was_broken_off_ends_as_an_unbroken_one(pool, tokenizer, tmp_path, monkeypatch):
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    whole.mkdir()
    halves.mkdir()
    unbroken = train(pool, tokenizer, untrained(tokenizer), whole, config())

    draws = iter(range(4))

    def broken_off(rng, count):
        if next(draws) == 3:
            raise KeyboardInterrupt
        return PatchPool.draw(pool, rng, count)

    with monkeypatch.context() as patch:
        patch.setattr(pool, "draw", broken_off)
        with pytest.raises(KeyboardInterrupt):
            train(pool, tokenizer, untrained(tokenizer), halves, config())
    resumed = train(pool, tokenizer, untrained(tokenizer), halves, config())
    for ours, theirs in zip(resumed.parameters(), unbroken.parameters(), strict=True):
        torch.testing.assert_close(ours, theirs)


@pytest.mark.long
def test_training_lowers_the_loss(pool, tokenizer, tmp_path):
    def loss(model):
        rng = np.random.default_rng(5)
        chosen = pool.draw(rng, 32)
        facts = pool.facts.take(chosen)
        captions = draw_texts(facts, rng)
        truth = torch.from_numpy(target(captions, facts))
        with torch.inference_mode():
            images = model.image_tower(to_values(torch.from_numpy(pool.pixels[chosen])))
            texts = model.text_tower(to_ids(tokenizer, [c.text for c in captions]))
            return float(contrastive_loss(model.log_odds(images, texts), truth))

    before = loss(untrained(tokenizer).eval())
    steps = config(steps=12, average=0.0, checkpoint=100)
    trained = train(pool, tokenizer, untrained(tokenizer), tmp_path, steps)
    assert loss(trained) < 0.8 * before


@pytest.mark.long
def test_photographs_teach_what_their_teacher_says(pool, tokenizer, tmp_path):
    beliefs = np.tile(np.float32([name == "refrigerator" for name in NAMES]), (4, 1))
    yellow = Lessons(np.full((4, 96, 96, 3), (220, 220, 20), np.uint8), beliefs)
    steps, losses = config(steps=12, average=0.0, checkpoint=100), []
    for lessons in (None, yellow):
        folder = tmp_path / str(len(losses))
        folder.mkdir()
        trained = train(pool, tokenizer, untrained(tokenizer), folder, steps, lessons)
        with torch.inference_mode():
            images = trained.image_tower(to_values(torch.from_numpy(yellow.pixels)))
            odds = trained.log_odds(images, trained.text_tower(to_ids(tokenizer, NAMES)))
        losses.append(float(lesson_loss(odds, torch.from_numpy(beliefs))))
    assert losses[1] < 0.5 * losses[0]


def test_weights_lie_between_those_of_two_models(tokenizer):
    before, after = untrained(tokenizer), untrained(tokenizer)
    before.image_tower.stem.weight.data.fill_(1.0)
    after.image_tower.stem.weight.data.fill_(3.0)
    mean = between(before, after, 0.25)
    torch.testing.assert_close(
        mean.image_tower.stem.weight, torch.full_like(before.image_tower.stem.weight, 1.5)
    )
    with pytest.raises(KeyError):
        between(before, before.image_tower, 0.5)


@pytest.mark.long
def test_what_is_frozen_stays_as_it_is(pool, tokenizer, tmp_path):
    model, before = untrained(tokenizer), untrained(tokenizer)
    model.text_tower.requires_grad_(False)
    model.image_tower.freeze(2)
    trained = train(pool, tokenizer, model, tmp_path, config())
    for name, tensor in trained.text_tower.state_dict().items():
        assert torch.equal(tensor, before.text_tower.state_dict()[name])
    assert torch.equal(trained.image_tower.stem.weight, before.image_tower.stem.weight)
    assert not torch.equal(trained.image_tower.head.weight, before.image_tower.head.weight)


def test_the_loss_is_least_where_the_log_odds_agree_with_the_truth():
    truth = torch.tensor([[1.0, 0.0, torch.nan], [0.0, 1.0, 0.0]])
    agreeing = torch.where(truth.nan_to_num() > 0, 8.0, -8.0)
    assert contrastive_loss(agreeing, truth) < 0.1
    assert contrastive_loss(-agreeing, truth) > 10.0


def test_what_is_open_to_dispute_does_not_change_the_loss():
    truth = torch.tensor([[1.0, torch.nan], [0.0, 1.0]])
    odds = torch.tensor([[2.0, -1.0], [-3.0, 1.0]])
    changed = odds.clone()
    changed[0, 1] = 9.0
    assert contrastive_loss(odds, truth) == pytest.approx(float(contrastive_loss(changed, truth)))


def test_augmented_images_stay_in_range_and_depend_on_the_seed_alone(pool):
    values = to_values(torch.from_numpy(pool.pixels[:4]))
    first, again = (augmented(values, np.random.default_rng(3)) for _ in range(2))
    assert torch.equal(first, again)
    assert first.abs().max() <= 1.0
    assert not torch.equal(first, values)


def test_what_is_told_of_colours_is_open_where_colours_were_changed(pool):
    pixels, changed = swap_channels(pool.pixels, 0.5, np.random.default_rng(0))
    assert 30 < changed.sum() < 70
    differ = (pixels != pool.pixels).any(axis=(1, 2, 3))
    assert differ.any() and not differ[~changed].any()
    captions = [Caption("a sofa", ("sofa",)), Caption("a red sofa", ("red sofa",))]
    truth = truth_of(captions, pool.facts, changed)
    assert not np.isnan(truth[:, 0]).any()
    np.testing.assert_array_equal(np.isnan(truth[:, 1]), changed)


def test_rare_things_are_drawn_as_often_as_common_ones(pool):
    drawn = pool.draw(np.random.default_rng(0), 3000)
    counts = pool.facts.take(drawn).columns(np.array([FACT_INDEX[n] for n in COLOURS])).sum(axis=0)
    assert counts.min() > 0.6 * counts.max()


def test_what_was_exported_embeds_as_the_model_did(pool, tokenizer, tmp_path):
    torch.manual_seed(1)
    model = Clip(tokenizer.get_vocab_size()).eval()
    export_model(model, tokenizer, 0.4, tmp_path)
    encoder = load_embedded_clip(tmp_path)
    assert encoder.threshold == 0.4
    assert encoder.dimension == DIMENSION
    texts = encoder.embed_texts(["a red sofa", "sofa"])
    with torch.inference_mode():
        expected = model.text_tower(to_ids(tokenizer, ["a red sofa", "sofa"])).numpy()
    np.testing.assert_allclose(texts, expected, atol=5e-3)  # 16-bit weights
    np.testing.assert_allclose(np.linalg.norm(texts, axis=1), 1.0, atol=1e-5)


@pytest.mark.parametrize(
    ("right", "threshold"),
    [
        ("1111111110 1", 0.89),  # nine of ten, then ten of eleven
        ("1111111110 0", 0.9),  # nine of ten, and nine of eleven are too few
        ("1111111100 1", 0.92),  # eight of nine are too few
        ("1111111101 111111111", 0.81),  # too few meanwhile
        ("0000000000 0", 0.99),  # the most similar, where none is right
    ],
)
def test_nine_tenths_of_what_the_threshold_lets_through_are_right(right, threshold):
    shown = np.array([float(sign) for sign in right if sign != " "], np.float32)
    count, classes = len(shown), len(EVALUATION_CLASSES)
    truth = np.full((count, classes), np.nan, np.float32)
    truth[:, 0] = shown
    facts = Facts.from_dense(truth, np.array([FACT_INDEX[name] for name in EVALUATION_CLASSES]))
    pixels, edges = np.zeros((count, 96, 96, 3), np.uint8), np.zeros(count, np.int32)
    falling = np.zeros((count, classes), np.float32)
    falling[:, 0] = 0.99 - 0.01 * np.arange(count)
    encoder = SimpleNamespace(
        embed_images=lambda images: falling,
        embed_texts=lambda texts: np.eye(classes, dtype=np.float32),
    )
    assert chosen_threshold(LabelledPatches(pixels, edges, facts), encoder) == threshold


def test_damaged_weights_are_one_line(tokenizer, tmp_path):
    torch.manual_seed(1)
    export_model(Clip(tokenizer.get_vocab_size()), tokenizer, 0.4, tmp_path)
    weights = (tmp_path / "model.safetensors").read_bytes()
    (tmp_path / "model.safetensors").write_bytes(weights[: len(weights) // 2])
    with pytest.raises(ConfigError, match="damaged"):
        load_embedded_clip(tmp_path)


def test_words_that_were_never_seen_are_put_together_from_pieces(tokenizer):
    assert tokenizer.get_vocab_size() <= VOCABULARY
    ids = tokenizer.encode("a zygomorphic sofa").ids
    assert tokenizer.token_to_id("<unknown>") not in ids
    assert tokenizer.encode("sofa").ids == tokenizer.encode("SOFA").ids


def test_long_texts_are_cut_off_and_short_ones_padded(tokenizer):
    ids = to_ids(tokenizer, ["sofa", "sofa " * 100])
    assert ids.shape == (2, LONGEST_TEXT)
    assert (ids[0, len(tokenizer.encode("sofa").ids) :] == 0).all()


def test_padding_does_not_change_a_text(tokenizer):
    torch.manual_seed(0)
    tower = Clip(tokenizer.get_vocab_size()).eval().text_tower
    with torch.inference_mode():
        alone = tower(to_ids(tokenizer, ["a bed"]))
        padded = tower(to_ids(tokenizer, ["a bed", "a bed next to a red sofa"]))[:1]
    torch.testing.assert_close(alone, padded, atol=1e-5, rtol=0)


def test_images_are_cut_to_their_middle_square():
    image = np.zeros((100, 300, 3), np.uint8)
    image[:, 100:200] = 255
    assert to_pixels([image]).min() == 255


def test_large_patches_that_show_nothing_are_drawn_too(tmp_path):
    """As often as others on average; small ones seldom."""
    edges = np.array([448] * 50 + [224] * 50 + [112] * 50, np.int32)
    shown = np.zeros((150, 1), np.float32)
    shown[::2] = 1.0
    facts = Facts.from_dense(shown, np.array([FACT_INDEX["sofa"]]))
    pixels = np.zeros((150, 96, 96, 3), np.uint8)
    LabelledPatches(pixels, edges, facts).save(tmp_path / "0000.npz")
    drawn = PatchPool([tmp_path / "0000.npz"]).draw(np.random.default_rng(0), 20000)
    bare = drawn[drawn % 2 == 1]
    large, medium, small = (np.mean(bare // 50 == i) for i in range(3))
    assert large > 2.5 * medium > 5 * small > 0
    assert 0.15 < len(bare) / len(drawn) < 0.3


def test_a_withheld_colour_is_not_taught_by_what_else_is_wrong_there():
    columns = np.array([FACT_INDEX[key] for key in ("sofa", "purple sofa", "bed")])
    shown = np.array([[1.0, 1.0, 0.0], [1.0, 0.0, 0.0]], np.float32)
    facts = Facts.from_dense(shown, columns)
    texts = [Caption(key, (key,)) for key in ("purple chair", "red chair", "purple lamp", "sofa")]
    truth = truth_of(texts, facts, np.zeros(2, bool))
    np.testing.assert_array_equal(truth[0], [np.nan, 0.0, np.nan, 1.0])
    np.testing.assert_array_equal(truth[1], [0.0, 0.0, 0.0, 1.0])


def test_the_text_stage_draws_phrasings_to_the_plain_name(tokenizer):
    torch.manual_seed(0)
    teacher = Clip(tokenizer.get_vocab_size()).text_tower.eval()
    config = TextStageConfig(
        steps=50, patches=4, spoken=24, unrelated=4, learning_rate=1e-3, warmup=5
    )
    student = train_text_tower(teacher, tokenizer, config)
    ids = to_ids(tokenizer, ["sofa", "can you go to the old sofa?"])
    with torch.inference_mode():
        old, new = teacher(ids), student(ids)
    assert float(old[0] @ new[1]) > float(old[0] @ old[1]) + 0.02
    assert float(old[0] @ new[0]) > 0.8
