"""Simulated devices and homes that stand in for hardware."""
