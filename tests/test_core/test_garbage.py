"""No garbage is collected while a program loads, and afterwards as before."""

import gc

import pytest

from vizbot.core.garbage import collecting_afterwards


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
