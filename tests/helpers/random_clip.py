"""CLIP models of the real architecture with random weights, one small enough for most tests."""

import torch
from transformers import CLIPConfig, CLIPModel, CLIPTokenizer
from transformers.models.clip.image_processing_pil_clip import CLIPImageProcessorPil


def letters_tokenizer(start=49406, end=49407):
    letters = [chr(ord("a") + i) for i in range(26)]
    vocabulary = {token: i for i, token in enumerate([*letters, *(f"{x}</w>" for x in letters)])}
    vocabulary |= {"<|startoftext|>": start, "<|endoftext|>": end}
    return CLIPTokenizer(vocab=vocabulary, merges=[], model_max_length=77)


def save_tiny_clip(folder):
    torch.manual_seed(3)
    tower = {
        "hidden_size": 32,
        "intermediate_size": 64,
        "num_hidden_layers": 2,
        "num_attention_heads": 2,
        "projection_dim": 16,
    }
    text = tower | {"vocab_size": 64, "bos_token_id": 52, "eos_token_id": 53, "pad_token_id": 53}
    vision = tower | {"image_size": 64, "patch_size": 16}
    config = CLIPConfig(text_config=text, vision_config=vision, projection_dim=16)
    CLIPModel(config).save_pretrained(folder)
    letters_tokenizer(52, 53).save_pretrained(folder)
    size = {"shortest_edge": 64}
    processor = CLIPImageProcessorPil(size=size, crop_size={"height": 64, "width": 64})
    processor.save_pretrained(folder)
    return processor


def random_clip(config):
    """A CLIP of random weights, in a fraction of the time that the library's own start takes."""
    with torch.device("meta"):
        model = CLIPModel(config)
    model.to_empty(device="cpu")
    with torch.no_grad():
        for name, parameter in model.named_parameters():
            if parameter.ndim > 1:
                parameter.normal_(std=0.02)
            else:
                parameter.fill_(1.0 if name.endswith("weight") else 0.0)
        for positions in model.buffers():
            positions.copy_(torch.arange(positions.numel()))
    return model.eval()
