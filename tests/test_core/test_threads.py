import os
import subprocess
import sys

import pytest

from vizbot.core.program.threads import keep_a_core_free, let_threads_sleep


@pytest.fixture(autouse=True)
def nothing_set(monkeypatch):
    for name in ("OMP_WAIT_POLICY", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.setenv(name, "")  # restored in the end, also where the test sets it
        monkeypatch.delenv(name)


def test_threads_that_wait_sleep_unless_the_user_says_otherwise(monkeypatch):
    let_threads_sleep()
    assert os.environ["OMP_WAIT_POLICY"] == "passive"
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
    monkeypatch.setenv("OMP_WAIT_POLICY", "active")
    let_threads_sleep()
    assert os.environ["OMP_WAIT_POLICY"] == "active"


@pytest.mark.parametrize(("cores", "threads"), [(1, "1"), (2, "1"), (4, "3")])
def test_one_core_is_left_to_what_drives(monkeypatch, cores, threads):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)))
    keep_a_core_free()
    assert os.environ["OMP_NUM_THREADS"] == threads


def test_nothing_that_reads_the_variables_loads_before_the_command_line():
    code = "import sys, vizbot.cli.app; print({'numpy', 'torch', 'cv2'} & set(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert loaded.stdout == "set()\n"
