"""A frame's way through the files is counted, and stays straight."""

from tests.helpers.checkout import ROOT
from tests.tools.frame_way import counts, way_of, ways


def call_through(files):
    """A function that others are called from, from file to file."""
    functions = {}
    for name in set(files):
        source = "def go(rest, functions):\n    rest and functions[rest[0]](rest[1:], functions)\n"
        exec(compile(source, str(ROOT / name), "exec"), space := {})
        functions[name] = space["go"]
    return lambda: functions[files[0]](files[1:], functions)


def test_steps_are_changes_of_file_and_returns_lead_into_one_left_before():
    a, b, c, d = "mapping/a.py", "mapping/b.py", "nav/c.py", "vizbot/perception/d.py"
    _, files = way_of(call_through([a, b, b, c, b, a, d, b]))
    assert files == [a, b, a, d, b]
    assert counts(files) == (4, 2)


def test_a_frame_is_handed_on_without_going_to_and_fro():
    (plain, plain_returns), (keyframe, keyframe_returns) = map(counts, ways())
    assert 10 < plain <= 30 and plain_returns <= 13
    assert 20 < keyframe <= 60 and keyframe_returns <= 41
