"""Three scales against every single one, on the same trials: the paper's central claim."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.harness.scores import PairedCounts, Rate
from benchmarks.harness.tables import markdown_table

EMBEDDED_CLIP = Path("docs/embedded_clip.md")
"""The page that says how well the embedded encoder names patches of each scale."""
Outcomes = Mapping[Any, bool]
"""Whether each trial succeeded, by what tells it from others: its episode, or home and query."""


@dataclass(frozen=True, slots=True)
class ScaleComparison:
    """Three scales against every single one, on the trials that all have done.

    Attributes:
        three: Rate of the three scales together.
        singles: Rate of each single scale, by its name; empty where no trial is common to all.
        pairs: The three scales paired with each single scale.
    """

    three: Rate
    singles: Mapping[str, Rate]
    pairs: Mapping[str, PairedCounts]

    @staticmethod
    def over(three: Outcomes, singles: Mapping[str, Outcomes]) -> ScaleComparison:
        """Compare outcomes, those of single scales by their names."""
        common = set(three).intersection(*singles.values())
        ours = {trial: three[trial] for trial in common}
        alone = {
            name: {trial: single[trial] for trial in common} for name, single in singles.items()
        }
        return ScaleComparison(
            Rate.over(ours.values()),
            {name: Rate.over(single.values()) for name, single in alone.items() if common},
            {name: PairedCounts.over(ours, single) for name, single in alone.items() if common},
        )

    @property
    def best(self) -> str | None:
        """The single scale that is hardest to beat; None without common trials."""
        order = {name: (self.singles[name].count, pair.p) for name, pair in self.pairs.items()}
        return max(order, key=lambda name: order[name], default=None)

    @property
    def best_single(self) -> float | None:
        """Rate of the best single scale; None without common trials."""
        return None if self.best is None else self.singles[self.best].value

    def summary(self, prefix: str = "") -> dict[str, object]:
        """For programs: the pairs with the best single scale, and whether every one is beaten."""
        pair = None if self.best is None else self.pairs[self.best]
        better = None if pair is None else all(p.shows_better for p in self.pairs.values())
        return {
            f"{prefix}three_scale_wins": pair and pair.wins,
            f"{prefix}three_scale_losses": pair and pair.losses,
            f"{prefix}three_scale_p": pair and pair.p,
            f"{prefix}three_scales_better": better,
        }

    def table(self, what: str) -> str:
        """A table of the pairs; `what` names the rate. Empty without common trials."""
        rows = [
            [name, self.three, self.singles[name], pair.wins, pair.losses, f"{pair.p:.2g}",
             "yes" if pair.shows_better else "not shown"]
            for name, pair in self.pairs.items()
        ]  # fmt: skip
        header = (f"three scales against, {what}", "three", "single", "only three right",
                  "only single right", "p", "three better")  # fmt: skip
        return markdown_table(header, rows) if rows else ""


def scales_verdict(better: Sequence[object], page: Path) -> str:
    """Whether the central result is shown, and how it is decided; empty without a comparison."""
    if not better:
        return ""
    rule = "Three scales count as better only where p < 0.05 against each single scale."
    if all(better):
        return rule
    return (
        f"{rule} The paper's central result, that three scales find more than one, is not shown:"
        f" {better.count(True)} of {len(better)} comparisons show it. The likely cause is the"
        " embedded encoder, which names patches the worse the finer their scale"
        f" ([measured there]({os.path.relpath(EMBEDDED_CLIP, page.parent)}))."
    )
