"""A client of the API of a running robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, TypeGuard
from urllib.parse import urlencode

import httpx
from pydantic import BaseModel, ValidationError
from websockets.exceptions import InvalidURI
from websockets.sync.client import ClientConnection, connect

from vizbot.core.closeable import Closeable
from vizbot.core.errors import ConfigError, DeviceError
from vizbot.operator.api.answers import (
    DoubtShown,
    PlacesAnswer,
    RequestTaken,
    RobotState,
    SentenceAnswer,
    StopAnswer,
    TaskNumbers,
    VocabularyAnswer,
)
from vizbot.operator.api.auth import FREE_PATH, stored_token
from vizbot.operator.api.errors import InvalidField
from vizbot.operator.client.http_link import Authorization, HttpLink
from vizbot.operator.client.stop import HERE, no_vizbot

_TIMEOUT = 12.0
"""[s]"""
_OPEN_TIMEOUT = 10.0
"""Until a WebSocket is open [s]."""


class RobotClient(Closeable):
    """A robot that is running somewhere.

    Attributes:
        url: Address of its API.
    """

    def __init__(
        self,
        url: str = HERE,
        token: str | None = None,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        """Create it without sending anything.

        Args:
            url: As `launch` shows it; by default the robot of this machine.
            token: As `launch` shows it, to be sent as it is; empty to send none. Without it the one
                that is kept on this machine serves, with a robot of this machine that proves to
                know it.
            transport: Stands in for the network in tests.

        Raises:
            ConfigError: the URL is not valid, or the kept token cannot be read.
        """
        self._link = HttpLink(url, transport)
        kept = stored_token(url) if token is None else None
        self._authorization = Authorization(self._link, token or None, kept)
        self.url = self._link.url

    def say(self, text: str, who: str, *, at_once: bool = False) -> dict[str, Any]:
        """Have the robot do what a sentence asks for; see the API's `/said`.

        Args:
            text: As typed into the console: a thing alone is a goal, words in quotes are literal.
            who: Who says it.
            at_once: The running task gives way.
        """
        content = {"text": text, "who": who, "at_once": at_once}
        return self._send(SentenceAnswer, "POST", "/said", content)

    def ask(self, texts: Sequence[str], *, at_once: bool = False) -> list[int]:
        """Queue goals, each text literally.

        Returns:
            The numbers of the tasks, as in the state.
        """
        content = {"texts": list(texts), "at_once": at_once}
        answer = self._send(TaskNumbers, "POST", "/goals", content)
        return [int(number) for number in answer["numbers"]]

    def explore(self, *, at_once: bool = False) -> int:
        """Queue an exploration; returns the number of the task."""
        return self._queue("/explore", at_once)

    def come_back(self, *, at_once: bool = False) -> int:
        """Queue the way back to where the run began; returns the number of the task."""
        return self._queue("/come-back", at_once)

    def dock(self, *, at_once: bool = False) -> int:
        """Queue docking; returns the number of the task."""
        return self._queue("/dock", at_once)

    def judge(self, *, confirmed: bool, who: str) -> list[int]:
        """Say whether what it has arrived at last is what it was asked for.

        Args:
            confirmed: Where it is not, the search for the same words goes on at once.
            who: Who says so.

        Returns:
            The number of the search that goes on; none where it was found.
        """
        content = {"confirmed": confirmed, "who": who}
        answer = self._send(TaskNumbers, "POST", "/verdict", content)
        return [int(number) for number in answer["numbers"]]

    def doubt(self, question: str) -> None:
        """Show people, in the log and by a song, that a question waits for an answer."""
        self._send(DoubtShown, "POST", "/doubt", {"question": question})

    def vocabulary(self) -> list[str]:
        """Things and rooms of a household that its map finds."""
        answer = self._send(VocabularyAnswer, "GET", "/map/vocabulary")
        return [str(phrase) for phrase in answer["phrases"]]

    def stop(self, who: str, timeout: float = _TIMEOUT) -> None:
        """Stop it now.

        Args:
            who: Who stops it.
            timeout: Longest wait for the answer [s].
        """
        self._send(StopAnswer, "POST", "/stop", {"who": who}, timeout)

    def resume(self) -> None:
        """Ask its base to obey again after an edge or after it was lifted."""
        self._send(RequestTaken, "POST", "/resume")

    def open_websocket(self, path: str) -> AbstractContextManager[ClientConnection]:
        """Open a WebSocket of the API, which connects when it is entered.

        Raises:
            ConfigError: the robot's address cannot have one.
            DeviceError: nothing answers, or not the robot whose token is kept.
        """
        try:
            return connect(
                f"{self.url.replace('http', 'ws', 1)}{path}",
                additional_headers=self._authorization.headers(),
                proxy=None,
                ssl=self._link.trusted,
                ping_interval=None,
                open_timeout=_OPEN_TIMEOUT,
            )
        except (InvalidURI, ValueError) as error:
            raise ConfigError(f"--url {self.url}: give one like http://robot:8787") from error

    def hint(self, status: int) -> str:
        """Advice to append to the reason of a refusal with this HTTP status; may be empty."""
        if status not in (401, 403) or not self._authorization.is_none:
            return ""
        return "; no token was sent: give --token (that kept here is for this machine alone)"

    def places(self, text: str) -> dict[str, Any]:
        """Places on its map that match a text; see the API's `/map/places`."""
        return self._send(PlacesAnswer, "GET", f"/map/places?{urlencode({'text': text})}")

    def state(self) -> dict[str, Any]:
        """What it does, where it is, what it feels, and its tasks."""
        return self._send(RobotState, "GET", "/state")

    def close(self) -> None:
        """Close the connection."""
        self._link.close()

    def _queue(self, path: str, at_once: bool) -> int:
        """Queue a task that needs no words; returns its number."""
        return int(self._send(TaskNumbers, "POST", path, {"at_once": at_once})["numbers"][0])

    def _send(
        self,
        model: type[BaseModel],
        method: str,
        path: str,
        content: Mapping[str, object] | None = None,
        timeout: float = _TIMEOUT,
    ) -> dict[str, Any]:
        """Send a request and return the answer, which fits `model`.

        Raises:
            DeviceError: no robot answers there, or it refuses.
        """
        is_free = path == FREE_PATH
        headers = {} if is_free else self._authorization.headers()
        answer = self._link.exchange(method, path, content, headers, timeout)
        if answer.status == 401 and self._authorization.is_kept and not is_free:
            headers = self._authorization.headers(anew=True)  # the robot was launched again
            answer = self._link.exchange(method, path, content, headers, timeout)
        if answer.status >= 400 and (reason := _reason(answer.content)):
            hint = self.hint(answer.status)
            raise DeviceError(f"the robot at {self.url} refuses: {reason}{hint}")
        if answer.status >= 300 or not _fits(answer.content, model):
            raise no_vizbot(self.url)
        return answer.content


def _fits(said: object, model: type[BaseModel]) -> TypeGuard[dict[str, Any]]:
    """Whether an answer has every field of a model that a robot always sends, and they fit."""
    sent = [name for name, field in model.model_fields.items() if field.default is not None]
    try:
        model.model_validate(said)
    except ValidationError:
        return False
    return isinstance(said, dict) and all(name in said for name in sent)


def answer_lines(reply: Mapping[str, Any]) -> list[str]:
    """The lines of an answer to `say`; where it has queued tasks, the first says what they are."""
    question = reply.get("question")
    return [str(line) for line in (*reply["said"], *([question] if question else ()))]


def _reason(said: object) -> str:
    """The reason in an answer that refuses, in one line; empty where there is none."""
    detail = said.get("detail", "") if isinstance(said, dict) else ""
    if isinstance(detail, str):
        return detail
    try:
        first = InvalidField.model_validate(detail[0] if isinstance(detail, list) else None)
    except (ValidationError, IndexError):
        return ""
    return f"{'.'.join(str(part) for part in first.loc[1:])}: {first.msg}"
