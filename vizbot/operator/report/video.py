"""A video of a run that any browser plays: VP9 in WebM."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
from av.video.stream import VideoStream
from numpy.typing import NDArray

_OPTIONS = {"deadline": "realtime", "cpu-used": "7", "crf": "38", "b": "0"}


class Video:
    """A file that grows by pictures of one size."""

    def __init__(self, path: Path, width: int, height: int, rate: int) -> None:
        """Begin the file; `rate` is in pictures a second, width and height are even [px]."""
        self._file = av.open(str(path), "w", format="webm")
        self._stream: VideoStream = self._file.add_stream(
            "libvpx-vp9", rate=rate, options=_OPTIONS, width=width, height=height
        )

    def add(self, picture: NDArray[np.uint8]) -> None:
        """Append a picture (H, W, 3) RGB."""
        self._file.mux(self._stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))

    def close(self) -> None:
        """Write what is still in the encoder and finish the file."""
        self._file.mux(self._stream.encode())
        self._file.close()
