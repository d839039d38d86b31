"""A server proves that it knows the token, before a client trusts it with what the token opens.

Whoever takes the port of a robot would otherwise be sent the token. A client sends a random
challenge, and the server answers with a keyed hash of it that nobody makes without the token. The
hash covers the address that the client has reached, so that a stranger on another port cannot pass
the challenge on to the robot; and the client then gives not the token but a hash of it that only
this run of the server takes, so that whoever has the port next learns nothing of use.
"""

from __future__ import annotations

import hmac
import json
import secrets
from collections.abc import Sequence
from typing import Annotated

from fastapi import APIRouter, Query, Request

from vizbot.operator.api.answers import TokenProof
from vizbot.operator.api.errors import error_responses

PROOF_PATH = "/proof"
"""This path needs no token: it is asked before the token is given."""
Address = Sequence[object]
"""Host and port of the server's end of a connection."""


def prove(token: str, challenge: str, run: str, address: Address) -> str:
    """The proof that a server knows the token, at the address where a client has reached it."""
    return _keyed_hash(token, "server", challenge, run, *map(str, address[:2]))


def run_token(token: str, run: str) -> str:
    """What a client gives in place of the token; only this run of the server takes it."""
    return _keyed_hash(token, "client", run)


def _keyed_hash(token: str, *parts: str) -> str:
    return hmac.new(token.encode(), json.dumps(parts).encode(), "sha256").hexdigest()


class Credentials:
    """What one run of the server wants of its clients, and how it proves itself to them."""

    def __init__(self, token: str | None) -> None:
        """Draw the name of this run; without a `token` only this machine reaches the robot."""
        self._token = token
        self._run = secrets.token_urlsafe(16)

    @property
    def demanded(self) -> bool:
        """Whether clients must give a token."""
        return self._token is not None

    def admit(self, given: str) -> bool:
        """Whether what a client gives is the token, or stands for it in this run."""
        if not self._token or not given:
            return False
        accepted = self._token, run_token(self._token, self._run)
        return any([hmac.compare_digest(given.encode(), each.encode()) for each in accepted])

    def answer(self, challenge: str, address: Address) -> TokenProof:
        """The answer to a challenge that came to this address."""
        proof = None if self._token is None else prove(self._token, challenge, self._run, address)
        return TokenProof(run=self._run, proof=proof)


def proof_router(credentials: Credentials) -> APIRouter:
    """The route by which a server proves itself."""
    router = APIRouter(tags=["state"])

    @router.get(
        PROOF_PATH, summary="Prove to know the token", responses=error_responses(403, 422, 429)
    )
    def answer(
        request: Request, challenge: Annotated[str, Query(min_length=16, max_length=64)]
    ) -> TokenProof:
        """Prove that this server knows the token, before a client gives it; see docs/api.md."""
        return credentials.answer(challenge, request.scope["server"])

    return router
