"""Load spoilt maps, and use those that load as the program does; `python -m` in a process apart."""

import contextlib
import io
import shutil
import sys
from functools import partial
from pathlib import Path

from mapping.clip.places.belief import Belief
from mapping.clip.places.evidence import fitted_weights
from mapping.clip.scores import Query
from mapping.map_bundle import load, require_map_folder, save, with_background
from tests.conftest import MeanColours
from tests.fuzz.spoilt_maps import spoilt_maps
from tests.fuzz.trial import Allowed, try_one
from tests.helpers.bundles import assert_same, bundle_of
from tests.helpers.scripted_robot import ScriptedBase, wall_pipeline
from vizbot.commands.map import describe
from vizbot.commands.map_export import MapExport, export
from vizbot.config import Config
from vizbot.core.errors import MapError
from vizbot.objectnav.tasks import Task, goal_of
from vizbot.operator.session.place_answers import find_places


def use(folder: Path, bundle) -> None:
    """Describe, export and ask a map, and continue in it from another one."""
    describe(folder, as_json=False)
    for form in ("ply", "npz", "tum"):
        export(MapExport(folder, form, folder.with_name(f"export.{form}"), force=True))
    encoder, config = MeanColours(), Config()
    asked = with_background(bundle, encoder)
    find_places(asked, goal_of(encoder, "red chair"), config.objectnav)
    pipeline = wall_pipeline(ScriptedBase(), encoder, config, (240, 20, 12))
    pipeline.tick(Task.MAP)
    try:
        pipeline.begin_map(bundle)
    except MapError:
        assert pipeline.tick(Task.MAP).map_number == 0
        raise
    for task in (Task.MAP, pipeline.goal("red chair"), Task.EXPLORE):
        assert pipeline.tick(task).map_number == 1
    question = Query(encoder.embed_texts(["red chair"])[0], encoder.log_odds)
    pipeline.map.perception.believe(Belief(question, fitted_weights()))
    pipeline.finish()
    save(pipeline.bundle(), folder.with_name("continued"))
    load(folder.with_name("continued"))


def load_and_use(folder: Path, allowed: Allowed, original) -> None:
    with contextlib.suppress(MapError):
        require_map_folder(folder)
    bundle = load(folder)
    if allowed is Allowed.SAME:
        assert_same(bundle, original)
    else:
        use(folder, bundle)


def main(work: Path, seed: int, flips: int) -> None:
    """Try every spoilt map of a seed in a folder."""
    original = bundle_of(seed, frames=9, model_id="mean-colours")
    good = work / "good"
    save(original, good)
    original = load(good)

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        use(good, load(good))  # compiles what is compiled once
    for number, spoilt in enumerate(spoilt_maps(seed, flips)):
        folder = work / str(number) / "map"
        shutil.copytree(good, folder)
        spoilt.spoil(folder)
        try_one(spoilt, partial(load_and_use, folder, spoilt.allowed, original), MapError)
        shutil.rmtree(folder.parent)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
