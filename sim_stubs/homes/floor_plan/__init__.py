"""Rooms, walls, doors and stairs of a home."""
