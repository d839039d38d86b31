"""Where a CLIP checkpoint is, and its configuration, checked before anything of its size is loaded.

Nothing here needs PyTorch, so that a model which is not on this machine is refused at once.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from vizbot.core.errors import ConfigError
from vizbot.core.files import parse_json, read_regular
from vizbot.core.settings import explained

SHORT_NAMES = {
    "ViT-B/32": "openai/clip-vit-base-patch32",
    "ViT-L/14": "openai/clip-vit-large-patch14",
}
"""The paper's names of the models, and their repositories on the Hugging Face hub."""
SAFETENSORS = ("model.safetensors", "model.safetensors.index.json")
"""Weights that are tensors and nothing else: in one file, or the list of several."""
PICKLES = ("pytorch_model.bin", "pytorch_model.bin.index.json")
"""Weights in a pickle, likewise."""
_EXAMPLE = SHORT_NAMES["ViT-B/32"]
_CLIP_ALONE = 'give a CLIP model, whose config.json has "model_type": "clip"'
_TOKENIZERS = (("tokenizer.json",), ("vocab.json", "merges.txt"))
"""Files of which a tokenizer is made, in either way."""
_IMAGE_SETTINGS = ("preprocessor_config.json", "processor_config.json")
"""Where the image settings are; transformers 5 writes the second, for images among others."""
_LARGEST_JSON = 16 * 1024 * 1024
"""Size of a JSON file that is read [bytes]."""

_Width = Annotated[int, Field(gt=0, le=16_384, strict=True)]
_Layers = Annotated[int, Field(gt=0, le=128, strict=True)]


class _Tower(BaseModel):
    """What decides how large a tower is; absent values are the library's own."""

    model_config = ConfigDict(extra="ignore")

    hidden_size: _Width | None = None
    intermediate_size: Annotated[int, Field(gt=0, le=65_536, strict=True)] | None = None
    num_hidden_layers: _Layers | None = None
    num_attention_heads: _Layers | None = None
    projection_dim: _Width | None = None
    vocab_size: Annotated[int, Field(gt=0, le=1_000_000, strict=True)] | None = None
    max_position_embeddings: _Width | None = None
    num_channels: Annotated[int, Field(ge=3, le=3, strict=True)] | None = None
    image_size: Annotated[int, Field(gt=0, le=2048, strict=True)] | None = None
    patch_size: Annotated[int, Field(gt=0, le=2048, strict=True)] | None = None


class _Checkpoint(BaseModel):
    model_config = ConfigDict(extra="ignore")

    projection_dim: _Width | None = None
    text_config: _Tower = _Tower()
    vision_config: _Tower = _Tower()


class ImageSettings(BaseModel):
    """Mean and standard deviation of each colour over the training pictures, 0 to 1."""

    model_config = ConfigDict(extra="ignore")

    image_mean: tuple[FiniteFloat, FiniteFloat, FiniteFloat]
    image_std: tuple[
        Annotated[FiniteFloat, Field(gt=0.0)],
        Annotated[FiniteFloat, Field(gt=0.0)],
        Annotated[FiniteFloat, Field(gt=0.0)],
    ]


def require_plausible(config: Any) -> None:
    """Refuse sizes in a `config.json` that no CLIP has, 16 times those of the largest one.

    Raises:
        ValueError: a size is none, or too large.
    """
    _Checkpoint.model_validate(config)


@dataclass(frozen=True, slots=True)
class ClipCheckpoint:
    """A CLIP model on this machine.

    Attributes:
        source: Name on the Hugging Face hub, or absolute path of a folder.
        weights: The file of its weights, or the list of several, in the folder of them.
        tokenizer: The folder of its tokenizer.
        config: The content of its `config.json`.
        image_settings: How its pictures are normalised.
        remark: What is to be said of the weights before they are loaded; None for nothing.
        remedy: What to do where it turns out to be unusable.
    """

    source: str
    weights: Path
    tokenizer: Path
    config: dict[str, Any]
    image_settings: ImageSettings
    remark: str | None
    remedy: str

    def refused(self, fault: str) -> ConfigError:
        """The error to raise where the weights cannot be used, because of this."""
        return _refused(self.source, fault, self.remedy)


def find_checkpoint(name: str) -> ClipCheckpoint:
    """The CLIP model of a short name (`ViT-B/32`, `ViT-L/14`), a hub name, or a folder.

    Where a model of the hub was fetched in several revisions, one with safetensors comes before one
    with a pickle, then the main one before the others. Files that a revision lacks are taken from
    another: who converts a model adds the weights alone.

    Raises:
        ConfigError: there is no such model on this machine, it is not CLIP, or a file of it is
            missing or says what no CLIP has.
    """
    source, snapshots, remedy = _sought(name)
    found = weights_first(snapshots, (*SAFETENSORS, *PICKLES))
    # What a revision has of its own counts before what others have.
    around = snapshots if found is None else [found[0], *snapshots]
    config = _config(source, around, remedy)
    if found is None:
        fault = f"has no weights: neither {SAFETENSORS[0]} nor {PICKLES[0]} is there"
        raise _refused(source, fault, remedy)
    chosen, weights = found
    tokenizer = next(
        (
            each.folder
            for each in around
            for files in _TOKENIZERS
            if all((each.folder / file).is_file() for file in files)
        ),
        None,
    )
    if tokenizer is None:
        fault = "has no tokenizer: neither tokenizer.json nor vocab.json and merges.txt are there"
        raise _refused(source, fault, remedy)
    return ClipCheckpoint(
        source,
        chosen.folder / weights,
        tokenizer,
        config,
        _image_settings(source, around, remedy),
        _remark(source, chosen, weights),
        remedy,
    )


def _sought(name: str) -> tuple[str, list[Snapshot], str]:
    """The source of a model, the folders that may have its files, and the remedy."""
    folder = Path(name).expanduser()
    if name and folder.is_dir():
        folder = folder.resolve()
        remedy = f"give a folder as filled by: hf download {_EXAMPLE} --local-dir FOLDER"
        whole = [Snapshot(folder, "")]
        return str(folder), snapshots_in(folder) or whole, remedy
    source = SHORT_NAMES.get(name, name)
    if not re.fullmatch(r"[\w.-]+/[\w.-]+", source):
        raise ConfigError(
            f"no CLIP model {name!r}: give {' or '.join(SHORT_NAMES)}, a hub name like"
            f" {_EXAMPLE}, or an existing folder"
        )
    snapshots = snapshots_of(source)
    again = " --force-download" if snapshots else ""  # without it a damaged file stays as it is
    fetched = f"fetch it with: hf download{again} {source}"
    known = source in SHORT_NAMES.values()
    remedy = fetched if known else f"{_CLIP_ALONE}; if it is one, {fetched}"
    return source, snapshots, remedy


def _config(source: str, snapshots: list[Snapshot], remedy: str) -> dict[str, Any]:
    found = weights_first(snapshots, ["config.json"])
    if found is None:
        raise ConfigError(f"no CLIP weights for {source} on this machine; {remedy}")
    config = _json(source, found[0].folder / found[1], remedy)
    kind = config.get("model_type")
    if kind != "clip":
        raise ConfigError(
            f"{source} holds a {kind} model, which cannot be used; {_CLIP_ALONE}, such as"
            f" {' or '.join(SHORT_NAMES)}"
        )
    try:
        require_plausible(config)
    except ValidationError as error:
        fault = f"has a config.json of no CLIP: {explained(error, _Checkpoint)}"
        raise _refused(source, fault, remedy) from error
    return config


def _image_settings(source: str, snapshots: list[Snapshot], remedy: str) -> ImageSettings:
    found = weights_first(snapshots, _IMAGE_SETTINGS)
    if found is None:
        fault = f"has no image settings: neither {' nor '.join(_IMAGE_SETTINGS)} is there"
        raise _refused(source, fault, remedy)
    content = _json(source, found[0].folder / found[1], remedy)
    try:
        return ImageSettings.model_validate(content.get("image_processor", content))
    except ValidationError as error:
        fault = f"has image settings of no CLIP in {found[1]}: {explained(error, ImageSettings)}"
        raise _refused(source, fault, remedy) from error


def _remark(source: str, chosen: Snapshot, weights: str) -> str | None:
    """What is said of weights that are not the safetensors of a folder or the main revision."""
    plain = weights in SAFETENSORS
    of = f"{source}, revision {chosen.revision}" if chosen.revision else source
    if plain:
        return None if chosen.is_main or not chosen.revision else f"{of}: its weights are used"
    return f"{of}: {weights} is a pickle, of which tensors alone are read; no safetensors are here"


def _json(source: str, path: Path, remedy: str) -> dict[str, Any]:
    try:
        content = parse_json(read_regular(path, _LARGEST_JSON))
    except OSError as error:
        fault = f"has a {path.name} that cannot be read: {error.strerror}"
        raise _refused(source, fault, remedy) from error
    except ValueError as error:
        raise _refused(source, f"has a {path.name} that is not JSON", remedy) from error
    if not isinstance(content, dict):
        raise _refused(source, f"has a {path.name} that is no table", remedy)
    return content


def _refused(source: str, fault: str, remedy: str) -> ConfigError:
    return ConfigError(f"the CLIP model {source} {fault}; {remedy}")


_MAIN = "main"
_LONGEST_HASH = 200
"""A file of a reference with more letters is none."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A revision of a model that was fetched, perhaps in part.

    Attributes:
        revision: The name of what was asked for (`main`, `refs/pr/15`), else the commit.
    """

    folder: Path
    revision: str

    @property
    def is_main(self) -> bool:
        """Whether it is what is fetched unless a revision is named."""
        return self.revision == _MAIN


def snapshots_of(source: str) -> list[Snapshot]:
    """Revisions of a model by its hub name: the main one, those with a name, then the newest."""
    from huggingface_hub import constants
    from huggingface_hub.file_download import repo_folder_name

    folder = repo_folder_name(repo_id=source, repo_type="model")
    return snapshots_in(Path(constants.HF_HUB_CACHE) / folder)


def snapshots_in(folder: Path) -> list[Snapshot]:
    """The same of a folder of the cache, `models--OWNER--NAME`; none where it is no such folder."""
    names: dict[str, str] = {}
    for path in sorted((folder / "refs").rglob("*")):
        if path.is_file() and path.stat().st_size < _LONGEST_HASH:
            name, commit = path.relative_to(folder / "refs").as_posix(), path.read_bytes().strip()
            if names.get(known := commit.decode(errors="replace")) != _MAIN:
                names[known] = name
    found = [each for each in (folder / "snapshots").glob("*") if each.is_dir()]
    found.sort(key=lambda each: -each.stat().st_mtime)
    named = [Snapshot(each, names.get(each.name, each.name)) for each in found]
    return sorted(named, key=lambda each: (not each.is_main, each.folder.name not in names))


def weights_first(
    snapshots: Sequence[Snapshot], names: Sequence[str]
) -> tuple[Snapshot, str] | None:
    """The first snapshot with the earliest of these files, and the file; None where none has one.

    Better `snapshots` and `names` come first; a better file counts more than a better snapshot.
    """
    return next(
        ((each, name) for name in names for each in snapshots if (each.folder / name).is_file()),
        None,
    )
