"""What a rerun recording holds, read back."""

from rerun.chunk import RrdReader


def rows(path, entity):
    """Every row of an entity, as components by name with `step` and `stamp` [s], oldest first.

    Of two rows of one step the one that was sent later is the one that is shown.
    """
    found = []
    for chunk in RrdReader(path).stream():
        if chunk.entity_path == f"/{entity}" and not chunk.is_static:
            columns = chunk.to_record_batch().to_pydict()
            found += [
                dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
            ]
    for row in found:
        row["stamp"] = row["stamp"].total_seconds()
    found.sort(key=lambda row: (row["step"], row.pop("rerun.controls.RowId")))
    return found


def entities(path):
    """The names of all that was recorded."""
    return {chunk.entity_path[1:] for chunk in RrdReader(path).stream()}


def at(path, entity, step):
    """What is shown of an entity in a step; None before its first row."""
    return next((row for row in reversed(rows(path, entity)) if row["step"] <= step), None)
