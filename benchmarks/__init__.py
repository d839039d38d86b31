"""Benchmarks: one module a benchmark, and what they share. They know the simulator's truth."""
