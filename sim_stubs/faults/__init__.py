"""Faults that a rehearsal can have: devices and programs that fail on purpose."""
