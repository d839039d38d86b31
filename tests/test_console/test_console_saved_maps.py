"""Saved maps on the console: shown, renamed, deleted."""

import httpx
import pytest

from mapping import map_bundle
from tests.helpers.browsing import box_of, says, touch_screen, until
from tests.helpers.bundles import bundle_of, names_in


@pytest.fixture
def maps(tmp_path, server):
    """The folder of the saved maps, in which there are two before the page is opened."""
    folder = tmp_path / "vizbot" / "maps"
    for seed, name in enumerate(("attic", "home")):
        map_bundle.save(bundle_of(seed), folder / name)
    return folder


@pytest.fixture
def page(maps, page):
    says(page, "#maps b", "attic")
    return page


def item(page, name):
    return page.locator("#maps li").filter(has=page.locator("b", has_text=name))


def test_each_has_its_picture_its_date_and_says_which_is_in_use(page, maps):
    picture = item(page, "attic").locator("img")
    until(page, lambda: picture.evaluate("image => image.naturalWidth") == 160)
    year = page.evaluate("`${new Date().getFullYear()}`")
    assert year in item(page, "attic").locator("span").text_content()
    assert page.get_by_role("button", name="Delete attic").is_visible()
    page.get_by_role("button", name="Use attic").click()
    page.get_by_role("button", name="Use it").click()
    says(page, "#maps span", ", in use")
    assert item(page, "attic").locator("span").text_content().endswith(", in use")
    assert page.get_by_role("button", name="Delete attic").count() == 0
    assert page.get_by_role("button", name="Delete home").count() == 1


def test_a_map_is_deleted_after_one_question(page, maps, robot):
    page.get_by_role("button", name="Delete attic").click()
    says(page, "#maps-question", "Delete “attic” for good?")
    page.locator("#maps-no").click()
    assert names_in(maps) == ["attic", "home"]
    page.get_by_role("button", name="Delete attic").click()
    page.get_by_role("button", name="Delete it").click()
    says(page, "#maps-said", "“attic” is deleted.")
    item(page, "attic").wait_for(state="detached")
    assert names_in(maps) == ["home"]
    assert robot.session.log.lines()[-1].text == "the map 'attic' is deleted"


def test_a_map_is_renamed_by_keyboard_alone(page, maps):
    page.get_by_role("button", name="Rename attic").press("Enter")
    field = page.get_by_label("New name of attic")
    assert field.evaluate("one => one === document.activeElement && one.selectionEnd === 5")
    page.keyboard.type("../attic")
    page.keyboard.press("Enter")
    says(page, "#maps-said", "Give it a name of letters, digits, spaces and -.")
    field.fill("home")
    page.keyboard.press("Enter")
    says(page, "#maps-said", "Not renamed: there is a map 'home' already; delete it or give")
    field.fill("upper floor")
    page.keyboard.press("Enter")
    says(page, "#maps-said", "“attic” is called “upper floor” now.")
    says(page, "#maps b", "upper floor")
    assert names_in(maps) == ["home", "upper floor"]
    until(page, lambda: page.evaluate("document.activeElement.id") == "Rename-upper floor")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Cancel", exact=True).press("Enter")
    assert page.evaluate("document.activeElement.id") == "Rename-upper floor"


def test_what_others_rename_and_delete_is_seen(page, maps, server):
    httpx.post(f"{server.url}/maps/home/rename", json={"name": "office"}).raise_for_status()
    says(page, "#maps b", "office")
    httpx.delete(f"{server.url}/maps/office").raise_for_status()
    item(page, "office").wait_for(state="detached")


def test_a_damaged_map_is_listed_without_a_picture_and_can_be_deleted(page, maps, server):
    (maps / "home" / "map.json").write_text("{")
    page.reload()
    picture = item(page, "home").locator("img")
    until(page, lambda: picture.evaluate("image => image.complete"))
    assert picture.evaluate("image => image.naturalWidth") == 0
    page.get_by_role("button", name="Delete home").click()
    page.get_by_role("button", name="Delete it").click()
    says(page, "#maps-said", "“home” is deleted.")


def test_on_a_small_phone_all_of_it_fits_in_the_width(open_page, maps, server):
    page = open_page(server.url, **touch_screen(320, 568))
    says(page, "#maps b", "attic")
    page.get_by_role("button", name="Rename attic").tap()
    page.get_by_label("New name of attic").wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    for button in page.locator("#maps button").all():
        box = box_of(button)
        assert box["height"] >= 44 and box["x"] >= 0 and box["x"] + box["width"] <= 320
