"""How a command ends that refuses what it was given."""


def assert_one_line(result, *words):
    """Check exit code 1, nothing on standard output, and one line of errors with these words."""
    code, out, err = result
    assert (code, out, err.count("\n")) == (1, "", 1), err
    assert "Traceback" not in err
    assert all(word in err for word in words), err
