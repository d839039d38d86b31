"""Homes drawn in Sweet Home 3D."""
