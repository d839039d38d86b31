"""The files of an embedded CLIP that ship with vizbot."""

from __future__ import annotations

import json
from pathlib import Path

from safetensors.torch import save as tensors_to_bytes
from tokenizers import Tokenizer

from mapping.clip.embedded.towers import Clip
from training.spoken_texts import trained_words
from vizbot.core.files import write_whole


def export_model(model: Clip, tokenizer: Tokenizer, threshold: float, folder: Path) -> None:
    """Write weights in 16 bits, tokenizer, threshold and the words of the trained phrasings."""
    folder.mkdir(parents=True, exist_ok=True)
    tensors = {name: tensor.half().contiguous() for name, tensor in model.state_dict().items()}
    config = {"threshold": threshold, "words": sorted(trained_words())}
    write_whole(folder / "model.safetensors", tensors_to_bytes(tensors))
    write_whole(folder / "tokenizer.json", tokenizer.to_str().encode())
    write_whole(folder / "config.json", json.dumps(config).encode())
