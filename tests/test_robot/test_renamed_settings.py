"""Settings files of the release before are read, with one line that has the new names."""

import pytest

from vizbot.config import Config, load_config
from vizbot.core.errors import ConfigError
from vizbot.core.renamed_settings import RENAMED

FORMER = [(table, former) for table, names in RENAMED.items() for former in names]
UNUSUAL = {float: lambda value: value * 0.99, int: lambda value: value + 1}


def setting(config, path):
    """The value at a path; of a table the first number in it, with its name behind the path."""
    for name in path.split("."):
        config = getattr(config, name)
    if not hasattr(config, "model_fields_set"):
        return path, config
    names = [name for name in type(config).model_fields if type(getattr(config, name)) in UNUSUAL]
    return f"{path}.{names[0]}", getattr(config, names[0])


@pytest.mark.parametrize(("above", "old"), FORMER)
def test_each_former_name_gives_the_value_and_one_line_with_the_new_one(
    above, old, tmp_path, caplog
):
    former, today = f"{above}.{old}", f"{above}.{RENAMED[above][old]}"
    path, value = setting(Config(), today)
    other = UNUSUAL[type(value)](value)
    table, _, name = path.replace(today, former, 1).rpartition(".")
    (tmp_path / "robot.toml").write_text(f"[{table}]\n{name} = {other}\n")
    assert setting(load_config(tmp_path / "robot.toml"), path)[1] == other
    [line] = [record.getMessage() for record in caplog.records]
    assert f"{former} is {today}" in line and "\n" not in line

    with (tmp_path / "robot.toml").open("a") as file:
        file.write(f"{RENAMED[above][old]} = {value}\n" if path == today else f"[{today}]\n")
    with pytest.raises(ConfigError, match=rf"{former} is {today} today, and both are set"):
        load_config(tmp_path / "robot.toml")


def test_a_name_of_today_needs_no_line(tmp_path, caplog):
    (tmp_path / "robot.toml").write_text("[objectnav]\nanswer_probability = 0.6\n")
    assert load_config(tmp_path / "robot.toml").objectnav.answer_probability == 0.6
    assert not caplog.records


def test_former_names_in_a_table_of_a_former_name_are_read(tmp_path):
    text = "[perception.slam.solid]\ncorners = 21\nshare = 0.4\n"
    (tmp_path / "robot.toml").write_text(text)
    consistency = load_config(tmp_path / "robot.toml").perception.slam.depth_consistency
    assert (consistency.min_corners, consistency.min_share) == (21, 0.4)
