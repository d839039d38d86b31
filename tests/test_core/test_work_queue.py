import subprocess
import sys
from threading import Event, current_thread

import pytest

from vizbot.core.work_queue import WorkQueue


def test_work_is_done_in_order_beside_the_caller():
    queue, goes_on, done = WorkQueue(8), Event(), []
    queue.put(lambda: goes_on.wait(10.0) and done.append("first"))
    queue.put(lambda: done.append("second"))
    assert done == []
    goes_on.set()
    queue.finish()
    assert done == ["first", "second"]


def test_who_puts_in_more_than_fits_waits_for_the_oldest():
    queue, done = WorkQueue(2), []
    for number in range(20):
        queue.put(lambda number=number: done.append(number))
        assert len(done) >= number - 2
    queue.finish()
    assert done == list(range(20))


def test_the_error_of_work_is_raised_once_and_what_came_behind_it_is_done():
    queue, goes_on, done = WorkQueue(8), Event(), []
    queue.put(lambda: goes_on.wait(10.0) and 1 / 0)
    queue.put(lambda: done.append(1))
    goes_on.set()
    with pytest.raises(ZeroDivisionError):
        queue.finish()
    queue.finish()
    assert done == [1]


INTERRUPTED = """
import threading
from vizbot.core.work_queue import WorkQueue

waited = threading.Event.wait

def interrupted(self, timeout=None):
    waited(self, timeout)
    raise KeyboardInterrupt

threading.Event.wait = interrupted  # for which every start of a thread waits
try:
    queue = WorkQueue(1)
    queue.put(int)
except KeyboardInterrupt:
    print("interrupted")
"""


def test_a_program_ends_whose_interrupt_strikes_while_the_thread_starts():
    program = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], timeout=30, capture_output=True, text=True
    )
    assert (program.returncode, program.stdout) == (0, "interrupted\n")


def test_the_thread_ends_with_its_queue():
    queue, threads = WorkQueue(1), []
    queue.put(lambda: threads.append(current_thread()))
    queue.finish()
    del queue
    threads[0].join(10.0)
    assert not threads[0].is_alive()
