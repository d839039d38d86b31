"""Episodes of a benchmark: the home, the goals, the run, the result."""
