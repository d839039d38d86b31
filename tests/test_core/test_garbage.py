"""No garbage is collected while a program loads; what it frees later is used again."""

import gc
import subprocess
import sys

import pytest

from vizbot.core.program.garbage import collecting_afterwards


def test_garbage_is_collected_after_the_block_and_not_in_it():
    assert gc.isenabled()
    with collecting_afterwards():
        assert not gc.isenabled()
        with collecting_afterwards():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()


def test_an_error_in_the_block_leaves_collection_on():
    with pytest.raises(ValueError), collecting_afterwards():
        raise ValueError
    assert gc.isenabled()


def test_where_collection_is_off_it_stays_off():
    gc.disable()
    try:
        with collecting_afterwards():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_what_was_loaded_is_never_gone_through_again():
    before = gc.get_freeze_count()
    with collecting_afterwards():
        loaded = [[] for _ in range(1000)]
    assert gc.get_freeze_count() >= before + len(loaded)
    assert not {id(each) for each in gc.get_objects()} & {id(each) for each in loaded}
    gc.unfreeze()


_CODE = """
import resource, threading
from vizbot.core.program.garbage import keep_freed_memory

def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

def use():
    global last
    for _ in range(3):
        before = faults()
        blocks = [bytearray(size << 20) for size in (40, 30, 20)]
        del blocks
        last = faults() - before

{}
thread = threading.Thread(target=use)
thread.start()
thread.join()
print(last)
"""


def _faults(first: str) -> int:
    """Page faults of a thread that uses the same 90 MiB for the third time."""
    run = [sys.executable, "-c", _CODE.format(first)]
    return int(subprocess.run(run, capture_output=True, text=True, check=True).stdout)


def test_memory_that_was_freed_needs_no_new_pages():
    assert _faults("keep_freed_memory()") < 100
    assert _faults("") > 1000
