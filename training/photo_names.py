"""Make the table of names of the classes of photographs: `python -m training.photo_names`.

It reads WordNet's database as Debian's package `wordnet-base` (1:3.0-37) installs it. Each class of
ImageNet is a synset of WordNet 3.0 (`photo_classes.txt`). A noun names the classes that are its
first sense that has any, or kinds of that sense. Names by hand (`photo_names.tsv`) come before.

A common noun without a name has the three names that are nearest by the hypernyms that they have in
common (Wu and Palmer 1994, "Verb semantics and lexical selection").
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from mapping.clip.embedded.word_table import looked_up
from mapping.clip.photos.names import CLASSES, HEADING, TABLE
from training.wordnet import WordNet, class_synsets
from vizbot.core.home_vocabulary import class_of

SYNSETS = Path(__file__).with_name("photo_classes.txt")
"""The synsets of the classes, as offsets into WordNet 3.0, in the order of the classifier."""
BY_HAND = Path(__file__).with_name("photo_names.tsv")
"""Names of a home by hand; the file says how it is laid out."""
SENSES = 3
"""Senses of a word of which kinds are looked for; what is a class itself may be a later sense."""
MOST = 120
"""Classes that a name has at most: "dog" has 118, and "object" says nothing."""
RELATIONS: Mapping[str, str] = {
    "like": "what looks like it", "part": "what it belongs to", "holds": "what it holds",
    "worn": "what people wear",
}  # fmt: skip
"""What a name is looked for by, where its classes are none of its kinds."""
KINDS, OTHER_KINDS = ("artifact.1", "food.1"), ("building.1", "vehicle.1", "weapon.1")
"""What nouns without a name have to be for names near them to be offered, and must not be."""
NEAR = 0.85
"""Least similarity of the nearest of three names (Wu and Palmer), 0 to 1."""
_FEWEST_ABOVE = 4
"""Hypernyms above one that two meanings have in common, for them to be near at all."""


def photo_synsets() -> tuple[int, ...]:
    """The synset of each class."""
    found = tuple(int(offset) for line in _lines(SYNSETS) for offset in line.split())
    assert len(found) == CLASSES
    return found


def rows_of_table(wordnet: WordNet) -> str:
    """The text of the table: names of the same classes share a line."""
    lines: dict[str, list[str]] = {}
    for name, meaning in sorted(_meanings(wordnet, photo_synsets()).items()):
        lines.setdefault(meaning, []).append(name)
    return "".join([HEADING, *(f"{', '.join(names)}\t{it}\n" for it, names in lines.items())])


def _meanings(wordnet: WordNet, synsets: Sequence[int]) -> dict[str, str]:
    """The columns behind each name."""
    kinds = _kinds(wordnet, synsets)
    found = {}
    for word, senses in wordnet.senses.items():
        classes = next(
            (
                kinds[sense]
                for i, sense in enumerate(senses)
                if sense in kinds and (i < SENSES or sense in synsets)
            ),
            [],
        )
        if 0 < len(classes) <= MOST:
            found[_name(word)] = _ranges(classes)
    for synset, name in class_synsets(wordnet).items():
        if synset in kinds:
            found[name] = _ranges(kinds[synset])
    number_of = _numbers_by_word(wordnet, synsets)
    for line in _lines(BY_HAND):
        name, relation, words = line.split("\t")
        if relation == "near":
            found[name] = f"\t{words}"
            continue
        classes = sorted(number_of[word] for word in words.split(", "))
        by = f"\t{RELATIONS[relation]}, {words}" if relation in RELATIONS else ""
        found[name] = _ranges(classes) + by
    return found | _near_names(wordnet, synsets, found)


def _near_names(
    wordnet: WordNet, synsets: Sequence[int], meanings: Mapping[str, str]
) -> dict[str, str]:
    """The columns behind common nouns without a name: the three that are nearest in meaning."""
    offered = {
        name: synset
        for number, synset in enumerate(synsets)
        if meanings.get(name := _name(wordnet.words[synset])) == str(number)
    }
    homes = {name: synset for synset, name in class_synsets(wordnet).items()}
    offered |= {name: it for name, it in homes.items() if meanings.get(name, "\t")[0] != "\t"}
    above = {name: _steps_up(wordnet, synset) for name, synset in offered.items()}
    below: dict[int, list[str]] = {}
    for name, ups in above.items():
        for up in ups:
            below.setdefault(up, []).append(name)
    kinds, others = ({wordnet.synset(it) for it in senses} for senses in (KINDS, OTHER_KINDS))
    near = {}
    for noun in wordnet.counted:
        ups = _steps_up(wordnet, wordnet.senses[noun][0])
        if kinds.isdisjoint(ups) or not others.isdisjoint(ups):
            continue
        if (name := _name(noun)) in meanings or class_of(name) or looked_up(name):
            continue
        alike: dict[str, float] = {}
        for up, steps in ups.items():
            depth = 1 + max(_steps_up(wordnet, up).values())
            for other in below.get(up, ()) if depth > _FEWEST_ABOVE else ():
                similarity = 2 * depth / (2 * depth + steps + above[other][up])
                alike[other] = max(similarity, alike.get(other, 0.0))
        best = sorted(alike, key=lambda it: (-alike[it], it not in homes, it))[:3]
        if len(best) == 3 and alike[best[0]] >= NEAR:
            near[name] = f"\t{', '.join(best)}"
    return near


def _name(word: str) -> str:
    """A word of WordNet as it is asked for."""
    return word.replace("_", " ").casefold()


def _steps_up(wordnet: WordNet, synset: int) -> dict[int, int]:
    """Hypernyms of a synset at any depth, itself among them, with the fewest steps up to each."""
    steps, layer = {synset: 0}, [synset]
    while layer:
        at = steps[layer[0]] + 1
        layer = [up for one in layer for up in wordnet.hypernyms[one] if up not in steps]
        steps |= dict.fromkeys(layer, at)
    return steps


def _lines(file: Path) -> Iterator[str]:
    """Lines of a file that are no comments."""
    lines = file.read_text(encoding="utf-8").splitlines()
    return (line for line in lines if not line.startswith("#"))


def _kinds(wordnet: WordNet, synsets: Sequence[int]) -> dict[int, list[int]]:
    """Classes that are each synset itself or kinds of it, at any depth."""
    kinds: dict[int, list[int]] = {}
    for number, synset in enumerate(synsets):
        for above in _steps_up(wordnet, synset):
            kinds.setdefault(above, []).append(number)
    return kinds


def _numbers_by_word(wordnet: WordNet, synsets: Sequence[int]) -> dict[str, int]:
    """The class of each word that is one of a single class."""
    number_at = {synset: number for number, synset in enumerate(synsets)}
    found = {
        _name(word): [number_at[sense] for sense in senses if sense in number_at]
        for word, senses in wordnet.senses.items()
    }
    return {word: numbers[0] for word, numbers in found.items() if len(numbers) == 1}


def _ranges(numbers: Iterable[int]) -> str:
    """Numbers in order as a text like "3,7-9"."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1][1:] = [number]
        else:
            parts.append([number])
    return ",".join("-".join(map(str, part)) for part in parts)


def make_table(
    folder: Annotated[Path, typer.Argument(help="WordNet's database.")] = Path(
        "/usr/share/wordnet"
    ),
) -> None:
    """Write the table of names that ships with the classes of photographs."""
    TABLE.write_text(rows_of_table(WordNet.read(folder)), encoding="utf-8")


if __name__ == "__main__":
    typer.run(make_table)
