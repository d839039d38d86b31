"""Pictures as JPEG, PNG and data URIs."""

from __future__ import annotations

import base64

import cv2
import numpy as np
from numpy.typing import NDArray


def jpeg(rgb: NDArray[np.uint8], quality: int = 80) -> bytes:
    """Encode a picture (H, W, 3) with losses; `quality` is from 0 to 100."""
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    done, encoded = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), options)
    assert done
    return encoded.tobytes()


def png(picture: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """Encode a picture (H, W, 3) RGB or (H, W) without losses."""
    if picture.ndim == 3:
        picture = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), np.uint8)
    done, encoded = cv2.imencode(".png", picture)
    assert done
    return encoded.tobytes()


def data_uri(kind: str, content: bytes) -> str:
    """An address that holds its own content; `kind` is the media type."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
