import socket

import numpy as np
import pytest
import torch
from transformers import CLIPConfig, CLIPModel
from transformers.models.clip.image_processing_pil_clip import CLIPImageProcessorPil

from mapping.clip.encoder import ImageInput, TransformersClip, load_clip, to_pixel_values
from tests.helpers.failing import raising
from tests.helpers.random_clip import letters_tokenizer, random_clip, save_tiny_clip
from vizbot.core.errors import ConfigError, DeviceError

LARGE = "openai/clip-vit-large-patch14"
PUBLISHED = {
    "openai/clip-vit-base-patch32": (
        {"projection_dim": 512, "text_config": {}, "vision_config": {}},
        151_277_313,
        0.30,
    ),
    LARGE: (
        {
            "projection_dim": 768,
            "text_config": {
                "hidden_size": 768,
                "intermediate_size": 3072,
                "num_attention_heads": 12,
                "projection_dim": 768,
            },
            "vision_config": {
                "hidden_size": 1024,
                "intermediate_size": 4096,
                "num_hidden_layers": 24,
                "num_attention_heads": 16,
                "patch_size": 14,
                "projection_dim": 768,
            },
        },
        427_616_513,
        0.27,
    ),
}


def pictures(*shapes):
    """Smooth gradients with sharp noise in one corner."""
    rng = np.random.default_rng(7)
    images = []
    for height, width in shapes:
        ramp = np.linspace(0, 255, height)[:, None, None] * np.linspace(0, 1, width)[None, :, None]
        image = np.broadcast_to(ramp, (height, width, 3)).astype(np.uint8).copy()
        noise = rng.integers(0, 256, (height // 2, width // 3, 3), np.uint8)
        image[: height // 2, : width // 3] = noise
        images.append(image)
    return images


def unit(features):
    return torch.nn.functional.normalize(features, dim=-1).numpy()


@pytest.fixture
def encoder(tmp_path):
    save_tiny_clip(tmp_path)
    return load_clip(str(tmp_path), "cpu")


@pytest.fixture
def no_network(monkeypatch):
    refuse = raising(AssertionError("the network was asked"))
    monkeypatch.setattr(socket, "getaddrinfo", refuse)
    monkeypatch.setattr(socket.socket, "connect", refuse)


@pytest.mark.parametrize(
    "model_id",
    ["openai/clip-vit-base-patch32", pytest.param(LARGE, marks=pytest.mark.long)],
)
def test_the_published_architectures_embed_as_the_library_does(model_id):
    settings, parameters, threshold = PUBLISHED[model_id]
    torch.manual_seed(1)
    model = random_clip(CLIPConfig(**settings))
    assert sum(p.numel() for p in model.parameters()) == parameters
    tokenizer, processor = letters_tokenizer(), CLIPImageProcessorPil()
    encoder = TransformersClip(model_id, model, tokenizer, ImageInput())

    images, texts = pictures((112, 112), (448, 448)), ["yellow chair", "a fan"]
    with torch.inference_mode():
        pixels = processor(images, return_tensors="pt")["pixel_values"]
        expected_images = unit(model.get_image_features(pixels).pooler_output)
        tokens = tokenizer(texts, padding=True, return_tensors="pt")
        expected_texts = unit(model.get_text_features(**tokens).pooler_output)

    assert (encoder.model_id, encoder.dimension) == (model_id, settings["projection_dim"])
    assert encoder.threshold == threshold
    scale, bias = encoder.log_odds
    assert scale == pytest.approx(float(model.logit_scale.detach().exp()), rel=1e-6)
    assert scale * threshold + bias == pytest.approx(0.0, abs=1e-6)
    assert encoder.notice is None
    np.testing.assert_allclose(encoder.embed_images(images), expected_images, atol=2e-4)
    np.testing.assert_allclose(encoder.embed_texts(texts), expected_texts, atol=1e-5)
    assert np.abs(expected_images[0] - expected_images[1]).max() > 2e-3
    assert np.abs(expected_texts[0] - expected_texts[1]).max() > 1e-3


@pytest.mark.parametrize(
    ("shapes", "levels"),
    [([(448, 448), (112, 112), (224, 224), (448, 448)], 1), ([(120, 301), (333, 250)], 2)],
)
def test_pixels_are_within_a_grey_level_or_two_of_the_librarys(shapes, levels):
    images, wanted = pictures(*shapes), ImageInput()
    expected = CLIPImageProcessorPil()(images, return_tensors="pt")["pixel_values"]
    pixels = to_pixel_values(images, wanted)
    assert pixels.shape == expected.shape == (len(images), 3, 224, 224)
    error = (pixels - expected).abs() * 255.0 * torch.tensor(wanted.std).view(3, 1, 1)
    assert error.max() <= levels + 0.01
    assert (error > 0.01).float().mean() < 0.01


def test_a_checkpoint_in_a_folder_answers_as_the_library_without_a_word(
    tmp_path, capfd, no_network
):
    processor = save_tiny_clip(tmp_path)
    capfd.readouterr()
    encoder = load_clip(str(tmp_path), "cpu")
    images = pictures((112, 112), (64, 64), (90, 131))
    embeddings = encoder.embed_images(images)
    spoken = capfd.readouterr()
    assert (spoken.out, spoken.err) == ("", "")

    model = CLIPModel.from_pretrained(tmp_path).eval()
    with torch.inference_mode():
        pixels = processor(images, return_tensors="pt")["pixel_values"]
        expected = unit(model.get_image_features(pixels).pooler_output)
    np.testing.assert_allclose(embeddings, expected, atol=2e-3)
    assert embeddings.dtype == np.float32
    assert encoder.model_id == str(tmp_path)  # a map of it can be asked by that name
    assert encoder.embed_images([]).shape == encoder.embed_texts([]).shape == (0, 16)


def test_half_precision_gives_nearly_the_same_unit_embeddings(tmp_path):
    save_tiny_clip(tmp_path)
    full, half = load_clip(str(tmp_path), "cpu"), load_clip(str(tmp_path), "cpu", half=True)
    images = pictures((112, 112), (64, 64))
    np.testing.assert_allclose(half.embed_images(images), full.embed_images(images), atol=5e-3)
    np.testing.assert_allclose(np.linalg.norm(half.embed_texts(["a fan"]), axis=1), 1.0, atol=1e-5)


def test_a_text_longer_than_the_model_reads_is_cut(encoder):
    long, longer = encoder.embed_texts(["chair " * 40, "chair " * 200])
    np.testing.assert_allclose(long, longer, atol=1e-6)


def test_weights_that_are_not_at_hand_name_the_command_and_ask_no_network(no_network):
    with pytest.raises(ConfigError) as error:
        load_clip("nobody/no-such-clip")
    assert "hf download nobody/no-such-clip" in str(error.value)
    assert "\n" not in str(error.value)


def test_short_names_stand_for_the_published_weights(monkeypatch, tmp_path, no_network):
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_CACHE", str(tmp_path))
    with pytest.raises(ConfigError, match="hf download openai/clip-vit-large-patch14"):
        load_clip("ViT-L/14")


@pytest.mark.parametrize(
    ("config", "said"), [(None, "no CLIP weights"), ('{"model_type": "bert"}', "bert"), ("{", "no")]
)
def test_a_folder_without_a_clip_checkpoint_is_refused_in_one_line(tmp_path, config, said):
    if config is not None:
        (tmp_path / "config.json").write_text(config)
    with pytest.raises(ConfigError, match=said) as error:
        load_clip(str(tmp_path))
    assert str(tmp_path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["", "yellow", "/no/such/folder", "a/b/c"])
def test_a_name_that_can_be_no_model_is_refused(name):
    with pytest.raises(ConfigError, match="ViT-B/32"):
        load_clip(name)


def test_a_device_that_is_not_there_is_refused(tmp_path):
    save_tiny_clip(tmp_path)
    with pytest.raises(ConfigError, match="cuda:63"):
        load_clip(str(tmp_path), "cuda:63")
    with pytest.raises(ConfigError, match="potato"):
        load_clip(str(tmp_path), "potato")


def test_a_batch_too_large_for_the_device_is_halved(encoder, monkeypatch):
    images = pictures(*[(40, 60)] * 5)
    whole = encoder.embed_images(images)
    sizes, embed = [], encoder._embedded

    def at_most_two(images):
        sizes.append(len(images))
        if len(images) > 2:
            raise torch.OutOfMemoryError("CUDA out of memory")
        return embed(images)

    monkeypatch.setattr(encoder, "_embedded", at_most_two)
    np.testing.assert_allclose(encoder.embed_images(images), whole, atol=1e-5)
    assert sizes == [5, 2, 3, 1, 2]


def test_a_device_without_memory_for_one_image_is_an_error_with_its_remedy(encoder, monkeypatch):
    monkeypatch.setattr(encoder, "_embedded", raising(torch.OutOfMemoryError("CUDA out of memory")))
    with pytest.raises(DeviceError, match="no memory left for one image; end other programs"):
        encoder.embed_images(pictures((40, 60), (40, 60)))
