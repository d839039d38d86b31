import importlib
import subprocess
import sys
import tarfile
import zipfile

import pytest

from tests.helpers.checkout import ROOT
from vizbot.core.errors import DeviceError
from vizbot.operator.api.console_routes import FILES

PACKAGES = {"vizbot", "drivers", "mapping", "nav", "sim_stubs"}


def built(kind, folder):
    """What hatchling makes of the sources."""
    program = f"from hatchling.build import {kind}; import sys; {kind}(sys.argv[1])"
    subprocess.run([sys.executable, "-c", program, str(folder)], cwd=ROOT, check=True)
    (made,) = folder.iterdir()
    return made


def test_the_wheel_ships_the_five_packages_the_page_and_whose_it_is(tmp_path):
    wheel = zipfile.ZipFile(built("build_wheel", tmp_path))
    names = set(wheel.namelist())
    top = {name.split("/")[0] for name in names if ".dist-info" not in name}
    assert top == PACKAGES
    assert "vizbot/operator/page/report.html" in names
    assert {f"vizbot/operator/page/{name}" for name, _ in FILES.values()} <= names
    assert {f"{package}/py.typed" for package in PACKAGES} <= names
    (metadata,) = (wheel.read(name).decode() for name in names if name.endswith("/METADATA"))
    assert "License-File: NOTICE" in metadata
    assert "Author: the vizbot developers" in metadata
    required = [line for line in metadata.splitlines() if line.startswith("Requires-Dist: mujoco")]
    assert all("extra == 'sim'" in line for line in required)


def test_the_sdist_holds_what_belongs_to_the_project(tmp_path):
    with tarfile.open(built("build_sdist", tmp_path)) as sdist:
        top = {name.split("/")[1] for name in sdist.getnames()}
    documents = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", "NOTICE"}
    build_files = {"Makefile", "constraints.txt", "pyproject.toml", ".ci", ".gitignore"}
    folders = {"tests", "docs", "examples", "PKG-INFO", "CITATION.cff"}
    assert top == PACKAGES | documents | build_files | folders


def test_a_missing_realsense_sdk_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    monkeypatch.delitem(sys.modules, "drivers.realsense.sdk", raising=False)
    with pytest.raises(DeviceError, match=r"^the RealSense SDK is not installed: pip install"):
        importlib.import_module("drivers.realsense.sdk")
