"""Has a running robot obey commands, typed or spoken."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot

from vizbot.core.home_vocabulary import ROOMS
from vizbot.core.observer import Outcome
from vizbot.core.types import Charging, Tracking
from vizbot.objectnav.tasks import FARTHEST, ShortMove, Task, Waypoint
from vizbot.operator.language.command import (
    All,
    Ask,
    Cancel,
    ComeBack,
    Command,
    Decline,
    Dock,
    Explore,
    GoOn,
    HowMany,
    KeepOut,
    Mission,
    Move,
    No,
    Stop,
    Topic,
    WhereIs,
    Yes,
    task_requests,
)
from vizbot.operator.language.language import ENGLISH, Language
from vizbot.operator.language.lexicon import singulars
from vizbot.operator.session.live_map import LiveMap
from vizbot.operator.session.session import OperatorSession
from vizbot.operator.session.task_queue import QueuedTask
from vizbot.operator.session.verdicts import ApproachedCandidate

_CHARGES = (Charging.RECONDITIONING, Charging.FULL_CHARGING, Charging.TRICKLE)
_COMMANDS: Mapping[Task, Mission] = {
    Task.EXPLORE: Explore(),
    Task.COME_BACK: ComeBack(),
    Task.DOCK: Dock(),
}
_MOST_NAMES = 8
"""Names of what is seen that are said at once."""


@dataclass(frozen=True, slots=True)
class Reply:
    """What the robot answers.

    Attributes:
        said: Lines to be shown.
        question: Asked back before anything is done; None without a doubt.
        meant: What to say for yes to that question; None without one.
        place: x, y in `map` of what was asked for [m]; None where it is not on the map, or nothing
            was asked for.
        heard: The words, where they were spoken; None where they were typed.
        numbers: Of the tasks that it asked for, in order.
    """

    said: tuple[str, ...]
    question: str | None = None
    meant: str | None = None
    place: tuple[float, float] | None = None
    heard: str | None = None
    numbers: tuple[int, ...] = ()


class Dispatcher:
    """Obeys one running robot's operators; safe to use from several threads."""

    def __init__(
        self, session: OperatorSession, live_map: LiveMap, language: Language = ENGLISH
    ) -> None:
        self._session = session
        self._live_map = live_map
        self._language = language
        self._say, self._own = language.say, language.lexicon.own

    def obey(
        self, command: Command, who: str, *, at_once: bool = False, stops: int | None = None
    ) -> Reply:
        """Do what a command asks for, or answer it.

        The goals of `command` are in the encoder's words. With `at_once` what is running gives way;
        `stops` was the session's when the command was given, where that was a while ago.

        Raises:
            VizbotError: too much is asked for, the robot was stopped since, or it is too busy.
        """
        say = self._say
        match command:
            case Stop():
                self._session.stop(who)
                return Reply((say("stopped"),))
            case WhereIs(goal):
                return self._where(goal)
            case HowMany(goal):
                return Reply((self._how_many(goal),))
            case Ask(topic):
                return Reply((self._about(topic),))
            case Cancel(goal, after):
                cancelled = self._cancelled(goal, who)
                if after is None:
                    return Reply((cancelled,))
                reply = self._ask_for(after, at_once, stops)
                return replace(reply, said=(cancelled, *reply.said))
            case KeepOut(goal):
                return Reply((self._kept_out(goal),))
            case GoOn():
                return Reply((self._going_on(),))
            case Yes() if self._session.question is not None:
                return Reply((self._going_on(),))
            case No() if self._session.question is not None:
                return Reply((say("stays"),))
            case Yes() | No() if self._session.awaits_verdict:
                return self._judged(isinstance(command, Yes), who)
            case Yes() | No() if (candidate := self._session.candidate) is not None:
                return self._judged_candidate(candidate, isinstance(command, Yes), who)
            case Yes():
                return Reply((say("nothing_asked"),))
            case No():
                runs = bool(self._to_do())
                return Reply((say("no_running", task=self._task()) if runs else say("no_then"),))
            case Decline(reason):
                return Reply((say(reason.value, most=FARTHEST),))
        return self._ask_for(command, at_once, stops)

    def _ask_for(self, command: Mission, at_once: bool, stops: int | None) -> Reply:
        tasks = self._session.ask(task_requests(command), at_once=at_once, stops=stops)
        numbers = tuple(task.number for task in tasks)
        if isinstance(command, All):
            said = self._say("asked_all", goal=self._own(command.goal))
            return Reply((said, self._say("one_of_all")), numbers=numbers)
        text = self._language.grammar.text(command, at_once, own=self._own)
        return Reply((self._say("asked", text=text),), numbers=numbers)

    def _judged(self, confirmed: bool, who: str) -> Reply:
        """A yes or no after an arrival says whether that is the goal."""
        tasks = self._session.judge(confirmed=confirmed, who=who)
        said = tuple(self._say("searching_on", goal=self._name(task)) for task in tasks)
        numbers = tuple(task.number for task in tasks)
        return Reply(said or (self._say("confirmed"),), numbers=numbers)

    def _judged_candidate(self, candidate: ApproachedCandidate, confirmed: bool, who: str) -> Reply:
        """A yes or no while the robot approaches a candidate says whether to go there."""
        self._session.judge_candidate(candidate.number, confirmed=confirmed, who=who)
        answer = "going_there" if confirmed else "searching_on"
        return Reply((self._say(answer, goal=candidate.goal),))

    def _where(self, goal: str) -> Reply:
        answer = self._live_map.places(goal)
        located = answer.outcome is Outcome.LOCATED
        place = answer.places[0].position[:2] if located else None
        named = replace(answer, text=self._own(answer.text))
        return Reply((self._live_map.summary(named, self._language),), place=place)

    def _how_many(self, goal: str) -> str:
        count = self._live_map.count(goal)
        answer = {0: "how_many_none", 1: "how_many_one"}.get(count, "how_many")
        return self._say(answer, goal=self._own(goal), count=count)

    def _cancelled(self, goal: str, who: str) -> str:
        called_off = self._session.call_off(self._same_goals(goal), who)
        if not called_off:
            return self._say("cancelled_none", goal=self._own(goal))
        return self._say("cancelled", goals=", ".join(map(self._own, called_off)))

    def _same_goals(self, goal: str) -> list[str]:
        """The texts in the queue that mean the same as a goal."""

        def plain(text: str) -> set[str]:
            words = self._language.grammar.without_article(text)
            return {*singulars(words), *singulars(self._language.lexicon.read(words).words)}

        texts = [task.text for task in self._session.queue.tasks() if task.outcome is None]
        return [text for text in texts if plain(text) & plain(goal)]

    def _kept_out(self, goal: str) -> str:
        size = self._live_map.keep_out_of(goal)
        if size is None:
            return self._say("kept_out_none", goal=self._own(goal))
        width, depth = size
        return self._say("kept_out", goal=self._own(goal), width=width, depth=depth)

    def _going_on(self) -> str:
        waiting, asked = self._to_do(), self._session.question is not None
        if not (waiting or asked):
            return self._say("going_on_none")
        self._session.go_on()
        if asked:
            return self._say("going_on_asked")
        return self._say("going_on", goal=waiting[0])

    def _to_do(self) -> Sequence[str]:
        """The tasks that are not over: the running one first."""
        tasks = self._session.queue.tasks()
        return [self._name(task) for task in tasks if task.outcome is None and not task.called_off]

    def _name(self, task: QueuedTask) -> str:
        """What people call a task."""
        match task.request:
            case str():
                return self._own(task.request)
            case Waypoint(x, y):
                return self._say("a_place", x=x, y=y)
            case ShortMove():
                return self._language.grammar.text(Move((task.request,)))
            case Task.FIND_PLACE:
                return self._say("own_place")
        return self._language.grammar.text(_COMMANDS[task.request])

    def _about(self, topic: Topic) -> str:
        about: Mapping[Topic, Callable[[], str]] = {
            Topic.BATTERY: self._battery,
            Topic.PLACE: self._place,
            Topic.SIGHT: self._sight,
            Topic.TASK: self._task,
        }
        return self._say("help") if topic is Topic.HELP else about[topic]()

    def _battery(self) -> str:
        state = self._session.robot.battery_state()
        if state is None or state.battery is None:
            return self._say("battery_unknown")
        charges = state.charging in _CHARGES
        answer = "battery_charging" if charges else "battery"
        return self._say(answer, percent=100 * state.battery)

    def _place(self) -> str:
        step = self._session.newest_step()
        if step is None:
            return self._say("place_unknown")
        if step.estimate.tracking is Tracking.LOST:
            waits = self._session.stopped.is_set() or self._session.lease.holder is not None
            looks = bool(self._to_do()) and not waits
            return self._say("place_lost" if looks else "place_lost_idle")
        x, y = map(float, step.T_map_base[:2, 3])
        place = self._say("place", distance=hypot(x, y), x=x, y=y)
        room = next((name for name in self._live_map.in_view() if name in ROOMS), None)
        if room is None:
            return place
        return self._say("place_room", place=place, room=self._own(room))

    def _sight(self) -> str:
        names = map(self._own, self._live_map.in_view()[:_MOST_NAMES])
        seen = ", ".join(names)
        return self._say("sight" if seen else "sight_none", names=seen)

    def _task(self) -> str:
        if (who := self._session.lease.holder) is not None:
            return self._say("by_hand", who=who)
        if self._session.stopped.is_set():
            return self._say("task_resting")
        if (question := self._session.question) is not None:
            return self._language.doing(question.text)
        if not (to_do := self._to_do()):
            return self._say("task_idle")
        running, *waiting = to_do
        step = self._session.newest_step()
        activity = self._language.doing("starting" if step is None else step.activity)
        task = self._say("task_running", activity=activity, goal=running)
        if step is not None and step.why:
            task = self._say("task_why", task=task, why=self._language.doing(step.why))
        if not waiting:
            return task
        return self._say("task_waiting", task=task, waiting=", ".join(waiting))
