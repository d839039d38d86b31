"""The learning rate over the steps of a training."""

from math import cos, pi


def part_of_rate(step: int, warmup: int, steps: int) -> float:
    """Part of the highest learning rate at a step: a linear warm-up, then half a cosine to 0."""
    if step < warmup:
        return (step + 1) / warmup
    return 0.5 * (1.0 + cos(pi * (step - warmup) / max(1, steps - warmup)))
