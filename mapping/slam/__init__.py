"""Pose estimation as a whole: tracking, keyframes and loop closure."""
