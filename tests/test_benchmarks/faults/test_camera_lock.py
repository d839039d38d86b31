import ctypes

from benchmarks.faults import camera_lock
from benchmarks.faults.camera_lock import measure_camera_lock
from tests.helpers.roomba_rig import wait_for


def test_frames_are_read_while_the_turns_of_others_are_timed():
    lock = measure_camera_lock(1.0)
    assert lock.frames > 3
    for late in (lock.without, lock.opening, lock.reading):
        assert 0.0 <= late.median_ms <= late.p99_ms <= late.max_ms
    assert lock.copy_ms > 0.0
    assert f"while {lock.frames} frames are read" in lock.summary()


def test_a_thread_that_holds_the_lock_is_seen():
    with camera_lock._late_turns() as late:
        wait_for(lambda: late)
        before = len(late)
        ctypes.PyDLL(None).usleep(150_000)
    assert max(late[before:]) > 0.1
