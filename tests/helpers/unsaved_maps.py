"""What keeps a map from being saved: each cause as a patch, with words of what is said of it."""

import os

from mapping import map_bundle


def a_full_disk(monkeypatch):
    def full(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(map_bundle, "_write_through", full)


def too_large_a_map(monkeypatch):
    monkeypatch.setattr(map_bundle, "MOST_BYTES", 1000)


def a_map_with_a_fault_of_ours(monkeypatch):
    def fail(*_):
        raise IndexError("index 7 is out of bounds")

    monkeypatch.setattr(map_bundle, "_packed", fail)


def too_little_memory(monkeypatch):
    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(map_bundle, "_packed", fail)


NO_MAP = {
    a_full_disk: "No space left on device; give another folder",
    too_large_a_map: "more than 1000: begin a new map",
    a_map_with_a_fault_of_ours: "index 7 is out of bounds",
    too_little_memory: "MemoryError",
}
