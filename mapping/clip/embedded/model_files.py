"""The files of the embedded CLIP: its weights, its tokenizer, and how it is used."""

from __future__ import annotations

import json
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from tokenizers import Tokenizer

from vizbot.core.errors import ConfigError

WEIGHTS = Path(__file__).with_name("weights")
"""Folder with `model.safetensors` (16-bit), `tokenizer.json` and `config.json`."""


@dataclass(frozen=True, slots=True, eq=False)
class EmbeddedFiles:
    """The files of the embedded model.

    Attributes:
        model_id: Names the weights.
        weights: Content of `model.safetensors`.
        tokenizer: Splits texts into the text tower's tokens.
        threshold: Similarity above which an image shows what a text says.
        words: Words of the phrasings that it was trained on.
    """

    folder: Path
    model_id: str
    weights: bytes
    tokenizer: Tokenizer
    threshold: float
    words: frozenset[str] = frozenset()


def read_files(folder: Path = WEIGHTS) -> EmbeddedFiles:
    """The files of the embedded model.

    Raises:
        ConfigError: they are missing or damaged.
    """
    try:
        weights = (folder / "model.safetensors").read_bytes()
        tokenizer = Tokenizer.from_file(str(folder / "tokenizer.json"))
        config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
        threshold, words = float(config["threshold"]), frozenset(config.get("words", ()))
    except Exception as error:  # the libraries raise whatever a damaged file leads them into
        raise damaged_files(folder) from error
    model_id = f"embedded-{sha256(weights).hexdigest()[:8]}"
    return EmbeddedFiles(folder, model_id, weights, tokenizer, threshold, words)


def damaged_files(folder: Path) -> ConfigError:
    """The error for files that are missing or damaged."""
    return ConfigError(f"the embedded CLIP in {folder} is missing or damaged: install vizbot again")
