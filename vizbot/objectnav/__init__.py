"""Search for a goal in words: the paper's Algorithm 1 and what surrounds it."""
