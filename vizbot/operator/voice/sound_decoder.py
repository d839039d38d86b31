"""Decodes a recording of speech with FFmpeg: a program of its own, which may open nothing.

FFmpeg guesses formats, follows references to files and addresses, and has had faults that end or
hang a program. So it gets the name of one container and of its codecs, no protocol, bounded memory
and processor time, and no further file or socket. The recording comes on standard input; what goes
to standard output is sound (16 bit, one channel, `RATE`), or, with the exit code `REFUSED`, why
there is none.
"""

from __future__ import annotations

import io
import resource
import sys
from itertools import chain

import av

from vizbot.core.program.interpreter import end_when_left
from vizbot.operator.voice.sound_container import CODECS, SoundContainer, is_whole

RATE = 16000
"""Samples a second that Whisper takes."""
REFUSED = 3
UNREADABLE = "holds no sound that can be read; record it again, or as .wav"
_SLOWEST, _FASTEST = 4000, 192_000
"""Samples a second that speech needs, far less of which would become far too many at `RATE`, and
that recorders have."""
_MOST_MEMORY = 512 * 1024 * 1024
"""Address space of the program [bytes]; it starts with a quarter of that."""
_MOST_TIME = 4
"""Of the processor [s]; half a minute of sound takes a tenth of a second."""

_SILENCE = (
    b"RIFF\x34\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x80\x3e\0\0\0\x7d\0\0\x02\0\x10\0"
    b"data\x10\0\0\0" + bytes(16)
)
"""A WAV of 8 samples."""


class _RefusalError(Exception):
    """The recording is not decoded; why, without its name."""


def main(container: str, longest: str) -> None:
    """Decode standard input.

    Args:
        container: What it is in, a `SoundContainer`.
        longest: Length that is decoded at most [s].
    """
    end_when_left(sys.stdout.fileno())
    content = sys.stdin.buffer.read()
    _decoded(_SILENCE, SoundContainer.WAV, 1.0)  # imports what PyAV imports on use
    confine()
    try:
        decoded, code = _decoded(content, SoundContainer(container), float(longest)), 0
    except _RefusalError as refusal:
        decoded, code = str(refusal).encode(), REFUSED
    sys.stdout.buffer.write(decoded)
    sys.stdout.flush()
    sys.exit(code)


def confine() -> None:
    """Bound this process's memory and time, and let it open no more files, sockets and the like."""
    for limit, most in (
        (resource.RLIMIT_AS, _MOST_MEMORY),
        (resource.RLIMIT_CPU, _MOST_TIME),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_NOFILE, 0),
    ):
        resource.setrlimit(limit, (most, most))


def _decoded(content: bytes, container: SoundContainer, longest: float) -> bytes:
    """The sound in a recording.

    Raises:
        _RefusalError: it is cut short, or of a codec or rate that is not decoded.
    """
    if not is_whole(container, content):
        raise _RefusalError("is cut short or empty; record it again")
    codecs, wanted = CODECS[container], 2 * round(longest * RATE)
    sound = bytearray()
    options = {
        "protocol_whitelist": "",
        "format_whitelist": container.value,
        "codec_whitelist": ",".join(codecs),
    }
    resampler = av.AudioResampler("s16", "mono", RATE)
    source = io.BytesIO(content)
    with av.open(
        source, mode="r", format=container.value, options=options, metadata_errors="ignore"
    ) as file:
        stream = file.streams.audio[0]
        if stream.codec_context.name not in codecs:
            raise _RefusalError(UNREADABLE)
        for frame in chain(file.decode(stream), [None]):
            if frame is not None and not _SLOWEST <= frame.sample_rate <= _FASTEST:
                raise _RefusalError(
                    f"has {frame.sample_rate} samples a second, which no speech has; record with"
                    f" {RATE}"
                )
            for piece in resampler.resample(frame):
                sound += bytes(piece.planes[0])[: 2 * piece.samples]
            if len(sound) >= wanted:
                break
    return bytes(sound[:wanted])
