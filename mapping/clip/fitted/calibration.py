"""Numbers of the belief that were fitted to one encoder, and the files that keep them.

`vizbot calibrate encoder` writes such a file into this user's data folder, under the hash of the
encoder's weights, and a page on how reliable the belief is beside it.
"""

from __future__ import annotations

import hashlib
import json
import logging
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import numpy as np
from pydantic import Field, ValidationError

from mapping.clip.background.kept_bank import KnownWeights
from mapping.clip.places.evidence import Weights
from vizbot.core.errors import ConfigError
from vizbot.core.files import parse_json, read_regular, user_folder, write_whole
from vizbot.core.settings import Settings, causes

if TYPE_CHECKING:  # its module loads torch
    from mapping.clip.encoder import TextEncoder

log = logging.getLogger(__name__)

FORMAT: Final = "vizbot encoder calibration"
LIST_OF_VIEWS = 1
"""Number of the list of views that numbers are fitted to (`vizbot.rehearsal.belief_fit`): it rises
whenever their homes, places or pictures change, and older files are refused then."""
_LARGEST = 256 * 1024
"""Size of a file that is read [bytes]."""
_REMEDY = "`vizbot calibrate encoder` fits them anew"
_Number = Annotated[float, Field(ge=-1000.0, le=1000.0)]
_Twenty = Annotated[tuple[_Number, ...], Field(min_length=20, max_length=20)]
_Phrasing = Annotated[str, Field(max_length=200, pattern=r"^[^{}]*\{\}[^{}]*$")]
_Share = Annotated[float, Field(ge=0.0, le=1.0)]
_Hash = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class ReliabilityBin(Settings):
    """Places that are believed about alike.

    Attributes:
        believed: Their mean probability [1].
        true: Share of them that show what was asked for [1].
        places: Their number.
    """

    believed: _Share
    true: _Share
    places: int = Field(ge=1)


class EncoderCalibration(Settings):
    """What was fitted to one encoder.

    Attributes:
        model_id: Of the encoder.
        encoder_hash: Of its weights (`encoder_hash`).
        views: `LIST_OF_VIEWS` of the program that fitted.
        homes: The homes that the views are of.
        phrasings: Sentences that together stand for a goal (`mapping.clip.fitted.phrasings`); the
            method `paper` takes the bare words, whatever they are.
        scale: Makes, with `bias`, log odds of a cosine.
        bias: Log odds of cosine 0.
        threshold: Cosine above which an image matches a text, for the method `paper`.
        near: Weights of a view from near (`mapping.clip.places.evidence`).
        far: Weights of a view from afar.
        join: Weights of all views of a place (`mapping.clip.places.place_views`).
        reliability: Of places in homes that the weights were not fitted to, from what is believed
            least on.
        calibration_error: Mean difference of what is believed and what is true there, by places
            [1].
    """

    format: Literal["vizbot encoder calibration"] = FORMAT
    model_id: str = Field(min_length=1, max_length=1000)
    encoder_hash: _Hash
    views: int
    homes: tuple[Annotated[str, Field(max_length=200)], ...] = Field(max_length=1000)
    phrasings: tuple[_Phrasing, ...] = Field(min_length=1, max_length=10)
    scale: float = Field(gt=0.0, le=100_000.0)
    bias: float = Field(ge=-100_000.0, le=100_000.0)
    threshold: float = Field(gt=-1.0, lt=1.0)
    near: _Twenty
    far: _Twenty
    join: _Twenty
    reliability: tuple[ReliabilityBin, ...] = Field(max_length=100)
    calibration_error: _Share

    @property
    def log_odds(self) -> tuple[float, float]:
        """Scale and bias, as in `TextEncoder`."""
        return self.scale, self.bias

    @property
    def weights(self) -> Weights:
        """The weights, as arrays."""
        return Weights(*(np.array(each) for each in (self.near, self.far, self.join)))

    @property
    def digest(self) -> str:
        """Digest of all of it (64 hexadecimal digits)."""
        return _checksum(self.model_dump(mode="json"))

    def content(self) -> bytes:
        """The file's content, with its digest."""
        raw = self.model_dump(mode="json") | {"sha256": self.digest}
        return (json.dumps(raw, indent=1) + "\n").encode()


def encoder_hash(encoder: TextEncoder) -> str:
    """Hash (64 hexadecimal digits) of what embeds: of the weights, else of the id for them.

    It takes about a second for each GB of weights.
    """
    if isinstance(encoder, KnownWeights):
        return encoder.weights_hash()
    return hashlib.sha256(encoder.model_id.encode()).hexdigest()


def calibration_folder() -> Path:
    """This user's folder of calibrations, `$XDG_DATA_HOME/vizbot/encoders` (default `~/.local`)."""
    return user_folder("XDG_DATA_HOME", ".local/share") / "encoders"


def calibration_file(hashed: str) -> Path:
    """Where the calibration of an encoder of this hash is kept; it may not be there."""
    return calibration_folder() / f"{hashed[:32]}.json"


def read_calibration(file: Path) -> EncoderCalibration:
    """Read and check a calibration.

    Raises:
        ConfigError: it is not there, torn, no calibration, or of another list of views.
    """
    try:
        raw = parse_json(read_regular(file, _LARGEST))
    except OSError as error:
        raise ConfigError(f"calibration {file}: {error.strerror}; name another file") from error
    except ValueError as error:
        raise ConfigError(f"calibration {file} is torn ({error}); {_REMEDY}") from error
    if not isinstance(raw, dict) or raw.get("format") != FORMAT:
        raise ConfigError(f"{file} is no calibration of an encoder; {_REMEDY}")
    if raw.get("views") != LIST_OF_VIEWS:
        raise ConfigError(
            f"calibration {file} is of list of views {repr(raw.get('views'))[:20]}, not"
            f" {LIST_OF_VIEWS}; {_REMEDY}"
        )
    known = raw.pop("sha256", None)
    if known != _checksum(raw):
        raise ConfigError(f"calibration {file} is torn or was changed by hand; {_REMEDY}")
    try:
        return EncoderCalibration.model_validate(raw)
    except ValidationError as error:
        wrong = causes(error.errors(include_url=False))[0]
        where = ".".join(map(str, wrong["loc"]))[:80]
        raise ConfigError(
            f"calibration {file} is damaged ({where} {wrong['msg']}); {_REMEDY}"
        ) from error


def require_same_encoder(found: EncoderCalibration, hashed: str, model_id: str, file: Path) -> None:
    """Refuse a calibration of another encoder.

    Raises:
        ConfigError: it is of another one.
    """
    if found.encoder_hash != hashed:
        raise ConfigError(
            f"calibration {file} is for {found.model_id} ({found.encoder_hash[:8]}), not for"
            f" {model_id} ({hashed[:8]}); name the encoder that it is for by --clip"
        )


def keep_calibration(fitted: EncoderCalibration) -> Path:
    """Write a calibration and its page into this user's folder, in place of the one before.

    Raises:
        ConfigError: they cannot be written.
    """
    file = calibration_file(fitted.encoder_hash)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(
            f"{file.parent} cannot be made ({error.strerror}); set XDG_DATA_HOME to a folder that"
            " can be written"
        ) from error
    write_whole(file.with_suffix(".md"), reliability_page(fitted).encode())
    write_whole(file, fitted.content())
    return file


def reliability_page(fitted: EncoderCalibration) -> str:
    """How reliable the belief is with these numbers, in Markdown."""
    rows = [
        f"| {each.believed:.1%} | {each.true:.1%} | {each.places} |" for each in fitted.reliability
    ]
    return "\n".join(
        [
            f"# The belief with {fitted.model_id}",
            "",
            f"Fitted to views of {len(fitted.homes)} homes: {', '.join(fitted.homes)}. The table"
            " is of places in the half of them that the weights were not fitted to, by turns.",
            "",
            "| believed | true | places |",
            "|---|---|---|",
            *rows,
            "",
            f"Mean difference of the two, by places: {fitted.calibration_error:.3f}."
            f" Log odds of a cosine c: {fitted.scale:.3g} c {fitted.bias:+.3g}. Threshold of the"
            f" method `paper`: {fitted.threshold:.3f}. A sofa is asked for by:"
            f" {', '.join(each.replace('{}', 'sofa') for each in fitted.phrasings)}.",
            "",
        ]
    )


def kept_calibration(encoder: TextEncoder) -> tuple[EncoderCalibration, Path] | None:
    """The calibration of an encoder in this user's folder, and its file; None without one.

    One that cannot be used counts as none, after a warning in the log.
    """
    try:
        if next(calibration_folder().glob("*.json"), None) is None:
            return None  # so that no weights are hashed where nothing is kept
    except OSError:
        return None
    hashed = encoder_hash(encoder)
    file = calibration_file(hashed)
    if not file.exists():
        return None
    try:
        found = read_calibration(file)
        require_same_encoder(found, hashed, encoder.model_id, file)
    except ConfigError as error:
        log.warning("%s", error)
        return None
    return found, file


def _checksum(raw: dict[str, object]) -> str:
    return hashlib.sha256(json.dumps(raw, sort_keys=True).encode()).hexdigest()
