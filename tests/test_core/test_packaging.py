import importlib
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib.metadata import PackageNotFoundError, distribution

import pytest

from tests.helpers.checkout import ROOT
from vizbot.core.errors import DeviceError
from vizbot.operator.api.console_routes import FILES

PACKAGES = {"vizbot", "drivers", "mapping", "nav", "sim_stubs"}
WEIGHTS = {".bin", ".gguf", ".onnx", ".pt", ".pth", ".safetensors", ".tflite"}


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


@pytest.mark.slow
def test_the_sdist_holds_what_belongs_to_the_project(tmp_path):
    with tarfile.open(built("build_sdist", tmp_path)) as sdist:
        top = {name.split("/")[1] for name in sdist.getnames()}
    documents = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", "NOTICE"}
    build_files = {"Makefile", "constraints.txt", "pyproject.toml", ".ci", ".gitignore"}
    build_files |= {"pip.lock", "requirements.lock", "development.lock", "torch.lock"}
    folders = {"benchmarks", "training", "tests", "docs", "examples", "PKG-INFO", "CITATION.cff"}
    assert top == PACKAGES | documents | build_files | folders


def locked(name):
    """Versions and hashes by package; one of several versions where markers choose."""
    pinned, package = {}, ""
    for line in (ROOT / name).read_text().splitlines():
        if match := re.match(r"([a-z0-9._-]+)==([^\s;]+)", line):
            package = match[1]
            versions, hashes = pinned.setdefault(package, (set(), []))
            versions.add(match[2])
        hashes += re.findall(r"--hash=sha256:([0-9a-f]{64})\b", line)
    return pinned


def test_everything_but_pytorch_and_what_it_brings_is_locked_by_hash():
    by_hash = locked("pip.lock") | locked("requirements.lock") | locked("development.lock")
    by_version = locked("torch.lock")
    assert [name for name, (_, hashes) in by_hash.items() if not hashes] == []
    assert "torch" in by_version and not set(by_hash) & set(by_version)
    assert "pip" in by_hash
    ours = ("torch", "triton", "cuda-", "nvidia-")
    assert [name for name in by_version if not name.startswith(ours)] == []


def test_the_locks_hold_the_versions_of_the_constraints_and_every_dependency():
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    wanted = dict(line.split("==") for line in lines if "==" in line)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    groups = project["dependency-groups"]
    needed = [*project["project"]["dependencies"], *groups["build"]]
    needed += project["project"]["optional-dependencies"]["sim"]
    developing = [*needed, *groups["dev"], *groups["page"]]
    for lock, each_needed in (("requirements.lock", needed), ("development.lock", developing)):
        pinned = locked(lock) | locked("torch.lock")
        assert {n: v for n, v in wanted.items() if n in pinned and pinned[n][0] != {v}} == {}
        names = {re.match(r"[A-Za-z0-9._-]+", each)[0] for each in each_needed}
        assert names - set(pinned) == set()


def brings_weights(package):
    """Whether an installed package has weights of a network among its files."""
    try:
        files = distribution(package).files or []
    except PackageNotFoundError:
        return False
    weights = [each for each in files if each.suffix in WEIGHTS]
    return any(each.locate().stat().st_size > 100_000 for each in weights)


def test_every_package_that_brings_weights_is_in_the_notice():
    found = [package for package in locked("development.lock") if brings_weights(package)]
    assert "faster-whisper" in found
    notice = (ROOT / "NOTICE").read_text()
    assert [package for package in found if f"package {package} " not in notice] == []


def test_a_missing_realsense_sdk_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    monkeypatch.delitem(sys.modules, "drivers.realsense.sdk", raising=False)
    with pytest.raises(DeviceError, match=r"^the RealSense SDK is not installed: pip install"):
        importlib.import_module("drivers.realsense.sdk")
