"""Faults of a rehearsal: devices and programs that fail on purpose."""
