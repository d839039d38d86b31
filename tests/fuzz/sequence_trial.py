"""Build maps of spoilt sequences as `map build` does; `python -m` in a process apart."""

import contextlib
import io
import json
import os
import shutil
import sys
import warnings
from functools import partial
from pathlib import Path

import numpy as np

from mapping import map_bundle
from tests.conftest import MeanColours
from tests.fuzz.spoilt_sequences import make_strange, spoil, write_sequence
from tests.fuzz.trial import Allowed, Spoilt, try_one
from tests.helpers.failing import raising
from vizbot.commands import map as map_commands
from vizbot.commands.options import MapBuildOptions


def build(folder, out):
    with contextlib.redirect_stdout(io.StringIO()) as said:
        map_commands.build(MapBuildOptions(folder, out, force=True, as_json=True))
    json.loads(said.getvalue(), parse_constant=raising(ValueError("NaN or an infinity is no JSON")))
    map_bundle.load(out)


def main(work, seed, count):
    """Try spoilt sequences, every third of them whole but strange.

    Args:
        work: An empty folder.
        seed: What they are drawn from.
        count: How many are drawn.
    """
    warnings.simplefilter("error")
    sys.stderr = os.fdopen(os.dup(2), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libpng writes there of its own accord
    map_commands.open_encoder = lambda *_: MeanColours()  # it is not what is tried
    good = [work / "associated", work / "listed"]
    with contextlib.redirect_stderr(io.StringIO()):
        for folder in good:
            write_sequence(folder, associated=folder is good[0])
            build(folder, work / "map")
    for number in range(count):
        folder, out = work / "spoilt", work / "spoilt map"
        shutil.copytree(good[number % 2], folder)
        way = make_strange if number % 3 == 0 else spoil
        rng = np.random.default_rng((seed, number))
        spoilt = Spoilt(f"{way.__name__} {seed} {number}", Allowed.ANY, partial(way, rng=rng))
        spoilt.spoil(folder)
        try_one(spoilt, partial(build, folder, out))
        shutil.rmtree(folder)
        shutil.rmtree(out, ignore_errors=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
