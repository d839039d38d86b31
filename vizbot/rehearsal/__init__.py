"""Rehearsals: opens simulated devices and faults; nothing else of the robot knows the simulator."""
