"""`docs/results/belief.md` and its picture: whether the probabilities of places hold."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.fast_world.curves import MEASURES, draw_curves
from benchmarks.fast_world.examination import ASKED
from benchmarks.harness.tables import markdown_table, percent, percent_range
from mapping.clip import belief, evidence, place_views, scores
from mapping.clip.footprint import PLACE
from mapping.clip.weights import FILE as WEIGHTS
from mapping.clip.weights import fitted_weights
from vizbot.config import BeliefSearchConfig
from vizbot.core.files import write_whole
from vizbot.objectnav.verdicts import REFUTED

FILE = "examination.json"
PICTURE = "pictures/belief/curves.png"
"""The picture, from the folder of the page."""
_SEEN = "little in the fit lies beyond"
"""Why scores are held within bounds."""
_TITLE = f"""# The belief, examined

`python -m benchmarks.fast_world.examination VIEWS --out docs/results/rows/belief/{FILE}` takes
walks in homes on which neither the encoder, nor its threshold, nor the numbers of the belief were
fitted. The poses are true, the pictures those of the simulator. It asks the probability of
each place that was seen two things: does it hold, and does it tell a thing that the robot passes
near by (within 2 m) from what only looks like it? The best cosine of each place is asked the same,
in place of the rule that was in use before the belief, which is gone; two numbers, fitted on the
homes of the belief's fit, make a probability of it (Platt 1999). Over how large a square another
room is compared was chosen in other homes, too (916 to 931).

Log loss and calibration error are over all places that were seen (of 0.25 m, 40 % through each walk
and at its end). "Missed" are things that are not believed while views show them near by for the
first time, on the way past them, at the level at which so many of the three likeliest wrong places
of each walk are believed. A search looks at what is likely from more than one spot; this walk does
not."""


def belief_page(folder: Path, page: Path) -> str:
    """The page of the kept examination; empty without any.

    Args:
        folder: Folder of the kept rows.
        page: The file that the text is for.
    """
    if (kept := _kept(folder)) is None:
        return ""
    homes = f"{kept['homes'][0]} to {kept['homes'][-1]}"
    parts = [
        _TITLE,
        f"Commit {kept['commit']}, homes {homes}, {kept['passes']} first passes and"
        f" {kept['wrong_places']} wrong places; encoder {kept['encoder']}.",
        f"![Reliability, and what is missed against what is wrongly believed]({PICTURE})",
        "## Does it hold?",
        markdown_table(
            ("", "log loss", "expected calibration error"),
            [
                [name, f"{kept[key]['log_loss']:.4f}", f"{kept[key]['calibration_error']:.4f}"]
                for key, name in MEASURES.items()
            ],
        ),
        markdown_table(
            ("probability by the belief", "places where it is [%]", "places"),
            [
                [f"{each['mean']:.2f}", percent(each["share"]), each["count"]]
                for each in kept["belief"]["bins"]
            ],
        ),
        "## What is passed near by",
        markdown_table(
            (
                "wrong places that are believed [%]",
                *(f"missed by {name} [%]" for name in MEASURES.values()),
            ),
            [
                [percent(one["false"]), *(_missed(kept[key]["curve"][i]) for key in MEASURES)]
                for i, one in enumerate(kept["belief"]["curve"])
            ],
        ),
        "Intervals are 95 % over homes.",
        _half_as_many(kept),
        "## After a refutation",
        _after_refutation(kept),
        *_numbers(),
    ]
    return "\n\n".join(parts) + "\n"


def write_belief_picture(folder: Path, page: Path) -> None:
    """Draw the picture of the page, where there is an examination."""
    if (kept := _kept(folder)) is not None:
        path = page.parent / PICTURE
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, draw_curves(kept))


def _half_as_many(kept: Mapping[str, Any]) -> str:
    """Whether what was asked for is reached: half as many missed at so many believed wrongly."""
    at = next((i for i, one in enumerate(kept["belief"]["curve"]) if one["false"] == ASKED), None)
    if at is None:
        return ""
    belief, cosine = (kept[key]["curve"][at]["missed"] for key in MEASURES)
    reached = "are" if belief <= cosine / 2 else "are not"
    return (
        f"It was asked that at {percent(ASKED)} % at most half as many are missed as by the best"
        f" cosine: they {reached} ({percent(belief)} % of {percent(cosine)} %). Things and rooms,"
        f" each at a level of its own: {_missed(kept['things'])} and {_missed(kept['rooms'])} %."
    )


def _after_refutation(kept: Mapping[str, Any]) -> str:
    """Whether the next place is believed enough where the likeliest is refuted."""
    after = kept["after_refutation"]
    low, high = after["over_homes"] or (0.0, 1.0)
    holds = low <= after["believed"] <= high
    so = (
        "what is believed lies within that, so a refutation leaves other places as they are"
        if holds
        else "a refutation says more of other places than is made of it"
    )
    return (
        f"Where the likeliest place is wrong ({after['count']} times) the next one is believed at"
        f" {percent(after['believed'])} % on average and is right in {percent(after['right'])} %"
        f" ({percent_range(after['over_homes'])}): {so}. One distribution over all candidates,"
        " what is unseen and that there is none, with a prior for each question, was asked for and"
        " is not built: each place has a probability of its own, a frontier one of what may be"
        " behind it, and a search ends when nothing that is left is worth its way."
    )


def _numbers() -> list[str]:
    """All fitted numbers, and which are not fitted."""
    weights = fitted_weights()
    fitted = len(weights.near) + len(weights.far) + len(weights.join)
    of_views = [
        [name, *(f"{value:.3f}" for value in both)]
        for name, *both in zip(evidence.NAMES, weights.near, weights.far, strict=True)
    ]
    of_places = [
        [name, f"{value:.3f}"] for name, value in zip(place_views.NAMES, weights.join, strict=True)
    ]
    return [
        "## Its numbers",
        f"{fitted} numbers are fitted (logistic regression; `python -m"
        " benchmarks.fast_world.fit`) and lie in"
        f" `mapping/clip/{WEIGHTS.name}`: first those of a view, near and afar apart, then, on what"
        " these say, those of all views of a place. The last table has what is not fitted; some of"
        " it was read off homes of development all the same, and what is left after a look in vain"
        ' or a "no" was set by hand, which was not to be.',
        markdown_table(
            (
                "one view of a place",
                f"from within {evidence.NEAR:g} m",
                "from afar",
            ),
            of_views,
        ),
        markdown_table(("all views of a place", "weight"), of_places),
        markdown_table(("not fitted", "value", "why so"), _not_fitted()),
    ]


def _not_fitted() -> list[list[object]]:
    """The numbers of the belief that no fit made."""
    slope, offset = scores.ABOVE_TO_LOG_ODDS
    room = belief.ROOM * PLACE
    doubt = BeliefSearchConfig.model_fields["rejection_factor"].default
    return [
        ["log odds of the encoder count from, to", _range(evidence.LOG_ODDS), _SEEN],
        ["z-scores count from, to", _range(evidence.STANDARD), _SEEN],
        ["upper tails count from, to", _range(evidence.TAILS), _SEEN],
        ["evidence of one view from, to", _range((evidence.LEAST, evidence.MOST)),
         "one view alone neither proves nor excludes"],
        ["near, afar at most [m]", f"{evidence.NEAR:g}, {evidence.FARTHEST:g}",
         "where the fit is parted; the camera's range"],
        ["share of places with the goal, in the fit", evidence.PRIOR, "evidence counts from here"],
        ["phrases left out, of those of the background", scores.LEFT_OUT,
         "those most like an element: whatever means the question is among them where it is shown"],
        ["quantile of the bank that is the upper tail", scores.TAIL, "of the bank of pictures"],
        ["upper tail where there is no bank", scores.USUAL_TAIL, "mean over the paper's goals"],
        ["log odds of a z-score z, where an encoder tells no scale", f"{slope:g} z {offset:+g}",
         "the embedded encoder's, in training home 916"],
        ["edges of the squares of neighbours, of surroundings [m]",
         f"{place_views.NEIGHBOURS * PLACE:g}, {place_views.SURROUNDINGS * PLACE:g}",
         "next to it; about a piece of furniture"],
        ["edge of the square on which rooms are compared [m]", f"{room:g}",
         "chosen in homes 916 to 931"],
        ["left of a place after a look in vain", doubt,
         "set by hand (`objectnav.search.rejection_factor`): looks may err"],
        ['left of a place after a person\'s "no"', REFUTED, "set by hand: people may err"],
    ]  # fmt: skip


def _range(bounds: tuple[float, float]) -> str:
    return " to ".join(f"{bound:g}" for bound in bounds)


def _missed(one: Mapping[str, Any]) -> str:
    return f"{percent(one['missed'])} ({percent_range(one['over_homes'])})"


def _kept(folder: Path) -> dict[str, Any] | None:
    path = folder / FILE
    if not path.is_file():
        return None
    kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return kept
