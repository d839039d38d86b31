"""What a person does and waits for in a browser."""

import time

PATIENCE = 30.0


def until(page, condition):
    """Wait; meanwhile the browser goes on."""
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        page.wait_for_timeout(20)


def says(page, selector, text):
    page.locator(selector, has_text=text).wait_for()


def take_wheel(page):
    page.get_by_role("button", name="Take the wheel").click()
    page.get_by_role("button", name="Give the wheel back").wait_for()
