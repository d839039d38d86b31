import logging
import math
import multiprocessing
import os
import time

import pytest

from benchmarks.harness.workers import in_parallel, processes
from vizbot.core.errors import VizbotError


def described(job, result):
    return f"{job} done"


def test_every_job_comes_back_with_its_result_and_the_time_left_is_said(capfd):
    results = dict(in_parallel(math.sqrt, [1.0, 4.0, 9.0], "roots", described))
    assert results == {1.0: 1.0, 4.0: 2.0, 9.0: 3.0}
    out, err = capfd.readouterr()
    assert out == ""
    assert "roots: 3 of 3, 0 min left | " in err


def test_workers_have_one_thread_each_and_the_caller_keeps_its_own(monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    [(_, threads)] = in_parallel(os.getenv, ["OMP_NUM_THREADS"], "variables", described)
    assert threads == "1"
    assert "OMP_NUM_THREADS" not in os.environ


@pytest.mark.parametrize(("cores", "gigabytes", "jobs"), [(16, 125, 16), (8, 7, 3), (2, 1, 1)])
def test_a_job_runs_on_every_core_that_there_is_memory_for(monkeypatch, cores, gigabytes, jobs):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)))
    sizes = {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": gigabytes * 10**9 // 4096}
    monkeypatch.setattr(os, "sysconf", sizes.get)
    assert processes() == jobs


def warn(_job):
    logging.getLogger("drivers.roomba").warning("asking it to obey again")


def test_what_devices_warn_of_does_not_come_between_the_lines_of_progress(capfd):
    list(in_parallel(warn, [1], "warnings", described))
    assert "obey" not in capfd.readouterr().err


def process_of(_job):
    return os.getpid()


def test_every_job_has_a_process_of_its_own():
    processes = {process for _, process in in_parallel(process_of, range(4), "pids", described)}
    assert len(processes) == 4 and os.getpid() not in processes


@pytest.mark.parametrize("more", [2, 9])
def test_a_caller_that_leaves_early_leaves_no_process_behind(more):
    for _ in in_parallel(time.sleep, [0.0, *more * [600.0]], "naps", described):
        break
    assert multiprocessing.active_children() == []


def test_a_job_that_fails_stops_no_other_and_is_raised_in_the_end():
    finished = []
    with pytest.raises(ValueError):
        for _, result in in_parallel(math.sqrt, [-1.0, 4.0, 9.0], "roots", described):
            finished.append(result)
    assert sorted(finished) == [2.0, 3.0]


def test_a_process_that_is_killed_is_told_in_one_line():
    with pytest.raises(VizbotError, match="a process of exits was killed"):
        list(in_parallel(os._exit, [1], "exits", described))


def test_nothing_is_started_for_nothing():
    assert list(in_parallel(math.sqrt, [], "roots", described)) == []
