"""What a client gives to a robot so that it obeys."""

from __future__ import annotations

import hmac
import secrets
import threading

from pydantic import ValidationError

from vizbot.core.errors import ConfigError, DeviceError
from vizbot.operator.api.answers import TokenProof
from vizbot.operator.api.auth import token_path
from vizbot.operator.api.proof import PROOF_PATH, prove, run_token
from vizbot.operator.client.http_link import HttpAnswer, HttpLink

_TIMEOUT = 12.0
"""[s]"""


class Authorization:
    """The token that a person gives, or what stands for the one kept on this machine.

    A kept token is never sent. Once for each client the server proves that it knows it; then what
    stands for it in that run is given.
    """

    def __init__(self, link: HttpLink, given: str | None, kept: str | None) -> None:
        """Create it, sending nothing; a `given` token is sent as it is, else `kept` counts."""
        self._link = link
        self._given = given
        self._kept = kept if given is None else None
        self._proved = False
        self._lock = threading.Lock()

    @property
    def is_kept(self) -> bool:
        """Whether the server must prove itself."""
        return self._kept is not None

    @property
    def is_none(self) -> bool:
        """Whether there is no token to send."""
        return self._given is None and self._kept is None

    def headers(self, *, anew: bool = False) -> dict[str, str]:
        """The headers of a request; `anew` has a server that was launched again prove itself again.

        Raises:
            ConfigError: the token is none that a robot may have.
            DeviceError: nothing answers, or not the robot whose token is kept.
        """
        if self._given is not None and not (self._given.isascii() and self._given.isprintable()):
            raise ConfigError("--token: it holds what no token does; give it as launch shows it")
        with self._lock:
            if self._kept is not None and (anew or not self._proved):
                self._given = self._stand_in(self._kept)
                self._proved = True
            return {} if self._given is None else {"Authorization": f"Bearer {self._given}"}

    def _stand_in(self, kept: str) -> str | None:
        """What to give in place of the kept token; None where the robot wants none."""
        challenge = secrets.token_urlsafe(16)
        path = f"{PROOF_PATH}?challenge={challenge}"
        answer = self._link.exchange("GET", path, None, {}, _TIMEOUT)
        if answer.status == 429:
            raise DeviceError(f"the robot at {self._link.url} has too many requests; ask later")
        shown = _proof(answer)
        if shown is not None and shown.proof is None:
            return None
        if shown is None or not hmac.compare_digest(
            (shown.proof or "").encode("utf-8", "replace"),
            prove(kept, challenge, shown.run, answer.address).encode(),
        ):
            raise DeviceError(
                f"what answers at {self._link.url} is not the vizbot whose token is kept in"
                f" {token_path()}; nothing was sent; give another --url, or that robot's --token"
            )
        return run_token(kept, shown.run)


def _proof(answer: HttpAnswer) -> TokenProof | None:
    """The answer to a challenge; None where it is none."""
    try:
        return TokenProof.model_validate(answer.content) if answer.status == 200 else None
    except ValidationError:
        return None
