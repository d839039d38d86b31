"""Textures of the surfaces of a home."""
