"""What `make` installs, for whom, and from where."""

import base64
import hashlib
import json
import re
import subprocess
import sys
import tomllib
import zipfile

import pytest

from tests.helpers.checkout import ROOT

CPU_INDEX = "https://download.pytorch.org/whl/cpu"


def planned(target, *variables, **environment):
    """The lines that `make` would run for a target whose files are all missing."""
    told = subprocess.run(
        ["make", "--dry-run", "--always-make", target, *variables],
        cwd=ROOT, env={"PATH": "/usr/bin:/bin", **environment}, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return told.stdout.splitlines()


def torch_line(*variables, **environment):
    """How PyTorch is installed."""
    lines = planned(".venv/installed", f"PYTHON={sys.executable}", *variables, **environment)
    (line,) = (each for each in lines if each.endswith("-c torch.lock torch"))
    return line


def said_where(folder, package, *variables):
    """What `make` says it will install, where PyTorch needs this package."""
    lines = planned(".venv/installed", f"PYTHON={sys.executable}", *variables)
    (start,) = (i for i, line in enumerate(lines) if line.startswith("if grep"))
    (folder / ".venv").mkdir(exist_ok=True)
    needs = json.dumps({"install": [{"metadata": {"requires_dist": [f"{package}==1"]}}]})
    (folder / ".venv/torch.json").write_text(needs)
    said = subprocess.run(
        ["sh", "-c", "\n".join(lines[start : start + 3])],
        cwd=folder, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    (line,) = said.splitlines()
    return line


@pytest.fixture
def no_driver(tmp_path):
    return (f"NVIDIA_PROC={tmp_path}/none", f"NVIDIA_SMI={tmp_path}/none")


def test_without_an_nvidia_driver_pytorch_comes_without_cuda_and_make_says_so(no_driver, tmp_path):
    assert f" --extra-index-url {CPU_INDEX} " in torch_line(*no_driver)
    said = said_where(tmp_path, "numpy", *no_driver)
    assert "without CUDA, since no NVIDIA driver" in said and "PIP_ARGS" in said
    assert "2 GB on disk" in said and "with CUDA" not in said


def test_a_driver_that_the_kernel_or_its_program_shows_takes_pytorch_as_the_index_has_it(tmp_path):
    kernel = tmp_path / "version"
    kernel.write_text("NVRM version: NVIDIA UNIX x86_64 Kernel Module  580.95.05\n")
    program = tmp_path / "nvidia-smi"
    program.write_text('#!/bin/sh\n[ "$*" = -L ]\n')
    program.chmod(0o755)
    for proc, smi in ((kernel, "none"), (tmp_path / "none", program)):
        shown = (f"NVIDIA_PROC={proc}", f"NVIDIA_SMI={smi}")
        assert "index-url" not in torch_line(*shown)
        said = said_where(tmp_path, "nvidia-cublas", *shown)
        assert "with CUDA, for" in said and "shows an NVIDIA driver" in said
        assert "6 GB on disk" in said


def test_a_program_of_nvidia_that_finds_no_driver_shows_none(tmp_path):
    program = tmp_path / "nvidia-smi"
    program.write_text("#!/bin/sh\necho NVIDIA-SMI has failed\nexit 9\n")
    program.chmod(0o755)
    assert CPU_INDEX in torch_line(f"NVIDIA_PROC={tmp_path}/none", f"NVIDIA_SMI={program}")


@pytest.mark.parametrize("chosen", ["--extra-index-url https://example.org/cu128", ""])
def test_who_names_an_index_is_obeyed(no_driver, chosen):
    by_argument = torch_line(*no_driver, f"PIP_ARGS={chosen}")
    by_environment = torch_line(*no_driver, PIP_ARGS=chosen)
    assert by_argument == by_environment
    assert CPU_INDEX not in by_argument and chosen in by_argument


def wheel(folder, version):
    """A package named torch with nothing in it."""
    told = f"torch-{version}.dist-info"
    metadata = f"Metadata-Version: 2.1\nName: torch\nVersion: {version}\n"
    kind = "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    record = ""
    path = folder / f"torch-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as file:
        for name, text in ((f"{told}/METADATA", metadata), (f"{told}/WHEEL", kind)):
            file.writestr(name, text)
            digest = base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest())
            record += f"{name},sha256={digest.decode().rstrip('=')},{len(text)}\n"
        file.writestr(f"{told}/RECORD", f"{record}{told}/RECORD,,\n")
    return path


def test_the_line_takes_the_build_of_the_index_that_it_names(no_driver, tmp_path):
    (pinned,) = (line for line in locked("torch.lock") if line.startswith("torch=="))
    pinned = pinned.removeprefix("torch==")
    for name, version in (("all", pinned), ("cpu", f"{pinned}+cpu"), ("cpu", "99.0+cpu")):
        folder = tmp_path / name / "torch"
        folder.mkdir(parents=True, exist_ok=True)
        wheel(folder, version)
    for folder in (tmp_path / "all/torch", tmp_path / "cpu/torch"):
        links = "".join(f'<a href="{each.name}">{each.name}</a>' for each in folder.iterdir())
        (folder / "index.html").write_text(f"<!DOCTYPE html><html><body>{links}</body></html>")
    line = torch_line(*no_driver, f"CPU_INDEX={(tmp_path / 'cpu').as_uri()}")
    _, _, arguments = line.partition(" -m pip install ")
    subprocess.run(
        [sys.executable, "-m", "pip", "download", "--no-deps", "--dest", tmp_path / "found",
         "--index-url", (tmp_path / "all").as_uri(), *arguments.split()],
        cwd=ROOT, env={"PATH": "/usr/bin:/bin", "PIP_CONFIG_FILE": "/dev/null"}, check=True,
    )  # fmt: skip
    (taken,) = (tmp_path / "found").iterdir()
    assert taken.name == f"torch-{pinned}+cpu-py3-none-any.whl"


def test_cuda_that_comes_for_want_of_another_index_is_said_before_it_comes(no_driver, tmp_path):
    said = said_where(tmp_path, "nvidia-cublas", *no_driver)
    assert "with CUDA, though no NVIDIA driver is here" in said
    assert f"{CPU_INDEX} cannot be reached" in said
    assert "6 GB on disk" in said and "without" not in said


def test_an_index_that_somebody_named_is_not_said_to_be_out_of_reach(no_driver, tmp_path):
    said = said_where(tmp_path, "nvidia-cublas", *no_driver, "PIP_ARGS=--pre")
    assert said.endswith("PyTorch comes with CUDA")


def test_what_is_looked_up_comes_before_what_is_said_and_that_before_what_takes_long(no_driver):
    lines = planned(".venv/installed", *no_driver)
    parts = ("--dry-run --no-deps --report", "if grep", "-r requirements.lock", "--quiet --retries")
    order = [next(i for i, line in enumerate(lines) if part in line) for part in parts]
    assert order == sorted(order)


def locked(name):
    """Lines of a lock that name a package: `name==version`, and a marker where there is one."""
    lines = (ROOT / name).read_text().splitlines()
    return {line.removesuffix("\\").strip() for line in lines if re.match(r"[a-z0-9]", line)}


def test_the_demo_installs_nothing_that_only_developers_need():
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]
    theirs = {re.match(r"[\w-]+", each)[0] for each in (*groups["dev"], *groups["page"])}
    installed = {line.partition("==")[0] for line in locked("requirements.lock")}
    # A rehearsal draws with MuJoCo and reads meshes with pycollada; GTSAM asks for pytest itself.
    assert theirs & installed <= {"mujoco", "pycollada", "pytest"}
    assert {"ruff", "mypy", "playwright", "rerun-sdk"} <= theirs
    assert not any("development.lock" in line for line in planned("demo"))


def test_checks_and_tests_install_what_they_need_beside_what_the_demo_does():
    without_markers = [
        {line.partition(" ;")[0] for line in locked(name)}
        for name in ("requirements.lock", "development.lock")
    ]
    assert without_markers[0] < without_markers[1]
    for target in ("test", "test-slow", "test-benchmarks", "test-long", "check"):
        installing = " ".join(line for line in planned(target) if " pip install " in line)
        assert "-r requirements.lock" in installing and "-r development.lock" in installing


def test_before_it_installs_make_says_what_how_much_and_how_long():
    (said,) = (line for line in planned(".venv/developed") if re.match("echo .*tests", line))
    assert re.search(r"\d GB.*minute", said), said
