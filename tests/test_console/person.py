"""What a person does on the console, and where."""

from tests.helpers.browsing import box_of


def press(page, *keys):
    for key in keys:
        page.keyboard.press(key)


def ask(page, text):
    page.locator("#goal").fill(text)
    page.keyboard.press("Enter")


def save_map(page, name):
    page.get_by_label("Save this map as").fill(name)
    page.keyboard.press("Enter")


def tasks(robot):
    """What the robot was asked for."""
    return [task.request for task in robot.session.queue.tasks()]


def middle_of(locator):
    """Column, row of the middle of an element on the page."""
    box = box_of(locator)
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def scale_bar(page):
    """Length of the map's scale bar [pixels], found and measured at once: the map is drawn anew."""
    return page.evaluate("document.querySelector('#overlay .scale').getBBox().width")


def fingers_on(page):
    """What puts fingers on the page and moves them: the kind of event, and where they are."""
    touch = page.context.new_cdp_session(page)

    def move(kind, *points):
        at = [{"id": finger, "x": x, "y": y} for finger, (x, y) in enumerate(points)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": at})

    return move
