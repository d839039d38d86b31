"""Routes of the API that take sentences, typed and spoken."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Body, HTTPException

from vizbot.core.errors import VizbotError
from vizbot.core.normal_text import seen_text
from vizbot.operator.api.answers import SentenceAnswer
from vizbot.operator.api.errors import WITH_BODY, error_responses
from vizbot.operator.api.requests import PersonName, SentenceRequest
from vizbot.operator.language.command_grammar import SentenceTooLongError, require_length
from vizbot.operator.language.dialogue import Dialogue, QueueFullError
from vizbot.operator.session.session import SOMEBODY
from vizbot.operator.voice.recordings import Recordings
from vizbot.operator.voice.sound import SoundError

_SOUND = {"schema": {"type": "string", "format": "binary"}}
_SOUND_TYPES = ("audio/wav", "audio/webm", "audio/ogg", "audio/mp4")
_RECORDING = {"requestBody": {"content": dict.fromkeys(_SOUND_TYPES, _SOUND)}}


def sentence_router(dialogue: Dialogue, recordings: Recordings) -> APIRouter:
    """The routes that take sentences."""
    router = APIRouter(tags=["sentences"])

    @router.post(
        "/said", summary="Type a sentence", responses=error_responses(409, 503, *WITH_BODY)
    )
    def said(sentence: SentenceRequest) -> SentenceAnswer:
        """Do what a sentence asks for: go to, where is, come back, dock, stop, or a bare goal.

        Where the answer holds a `question`, `meant` is what to say for yes. While one sentence is
        read, two more may wait; a stop of up to three words waits for none.
        """
        text = seen_text(sentence.text)
        try:
            if not text.isprintable():
                require_length(text)
                raise HTTPException(422, f"{text!r} holds characters that are no text")
            reply = dialogue.typed(text, sentence.who, at_once=sentence.at_once)
        except SentenceTooLongError as error:
            raise HTTPException(422, str(error)) from error
        except QueueFullError as error:
            raise HTTPException(429, str(error)) from error
        return SentenceAnswer(**asdict(reply))

    @router.post(
        "/heard",
        summary="Speak a sentence",
        responses=error_responses(503, *WITH_BODY),
        openapi_extra=_RECORDING,
    )
    def heard(
        sound: Annotated[bytes, Body(media_type="application/octet-stream")],
        who: PersonName = SOMEBODY,
    ) -> SentenceAnswer:
        """Do what is said in a recording (WAV, WebM, Ogg or MP4); answers as `/said`.

        While one is listened to, two more may wait.
        """
        try:
            return SentenceAnswer(**asdict(recordings.spoken(sound, who)))
        except SoundError as error:
            raise HTTPException(422, str(error)) from error
        except QueueFullError as error:
            raise HTTPException(429, str(error)) from error
        except VizbotError as error:
            raise HTTPException(503, str(error)) from error

    return router
