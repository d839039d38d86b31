"""Which furniture stands in a room, and where."""
