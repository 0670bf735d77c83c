"""Failures in the panel: a person switches a vehicle off on its card and watches another one take over."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from frames import Frames
from manager_kit import choose
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[[Page, str], Path]

WATCHED_S = 120
"""The first transports with a watch are contracted within a minute of the factory's time."""


@pytest.fixture(scope="module")
def factory(start_dray: Callable[..., Any]) -> Iterator[Any]:
    """A factory with one order, so that whoever watches has nothing better to do. Its time stands; a test lets it pass."""
    dray = start_dray("--speed", "10", "--seed", "3", "--no-demand", stepped=True)
    # Everybody has been heard.
    dray.advance(5.0)
    yield dray
    assert dray.stop() == 0, dray.output()


HEARD = 3
"""Heartbeats of a carrier after which whoever watches it has heard of it, too: until then the machine acts alone."""


class Watched:
    """Waits for a transport of material that has just been contracted, with a watch that has begun."""

    def __init__(self) -> None:
        self.task: dict[str, Any] = {}
        self._heard_at_s: set[float] = set()

    def __call__(self, frame: dict[str, Any]) -> bool:
        """Take one frame of the stream."""
        for task in frame.get("tasks", ()):
            carried = task["kind"] == "transport" and not task["goal"] and task["phase"] == "approaching"
            if not self.task and carried and task["secondary"] and task["epoch"] == 1:
                self.task = task
        for atv in frame.get("atvs", ()):
            if self.task and atv["id"] == self.task["primary"]:
                self._heard_at_s.add(atv["seen_at_s"])
        return len(self._heard_at_s) >= HEARD


@pytest.mark.slow
def test_a_vehicle_that_is_switched_off_is_taken_over_from_and_its_load_delivered(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page, watched = open_page("about:blank", visits=factory.url), Watched()
    frames = Frames(page, watched)
    page.goto(factory.url)
    product = factory.ask("/api/products")["items"][0]["id"]
    factory.ask("/api/orders", {"customer": "Hall 3", "items": [{"product": product, "quantity": 20}]})
    frames.wait_while(lambda: factory.advance(1.0), WATCHED_S)
    task, primary = watched.task["id"], watched.task["primary"]

    choose(page, primary)
    card = page.locator(".card.atv")
    expect(card.get_by_role("heading")).to_contain_text(primary)
    card.get_by_role("button", name="Faults").press("Enter")
    page.get_by_role("button", name="Switch off").click()
    expect(card).to_contain_text("switched off")

    factory.advance_until(lambda: factory.ask(f"/api/tasks/{task}")["primary"] != primary, step_s=0.5)
    news = page.get_by_role("log")
    expect(news).to_contain_text(f"over {task} from {primary} after")
    factory.advance(factory.ask(f"/api/atvs/{primary}")["silence"]["lost_after_s"])
    expect(card).to_contain_text("silent")
    screenshot(page, "failover")
    news.get_by_role("button", name=f"over {task} from {primary}").click()
    carriers = page.get_by_role("list", name="Carriers").get_by_role("listitem")
    expect(carriers).to_have_count(2)
    expect(carriers.first).to_contain_text(primary)
    expect(page.locator(".auction .why")).to_contain_text(f"because nothing had been heard of {primary}")

    factory.advance_until(lambda: factory.ask(f"/api/tasks/{task}")["state"] == "delivered")
    expect(page.locator(".auction .card-aside")).to_contain_text("delivered")
    told = factory.ask(f"/api/tasks/{task}")
    assert told["state"] == "delivered"
    assert told["primary"] == told["carriers"][-1]["carrier"] != primary

    choose(page, primary)
    page.get_by_role("button", name="Bring back: switched off").click()
    expect(page.get_by_role("button", name="Bring back: switched off")).to_have_count(0)
    with factory.going():
        expect(card).not_to_contain_text("silent")
    # Of this vehicle: a first try may have left another one as it was.
    assert [each for each in factory.ask("/api/faults")["items"] if primary in each["agents"]] == []


@pytest.mark.slow
def test_a_vehicle_without_wlan_is_seen_over_its_neighbours(
    factory: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory.url)
    choose(page, "ATV2")
    card = page.locator(".card.atv")
    card.get_by_role("button", name="Faults").click()
    page.get_by_role("button", name="Cut its WLAN").click()
    with factory.going():
        expect(card).to_contain_text("mesh via ATV")
    screenshot(page, "mesh")
    page.get_by_role("button", name="Bring back: WLAN cut").click()
    with factory.going():
        expect(card).not_to_contain_text("mesh")
    expect(card).to_contain_text("WLAN")


@pytest.mark.slow
def test_faults_are_reached_and_left_by_keyboard(factory: Any, open_page: OpenPage) -> None:
    page = open_page(factory.url)
    choose(page, "ATV2")
    faults = page.locator(".card.atv").get_by_role("button", name="Faults")
    faults.focus()
    page.keyboard.press("Enter")
    shift = page.get_by_role("button", name="Shift its load")
    expect(shift).to_be_visible()
    page.keyboard.press("Escape")
    expect(shift).to_be_hidden()
    expect(faults).to_be_focused()
