import pytest

from vizbot.config import Config, load_config, write_config
from vizbot.core.errors import ConfigError
from vizbot.rehearsal.config import RehearsalConfig


def test_what_is_written_is_read_back_the_same(tmp_path):
    config = Config.model_validate({"clip": "ViT-B/32", "mount": {"height": 0.7}})
    write_config(config, tmp_path / "config.toml")
    assert load_config(tmp_path / "config.toml") == config


def test_a_robot_passes_over_the_settings_of_rehearsals_and_keeps_them(tmp_path):
    (tmp_path / "robot.toml").write_text("[world]\nwheel_bse = 0.2\n[sim_camera]\nrate = 5\n")
    config = load_config(tmp_path / "robot.toml")
    write_config(config, tmp_path / "config.toml")
    assert load_config(tmp_path / "config.toml") == config
    with pytest.raises(ConfigError, match=r"no setting world\.wheel_bse; use wheel_base"):
        RehearsalConfig.read(config)


def test_a_rehearsal_writes_every_setting_of_its_own_beside_the_robots(tmp_path):
    given = Config(clip="ViT-B/32", sim_camera={"rate": 5.0})
    config = RehearsalConfig.read(given).within(given)
    write_config(config, tmp_path / "config.toml")
    again = load_config(tmp_path / "config.toml")
    assert again == config and again.clip == "ViT-B/32"
    assert RehearsalConfig.read(again) == RehearsalConfig.read(given)
    assert RehearsalConfig.read(again).sim_camera.rate == 5.0


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ("[mount]\nhieght = 0.7\n", r"no setting mount\.hieght; use height$"),
        ("serial_prot = 1", "there is no setting serial_prot; use serial_port"),
        ("[mount]\nheight = -3.0", "mount.height = -3.0: it must be at least 0.1, in metres"),
        (
            "mount = 3\nhalf = 'x'",
            "half = 'x': it must be true or false.*; mount = 3: it must be a table",
        ),
        ("[realsense.filters]\nnear = 1", "there is no setting realsense.filters.near; use near"),
        ("[[objectnav.waypoint_reaches]]\nmost = 1\ndistance = 1\nextent = 1", "reaches.0.most"),
        ("[roomba.wheels]\nx = 1", "no setting roomba.wheels; use wheel_base"),
        ("device = 'tpu'", "device = 'tpu': it must be cpu, cuda, cuda:1 or auto"),
        ("clip = " + 900 * "[" + 900 * "]", "nested too deep"),
        ("clip = 1" + 5000 * "0", "is not TOML: .*digits"),
        ("height: 0.7", "is not TOML"),
        (
            "[objectnav]\nmax_steps = 1" + 400 * "0" + "\nanswer_probability = 0",
            "answer_probability = 0",
        ),
        ("[perception.clip_mapper]\nscales = [1100]", "scales.0 = 1100: it must be at most"),
        ('"a\\nb" = 1', "there is no setting"),
        # What keeps people safe.
        (
            "[roomba]\ncommand_timeout = 30",
            "roomba.command_timeout = .*0.5 at most, because a robot whose program hangs",
        ),
        ("[roomba]\ncommand_timeout = 1e308", "roomba.command_timeout = .*0.5 at most"),
        ("[roomba]\nsilence_timeout = 0.6", "roomba.silence_timeout = .*0.5 at most, because"),
        ("[roomba]\necho_delay = 1.0", "roomba.echo_delay = .*0.5 at most, because"),
        (
            "[roomba]\necho_tolerance = 0.06",
            "roomba.echo_tolerance = .*beyond 0.05 corrupt commands pass",
        ),
        (
            "[roomba]\nmax_wheel_speed = 0.6",
            "roomba.max_wheel_speed = .*the base accepts 0.5 at most",
        ),
        ("[roomba]\nmax_turn_rate = 5.0", "roomba.max_turn_rate = .*cannot turn faster than 4.3"),
    ],
)
def test_every_wrong_setting_is_told_with_its_value_and_a_remedy(tmp_path, settings, line):
    (tmp_path / "robot.toml").write_text(settings)
    with pytest.raises(ConfigError, match=line) as refusal:
        load_config(tmp_path / "robot.toml")
    assert len(str(refusal.value)) < 500


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ("[perception.clip_mapper]\nscales = [1100]", "scales.0 = 1100: it must be at most"),
        (
            "[[objectnav.waypoint_reaches]]\ndistance = -1\nextent = 1",
            "distance = -1: it must be at least 0.05",
        ),
        ("[perception.clip_mapper]\nscales = []", "scales = []: it has 0 entries"),
        ("[perception.clip_mapper]\npatch_size = 225", "{'patch_size': 225}: scale -1 of"),
        ("[mount]\nheight = 1.5", "robot.toml: the camera's top at 1.55 m is above"),
    ],
)
def test_a_wrong_setting_has_its_true_reason_alone(tmp_path, settings, reason):
    (tmp_path / "robot.toml").write_text(settings)
    with pytest.raises(ConfigError) as refusal:
        load_config(tmp_path / "robot.toml")
    line = str(refusal.value)
    assert reason in line
    assert "should" not in line and "Value error" not in line


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"robot\.toml: No such file"):
        load_config(tmp_path / "robot.toml")


@pytest.mark.parametrize("device", ["auto", "cpu", "cuda", "cuda:1"])
def test_the_devices_of_the_encoder_are_those_that_pytorch_has(device):
    assert Config(device=device).device == device
