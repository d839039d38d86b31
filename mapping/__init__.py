"""Pose estimation, obstacle mapping, CLIP mapping and retrieval."""
