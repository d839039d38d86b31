"""The wide stage: teaches the image tower homes that nobody here drew, after both other stages.

`python -m training.wide_stage FOLDER --jar sweethome3d.jar --number N` goes on from the weights
that come along. The text tower stays as it is, so that all phrasings stay learned. Some of the
pictures are of our own homes, so that those stay learned, too, and the weights that are written lie
between those before and those after the training.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import torch
import typer
from pydantic import BaseModel, Field

from mapping.clip.embedded.encoder import load_embedded_clip
from mapping.clip.embedded.model_files import WEIGHTS
from mapping.clip.embedded.towers import Clip
from training.homes import Mixture, TrainingHome
from training.lessons import read_lessons
from training.training import PatchPool, StepsConfig, finish, train
from training.views import ViewsConfig, take_all
from vizbot.core.settings import SETTINGS

OURS_END = 400
"""Our rooms are those of training homes below this number."""
MOST = 4
"""Number of the last stage; a later one would see the same homes again."""


class WideStageConfig(BaseModel):
    """Settings of the wide stage."""

    model_config = SETTINGS

    ours: int = Field(default=60, ge=0)
    """Homes of ours, half of them varied."""
    their_furniture: int = Field(default=40, ge=0)
    """Homes of ours with furniture of others."""
    their_rooms: int = Field(default=40, ge=0)
    """Homes of others with our furniture."""
    theirs: int = Field(default=20, ge=0)
    """Homes of others."""
    makers: int = Field(default=40, ge=0)
    """Homes with models of several makers, where these are given."""
    views: ViewsConfig = ViewsConfig(pictures=50, near=0.4)
    """Pictures of each home."""
    frozen: int = Field(default=2, ge=0)
    """Blocks of the image tower behind its stem that stay as they are."""
    steps: StepsConfig = StepsConfig(steps=1600, learning_rate=6e-4)
    """Steps of the optimiser."""
    share: float = Field(default=0.5, ge=0.0, le=1.0)
    """Where the weights lie that are written, between those before (0) and after (1)."""


def homes_of(
    config: WideStageConfig, number: int, jar: Path, models: Path | None = None
) -> list[TrainingHome]:
    """The homes of a stage; each stage has others, but for the rooms of others themselves."""
    counts = {
        Mixture.OURS: config.ours - config.ours // 2,
        Mixture.VARIED: config.ours // 2,
        Mixture.THEIR_FURNITURE: config.their_furniture,
        Mixture.THEIR_ROOMS: config.their_rooms,
        Mixture.THEIRS: config.theirs,
    }
    homes, first = [], number * sum(counts.values())
    if models is not None:
        counts[Mixture.MAKERS] = config.makers
    for mixture, count in counts.items():
        homes += [
            TrainingHome(mixture, seed % OURS_END, jar, models)
            for seed in range(first, first + count)
        ]
        first += count
    return homes


def train_wide_stage(
    folder: Annotated[Path, typer.Argument(help="Where pictures and checkpoints are kept.")],
    jar: Annotated[Path, typer.Option(help="Sweet Home 3D, with its example homes.")],
    number: Annotated[
        int, typer.Option(min=0, max=MOST, help="Number of the stage; each draws others.")
    ] = 0,
    models: Annotated[
        Path | None, typer.Option(help="Repositories with models of several makers.")
    ] = None,
    photographs: Annotated[
        list[Path] | None, typer.Option(help="Folder of photographs to learn from, one or more.")
    ] = None,
    first: Annotated[Path, typer.Option(help="Folder of the weights to go on from.")] = WEIGHTS,
    workers: Annotated[int, typer.Option(help="Processes that render.")] = 2,
) -> None:
    """Render homes of ours, of others and mixtures, and train the image tower on."""
    folder = folder / f"stage-{number}"
    torch.set_flush_denormal(True)  # tiny numbers in the optimiser are ten times as slow
    config = WideStageConfig()
    pool = PatchPool(
        take_all(folder / "views", homes_of(config, number, jar, models), config.views, workers)
    )
    lessons = read_lessons(photographs, folder / "lessons.npz") if photographs else None
    encoder, before = load_embedded_clip(first), load_embedded_clip(first).model
    encoder.model.text_tower.requires_grad_(False)
    encoder.model.image_tower.freeze(config.frozen)
    model = train(pool, encoder.tokenizer, encoder.model, folder, config.steps, lessons)
    finish(between(before, model, config.share), encoder.tokenizer, folder, workers)


def between(before: Clip, after: Clip, share: float) -> Clip:
    """A model whose weights lie between those of two models, at `share` of the way to `after`.

    It forgets less of what `before` knew than `after` does, and keeps most of what `after` has
    learned (Wortsman et al. 2022, Robust fine-tuning of zero-shot models).
    """
    learned = after.state_dict()
    mean = {name: torch.lerp(old.float(), learned[name].float(), share).to(old.dtype)
            for name, old in before.state_dict().items()}  # fmt: skip
    after.load_state_dict(mean)
    return after


if __name__ == "__main__":
    typer.run(train_wide_stage)
