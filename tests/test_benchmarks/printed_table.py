"""Tables of results, as they are printed."""


def cells(text, first):
    """Of the row of a table that begins with this cell."""
    rows = [[cell.strip() for cell in line.split("|")] for line in text.splitlines()]
    return next(row[2:-1] for row in rows if row[1:2] == [first])
