"""The part of the API that takes sentences, typed and spoken."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Body, HTTPException
from pydantic import BaseModel, StringConstraints

from vizbot.core.errors import VizbotError
from vizbot.operator.api.map_routes import STRICT, refusals
from vizbot.operator.session.session import SOMEBODY
from vizbot.operator.voice.dialogue import Dialogue

Sentence = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=4000)]
"""Long enough for a mission of twenty goals."""
Name = Annotated[str, StringConstraints(max_length=40)]


class SentenceRequest(BaseModel):
    """What somebody says to the robot."""

    model_config = STRICT

    text: Sentence
    at_once: bool = False
    """What is running ends; else it waits for its turn."""
    who: Name = SOMEBODY


def sentence_router(sentences: Dialogue) -> APIRouter:
    """What answers to sentences."""
    router = APIRouter()

    @router.post("/said")
    def said(sentence: SentenceRequest) -> dict[str, object]:
        """Do what a sentence asks for: go to, where is, come back, dock, stop, or a bare goal.

        Words in double quotes are taken literally. Where the answer holds a `question`, `meant` is
        what to say for yes; `numbers` are those of the tasks in the state.
        """
        if not sentence.text.isprintable():
            raise HTTPException(422, f"{sentence.text!r} holds what is no text")
        with refusals():
            reply = sentences.typed(sentence.text, sentence.who, at_once=sentence.at_once)
        return asdict(reply)

    @router.post("/heard")
    def heard(
        sound: Annotated[bytes, Body(media_type="application/octet-stream")],
        who: Name = SOMEBODY,
    ) -> dict[str, object]:
        """Do what is said in a recording (WAV, WebM, Ogg, ...); answers as `/said`."""
        try:
            return asdict(sentences.spoken(sound, who))
        except VizbotError as error:
            raise HTTPException(503, str(error)) from error

    return router
