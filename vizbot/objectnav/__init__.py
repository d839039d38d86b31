"""Search for a goal in words: by belief, or by the paper's Algorithm 1; exploration."""
