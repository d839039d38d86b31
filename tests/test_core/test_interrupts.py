import ctypes

from vizbot.core.interrupts import is_interrupt


def wrapped(error, times):
    for _ in range(times):
        outer = SystemError("returned a result with an exception set")
        outer.__cause__ = error
        error = outer
    return error


def test_an_interrupt_is_known_however_often_compiled_code_wrapped_it():
    for times in range(4):
        assert is_interrupt(wrapped(KeyboardInterrupt(), times))


def test_an_interrupt_is_known_in_imports_and_by_its_name():
    failed = ImportError("initialization failed")
    failed.__cause__ = KeyboardInterrupt()
    assert is_interrupt(failed)
    assert is_interrupt(ctypes.ArgumentError("argument 1: KeyboardInterrupt: "))
    assert not is_interrupt(ctypes.ArgumentError("argument 1: TypeError: wrong type"))
    assert not is_interrupt(ImportError("no such module"))


def test_other_errors_are_none():
    assert not is_interrupt(ValueError("no"))
    assert not is_interrupt(wrapped(ValueError("no"), 2))
    assert not is_interrupt(SystemError("nothing inside"))
