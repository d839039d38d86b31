"""Containers of sound as browsers and recorders write them: which it is, and whether it is whole.

Sources: RIFF WAVE (Microsoft, "Multimedia Programming Interface and Data Specifications 1.0"), EBML
(RFC 8794) and Matroska (RFC 9559), Ogg (RFC 3533), ISO base media files (ISO/IEC 14496-12).
"""

from __future__ import annotations

from enum import StrEnum


class SoundContainer(StrEnum):
    """A container that may be decoded; the value is FFmpeg's name for its demuxer."""

    WAV = "wav"
    WEBM = "matroska"
    OGG = "ogg"
    MP4 = "mp4"


CODECS = {
    SoundContainer.WAV: ("pcm_u8", "pcm_s16le", "pcm_s24le", "pcm_s32le", "pcm_f32le"),
    SoundContainer.WEBM: ("opus",),
    SoundContainer.OGG: ("opus", "vorbis"),
    SoundContainer.MP4: ("aac", "opus"),
}
"""FFmpeg's names of the codecs that are decoded from each container."""
_STREAMED = 0x7FFF_0000
"""A recorder that does not know the size of a WAV in advance writes one from here on, or 0."""
_SEGMENT, _CLUSTER = 0x18538067, 0x1F43B675
"""Elements of Matroska whose content is walked through; their size may be unknown."""
_BROKEN = -1


def container_of(content: bytes) -> SoundContainer | None:
    """The container that the first bytes of a recording name; None for any other."""
    if content[:4] == b"RIFF" and content[8:12] == b"WAVE":
        return SoundContainer.WAV
    if content[:4] == b"\x1a\x45\xdf\xa3":
        return SoundContainer.WEBM
    if content[:4] == b"OggS":
        return SoundContainer.OGG
    if content[4:8] == b"ftyp":
        return SoundContainer.MP4
    return None


def is_whole(container: SoundContainer, content: bytes) -> bool:
    """Whether a recording is as long as the sizes in it say; FFmpeg decodes what is cut short."""
    match container:
        case SoundContainer.WAV:
            return 0 <= _end_of_wav(content) <= len(content)
        case SoundContainer.WEBM:
            return _end_of_webm(content) == len(content)
        case SoundContainer.OGG:
            return _end_of_ogg(content) == len(content)
        case SoundContainer.MP4:
            return _end_of_mp4(content) == len(content)


def _end_of_wav(content: bytes) -> int:
    """Where its samples end; whatever follows them is ignored."""
    place = 12
    while place + 8 <= len(content):
        size = int.from_bytes(content[place + 4 : place + 8], "little")
        if content[place : place + 4] == b"data":
            return len(content) if size == 0 or size >= _STREAMED else place + 8 + size
        place += 8 + size + size % 2
    return _BROKEN


def _end_of_webm(content: bytes) -> int:
    """Where its last element ends."""
    place = 0
    while place < len(content):
        id_length = 9 - content[place].bit_length()
        identity = int.from_bytes(content[place : place + id_length])
        place += id_length
        if id_length > 4 or place >= len(content):
            return _BROKEN
        size_length = 9 - content[place].bit_length()
        if size_length > 8 or place + size_length > len(content):
            return _BROKEN
        unknown = (1 << 7 * size_length) - 1
        size = int.from_bytes(content[place : place + size_length]) & unknown
        place += size_length
        if identity not in (_SEGMENT, _CLUSTER):
            if size == unknown:
                return _BROKEN
            place += size
    return place


def _end_of_ogg(content: bytes) -> int:
    """Where its last page ends."""
    place = 0
    while place < len(content):
        if content[place : place + 4] != b"OggS" or place + 27 > len(content):
            return _BROKEN
        segments = content[place + 27 : place + 27 + content[place + 26]]
        place += 27 + content[place + 26] + sum(segments)
    return place


def _end_of_mp4(content: bytes) -> int:
    """Where its last box ends."""
    place = 0
    while place < len(content):
        size, least = int.from_bytes(content[place : place + 4]), 8
        if size == 0:
            return len(content)
        if size == 1:
            size, least = int.from_bytes(content[place + 8 : place + 16]), 16
        if size < least:
            return _BROKEN
        place += size
    return place
