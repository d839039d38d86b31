"""Keyframes, what they show, and the pose graph that joins them."""
