"""`vizbot calibrate encoder`: fit the belief's numbers to an encoder, or take a file of them."""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mapping.clip.fitted.calibration import (
    EncoderCalibration,
    calibration_folder,
    encoder_hash,
    keep_calibration,
    read_calibration,
    require_same_encoder,
)
from vizbot.commands.config.discovery import load_settings
from vizbot.commands.options import CalibrateEncoderOptions
from vizbot.commands.progress import BankProgress
from vizbot.config import Config
from vizbot.core.errors import ConfigError
from vizbot.core.files import require_folder
from vizbot.operator.printing import echo
from vizbot.rig import open_encoder, require_encoder

if TYPE_CHECKING:  # its module loads the simulator
    from vizbot.rehearsal.belief_fit.view_list import ListedHome

_EVERY = 10.0
"""Time between two lines of progress [s]."""
_RENDERING = 0.15
"""Time to render a view and to see which places it shows, with any encoder [s]."""


def run(options: CalibrateEncoderOptions) -> None:
    """Fit the numbers and keep them, with a page on how reliable the belief is then.

    With `use` nothing is fitted: that file is kept in place of what would be.

    Raises:
        VizbotError: the simulator or the encoder is missing, the file is no calibration of it,
            nothing can be written, or the encoder tells nothing apart.
    """
    if options.use is not None and options.jar is not None:
        raise ConfigError(f"--use {options.use} renders no homes; leave out --jar {options.jar}")
    config = load_settings(options.config, options.clip)
    taken = None if options.use is None else read_calibration(options.use)
    homes = _homes(options.jar) if taken is None else []
    require_encoder(config.clip, config.device)
    try:
        require_folder(calibration_folder())
    except OSError as error:
        raise ConfigError(
            f"{calibration_folder()} cannot be written ({error.strerror}); set XDG_DATA_HOME"
        ) from error
    if options.use is not None and taken is not None:
        encoder = open_encoder(config.clip, config.device, config.half)
        require_same_encoder(taken, encoder_hash(encoder), encoder.model_id, options.use)
        _keep(taken)
        return
    _fit(config, homes)


def _homes(jar: Path | None) -> list[ListedHome]:
    from vizbot.rehearsal.belief_fit.view_list import list_homes, require_simulator

    require_simulator()
    return list_homes(jar)


def _fit(config: Config, homes: Sequence[ListedHome]) -> None:
    from vizbot.rehearsal.belief_fit.calibration import (
        calibrate_encoder,
        seconds_a_view,
        views_folder,
        views_left,
    )
    from vizbot.rehearsal.belief_fit.view_list import VIEWS_OF_HOME

    encoder = open_encoder(config.clip, config.device, config.half)
    folder = views_folder(encoder_hash(encoder))
    views = VIEWS_OF_HOME * len(homes)
    left = views_left(homes, folder)
    others = sum(each.jar is not None for each in homes)
    without = "" if others else " (--jar sweethome3d.jar adds five)"
    kept = f"; {views - left} are kept from before" if left < views else ""
    echo(
        f"{encoder.model_id} looks at {views:,} views of {len(homes)} homes, {others} of them drawn"
        f" by others{without}: about {_duration(left * (seconds_a_view(encoder) + _RENDERING))}"
        f"{kept}. Ctrl-C keeps what is finished.",
        err=True,
    )
    progress = _Progress(left)
    bank = BankProgress(encoder.model_id)
    fitted = calibrate_encoder(encoder, homes, folder, progress.count, bank)
    _keep(fitted)
    shutil.rmtree(folder, ignore_errors=True)


def _keep(found: EncoderCalibration) -> None:
    file = keep_calibration(found)
    echo(
        f"{found.model_id} is calibrated: what it believes of a place differs from what is true by"
        f" {found.calibration_error:.3f} on average"
    )
    echo(f"written: {file}, and {file.with_suffix('.md').name} beside it on how reliable it is")


class _Progress:
    """Says how far the views are, at most every ten seconds."""

    def __init__(self, of: int, now: Callable[[], float] = time.monotonic) -> None:
        """Begin; `of` views are to be taken, and `now` reads a monotonic clock [s]."""
        self._of, self._now, self._done = of, now, 0
        self._said = now()
        self._first: float | None = None

    def count(self) -> None:
        """Count a view, and say so if the last line is old enough."""
        now = self._now()
        self._done += 1
        if self._first is None:
            self._first = now  # before it a home was drawn, perhaps one whose views are kept
            return
        if self._done < self._of and now - self._said < _EVERY:
            return
        self._said = now
        left = (now - self._first) / (self._done - 1) * (self._of - self._done)
        about = f", about {_duration(left)} left" if self._done < self._of else ""
        echo(f"{self._done} of {self._of} views{about}", err=True)


def _duration(seconds: float) -> str:
    """A time in words: seconds, minutes or hours."""
    if seconds < 90.0:
        return f"{math.ceil(seconds)} s"
    if seconds < 5400.0:
        return f"{math.ceil(seconds / 60.0)} min"
    return f"{seconds / 3600.0:.1f} h"
