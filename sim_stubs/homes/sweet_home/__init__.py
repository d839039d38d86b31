"""Homes that somebody drew in Sweet Home 3D."""
