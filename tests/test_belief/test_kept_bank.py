"""The bank of pictures is embedded once for a set of weights."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from safetensors.torch import load_file

from mapping import map_bundle
from mapping.clip.background import kept_bank
from mapping.clip.background.kept_bank import bank_file
from mapping.clip.background.pictures import bank
from mapping.clip.encoder import load_clip
from mapping.clip.scores import NO_PICTURES, Background
from tests.helpers.bundles import bundle_of
from tests.helpers.failing import raising
from tests.helpers.random_clip import save_tiny_clip
from vizbot.commands.progress import BankProgress, parts_with_bank


@pytest.fixture
def weights(tmp_path, monkeypatch):
    """A folder of weights, for a user whose cache is empty."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    save_tiny_clip(tmp_path / "clip")
    return tmp_path / "clip"


class Counting:
    """An encoder that counts the pictures it embeds."""

    def __init__(self, folder, half=False):
        self.inner, self.pictures = load_clip(str(folder), "cpu", half), 0
        self.model_id = self.inner.model_id

    def weights_hash(self):
        return self.inner.weights_hash()

    def embed_texts(self, texts):
        return self.inner.embed_texts(texts)

    def embed_images(self, images):
        self.pictures += len(images)
        return self.inner.embed_images(images)


def test_the_next_run_with_the_same_weights_embeds_no_picture(weights):
    first, second = Counting(weights), Counting(weights)
    embedded = Background.embedded_by(first)
    kept = Background.embedded_by(second)
    assert (first.pictures, second.pictures) == (256, 0)
    np.testing.assert_array_equal(kept.pictures, embedded.pictures)
    np.testing.assert_array_equal(kept.embeddings, embedded.embeddings)
    np.testing.assert_allclose(kept.pictures, first.inner.embed_images(bank()), atol=1e-5)


def test_the_bank_is_of_the_weights_and_not_of_their_file_or_folder(weights, tmp_path):
    before = bank_file(Counting(weights))
    moved = weights.rename(tmp_path / "moved")
    torch.save(load_file(moved / "model.safetensors"), moved / "pytorch_model.bin")
    (moved / "model.safetensors").unlink()
    assert bank_file(Counting(moved)) == before
    assert bank_file(Counting(moved, half=True)) != before
    changed = torch.load(moved / "pytorch_model.bin")
    changed["visual_projection.weight"][0, 0] += 0.25
    torch.save(changed, moved / "pytorch_model.bin")
    assert bank_file(Counting(moved)) != before


def test_other_image_settings_make_another_bank(weights):
    before = bank_file(Counting(weights))
    settings = weights / "preprocessor_config.json"
    settings.write_text(settings.read_text().replace("0.48145466", "0.5"))
    assert bank_file(Counting(weights)) != before


def test_the_bank_is_in_the_users_cache(weights, tmp_path, monkeypatch):
    encoder = Counting(weights)
    assert bank_file(encoder).is_relative_to(tmp_path / "cache" / "vizbot")
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert bank_file(encoder).is_relative_to(tmp_path / "home" / ".cache" / "vizbot")


DAMAGE = {
    "cut": lambda content: content[: len(content) // 2],
    "a bit": lambda content: content[:-1000] + bytes([content[-1000] ^ 64]) + content[-999:],
    "empty": lambda _: b"",
    "text": lambda _: b"hello",
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_bank_is_made_anew_and_kept_again(weights, damage):
    first = Counting(weights)
    embedded = Background.embedded_by(first).pictures
    file = bank_file(first)
    whole = file.read_bytes()
    file.write_bytes(DAMAGE[damage](whole))
    again = Counting(weights)
    np.testing.assert_array_equal(Background.embedded_by(again).pictures, embedded)
    assert again.pictures == 256 and file.read_bytes() == whole


@pytest.mark.parametrize("home", ["a file", "nowhere"])
def test_a_cache_that_cannot_be_written_is_one_line_and_no_error(
    weights, tmp_path, monkeypatch, caplog, home
):
    if home == "a file":
        (tmp_path / "cache").write_text("")
    else:
        monkeypatch.setenv("XDG_CACHE_HOME", "/proc/nowhere")
    monkeypatch.chdir(tmp_path)
    encoder = Counting(weights)
    assert Background.embedded_by(encoder).pictures.shape == (256, 16)
    [line] = caplog.messages
    assert line.startswith("the bank of pictures is not kept") and "XDG_CACHE_HOME" in line
    assert "\n" not in line and not (tmp_path / "~").exists()


def test_a_run_that_is_killed_while_it_writes_leaves_no_half_bank(weights, monkeypatch):
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(kept_bank, "write_whole", raising(KeyboardInterrupt()))
        Background.embedded_by(Counting(weights))
    assert not bank_file(Counting(weights)).exists()


def test_a_run_embeds_the_bank_beforehand_and_says_how_far_it_is(weights, capsys):
    encoder = Counting(weights)
    parts = parts_with_bank(encoder)
    assert encoder.pictures == 256
    assert parts.background().pictures.shape == (256, 16)
    out, err = capsys.readouterr()
    assert out == "" and "embeds 256 pictures" in err and "256 of 256 pictures after" in err
    assert parts_with_bank(Counting(weights)) is not None
    assert capsys.readouterr() == ("", "")


def test_a_question_about_a_map_without_a_bank_says_how_far_it_is(weights, capsys):
    encoder = Counting(weights)
    bundle = bundle_of(1)
    wide = np.tile(bundle.elements.embeddings, 4)  # 16 numbers, as those of the encoder
    elements = replace(bundle.elements, embeddings=wide)
    bundle = replace(bundle, elements=elements, statistics=None, pictures=NO_PICTURES)
    map_bundle.with_background(bundle, encoder, BankProgress("ViT-L/14"))
    assert encoder.pictures == 256
    assert "ViT-L/14 embeds 256 pictures" in capsys.readouterr().err


def test_an_encoder_without_a_name_of_its_weights_embeds_with_the_first_frame(mean_colours):
    assert parts_with_bank(mean_colours) is None


def test_progress_is_said_every_five_seconds_with_the_time_that_is_left(capsys):
    now = [100.0]
    progress = BankProgress("ViT-L/14", lambda: now[0])
    for done in range(0, 257, 8):
        progress(done, 256)
        now[0] += 2.0
    first, *lines = capsys.readouterr().err.splitlines()
    assert "ViT-L/14 embeds 256 pictures" in first
    assert lines[0] == "24 of 256 pictures after 6 s, about 58 s left"
    assert len(lines) == 11 and lines[-1] == "256 of 256 pictures after 64 s"
