"""Talks to a running robot over its API."""

from __future__ import annotations

import ssl
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, Self
from urllib.parse import urlencode

import httpx
from websockets.exceptions import InvalidURI
from websockets.sync.client import ClientConnection, connect

from vizbot.core.errors import ConfigError, DeviceError

_TIMEOUT = 12.0
"""[s]"""


class RobotClient:
    """A robot that is running somewhere.

    Attributes:
        url: Where.
    """

    def __init__(
        self, url: str, token: str | None, transport: httpx.BaseTransport | None = None
    ) -> None:
        """Nothing is sent yet.

        Args:
            url: As `launch` shows it.
            token: Likewise; None to send none, as where the robot asks for none.
            transport: Another way there than the network, for tests.

        Raises:
            ConfigError: that is no address.
        """
        self.url = url.rstrip("/")
        self._token = token
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        # As everywhere on this machine: SSL_CERT_FILE names a certificate that is not public.
        self._trusted = ssl.create_default_context() if self.url.startswith("https:") else None
        try:
            self._http = httpx.Client(
                base_url=self.url,
                headers=headers,
                transport=transport,
                trust_env=False,  # a robot at home is not behind the office's proxy
                verify=self._trusted or True,
            )
        except (httpx.InvalidURL, ValueError) as error:
            raise ConfigError(f"--url {url}: {error}; give one like http://robot:8787") from error

    def say(self, text: str, who: str, *, at_once: bool = False) -> dict[str, Any]:
        """Have it do what a sentence asks for; see the API's `/said`.

        Args:
            text: As typed into the console: a thing alone is a goal, words in quotes are literal.
            who: Says it.
            at_once: What is running gives way.
        """
        return self._send("POST", "/said", {"text": text, "who": who, "at_once": at_once})

    def ask(self, texts: Sequence[str], *, at_once: bool = False) -> list[int]:
        """Ask for goals, each text literally.

        Returns:
            Their numbers, as in the state.
        """
        answer = self._send("POST", "/goals", {"texts": list(texts), "at_once": at_once})
        return [int(number) for number in answer["numbers"]]

    def explore(self, *, at_once: bool = False) -> int:
        """Ask for an exploration; its number."""
        return int(self._send("POST", "/explore", {"at_once": at_once})["numbers"][0])

    def come_back(self, *, at_once: bool = False) -> int:
        """Ask it to go back to where the run began; the number of that."""
        return int(self._send("POST", "/come-back", {"at_once": at_once})["numbers"][0])

    def dock(self, *, at_once: bool = False) -> int:
        """Ask it to go to its dock; the number of that."""
        return int(self._send("POST", "/dock", {"at_once": at_once})["numbers"][0])

    def doubt(self, question: str) -> None:
        """Have it tell people that a question waits for an answer."""
        self._send("POST", "/doubt", {"question": question})

    def vocabulary(self) -> list[str]:
        """Which things and rooms of a household its map finds."""
        return [str(phrase) for phrase in self._send("GET", "/map/vocabulary")["phrases"]]

    def stop(self, who: str, timeout: float = _TIMEOUT) -> None:
        """Have it rest now.

        Args:
            who: Says so.
            timeout: So long its answer is waited for [s].
        """
        self._send("POST", "/stop", {"who": who}, timeout)

    def resume(self) -> None:
        """Have its base obey again after an edge or after it was lifted."""
        self._send("POST", "/resume")

    def open_websocket(self, path: str) -> AbstractContextManager[ClientConnection]:
        """One of the API, connected when entered.

        Raises:
            ConfigError: the robot's address has none.
        """
        headers = {} if self._token is None else {"Authorization": f"Bearer {self._token}"}
        try:
            return connect(
                f"{self.url.replace('http', 'ws', 1)}{path}",
                additional_headers=headers,
                proxy=None,
                ssl=self._trusted,
                ping_interval=None,
            )
        except (InvalidURI, ValueError) as error:
            raise ConfigError(f"--url {self.url}: give one like http://robot:8787") from error

    def hint(self, status: int) -> str:
        """What to add to the reason of a refusal with this HTTP status; empty without anything."""
        if status not in (401, 403) or self._token is not None:
            return ""
        return "; no token was sent: give --token (that kept here is for this machine alone)"

    def places(self, text: str) -> dict[str, Any]:
        """Where on its map is what these words ask for; see the API's `/map/places`."""
        return self._send("GET", f"/map/places?{urlencode({'text': text})}")

    def state(self) -> dict[str, Any]:
        """What it does, where it is, what it feels, what it was asked for."""
        return self._send("GET", "/state")

    def close(self) -> None:
        """Hang up."""
        self._http.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _send(
        self,
        method: str,
        path: str,
        content: Mapping[str, object] | None = None,
        timeout: float = _TIMEOUT,
    ) -> dict[str, Any]:
        """The answer.

        Raises:
            DeviceError: nobody answers there, or the robot refuses.
        """
        try:
            answer = self._http.request(method, path, json=content, timeout=timeout)
            said: dict[str, Any] = answer.json()
        except (httpx.HTTPError, httpx.InvalidURL, ValueError) as error:
            if "CERTIFICATE_VERIFY_FAILED" in str(error):
                raise DeviceError(
                    f"the certificate of {self.url} is not trusted here ({error}); name it:"
                    " SSL_CERT_FILE=robot.pem"
                ) from error
            raise DeviceError(
                f"no robot answers at {self.url} ({error}); start `vizbot launch` there or give"
                " another --url"
            ) from error
        if answer.is_error:
            hint = self.hint(answer.status_code)
            raise DeviceError(f"the robot at {self.url} refuses: {_reason(said)}{hint}")
        return said


def beyond_request(reply: Mapping[str, Any]) -> list[str]:
    """The lines of an answer to `say` that do not only repeat what was asked for."""
    return [str(line) for line in (reply["said"][1:] if reply["numbers"] else reply["said"])]


def _reason(said: Mapping[str, Any]) -> str:
    detail = said.get("detail")
    if isinstance(detail, list) and detail:
        first = detail[0]
        return f"{'.'.join(str(part) for part in first['loc'][1:])}: {first['msg']}"
    return str(detail)
