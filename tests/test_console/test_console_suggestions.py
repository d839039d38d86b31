"""What the map finds is offered while a person types."""

from tests.helpers.browsing import stand_in, until

PHRASES = ["kitchen", "kitchen cabinet", "red sofa", "sofa"]


def offered(page):
    return page.locator("#suggestions option").evaluate_all("all => all.map(one => one.value)")


def test_the_last_words_are_completed_to_what_the_map_finds(page):
    stand_in(page, "/map/vocabulary", lambda _: {"phrases": PHRASES})
    goal = page.locator("#goal")
    assert goal.get_attribute("list") == "suggestions"
    goal.fill("k")
    until(page, lambda: offered(page) == ["kitchen", "kitchen cabinet"])
    goal.fill("where is the Red s")
    until(page, lambda: offered(page) == ["where is the red sofa", "where is the Red sofa"])
    goal.fill("sofa, then the kitchen")
    until(page, lambda: offered(page) == ["sofa, then the kitchen cabinet"])
    for text in ("asdf", "", "the "):
        goal.fill(text)
        until(page, lambda: offered(page) == [])


def test_a_robot_that_does_not_answer_offers_nothing(page):
    page.route("**/map/vocabulary", lambda route: route.abort())
    page.locator("#goal").fill("kit")
    until(page, lambda: page.locator("#goal").input_value() == "kit")
    assert offered(page) == []
