"""Ablations: the robot's search with one part taken away, to see what that part is worth."""
