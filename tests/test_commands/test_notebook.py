"""The notebook of the examples runs from its first cell to its last."""

import json
import os
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from vizbot.rehearsal.stub import realsense

pytestmark = pytest.mark.slow

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "map_a_recording.ipynb"


def test_the_notebook_maps_a_recording_asks_it_and_draws_the_answer(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    (tmp_path / "runs").mkdir()
    realsense("0", tmp_path / "runs" / "room.db3", 2.0)
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    names = {}
    for cell in cells:
        assert not cell.get("outputs"), "results of somebody's machine"
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    told = [line for line in capsys.readouterr().out.splitlines() if "%" in line]
    assert {line.split()[0] for line in told} == set(names["TEXTS"])
    figure = cv2.imdecode(np.frombuffer(names["figure"]._repr_png_(), np.uint8), cv2.IMREAD_COLOR)
    assert figure.shape == names["figure"].rgb.shape
    assert len(np.unique(figure.reshape(-1, 3), axis=0)) > 1, "neither seen nor unseen places"
