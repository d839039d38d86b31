"""How many sentences of the tables lead to what they ask for.

    python -m tests.tools.sentences

`building.tsv` and `german.tsv` were written beside the grammar, `habits.tsv` and
`habits_german.tsv` just before it was last changed; it must have all of them right.
Tables by readers who have not seen the grammar lie beside them, in the same form:
`fresh_first.tsv` to `fresh_thirteenth.tsv`. How many of each were right at the commit that keeps
them is in `docs/results/rows/sentences.json`; the grammar has learned from all but the eleventh.
"""

from pathlib import Path

from vizbot.core.observer import Outcome
from vizbot.operator.language.command import MISSIONS, Decline, GoTo, command_name, goals_of
from vizbot.operator.language.dialogue import Dialogue
from vizbot.operator.language.language import load_language
from vizbot.operator.language.lexicon import singulars
from vizbot.operator.language.understanding import understand
from vizbot.operator.printing import echo
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.place_answers import Answer
from vizbot.operator.session.session import OperatorSession

FOLDER = Path(__file__).resolve().parents[1] / "test_voice" / "sentences"
LEAST = {"fresh_fifth": 0.99, "fresh_sixth": 0.99, "fresh_eleventh": 0.99}
"""Share of a table that must be right, where it is not the whole."""


def rows(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.split("\t") for line in lines if line and not line.startswith("#")]


class EmptyMap(LiveMap):
    """A map without anything, which answers at once."""

    def places(self, text):
        return Answer(text, Outcome.NOT_FOUND, 0.3, ())

    def count(self, text):
        return 0

    def in_view(self):
        return []

    def keep_out_of(self, text):
        return None


def what_happens(sentence, language):
    """What a sentence leads to, in the words of the tables, and what the robot was asked for."""
    session = OperatorSession()
    reply = Dialogue(session, EmptyMap(session), language=language).typed(sentence, "ann")
    asked = [task.text for task in session.queue.tasks()]
    literal = language.grammar.literals(sentence)
    if reply.question is not None:
        meant = language.grammar.typed(reply.meant)
        if any(goal in language.grammar.literals(reply.meant) for goal in goals_of(meant)):
            return "ask", asked
        return f"offer: {', '.join(goals_of(understand(meant, language).command))}", asked
    if asked:
        plain = language.grammar.without_article
        named = [text if text in literal else plain(text) for text in asked]
        return f"go: {', '.join(named)}", asked
    command = language.grammar.typed(sentence)
    assert not isinstance(command, MISSIONS), "a mission that nobody queued"
    if command is None or isinstance(command, Decline):
        return "refuse", asked
    command = understand(command, language, literal).command
    goals = ", ".join(goals_of(command))
    return command_name(command) + (f": {goals}" if goals else ""), asked


def same(happened, wanted, language):
    """Whether it is what is wanted: one stands for several, the robot's own word for another."""

    def names(goal):
        return {*singulars(goal), *goals_of(understand(GoTo((goal,)), language).command)}

    kind, _, goals = happened.casefold().partition(": ")
    wanted_kind, _, wanted_goals = wanted.casefold().partition(": ")
    pairs = zip(goals.split(", "), wanted_goals.split(", "), strict=False)
    alike = all({*singulars(one)} & names(other) for one, other in pairs)
    return kind == wanted_kind and alike and goals.count(", ") == wanted_goals.count(", ")


def tried(path):
    """Number of a table's sentences, lines on those that lead to something else, and the sentences
    that make it drive where nobody asked it to."""
    language = load_language("de" if path.stem.endswith("german") else "en")
    wrong, drove, table = [], [], rows(path)
    for sentence, wanted in table:
        happened, asked = what_happens(sentence, language)
        if not same(happened, wanted, language):
            wrong.append(f"{sentence!r}: {happened}, not {wanted}")
        if asked and not wanted.startswith("go:"):
            drove.append(sentence)
    return len(table), wrong, drove


def main() -> None:
    for path in sorted(FOLDER.glob("*.tsv")):
        count, wrong, drove = tried(path)
        echo(f"{path.stem}: {count - len(wrong)} of {count} right, {len(drove)} drive unasked")
        for line in wrong:
            echo(f"  {line}")


if __name__ == "__main__":
    main()
