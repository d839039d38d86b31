"""The text stage: teaches the text tower how people speak, after both towers were trained.

`python -m training.text_stage FIRST FOLDER` does this stage alone, from weights of
the first stage.

The image tower stays as it is. The text tower of the first stage is the teacher (Hinton et al.
2015, "Distilling the knowledge in a neural network"): the captions that it knows keep its
embeddings, and each phrasing learns the embedding of the plain phrase.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from copy import deepcopy
from math import cos, pi
from pathlib import Path
from typing import Annotated

import numpy as np
import torch
import typer
from pydantic import BaseModel, Field
from rich.console import Console
from safetensors.torch import save as tensors_to_bytes
from tokenizers import Tokenizer
from torch.nn.attention import SDPBackend, sdpa_kernel

from mapping.clip.embedded.encoder import load_embedded_clip, to_ids
from mapping.clip.embedded.towers import Clip, TextTower
from training.spoken_texts import TextPair, draw_kept, draw_spoken, draw_unrelated, trained_words
from vizbot.core.files import write_whole
from vizbot.core.settings import SETTINGS

SHORT = 8
"""Tokens; most texts of a step have no more."""


def export_model(model: Clip, tokenizer: Tokenizer, threshold: float, folder: Path) -> None:
    """Write weights in 16 bits, tokenizer, threshold and the words of the trained phrasings."""
    folder.mkdir(parents=True, exist_ok=True)
    tensors = {name: tensor.half().contiguous() for name, tensor in model.state_dict().items()}
    config = {"threshold": threshold, "words": sorted(trained_words())}
    write_whole(folder / "model.safetensors", tensors_to_bytes(tensors))
    write_whole(folder / "tokenizer.json", tokenizer.to_str().encode())
    write_whole(folder / "config.json", json.dumps(config).encode())


class TextStageConfig(BaseModel):
    """Settings of the text stage."""

    model_config = SETTINGS

    steps: int = Field(default=1200, gt=0)
    """Number of steps of the optimiser."""
    patches: int = Field(default=64, gt=0)
    """Imagined patches in a step, whose captions keep their embeddings."""
    spoken: int = Field(default=200, gt=0)
    """Spoken phrasings of things and rooms in a step."""
    unrelated: int = Field(default=96, gt=0)
    """Spoken phrasings of unrelated words in a step."""
    kept_weight: float = Field(default=3.0, gt=0.0)
    """Weight of a text that keeps its embedding; that of a new phrasing is 1."""
    learning_rate: float = Field(default=8e-4, gt=0.0)
    """Highest learning rate; it falls as a cosine to 0."""
    warmup: int = Field(default=60, gt=0)
    """Steps until the learning rate is reached."""
    seed: int = 0
    """Seed of all draws."""


def part_of_rate(step: int, warmup: int, steps: int) -> float:
    """Part of the highest learning rate at a step: a linear warm-up, then half a cosine to 0."""
    if step < warmup:
        return (step + 1) / warmup
    return 0.5 * (1.0 + cos(pi * (step - warmup) / max(1, steps - warmup)))


def train_text_tower(
    teacher: TextTower, tokenizer: Tokenizer, config: TextStageConfig
) -> TextTower:
    """The text tower that knows spoken phrasings, too."""
    device = next(teacher.parameters()).device
    student = deepcopy(teacher).train()
    optimiser = torch.optim.AdamW(student.parameters(), lr=config.learning_rate, weight_decay=0.0)
    half = device.type == "cuda" or bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())
    log, began, losses = Console(stderr=True), time.monotonic(), []
    for step in range(config.steps):
        rng = np.random.default_rng((config.seed, 17, step))
        rate = part_of_rate(step, config.warmup, config.steps) * config.learning_rate
        for group in optimiser.param_groups:
            group["lr"] = rate
        kept = draw_kept(rng, config.patches)
        new = draw_spoken(rng, config.spoken) + draw_unrelated(rng, config.unrelated)
        weight = torch.ones(len(kept) + len(new), device=device)
        weight[: len(kept)] = config.kept_weight
        ids, wanted = _batch(teacher, tokenizer, kept + new)
        with (
            torch.autocast(device.type, torch.bfloat16, enabled=half),
            sdpa_kernel(SDPBackend.MATH),
        ):
            embeddings = embedded(student, ids).float()
        distance = 1.0 - (embeddings * wanted).sum(dim=1)
        loss = (weight * distance).sum() / weight.sum()
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(student.parameters(), 1.0)
        optimiser.step()
        parts = distance.detach()[: len(kept)], distance.detach()[len(kept) :]
        losses.append([float(part.mean()) for part in parts])
        if (step + 1) % 50 == 0:
            left = (time.monotonic() - began) / (step + 1) * (config.steps - step - 1) / 60
            old, other = np.mean(losses[-50:], axis=0)
            log.print(f"text step {step + 1}: kept {old:.4f}, new {other:.4f}, {left:.0f} min left")
    return student.eval()


def train_text_stage(
    first: Annotated[Path, typer.Argument(help="Folder with the weights of the first stage.")],
    folder: Annotated[Path, typer.Argument(help="Where the weights are written.")],
) -> None:
    """Train the text tower of an embedded CLIP anew; image tower and threshold stay."""
    encoder = load_embedded_clip(first)
    model, tokenizer = encoder.model, encoder.tokenizer
    model.text_tower = train_text_tower(model.text_tower, tokenizer, TextStageConfig())
    export_model(model, tokenizer, encoder.threshold, folder)


@torch.no_grad()
def _batch(
    teacher: TextTower, tokenizer: Tokenizer, pairs: Sequence[TextPair]
) -> tuple[torch.Tensor, torch.Tensor]:
    """Token ids (N, L) of the texts, and the embeddings (N, 256) that they shall have."""
    device = next(teacher.parameters()).device
    models = list(dict.fromkeys(pair.model for pair in pairs))
    row_of = {model: i for i, model in enumerate(models)}
    wanted = embedded(teacher, to_ids(tokenizer, models).to(device))
    ids = to_ids(tokenizer, [pair.text for pair in pairs]).to(device)
    return ids, wanted[[row_of[pair.model] for pair in pairs]]


def embedded(tower: TextTower, ids: torch.Tensor) -> torch.Tensor:
    """Embeddings (N, 256) of token ids (N, L); short texts are not filled up to the longest."""
    short = (ids[:, SHORT:] == 0).all(dim=1)
    groups = [(rows, some) for rows, some in ((short, ids[:, :SHORT]), (~short, ids)) if rows.any()]
    order = torch.cat([rows.nonzero()[:, 0] for rows, _ in groups])
    return torch.cat([tower(some[rows]) for rows, some in groups])[order.argsort()]


if __name__ == "__main__":
    torch.set_flush_denormal(True)  # tiny numbers in the optimiser are ten times as slow
    typer.run(train_text_stage)
