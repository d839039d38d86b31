"""Tables of results, as they are printed."""


def rows_in(text):
    """The cells of each row of the tables, heads included."""
    lines = (line for line in text.splitlines() if line.startswith("|"))
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]


def cells(text, first):
    """Of the row of a table that begins with this cell."""
    return next(row[1:] for row in rows_in(text) if row[0] == first)
