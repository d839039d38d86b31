import logging

from vizbot.operator.session.notifications import log_warnings


def test_people_are_shown_our_warnings_once_and_nobody_elses(session):
    with log_warnings(session):
        logging.getLogger("drivers.realsense.camera").warning(
            "the camera is gone: %s", "plug it in"
        )
        logging.getLogger("vizbot.perception.sensor_reader").error("the camera is gone: plug it in")
        logging.getLogger("mapping.slam.slam").info("tracking")
        logging.getLogger("uvicorn.error").warning("Invalid HTTP request received.")
        logging.getLogger("nav").warning("no way")
    logging.getLogger("nav").warning("nobody listens any more")
    assert [(line.code, line.text) for line in session.log.lines()] == [
        ("warning", "the camera is gone: plug it in"),
        ("warning", "no way"),
    ]
