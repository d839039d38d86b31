"""CLIP models in every way in which people have them on a disk, and each cause why one is none."""

import json
import os
import shutil

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file
from transformers import CLIPConfig, CLIPModel, CLIPTokenizer

from mapping.clip.checkpoint import tensors
from mapping.clip.checkpoint.checkpoint import find_checkpoint
from mapping.clip.encoder import load_clip
from tests.helpers.failing import raising
from tests.helpers.random_clip import letters_tokenizer, random_clip, save_tiny_clip
from tests.test_maps.test_clip_encoder import pictures
from vizbot.core.errors import ConfigError
from vizbot.rig import require_encoder

B32 = "openai/clip-vit-base-patch32"
TEXTS = ["sofa", "toilet", "kitchen", "a red chair"]
MAIN, OTHER = 40 * "a", 40 * "b"
WEIGHTS, PICKLE = "model.safetensors", "pytorch_model.bin"


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """A folder as `save_pretrained` of transformers 4 fills it."""
    folder = tmp_path_factory.mktemp("tiny")
    save_tiny_clip(folder)
    return folder


@pytest.fixture
def folder(tiny, tmp_path):
    """A copy of it, to be changed."""
    return shutil.copytree(tiny, tmp_path / "clip")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The folder of B/32 in an empty cache of the hub."""
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path / "hub"))
    made = tmp_path / "hub" / "models--openai--clip-vit-base-patch32"
    made.mkdir(parents=True)
    return made


def as_pickle(folder, **settings):
    """Have the weights in a pickle alone, with the positions that older libraries keep in it."""
    weights = load_file(folder / WEIGHTS)
    weights["text_model.embeddings.position_ids"] = torch.arange(77)[None]
    torch.save(weights, folder / PICKLE, **settings)
    (folder / WEIGHTS).unlink()
    return folder


def fetched(cache, folder, commit, revision=None):
    """Put files into the cache as the hub's client does: links to blobs, and a reference."""
    snapshot = cache / "snapshots" / commit
    snapshot.mkdir(parents=True)
    (cache / "blobs").mkdir(exist_ok=True)
    for path in folder.iterdir():
        blob = cache / "blobs" / f"{commit}-{path.name}"
        shutil.copy(path, blob)
        (snapshot / path.name).symlink_to(os.path.relpath(blob, snapshot))
    if revision is not None:
        reference = cache / "refs" / revision
        reference.parent.mkdir(parents=True, exist_ok=True)
        reference.write_text(commit)
    return snapshot


def answers(name):
    encoder = load_clip(str(name), "cpu")
    images = pictures((112, 112), (64, 64), (90, 131))
    return np.concatenate([encoder.embed_texts(TEXTS), encoder.embed_images(images)])


def refusal(name):
    """The line that refuses it."""
    with pytest.raises(ConfigError) as refused:
        load_clip(str(name), "cpu")
    line = str(refused.value)
    assert "\n" not in line
    assert "hf download" in line or "give a CLIP model" in line, line
    return line


def of_the_librarys_own_pickle(folder):
    as_pickle(folder)


def of_a_pickle_of_an_older_torch(folder):
    as_pickle(folder, _use_new_zipfile_serialization=False)


def of_transformers_5(folder):
    settings = json.loads((folder / "preprocessor_config.json").read_text())
    (folder / "preprocessor_config.json").unlink()
    whole = {"processor_class": "CLIPProcessor", "image_processor": settings}
    (folder / "processor_config.json").write_text(json.dumps(whole))


def of_words_and_merges(folder):
    tokenizer = json.loads((folder / "tokenizer.json").read_text())
    (folder / "tokenizer.json").unlink()
    (folder / "vocab.json").write_text(json.dumps(tokenizer["model"]["vocab"]))
    (folder / "merges.txt").write_text("#version: 0.2\n")


def of_several_files(folder):
    weights = load_file(folder / WEIGHTS)
    names = sorted(weights)
    parts = {"model-1.safetensors": names[:40], "model-2.safetensors": names[40:]}
    for part, kept in parts.items():
        save_file({name: weights[name] for name in kept}, folder / part, {"format": "pt"})
    listed = {name: part for part, kept in parts.items() for name in kept}
    (folder / f"{WEIGHTS}.index.json").write_text(json.dumps({"weight_map": listed}))
    (folder / WEIGHTS).unlink()


LAYOUTS = (
    of_the_librarys_own_pickle, of_a_pickle_of_an_older_torch, of_transformers_5,
    of_words_and_merges, of_several_files,
)  # fmt: skip


@pytest.mark.parametrize("change", LAYOUTS)
def test_a_folder_of_every_layout_embeds_as_that_of_safetensors(tiny, folder, change):
    change(folder)
    np.testing.assert_array_equal(answers(folder), answers(tiny))


def test_what_transformers_itself_saves_now_loads(tiny, tmp_path):
    from transformers import CLIPProcessor

    folder = tmp_path / "now"
    CLIPModel.from_pretrained(tiny).save_pretrained(folder)
    processor = tiny / "preprocessor_config.json"
    CLIPProcessor(
        tokenizer=CLIPTokenizer.from_pretrained(tiny),
        image_processor=_image_processor(processor),
    ).save_pretrained(folder)
    assert not (folder / "preprocessor_config.json").exists()
    np.testing.assert_array_equal(answers(folder), answers(tiny))


def _image_processor(settings):
    from transformers.models.clip.image_processing_pil_clip import CLIPImageProcessorPil

    return CLIPImageProcessorPil.from_dict(json.loads(settings.read_text()))


def test_a_pickle_in_the_hubs_cache_loads_after_one_line_that_says_so(tiny, folder, cache, caplog):
    fetched(cache, as_pickle(folder), MAIN, "main")
    require_encoder("ViT-B/32")
    np.testing.assert_array_equal(answers("ViT-B/32"), answers(tiny))
    [line] = [each.getMessage() for each in caplog.records]
    assert line.startswith(f"{B32}, revision main: pytorch_model.bin is a pickle")


def test_safetensors_of_another_revision_come_before_the_pickle_of_main(
    tiny, folder, cache, caplog
):
    spoilt = as_pickle(folder)
    torch.save({"visual_projection.weight": torch.zeros(1)}, spoilt / PICKLE)
    fetched(cache, spoilt, MAIN, "main")
    fetched(cache, tiny, OTHER, "refs/pr/15")
    np.testing.assert_array_equal(answers("ViT-B/32"), answers(tiny))
    [line] = [each.getMessage() for each in caplog.records]
    assert line == f"{B32}, revision refs/pr/15: its weights are used"


def test_a_revision_of_weights_alone_takes_the_rest_from_main(tiny, folder, cache, tmp_path):
    converted = tmp_path / "converted"
    converted.mkdir()
    shutil.copy(folder / WEIGHTS, converted)
    fetched(cache, as_pickle(folder), MAIN, "main")
    fetched(cache, converted, OTHER, "refs/pr/15")
    assert find_checkpoint("ViT-B/32").weights.parent.name == OTHER
    np.testing.assert_array_equal(answers("ViT-B/32"), answers(tiny))


def test_a_revision_with_a_configuration_of_its_own_goes_by_that(tiny, folder, cache):
    wider(folder)
    fetched(cache, as_pickle(folder), MAIN, "main")
    fetched(cache, tiny, OTHER, "refs/pr/15")
    np.testing.assert_array_equal(answers("ViT-B/32"), answers(tiny))


def test_a_snapshot_without_a_reference_and_a_folder_of_the_cache_load(tiny, cache, caplog):
    snapshot = fetched(cache, tiny, OTHER)
    for name in ("ViT-B/32", cache, snapshot):
        np.testing.assert_array_equal(answers(name), answers(tiny))
    assert f"{B32}, revision {OTHER}: its weights are used" in caplog.messages


def test_main_with_safetensors_is_taken_without_a_word(tiny, cache, caplog):
    fetched(cache, tiny, OTHER, "refs/pr/15")
    fetched(cache, tiny, MAIN, "main")
    assert find_checkpoint("ViT-B/32").weights.parent.name == MAIN
    answers("ViT-B/32")
    assert caplog.messages == []


@pytest.mark.long
def test_the_papers_own_model_embeds_the_same_from_a_pickle_and_from_safetensors(
    cache, tmp_path, caplog
):
    torch.manual_seed(1)
    config = CLIPConfig(projection_dim=512, text_config={}, vision_config={})
    for name, plain in (("pickle", False), ("plain", True)):
        made = tmp_path / name
        torch.manual_seed(2)
        random_clip(config).save_pretrained(made)
        letters_tokenizer().save_pretrained(made)
        means = {"image_mean": [0.48, 0.46, 0.41], "image_std": [0.27, 0.26, 0.28]}
        (made / "preprocessor_config.json").write_text(json.dumps(means))
        if not plain:
            fetched(cache, as_pickle(made), MAIN, "main")
            by_pickle = answers("ViT-B/32")
    fetched(cache, made, OTHER, "refs/pr/15")
    by_safetensors = answers("ViT-B/32")
    assert by_pickle.shape == (7, 512)
    np.testing.assert_array_equal(by_pickle, by_safetensors)
    assert [line.split(": ")[0] for line in caplog.messages] == [
        f"{B32}, revision main",
        f"{B32}, revision refs/pr/15",
    ]


def without(*names):
    def change(folder):
        for name in names:
            (folder / name).unlink()

    return change


def torn(folder):
    weights = folder / WEIGHTS
    weights.write_bytes(weights.read_bytes()[:5000])


def torn_pickle(folder):
    as_pickle(folder)
    weights = folder / PICKLE
    weights.write_bytes(weights.read_bytes()[:5000])


def page_instead_of_a_pickle(folder):
    without(WEIGHTS)(folder)
    (folder / PICKLE).write_text("<html>not found</html>")


def stand_in(folder):
    (folder / WEIGHTS).write_text("version https://git-lfs.github.com/spec/v1\noid sha256:1\n")


class Trap:
    def __reduce__(self):
        return os.mkdir, ("sprung",)


def trap(folder):
    without(WEIGHTS)(folder)
    torch.save({"logit_scale": Trap()}, folder / PICKLE)


def no_table(folder):
    without(WEIGHTS)(folder)
    torch.save([torch.zeros(1)], folder / PICKLE)


def another_model(folder):
    save_file({"conv1.weight": torch.zeros(1)}, folder / WEIGHTS, {"format": "pt"})


def with_weights(change):
    """A change of the table of weights."""

    def spoil(folder):
        weights = load_file(folder / WEIGHTS)
        change(weights)
        save_file(weights, folder / WEIGHTS, {"format": "pt"})

    return spoil


def with_settings(change):
    """A change of `config.json`."""

    def spoil(folder):
        config = json.loads((folder / "config.json").read_text())
        change(config)
        (folder / "config.json").write_text(json.dumps(config))

    return spoil


one_tensor_less = with_weights(lambda weights: weights.pop("visual_projection.weight"))
wider = with_settings(lambda config: config.update(projection_dim=32))
implausible = with_settings(lambda config: config["vision_config"].update(num_hidden_layers=10**6))
odd_heads = with_settings(lambda config: config["vision_config"].update(num_attention_heads=5))


def newer_tokenizer(folder):
    (folder / "tokenizer.json").write_text('{"version": "9.0", "model": {"type": "Next"}}')


def lost_part(folder):
    of_several_files(folder)
    (folder / "model-2.safetensors").unlink()


def part_from_elsewhere(folder):
    of_several_files(folder)
    listed = {"weight_map": {"logit_scale": "../../model.safetensors"}}
    (folder / f"{WEIGHTS}.index.json").write_text(json.dumps(listed))


no_numbers = with_weights(lambda weights: weights["visual_projection.weight"].fill_(float("nan")))
no_direction = with_weights(lambda weights: weights["text_projection.weight"].fill_(0.0))


@with_weights
def blind(weights):
    """Whatever the picture, the same comes out."""
    weights["vision_model.post_layernorm.weight"][:] = 0.0
    weights["vision_model.post_layernorm.bias"][:] = 1.0


def no_words(folder):
    of_words_and_merges(folder)
    (folder / "vocab.json").write_text('{"<|startoftext|>": 52, "<|endoftext|>": 53}')


def no_colours(folder):
    (folder / "preprocessor_config.json").write_text('{"image_mean": [0.5, 0.5, 0.5]}')


def settings_without_end(folder):
    os.truncate(folder / "config.json", 16 * 1024 * 1024 + 1)


CAUSES = {
    torn: f"has a {WEIGHTS} that is damaged or not whole",
    torn_pickle: f"has a {PICKLE} that is damaged or not whole",
    page_instead_of_a_pickle: f"has a {PICKLE} that is damaged or not whole",
    stand_in: f"has a stand-in of Git LFS instead of {WEIGHTS}",
    trap: f"has a {PICKLE} that holds more than tensors, which might run: it is refused",
    no_table: f"has a {PICKLE} that is no table of tensors",
    another_model: "has weights of another model, of conv1.weight and not logit_scale",
    one_tensor_less: "is incomplete: it lacks 1 of its 78 tensors, visual_projection.weight first",
    wider: "has weights of another architecture: text_projection.weight is 16 x 32, by config.json"
    " 32 x 32",
    implausible: "vision_config.num_hidden_layers = 1000000: it must be at most 128",
    odd_heads: "is none that transformers 5",
    newer_tokenizer: "has a tokenizer that transformers 5",
    lost_part: "lacks 1 of its 2 files of weights, model-2.safetensors first",
    part_from_elsewhere: "that lists no files beside it",
    no_numbers: "computes what is no number",
    no_direction: "embeds texts as what is no direction",
    blind: "embeds different pictures as the same: its weights are damaged",
    no_words: "embeds different texts as the same: its tokenizer knows no words",
    no_colours: "has image settings of no CLIP in preprocessor_config.json: image_std",
    settings_without_end: "it has 16777217 bytes, more than 16777216; give a folder",
}


@pytest.mark.parametrize("spoil", CAUSES, ids=CAUSES.values())
def test_each_cause_why_weights_cannot_be_used_has_its_own_line(
    folder, spoil, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    spoil(folder)
    assert CAUSES[spoil] in refusal(folder)
    assert not (tmp_path / "sprung").exists()


MISSING = {
    (WEIGHTS,): f"has no weights: neither {WEIGHTS} nor {PICKLE} is there",
    ("tokenizer.json", "tokenizer_config.json"): "has no tokenizer",
    ("preprocessor_config.json",): "has no image settings",
    ("config.json",): "no CLIP weights for",
}


@pytest.mark.parametrize("names", MISSING)
def test_a_missing_file_is_named_before_anything_is_loaded(folder, names):
    without(*names)(folder)
    with pytest.raises(ConfigError, match=MISSING[names]):
        require_encoder(str(folder))
    assert MISSING[names] in refusal(folder)


def test_weights_that_may_not_be_read_say_so(folder, monkeypatch):
    path_open = type(folder).open

    def deny(path, *rest, **named):
        if path.name == WEIGHTS:
            raise PermissionError(13, "Permission denied", str(path))
        return path_open(path, *rest, **named)

    monkeypatch.setattr(type(folder), "open", deny)
    assert f"has a {WEIGHTS} that cannot be read: Permission denied" in refusal(folder)


@pytest.mark.parametrize(
    "error", [MemoryError(), RuntimeError("DefaultCPUAllocator: can't allocate memory"),
              OSError(12, "Cannot allocate memory")],
)  # fmt: skip
def test_too_little_memory_is_no_damage(folder, monkeypatch, error):
    monkeypatch.setattr(tensors, "load_file", raising(error))
    assert "does not fit into this computer's memory: model.safetensors has" in refusal(folder)


def test_a_fetched_model_without_its_weights_says_what_is_missing(folder, cache):
    without(WEIGHTS)(folder)
    fetched(cache, folder, MAIN, "main")
    line = refusal("ViT-B/32")
    assert (
        f"neither {WEIGHTS} nor {PICKLE}" in line and f"hf download --force-download {B32}" in line
    )


def test_a_link_to_a_blob_that_was_not_fetched_whole_is_a_missing_file(folder, cache):
    snapshot = fetched(cache, folder, MAIN, "main")
    (snapshot / WEIGHTS).resolve().unlink()
    assert "has no weights" in refusal("ViT-B/32")
