"""A frame's way through the files is counted, and stays straight."""

from tests.helpers.checkout import ROOT
from tests.tools.frame_way import Way, way_of, ways


def call_through(files):
    """Functions that call one another from file to file, as a way leads."""
    functions = {}
    for name in set(files):
        space = {}
        source = "def go(rest, functions):\n    rest and functions[rest[0]](rest[1:], functions)\n"
        exec(compile(source, str(ROOT / name), "exec"), space)
        functions[name] = space["go"]
    return functions[files[0]](files[1:], functions)


def test_steps_are_changes_of_file_and_returns_lead_into_one_left_before():
    files = ["mapping/a.py", "mapping/b.py", "mapping/b.py", "nav/c.py", "mapping/a.py"]
    _, way = way_of(lambda: call_through([*files, "vizbot/perception/d.py", "mapping/b.py"]))
    assert way == Way(
        ("mapping/a.py", "mapping/b.py", "mapping/a.py", "vizbot/perception/d.py", "mapping/b.py")
    )
    assert (way.steps, way.returns) == (4, 2)


def test_a_frame_takes_at_most_half_of_the_steps_and_returns_that_it_took():
    plain, keyframe = ways()
    assert plain.files[0] == keyframe.files[0] == "vizbot/perception/perception.py"
    assert plain.steps <= 31 and plain.returns <= 19
    assert keyframe.steps <= 63 and keyframe.returns <= 50
