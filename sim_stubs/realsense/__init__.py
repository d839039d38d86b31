"""A simulated D435i: what it sees and feels, and how it errs."""
