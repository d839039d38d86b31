"""One episode of a benchmark: its home, its goals, its run, its result."""
