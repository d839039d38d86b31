"""Procedural household objects."""
