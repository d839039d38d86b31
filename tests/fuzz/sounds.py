"""Recordings as browsers and programs make them."""

import io

import av
import numpy as np

RATE = 48000
"""Samples a second."""
RECORDED = {
    "Chromium": ("webm", "libopus", {"live": "1"}),
    "Firefox": ("ogg", "libopus", {}),
    "Safari": ("mp4", "aac", {"movflags": "frag_keyframe+empty_moov+default_base_moof"}),
    "Chromium in MP4": ("mp4", "libopus", {"movflags": "frag_keyframe+empty_moov"}),
    "a telephone": ("mp4", "aac", {}),
    "a program in Vorbis": ("ogg", "vorbis", {}),
    "a program": ("wav", "pcm_s16le", {}),
}
"""Container, codec and options by who records so."""


def tone(seconds):
    """(N,) int16 samples of 440 Hz."""
    times = np.arange(round(RATE * seconds)) / RATE
    return (10_000 * np.sin(2 * np.pi * 440 * times)).astype(np.int16)


def encoded(container, codec, options=None, seconds=2.0):
    """A tone as FFmpeg writes it."""
    written, samples = io.BytesIO(), np.repeat(tone(seconds), 2)[None]
    with av.open(written, "w", format=container, options=options or {}) as file:
        stream = file.add_stream(codec, rate=RATE, options={"strict": "experimental"})
        stream.layout = "stereo"
        frame = av.AudioFrame.from_ndarray(samples, format="s16", layout="stereo")
        frame.sample_rate = RATE
        for packet in [*stream.encode(frame), *stream.encode(None)]:
            file.mux(packet)
    return written.getvalue()


def recorded_by(who, seconds=2.0):
    """A tone as somebody records it."""
    container, codec, options = RECORDED[who]
    return encoded(container, codec, options, seconds)
