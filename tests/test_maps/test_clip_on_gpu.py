"""CLIP on an NVIDIA GPU; all of it is skipped where there is none."""

import numpy as np
import pytest
import torch
from transformers import CLIPConfig

from mapping.clip.encoder import ImageInput, TransformersClip, gpu_name, load_clip
from tests.helpers.random_clip import letters_tokenizer, random_clip, save_tiny_clip
from tests.test_maps.test_clip_encoder import PUBLISHED, pictures

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="needs an NVIDIA GPU")
TEXTS = ["yellow chair", "a fan"]


@pytest.fixture
def little_memory():
    """Leaves this process 600 MB of the GPU."""
    torch.cuda.empty_cache()
    total = torch.cuda.get_device_properties(0).total_memory
    torch.cuda.set_per_process_memory_fraction(600e6 / total)
    yield
    torch.cuda.set_per_process_memory_fraction(1.0)
    torch.cuda.empty_cache()


def on_gpu(model_id, half=False):
    """A published architecture with random weights, on the processor and on the GPU."""
    torch.manual_seed(1)
    model = random_clip(CLIPConfig(**PUBLISHED[model_id][0]))
    tokenizer, image_input = letters_tokenizer(), ImageInput()
    processor = TransformersClip(model_id, model, tokenizer, image_input)
    images = pictures((112, 112), (448, 448), (224, 224))
    expected = processor.embed_images(images), processor.embed_texts(TEXTS)
    model = model.to("cuda", torch.float16 if half else torch.float32)
    return TransformersClip(model_id, model, tokenizer, image_input), images, expected


def least_cosine(found, expected):
    return (found * expected).sum(axis=1).min()


@pytest.mark.parametrize(("half", "tolerance"), [(False, 2e-3), (True, 5e-3)])
def test_a_checkpoint_embeds_on_the_gpu_as_on_the_processor(tmp_path, half, tolerance):
    save_tiny_clip(tmp_path)
    processor, gpu = load_clip(str(tmp_path), "cpu"), load_clip(str(tmp_path), "auto", half)
    assert gpu._model.device.type == "cuda"
    assert gpu_name()
    images = pictures((112, 112), (64, 64), (90, 131))
    found = gpu.embed_images(images)
    np.testing.assert_allclose(found, processor.embed_images(images), atol=tolerance)
    np.testing.assert_allclose(gpu.embed_texts(TEXTS), processor.embed_texts(TEXTS), atol=tolerance)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, atol=1e-5)


@pytest.mark.long
@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("model_id", PUBLISHED)
def test_a_published_architecture_embeds_on_the_gpu_as_on_the_processor(model_id, half):
    gpu, images, (expected_images, expected_texts) = on_gpu(model_id, half)
    least = 0.999 if half else 0.9999
    assert least_cosine(gpu.embed_images(images), expected_images) > least
    assert least_cosine(gpu.embed_texts(TEXTS), expected_texts) > least


def test_a_batch_beyond_the_gpus_memory_is_embedded_in_parts(little_memory):
    gpu, images, (expected, _) = on_gpu("openai/clip-vit-base-patch32", half=True)
    sizes, embed = [], gpu._embedded
    gpu._embedded = lambda batch: sizes.append(len(batch)) or embed(batch)
    found = gpu.embed_images(images * 400)
    assert sizes[0] == 1200
    assert len(sizes) > 2
    assert least_cosine(found, np.tile(expected, (400, 1))) > 0.999
