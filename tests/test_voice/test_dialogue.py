"""Sentences, typed and spoken, to a robot that is running."""

import re
import threading
from dataclasses import replace
from datetime import UTC, datetime

import httpx
import numpy as np
import pytest

from tests.helpers.failing import raising
from tests.helpers.roomba_rig import DEADLINE, wait_for
from tests.helpers.served import arrived, jobs_done, refusal, served
from tests.helpers.served import step as standing
from tests.test_voice.test_sound import recording
from vizbot.core.errors import ConfigError
from vizbot.core.geometry import planar
from vizbot.core.observer import Outcome
from vizbot.core.types import BaseMode, BaseState, Feedback, Tracking
from vizbot.objectnav.tasks import Task
from vizbot.operator.language import dialogue
from vizbot.operator.language.command import GoTo, No, Stop, Yes
from vizbot.operator.language.language import load_language
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.place_answers import Answer, FoundPlace, summary
from vizbot.operator.voice import recordings
from vizbot.operator.voice.intent import ResolvedGoal, Utterance

JUST_NOW = datetime.now(UTC).isoformat()


def nowhere(live_map, text):
    return Answer(text, Outcome.NOT_FOUND, 0.3, ())


def dialogue_in(code, session):
    return dialogue.Dialogue(session, LiveMap(session), load_language(code))


def at(x, y):
    return Answer(
        "sofa",
        Outcome.LOCATED,
        0.3,
        (FoundPlace((x, y, 0.4), 0.5, 3, (), JUST_NOW),),
    )


@pytest.fixture
def http(session, monkeypatch):
    monkeypatch.setattr(LiveMap, "vocabulary", lambda live_map: ["yellow chair"])
    monkeypatch.setattr(LiveMap, "places", nowhere)
    with served(session) as server, httpx.Client(base_url=server.url) as http:
        yield http


@pytest.fixture
def hears(monkeypatch):
    """Makes the recogniser hear something."""

    def hear(heard):
        monkeypatch.setattr(recordings.Recogniser, "__init__", lambda *_, **__: None)
        monkeypatch.setattr(recordings.Recogniser, "hear", lambda *_: heard)
        monkeypatch.setattr(recordings.Recogniser, "learn", lambda *_: None)

    return hear


def say(http, text, **others):
    answer = http.post("/said", json={"text": text, **others})
    assert answer.status_code == 200
    return answer.json()


def requests(session):
    return [task.request for task in session.queue.tasks()]


def sound():
    return {"content": recording(16000, 8000), "headers": {"Content-Type": "audio/wav"}}


def test_a_bare_thing_is_a_goal_and_a_sentence_what_it_says(http, session):
    assert say(http, "yellow chair")["said"] == ["asked for: go to yellow chair"]
    say(http, "Go to the sofa, then the kitchen, then come back.")
    say(http, "dock")
    assert requests(session) == ["yellow chair", "sofa", "kitchen", Task.COME_BACK, Task.DOCK]


@pytest.mark.parametrize(
    ("text", "others", "wanted"),
    [("bed", {"at_once": True}, "bed"), ("go to the bed right now", {}, "bed"),
     ("instead, find the bed", {}, "bed"), ("bed, now", {}, "bed"),
     ("come back at once", {}, Task.COME_BACK), ("show me all the beds immediately", {}, "beds")],
)  # fmt: skip
def test_what_is_told_or_said_to_be_for_now_comes_first(http, session, text, others, wanted):
    say(http, "sofa")
    assert session.queue.current().request == "sofa"
    say(http, text, **others)
    assert session.queue.current().called_off
    assert requests(session) == ["sofa", wanted]


@pytest.mark.slow
def test_haste_outlives_a_doubt(http, session, hears):
    say(http, "bed")
    doubtful = ResolvedGoal("so far", "so far", "sofa")
    hears(Utterance("so far, now", GoTo(("so far",)), (doubtful,), at_once=True))
    assert session.queue.current().request == "bed"
    say(http, http.post("/heard", **sound()).json()["meant"])
    assert session.queue.current().called_off
    assert requests(session) == ["bed", "sofa"]


def test_what_must_not_be_done_is_not(http, session):
    for text in ("don't go to the kitchen", "never explore", "sofa, then do not dock"):
        assert "I set nothing off" in say(http, text)["said"][0]
    assert requests(session) == []


def test_explore_and_bare_things_in_a_row(http, session):
    assert say(http, "look around")["said"] == ["asked for: explore"]
    say(http, "the bookshelf, then the electric fan")
    assert requests(session) == [Task.EXPLORE, "bookshelf", "electric fan"]


def test_stop_names_who_stopped(http, session):
    say(http, "sofa")
    assert say(http, "stop it now", who="ann")["said"] == ["stopped"]
    assert session.stopped.is_set()
    assert session.queue.tasks()[0].reason == "stopped by ann"


def test_of_all_things_one_is_gone_to_and_that_is_said(http, session):
    (_, told) = say(http, "show me all the chairs")["said"]
    assert "it goes to one, and of several on its map to one near by" in told
    assert requests(session) == ["chairs"]


def test_where_something_is_is_told_and_nothing_is_driven(http, session, monkeypatch):
    assert say(http, "where is the sofa")["said"] == ["sofa: not on the map so far"]
    monkeypatch.setattr(LiveMap, "places", lambda live_map, text: at(1.0, -2.0))
    lost = "sofa: on the map, but the robot does not know where it is itself"
    assert say(http, "where is the sofa")["said"] == [lost]
    session.on_step(standing(0))
    found = say(http, "where is the sofa")
    assert found["place"] == [1.0, -2.0]
    assert found["said"] == ["sofa: 2.2 m ahead and to the right of the robot"]
    assert requests(session) == []


@pytest.mark.parametrize(
    ("position", "where"),
    [((2.0, 2.0), "1.0 m ahead of"), ((1.0, 3.5), "1.5 m to the left of"),
     ((2.0, 1.0), "1.4 m ahead and to the right of"),
     ((0.8, 1.8), "0.3 m behind and to the right of"),
     ((1.0, 2.0), "0.0 m ahead of"), ((1.1, 0.9), "1.1 m to the right of"),
     ((-1.0, 2.1), "2.0 m behind"), ((0.0, 3.0), "1.4 m behind and to the left of"),
     ((2.0, 3.0), "1.4 m ahead and to the left of")],
)  # fmt: skip
def test_a_place_is_told_as_seen_from_the_robot(position, where):
    assert summary(at(*position), planar(1.0, 2.0, 0.0)) == f"sofa: {where} the robot"


def test_the_battery_is_told_of_a_base_that_has_just_been_silent(http, session):
    state = BaseState(0.0, np.eye(4), True, False, (False,) * 4, (False, False), 0.5, BaseMode.SAFE)
    session.robot.battery_state = lambda: state
    assert say(http, "how full is the battery?")["said"] == ["my battery is at 50 %"]


def test_a_place_is_told_along_the_robots_own_axes():
    T_map_base = planar(0.0, 0.0, np.pi / 2)
    assert summary(at(0.0, 3.0), T_map_base) == "sofa: 3.0 m ahead of the robot"
    assert summary(at(3.0, 0.0), T_map_base) == "sofa: 3.0 m to the right of the robot"


def test_what_is_no_sentence_is_refused(http, session):
    for text in ("", " ", "a" * 4001, "so\x07fa"):
        assert http.post("/said", json={"text": text}).status_code == 422, text
        assert requests(session) == [], text


@pytest.mark.parametrize(
    ("heard", "told", "done"),
    [
        (
            Utterance("Go to the sofa.", GoTo(("sofa",))),
            {"heard": "Go to the sofa.", "said": ["asked for: go to sofa"], "question": None},
            ["sofa"],
        ),
        (
            Utterance("Find the mace.", GoTo(("mace",)), (ResolvedGoal("mace", "mace"),)),
            {
                "question": 'I can go to things and rooms. Search for "mace"?',
                "meant": 'go to "mace"',
            },
            [],
        ),
    ],
    ids=["known", "unknown"],
)
def test_what_is_spoken_is_done_and_asked_back_where_it_is_unknown(
    http, session, hears, heard, told, done
):
    hears(heard)
    answer = http.post("/heard", **sound()).json()
    assert answer | told == answer
    assert requests(session) == done


def test_a_doubt_is_asked_back_and_yes_to_it_is_a_sentence(http, session, hears):
    shown = []
    session.robot.show = shown.append
    hears(Utterance("so far", GoTo(("so far",)), (ResolvedGoal("so far", "so far", "sofa"),)))
    answer = http.post("/heard", **sound()).json()
    assert answer["question"] == 'did you mean "sofa"?'
    assert requests(session) == [] and shown == [Feedback.DOUBT]
    say(http, answer["meant"])
    assert requests(session) == ["sofa"]


def test_what_is_spoken_in_haste_comes_first(http, session, hears):
    say(http, "bed")
    assert session.queue.current().request == "bed"
    hears(Utterance("Go to the sofa now.", GoTo(("sofa",)), at_once=True))
    assert http.post("/heard", **sound()).json()["said"] == ["asked for: go to sofa, right now"]
    assert session.queue.current().called_off


def test_what_is_no_command_is_not_done(http, session, hears):
    hears(Utterance("nice weather", None))
    assert "not understood" in http.post("/heard", **sound()).json()["said"][0]
    assert requests(session) == []


def test_what_was_said_before_a_stop_is_not_done_after_it(http, session, hears, monkeypatch):
    def hear(*_):
        session.stop("ann")
        return Utterance("go to the sofa", GoTo(("sofa",)))

    hears(None)
    monkeypatch.setattr(recordings.Recogniser, "hear", hear)
    answer = http.post("/heard", **sound())
    assert answer.json()["detail"] == "the robot was stopped meanwhile; ask again"
    session.begin_step()
    assert session.stopped.is_set() and requests(session) == []
    say(http, "sofa")
    session.begin_step()
    assert not session.stopped.is_set() and requests(session) == ["sofa"]


def test_a_spoken_stop_waits_for_no_robot_that_is_busy(http, session, hears, monkeypatch):
    busy = threading.Event()
    monkeypatch.setattr(LiveMap, "vocabulary", lambda live_map: busy.wait(DEADLINE) and [])
    hears(Utterance("stop", Stop()))
    assert http.post("/heard", **sound()).json()["said"] == ["stopped"]
    assert session.stopped.is_set() and not busy.is_set()
    busy.set()


def test_while_somebody_is_listened_to_no_other_recording_is_read(http, hears, monkeypatch):
    begun, over, read = threading.Event(), threading.Event(), []

    def hear(*_):
        begun.set()
        over.wait(DEADLINE)
        return Utterance("nice weather", None)

    hears(None)
    monkeypatch.setattr(recordings.Recogniser, "hear", hear)
    monkeypatch.setattr(recordings, "read_sound", lambda *given: read.append(given) or np.zeros(0))
    monkeypatch.setattr(recordings, "_PATIENCE", 0.01)
    first = threading.Thread(target=http.post, args=("/heard",), kwargs=sound())
    first.start()
    assert begun.wait(DEADLINE)
    assert "listens to somebody else" in http.post("/heard", **sound()).json()["detail"]
    over.set()
    first.join()
    assert len(read) == 1


def test_the_model_is_loaded_once_and_learns_what_the_map_finds(http, hears, monkeypatch):
    loaded, learnt = [], []
    hears(Utterance("nice weather", None))
    monkeypatch.setattr(recordings.Recogniser, "__init__", lambda *_, **__: loaded.append(True))
    monkeypatch.setattr(recordings.Recogniser, "learn", lambda _, words: learnt.append(words))
    for _ in range(3):
        http.post("/heard", **sound())
    wait_for(lambda: len(learnt) == 3)
    assert loaded == [True] and set(learnt) == {("yellow chair",)}


def test_noise_and_a_missing_model_are_refused_in_a_line(http, monkeypatch):
    monkeypatch.setattr(recordings.Recogniser, "__init__", lambda *_, **__: None)
    noise = http.post("/heard", content=b"noise", headers={"Content-Type": "audio/webm"})
    assert "what was sent holds no sound" in refusal(noise, 422)
    missing = raising(ConfigError("no speech model 'tiny.en'"))
    monkeypatch.setattr(recordings.Recogniser, "__init__", missing)
    assert refusal(http.post("/heard", **sound()), 503) == "no speech model 'tiny.en'"


def test_a_recording_may_be_large_but_not_endless(http):
    headers = {"Content-Type": "audio/wav"}
    assert http.post("/heard", content=b"0" * 500_000, headers=headers).status_code == 422
    assert http.post("/heard", content=b"0" * 1_100_000, headers=headers).status_code == 413
    assert http.post("/said", content=b"0" * 100_000, headers=headers).status_code == 413


def test_a_yes_settles_what_was_asked_of_the_same_person_and_for_a_while(session, monkeypatch):
    clock = iter(range(0, 1000, 20))
    monkeypatch.setattr(LiveMap, "places", nowhere)
    answers = dialogue.Dialogue(session, LiveMap(session), now=lambda: next(clock))
    assert answers.typed("kitchn", "ann").question == 'did you mean "kitchen"?'
    assert answers.typed("yes", "bob").said == ("nothing was asked",)
    assert answers.typed("yes", "ann").said == ("asked for: go to kitchen",)
    assert answers.typed("yes", "ann").said == ("nothing was asked",)
    answers.typed("bethroom", "ann")
    answers.typed("where is the sofa", "ann")
    assert answers.typed("yes", "ann").said == ("nothing was asked",)
    answers.typed("bethroom", "ann")
    for _ in range(2):
        next(clock)
    assert answers.typed("yes", "ann").said == ("nothing was asked",)
    assert requests(session) == ["kitchen"]


def test_a_spoken_yes_settles_it_too(http, session, hears):
    say(http, "bed")
    assert say(http, "kitchn, now", who="ann")["meant"] == "go to kitchen, right now"
    hears(Utterance("Yes, please.", Yes()))
    heard = http.post("/heard", params={"who": "ann"}, **sound()).json()
    assert (heard["heard"], heard["said"]) == (
        "Yes, please.",
        ["asked for: go to kitchen, right now"],
    )
    assert requests(session) == ["kitchen", "bed"]


@pytest.fixture
def refuted(session):
    """What the robot's loop refutes."""
    with jobs_done(session) as refuted:
        yield refuted


@pytest.mark.parametrize(
    ("code", "text"),
    [("en", "no"), ("en", "No, that is not it."), ("en", "that's not it, keep looking"),
     ("en", "no, keep looking"), ("en", "that isn't it"), ("en", "wrong one"),
     ("de", "nein"), ("de", "Nein, das ist es nicht."), ("de", "das ist es nicht, such weiter"),
     ("de", "nein, such weiter"), ("de", "das ist er nicht"), ("de", "falsch")],
)  # fmt: skip
def test_no_after_an_arrival_has_the_robot_search_on(session, refuted, code, text):
    number = arrived(session)
    language, reply = load_language(code), dialogue_in(code, session).typed(text, "ann")
    assert reply.numbers == (number + 1,) and refuted == [True]
    assert reply.said == (language.say("searching_on", goal=language.lexicon.own("sofa")),)
    assert session.arrival.confirmed is False


@pytest.mark.parametrize(
    ("code", "text"),
    [("en", "yes"), ("en", "Yes, that is it!"), ("en", "yes, that's it"), ("en", "that is the one"),
     ("de", "ja"), ("de", "Ja, das ist es!"), ("de", "genau"), ("de", "das ist richtig")],
)  # fmt: skip
def test_yes_after_an_arrival_confirms_it(session, refuted, code, text):
    arrived(session)
    language, answers = load_language(code), dialogue_in(code, session)
    assert answers.typed(text, "ann").said == (language.say("confirmed"),)
    assert session.arrival.confirmed is True and refuted == []
    assert answers.typed(text, "ann").said == (language.say("nothing_asked"),)


@pytest.mark.parametrize("code", ["en", "de"])
def test_yes_and_no_answer_whether_to_go_to_what_the_robot_sees(session, refuted, code):
    language, answers = load_language(code), dialogue_in(code, session)
    yes, no = ("yes", "no") if code == "en" else ("ja", "nein")
    session.on_step(replace(standing(0), candidate_xy=np.array([2.0, 1.0])))
    assert answers.typed(yes, "ann").said == (language.say("going_there", goal="sofa"),)
    assert session.candidate.confirmed and refuted == []
    assert answers.typed(no, "ann").said == (language.say("searching_on", goal="sofa"),)
    assert session.candidate is None and refuted == [(2.0, 1.0)]
    assert answers.typed(no, "ann").said == (language.say("no_then"),)


def test_a_question_that_was_asked_back_is_answered_before_the_arrival(session, refuted):
    arrived(session)
    answers = dialogue_in("en", session)
    for answer, said in (
        ("no", "then not: nothing was set off"),
        ("yes", "asked for: go to kitchen"),
    ):
        assert answers.typed("kitchn", "ann").question == 'did you mean "kitchen"?'
        assert answers.typed(answer, "ann").said == (said,)
    answers._doubts["ann"] = dialogue._Doubt(None, False, np.inf)  # with no way to say yes
    assert answers.typed("no", "ann").said == ("then not: nothing was set off",)
    assert session.awaits_verdict and refuted == []


def test_a_spoken_no_has_the_robot_search_on(http, session, hears, refuted):
    number = arrived(session)
    hears(Utterance("No, that is not it.", No()))
    assert http.post("/heard", **sound()).json()["numbers"] == [number + 1]


@pytest.mark.parametrize(
    ("code", "text", "answer"),
    [
        ("en", "no", "nothing was asked, so I go on: looking closer, for: kitchen; after that:"
                     ' come back. "Stop" stops me'),
        ("de", "nein", "es war nichts gefragt, also mache ich weiter: ich sehe es mir näher an,"
                       ' für: Küche; danach: komm zurück. "Stopp" hält mich an'),
        ("en", "what are you doing", "looking closer, for: kitchen; after that: come back"),
        ("de", "was machst du", "ich sehe es mir näher an, für: Küche; danach: komm zurück"),
    ],
)  # fmt: skip
def test_a_no_to_nothing_tells_what_goes_on_in_the_words_of_the_language(
    session, code, text, answer
):
    answers = dialogue_in(code, session)
    session.ask(["kitchen", Task.COME_BACK])
    session.on_step(replace(standing(0), activity="looking closer"))
    assert answers.typed(text, "ann").said == (answer,)
    assert requests(session) == ["kitchen", Task.COME_BACK] and not session.stopped.is_set()


@pytest.mark.parametrize(
    ("code", "text", "idle", "looking", "doing"),
    [("en", "where are you?", "ask me for something", "look for my place",
      "lost, looking around, for: my place on the map"),
     ("de", "wo bist du?", "verlange etwas", "suche meinen Ort",
      "ich weiß nicht, wo ich bin, und sehe mich um, für: mein Ort auf der Karte")],
)  # fmt: skip
def test_a_lost_robot_says_that_it_looks_for_its_place_only_while_it_does(
    session, code, text, idle, looking, doing
):
    answers = dialogue_in(code, session)
    lost = replace(standing(0).estimate, tracking=Tracking.LOST)
    session.on_step(replace(standing(0), estimate=lost, activity="lost, looking around"))
    assert idle in answers.typed(text, "ann").said[0]
    session.ask([Task.FIND_PLACE])
    assert looking in answers.typed(text, "ann").said[0]
    assert idle not in answers.typed(text, "ann").said[0]
    what = {"en": "what are you doing?", "de": "was machst du?"}[code]
    assert answers.typed(what, "ann").said == (doing,)
    session.stop("ann")
    assert idle in answers.typed(text, "ann").said[0]


def test_a_no_to_nothing_while_nothing_runs_sets_nothing_off(session):
    said = dialogue_in("en", session).typed("no", "ann").said
    assert said == ("then not: nothing was set off",)


@pytest.mark.parametrize(
    ("code", "before", "text", "said"),
    [("en", "go to the bed, then the lamp", "forget about the bed and go to the sofa instead",
      ("called off: bed", "asked for: go to sofa, right now")),
     ("de", "fahr zum Bett, dann zur Lampe", "vergiss das Bett und fahr stattdessen zum Sofa",
      ("abgesagt: Bett", "gefragt: fahr zu Sofa, sofort"))],
)  # fmt: skip
def test_what_is_called_off_and_what_is_asked_for_instead_are_one_line(
    session, code, before, text, said
):
    answers = dialogue_in(code, session)
    answers.typed(before, "ann")
    assert answers.typed(text, "ann").said[:2] == said
    to_do = [task.request for task in session.queue.tasks() if task.outcome is None]
    assert to_do == ["sofa", "lamp"]


@pytest.mark.parametrize(
    ("code", "text", "word"),
    [("en", "go to the second chair", "second"), ("en", "where is the other chair", "other"),
     ("en", "is there a chair in the bedroom", "in the bedroom"),
     ("de", "fahr zum zweiten Stuhl", "zweiten")],
)  # fmt: skip
def test_a_word_that_tells_no_thing_from_another_is_left_out_and_said(
    session, monkeypatch, code, text, word
):
    monkeypatch.setattr(LiveMap, "places", nowhere)
    language, said = load_language(code), dialogue_in(code, session).typed(text, "ann").said
    assert language.lexicon.own("chair") in said[0] and word not in said[0]
    assert language.say("unread", word=word) in said


def test_a_sentence_that_is_too_long_is_refused_in_one_line(http):
    for text in ("next " * 795, "x" * 601, "sofa and " * 61):
        refused = refusal(http.post("/said", json={"text": text}), 422)
        assert "say it in 120 words and 600 characters" in refused, text


@pytest.mark.parametrize(
    "text", ["stop", "st\u200bop", "\uff53\uff54\uff4f\uff50", "stop" + "!" * 5000]
)
def test_a_stop_is_read_before_the_limit_and_before_all_that_wait(session, monkeypatch, text):
    begun, go_on = threading.Event(), threading.Event()
    sentences = dialogue_in("en", session)

    def slow(*_, **__):
        begun.set()
        assert go_on.wait(DEADLINE)
        raise ConfigError("read")

    monkeypatch.setattr(dialogue, "read_typed", slow)

    def ask():
        with pytest.raises(ConfigError):
            sentences.typed("sofa", "bob")

    readers = [threading.Thread(target=ask) for _ in range(3)]
    for reader in readers:
        reader.start()
    assert begun.wait(DEADLINE)
    wait_for(lambda: not sentences._sentences._value)
    with pytest.raises(dialogue.QueueFullError, match="2 sentences wait already"):
        sentences.typed("bed", "ann")
    assert sentences.typed(text, "ann").said
    assert session.stopped.is_set()
    go_on.set()
    for reader in readers:
        reader.join()


@pytest.mark.parametrize("text", ["go to the sofa and then come back", "the study instead, please"])
def test_a_typed_sentence_is_parsed_once(session, monkeypatch, text):
    parsed, grammar = [], load_language("en").grammar

    def parse(*given):
        parsed.append(given)
        return grammar._parsed(*given)

    monkeypatch.setattr(grammar, "_parse", parse)
    assert dialogue_in("en", session).typed(text, "ann").numbers
    assert parsed and len(parsed) == len({*parsed})


def test_a_sentence_that_finds_no_place_to_wait_is_answered_with_429(http, monkeypatch):
    full = dialogue.QueueFullError("2 sentences wait already; say it again in a moment")
    monkeypatch.setattr(dialogue.Dialogue, "_read", raising(full))
    assert http.post("/said", json={"text": "go to the sofa"}).status_code == 429
    assert http.post("/said", json={"text": "stop"}).status_code == 200


@pytest.mark.parametrize(
    ("code", "said"), [("en", "the robot; last seen 2"), ("de", "dem Roboter; zuletzt gesehen 2")]
)
def test_what_was_seen_long_ago_is_said_with_its_time(code, said):
    answer = at(0.0, 3.0)
    [place] = answer.places
    old = replace(place, seen_at="2026-01-02T03:04:05+00:00")
    line = summary(replace(answer, places=(old,)), planar(0.0, 0.0, 0.0), load_language(code))
    assert said in line and re.search(r"2026-01-0[123] \d\d:04$", line)
