"""Furnishing: which furniture stands in a room, and where."""
