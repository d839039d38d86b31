"""What fails: functions in the place of others, and commands that refuse."""


def raising(error):
    """A function that raises an error, whatever it is given."""

    def fail(*_, **__):
        raise error

    return fail


def assert_one_line(result, *words):
    """Check exit code 1, nothing on standard output, and one line of errors with these words."""
    code, out, err = result
    assert (code, out, err.count("\n")) == (1, "", 1), err
    assert "Traceback" not in err
    assert all(word in err for word in words), err
