"""Furniture models: from the Sweet Home 3D catalogue, or procedural."""
