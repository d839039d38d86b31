"""Make the table of words from WordNet 3.0: `python -m training.wordnet FOLDER`.

FOLDER holds WordNet's database, as Debian's package `wordnet-base` (1:3.0-37) installs it in
/usr/share/wordnet. A noun stands for the class that one of its senses is a synonym of, or whose
kinds it is among, a few hypernyms up. Its senses are asked in WordNet's order, the most common
first, and the nearest class of the first sense that has one is taken; the later senses count as
synonyms only, since a rare sense of a common word is seldom meant.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import typer

from mapping.clip.embedded.word_table import HEADING, TABLE
from training.captions.captions import NAMES
from training.captions.spoken_phrasing import TRAINED_SYNONYMS

SENSES = 3
"""Senses of a word that are asked."""
STEPS = 3
"""Hypernyms from a sense to a class, at most."""
FEWER_STEPS: Mapping[str, int] = {
    "ball": 1, "book": 1, "bottle": 1, "bowl": 1, "box": 1, "cat": 1, "computer": 1, "cup": 1,
    "dog": 2, "door": 1, "fan": 1, "flowers": 1, "hallway": 1, "ladder": 1, "monitor": 1,
    "person": 0, "picture": 1, "plate": 1, "pot": 1, "radio": 1, "shelf": 1, "shoes": 2,
    "stairs": 1, "suitcase": 1, "toy": 1, "window": 1,
}  # fmt: skip
"""The same for classes with kinds that do not look like them, or that are nothing for a home."""

SYNSETS: Mapping[str, tuple[str, ...]] = {
    "ball": ("ball.6",), "beanbag": (), "blinds": ("window_blind.1",), "book": ("book.2",),
    "bowl": ("bowl.3",), "bunk bed": ("bunk_bed.1", "bunk.3"), "cardboard box": ("carton.2",),
    "cat": ("domestic_cat.1",), "ceiling lamp": ("pendant.2", "chandelier.1"),
    "chest": ("chest.2",), "christmas tree": ("christmas_tree.5",),
    "coat rack": ("coatrack.1",), "coffee machine": ("coffee_maker.1",),
    "cushion": ("cushion.3",), "dryer": ("clothes_dryer.1",), "drying rack": ("clotheshorse.1",),
    "fan": ("fan.1",), "flowers": ("flower.1", "bouquet.1"),
    "folding screen": ("shoji.1",), "hairdryer": ("hand_blower.1",),
    "hallway": ("hallway.1", "anteroom.1", "corridor.1", "entranceway.1"),
    "high chair": ("highchair.1",), "hob": ("hot_plate.1",), "keyboard": ("computer_keyboard.1",),
    "kitchen cabinet": (),
    "kid's room": ("nursery.1",), "kitchen": ("kitchen.1", "kitchenette.1"),
    "lamp": ("lamp.2",), "laundry room": ("laundry.2",),
    "laundry": ("laundry.1",), "microwave": ("microwave.2",), "monitor": ("monitor.4",),
    "oven": ("oven.1", "stove.1"), "person": ("man.1", "woman.1", "child.1"),
    "picture": ("painting.1", "photograph.1", "poster.1"),
    "plant": ("houseplant.1", "pot_plant.1"), "plate": ("plate.4",), "pot": ("pot.1", "pot.4"),
    "printer": ("printer.2",), "radiator": ("radiator.2",), "radio": ("radio.2",),
    "shoes": ("shoe.1",), "speaker": ("loudspeaker.1",), "study": ("study.5", "office.1"),
    "table": ("table.2",), "toaster": ("toaster.2",), "toilet": ("toilet.2", "water_closet.1"),
    "tv": ("television_receiver.1",), "wall lamp": ("sconce.3",), 
    "bathroom": ("bathroom.1",), "bench": ("bench.1",), "shower": ("shower.1",),
    "exercise bike": ("exercise_bike.1",), "office chair": ("swivel_chair.1",),
}  # fmt: skip
"""Synsets of classes, looked through by hand; of the others the first sense of their name."""


@dataclass(frozen=True, slots=True)
class WordNet:
    """The nouns of WordNet (`wndb(5WN)`).

    Attributes:
        senses: Synsets of each noun, the most common first.
        hypernyms: Synsets above each synset.
        words: The first word of each synset.
        counted: Nouns that occur in the texts whose senses were counted.
    """

    senses: Mapping[str, tuple[int, ...]]
    hypernyms: Mapping[int, tuple[int, ...]]
    words: Mapping[int, str] = field(default_factory=dict)
    counted: frozenset[str] = frozenset()

    @staticmethod
    def read(folder: Path) -> WordNet:
        """Read `index.noun` and `data.noun`."""
        senses, hypernyms, words, counted = {}, {}, {}, set()
        for line in _lines(folder / "index.noun"):
            fields = line.split()
            senses[fields[0]] = tuple(int(offset) for offset in fields[-int(fields[2]) :])
            if int(fields[-int(fields[2]) - 1]):
                counted.add(fields[0])
        for line in _lines(folder / "data.noun"):
            fields = line.split(" | ")[0].split()
            words[int(fields[0])] = fields[4]
            pointers = fields[4 + 2 * int(fields[3], 16) :]
            hypernyms[int(fields[0])] = tuple(
                int(offset) for mark, offset in pairwise(pointers)
                if mark == "@"
            )  # fmt: skip
        return WordNet(senses, hypernyms, words, frozenset(counted))

    def synset(self, sense: str) -> int:
        """The synset of a sense, as "sofa.1"."""
        word, _, number = sense.rpartition(".")
        return self.senses[word][int(number) - 1]

    def above(self, synset: int) -> Iterator[tuple[int, int]]:
        """The synset and its hypernyms, nearest first, with the steps up to each; at most STEPS."""
        layer = [synset]
        for steps in range(STEPS + 1):
            yield from ((above, steps) for above in layer)
            layer = list(dict.fromkeys(up for one in layer for up in self.hypernyms[one]))


def class_synsets(wordnet: WordNet) -> dict[int, str]:
    """The class or room of each synset that stands for one."""
    class_at: dict[int, str] = {}
    for name in NAMES:
        own = name.replace(" ", "_")
        default = (f"{own}.1",) if own in wordnet.senses else ()
        for sense in SYNSETS.get(name, default):
            class_at.setdefault(wordnet.synset(sense), name)
    return class_at


def word_table(wordnet: WordNet, class_at: Mapping[int, str]) -> dict[str, tuple[str, int]]:
    """Class of each noun that has one, and the hypernyms up to it; 0 for a synonym.

    Names and synonyms that are trained are left out; the withheld synonyms are not, so that the
    table can be examined on them.
    """
    table = {}
    for word, synsets in wordnet.senses.items():
        found = (
            _class_above(wordnet, synset, class_at, STEPS if i == 0 else 0)
            for i, synset in enumerate(synsets[:SENSES])
        )
        entry = next((it for it in found if it is not None), None)
        text = word.replace("_", " ")
        if entry is not None and text not in NAMES and text not in TRAINED_SYNONYMS:
            table[text] = entry
    return table


def _class_above(
    wordnet: WordNet, synset: int, class_at: Mapping[int, str], most: int
) -> tuple[str, int] | None:
    for above, steps in wordnet.above(synset):
        name = class_at.get(above)
        if name is not None and steps <= min(most, FEWER_STEPS.get(name, most)):
            return name, steps
    return None


def _lines(path: Path) -> Iterator[str]:
    with path.open(encoding="utf-8") as file:
        yield from (line for line in file if not line.startswith("  "))  # the licence


def make_table(
    folder: Annotated[Path, typer.Argument(help="WordNet's database.")] = Path(
        "/usr/share/wordnet"
    ),
) -> None:
    """Write the table of words that ships with the embedded CLIP."""
    wordnet = WordNet.read(folder)
    table = word_table(wordnet, class_synsets(wordnet))
    rows = [f"{word}\t{name}\t{steps}\n" for word, (name, steps) in sorted(table.items())]
    TABLE.write_text("".join([HEADING, *rows]), encoding="utf-8")


if __name__ == "__main__":
    typer.run(make_table)
