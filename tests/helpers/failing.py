"""Functions that fail, in the place of others."""


def raising(error):
    """A function that raises an error, whatever it is given."""

    def fail(*_, **__):
        raise error

    return fail
