"""Shared parts of the benchmarks: stored results, keys, tables, workers."""
