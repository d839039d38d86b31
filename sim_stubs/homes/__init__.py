"""Simulated homes, drawn from a seed."""
