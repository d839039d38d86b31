"""A sentence means the same, whichever way it comes in."""

from dataclasses import replace

import httpx
import pytest

from tests.helpers.served import served, step
from vizbot.commands import launch, remote
from vizbot.commands.dispatch import obey
from vizbot.commands.sentences import parse_goals, parse_texts
from vizbot.core.errors import ConfigError
from vizbot.core.observer import Outcome
from vizbot.objectnav import reasons
from vizbot.objectnav.tasks import Task
from vizbot.operator.client.robot_client import RobotClient
from vizbot.operator.language.command import ComeBack, GoTo
from vizbot.operator.language.language import ENGLISH, load_language
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.place_answers import Answer
from vizbot.operator.voice.intent import Utterance

TYPED = [
    ("go to the kitchen", ["kitchen"]),
    ("kitchen", ["kitchen"]),
    ("Take me to the sofa, then the lamp.", ["sofa", "lamp"]),
    ('"go to the kitchen"', ["go to the kitchen"]),
    ('find the "stop and go" sign', ["stop and go sign"]),
]


def requests(session):
    return [task.request for task in session.queue.tasks()]


def test_the_console_understands_it(client, session):
    for sentence, goals in TYPED:
        before = len(requests(session))
        answer = httpx.post(f"{client.url}/said", json={"text": sentence})
        assert requests(session)[before:] == goals
        assert answer.json()["numbers"] == list(range(before + 1, before + len(goals) + 1))


def test_the_command_goal_understands_it(client, session):
    for sentence, goals in TYPED:
        before = len(requests(session))
        assert remote.ask(client, [sentence], at_once=False, wait=False)
        assert requests(session)[before:] == goals


@pytest.mark.parametrize(("sentence", "goals"), TYPED)
def test_the_keyboard_of_a_launch_understands_it(session, monkeypatch, sentence, goals):
    monkeypatch.setattr(launch, "typed_lines", lambda: [sentence])
    launch._take_dictation(session)
    assert requests(session) == goals


@pytest.mark.parametrize(("sentence", "goals"), TYPED)
def test_a_dry_run_understands_it(sentence, goals):
    assert parse_goals([sentence]) == goals


@pytest.mark.parametrize(
    ("sentence", "goals"), [TYPED[0], TYPED[2], ('"Go to the kitchen."', ["kitchen"])]
)
def test_it_is_understood_when_spoken(client, session, sentence, goals):
    obey(Utterance(sentence, ENGLISH.grammar.heard(sentence)), client, quiet=True)
    assert requests(session) == goals


def test_a_program_asks_literally(client, session):
    for sentence, _ in TYPED:
        client.ask([sentence])
    assert requests(session) == [sentence for sentence, _ in TYPED]


def test_several_texts_are_one_mission(client, session):
    assert parse_texts(["sofa", "find the bed", "come back"]) == GoTo(("sofa", "bed"), ComeBack())
    session.ask(["lamp"])
    remote.ask(client, ["the sofa", "find the bed right now", "dock"], at_once=False, wait=False)
    assert requests(session) == ["the sofa", "bed", Task.DOCK, "lamp"]
    remote.ask(
        client, [f'"thing {number:013d}"' for number in range(20)], at_once=False, wait=False
    )
    assert len(requests(session)) == 24


def test_the_command_goal_answers_a_question(client, session, capsys, monkeypatch):
    monkeypatch.setattr(LiveMap, "places", lambda _, text: Answer(text, Outcome.NOT_FOUND, 0.3, ()))
    remote.ask(client, ["where is the sofa?"], at_once=False, wait=True)
    assert capsys.readouterr().out == "sofa: not on the map so far\n"
    assert requests(session) == []


def test_the_command_goal_stops(client, session, capsys):
    remote.ask(client, ["sofa", "stop"], at_once=False, wait=False)
    assert session.stopped.is_set() and requests(session) == []
    assert capsys.readouterr().out == "stopped\n"


@pytest.mark.parametrize(
    "texts", [["where is the sofa", "bed"], ["dock", "sofa"], ["come back", "explore"]]
)
def test_what_is_no_mission_is_refused_in_one_line(texts):
    with pytest.raises(ConfigError, match=r"cannot be one mission; give goals"):
        parse_texts(texts)


@pytest.mark.parametrize("text", ["don't go to the sofa", "go to the", "..."])
def test_what_is_not_understood_is_refused_in_one_line(text):
    for parse in (parse_texts, parse_goals):
        with pytest.raises(ConfigError, match=r"is not understood; say for example"):
            parse([text])


@pytest.mark.parametrize(
    "text",
    ["stop", "where is the sofa", "come back", "dock", "explore", "go to the sofa, then come back"],
)
def test_a_dry_run_takes_nothing_but_goals(text):
    with pytest.raises(ConfigError, match=r"a dry run takes goals .* is another command"):
        parse_goals(["sofa", text])


def test_a_dry_run_goes_to_one_of_all_and_says_so(capsys):
    assert parse_goals(["show me all the chairs", "sofa"]) == ["chairs", "sofa"]
    assert "chairs: all of them it cannot visit yet" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("sentence", "answer"),
    [
        ("help", "I go to things and rooms"),
        ("what are you doing?", "I have nothing to do"),
        ("how much battery is left?", "I do not know how full my battery is"),
        ("where are you?", "I do not know where I am yet"),
        ("go on", "there is nothing to go on with"),
        ("cancel the sofa", "sofa: that is not among what I was asked for"),
        ("not the bed", "I set nothing off"),
        ("make me a sandwich", "that I cannot do"),
        ("drive backwards", "I do not drive backwards by words"),
        ("yes", "nothing was asked"),
    ],
)
def test_it_is_answered_on_the_command_line_and_drives_nothing(
    client, session, capsys, sentence, answer
):
    assert remote.ask(client, [sentence], at_once=False, wait=True)
    assert capsys.readouterr().out.startswith(answer)
    assert requests(session) == []


def test_what_is_asked_back_on_the_command_line_is_settled_by_yes(client, session, capsys):
    assert not remote.ask(client, ["kitchn"], at_once=False, wait=False)
    assert capsys.readouterr().out == 'did you mean "kitchen"?\n'
    assert remote.ask(client, ["Yes."], at_once=False, wait=False)
    assert requests(session) == ["kitchen"]
    assert not remote.ask(client, ["asdf"], at_once=False, wait=False)
    assert remote.ask(client, ["no"], at_once=False, wait=False)
    assert remote.ask(client, ["yes"], at_once=False, wait=False)
    assert requests(session) == ["kitchen"]


def test_what_was_asked_for_is_called_off_in_other_words(client, session, capsys):
    remote.ask(client, ["sofa", "bed", "couch"], at_once=False, wait=False)
    assert requests(session) == ["sofa", "bed", "sofa"]
    remote.ask(client, ["forget about the settee"], at_once=False, wait=False)
    assert "called off: sofa, sofa" in capsys.readouterr().out
    left = [task for task in session.queue.tasks() if task.outcome is None]
    assert [task.request for task in left] == ["bed"]
    remote.ask(client, ["continue"], at_once=False, wait=False)
    assert capsys.readouterr().out == "I go on with: bed\n"


def test_a_robot_that_speaks_german_answers_in_it(session, capsys):
    with served(session, language="de") as server, RobotClient(server.url, None) as client:
        remote.ask(client, ["Fahr in die Küche, dann komm zurück."], at_once=False, wait=False)
        remote.ask(client, ["Hilfe"], at_once=False, wait=False)
    assert requests(session) == ["kitchen", Task.COME_BACK]
    accepted, taken, answer = capsys.readouterr().out.splitlines()
    assert accepted == "gefragt: fahr zu Küche, dann komm zurück"
    assert taken == "küche: kitchen" and answer.startswith("Ich fahre zu Dingen und Zimmern")


@pytest.mark.parametrize(
    ("language", "question", "answer"),
    [
        ("en", "what are you doing?", "exploring, for: sofa, since no other unseen place is"
         " reached sooner; no place seen so far is worth a closer look; after that: bed"),
        ("de", "Was machst du?", "ich erkunde, für: Sofa, denn keine andere ungesehene Stelle ist"
         " schneller zu erreichen; keine Stelle, die ich gesehen habe, lohnt einen näheren Blick;"
         " danach: Bett"),
    ],
)  # fmt: skip
def test_what_it_does_is_answered_with_why(session, capsys, language, question, answer):
    why = reasons.exploring(reasons.NEAREST, [])
    session.ask(["sofa", "bed"])
    with served(session, language=language) as server, RobotClient(server.url, None) as client:
        session.on_step(replace(step(0), why=why))
        remote.ask(client, [question], at_once=False, wait=False)
        assert client.state()["why"] == why
    assert capsys.readouterr().out == f"{answer}\n"


def test_a_dry_run_takes_german_goals(capsys):
    assert parse_goals(["geh zum Kühlschrank"], load_language("de")) == ["refrigerator"]
    assert capsys.readouterr().err == "kühlschrank: refrigerator\n"
