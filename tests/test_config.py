import pytest

from vizbot.config import Config, load_config, write_config
from vizbot.core.errors import ConfigError


def test_what_is_written_is_read_back_the_same(tmp_path):
    config = Config.model_validate({"clip": "ViT-B/32", "mount": {"height": 0.7}})
    write_config(config, tmp_path / "config.toml")
    assert load_config(tmp_path / "config.toml") == config


def test_a_misspelt_key_is_named(tmp_path):
    (tmp_path / "robot.toml").write_text("[mount]\nhieght = 0.7\n")
    with pytest.raises(ConfigError, match=r"mount\.hieght: Extra inputs are not permitted"):
        load_config(tmp_path / "robot.toml")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"robot\.toml: No such file"):
        load_config(tmp_path / "robot.toml")


def test_text_that_is_not_toml_is_refused(tmp_path):
    (tmp_path / "robot.toml").write_text("height: 0.7")
    with pytest.raises(ConfigError, match="is not TOML"):
        load_config(tmp_path / "robot.toml")
