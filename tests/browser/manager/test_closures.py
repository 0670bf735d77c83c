"""A manager closes a lane on the map, is told what an area would cut off, and opens again."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from manager_kit import on_map
from playwright.sync_api import Locator, Page, expect

from dray.plant import default_plant

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PLANT = default_plant()
LANE = ("b3.to-m4-lane", "m4-lane.from-b3")
WHY = "pallet dropped"


def choose_lane(page: Page, start: str, end: str) -> None:
    """Click on the middle of a lane, once the plant was heard of: until then the map has not its last size."""
    expect(page.locator(".alerts-button")).not_to_have_text("Alerts")
    a, b = PLANT.nodes[start], PLANT.nodes[end]
    page.mouse.click(*at_px(page, (a.x_m + b.x_m) / 2, (a.y_m + b.y_m) / 2))


def at_px(page: Page, x_m: float, y_m: float) -> tuple[float, float]:
    return on_map(page, PLANT.file, x_m, y_m)


def opened(page: Page) -> Locator:
    """The form in which something is closed."""
    page.get_by_role("button", name="Close lanes…").click()
    return page.locator(".pop-sheet:popover-open")


@pytest.mark.slow
def test_a_lane_is_chosen_on_the_map_closed_with_a_reason_and_opened(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    card = page.locator(".card.closures")
    expect(page.get_by_role("button", name="Close lanes…")).to_be_visible()
    expect(card).to_have_count(0)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    choose_lane(page, *LANE)
    sheet = opened(page)
    what = sheet.get_by_label("What")
    expect(what.locator("option").first).to_have_text(re.compile("b3|m4-lane"))
    act = sheet.get_by_role("button", name="Close lanes", exact=True)
    expect(act).to_be_disabled()
    sheet.get_by_label("Reason").fill(WHY)
    screenshot(page, "closures-sheet")
    act.click()
    line = card.get_by_role("listitem")
    expect(line).to_contain_text(WHY)
    expect(line).to_contain_text("closed")
    screenshot(page, "closures-map")
    page.get_by_role("link", name="Audit").click()
    expect(page.get_by_role("row", name=re.compile("floor closed"))).to_be_visible()
    page.get_by_role("link", name="Plant").click()
    card.get_by_role("button", name=re.compile("^Open Lane")).click()
    expect(card).to_have_count(0)


@pytest.mark.slow
def test_what_an_area_would_cut_off_is_said_before_it_is_closed(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    sheet = opened(page)
    area = next(iter(PLANT.areas.values()))
    sheet.get_by_label("What").select_option(f"area:{area.id}")
    sheet.get_by_label("Reason").fill("cleaning")
    sheet.get_by_role("button", name="Close lanes", exact=True).click()
    expect(sheet.get_by_role("alert").first).to_contain_text("No vehicle gets to")
    screenshot(page, "closures-warning")
    sheet.get_by_role("button", name="Cancel").click()
    expect(page.locator(".card.closures")).to_have_count(0)
    # Slow cuts nothing off, so it is done at once.
    sheet = opened(page)
    sheet.get_by_label("What").select_option(f"area:{area.id}")
    sheet.get_by_label("How").select_option("slow")
    sheet.get_by_label("Highest speed").fill("0.5")
    sheet.get_by_label("Reason").fill("visitors")
    sheet.get_by_role("button", name="Slow lanes down").click()
    expect(page.locator(".card.closures").get_by_role("listitem")).to_contain_text("0.5 m/s")
    screenshot(page, "closures-slow")


@pytest.mark.slow
def test_a_part_of_the_floor_is_drawn_on_the_map_and_closed(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    opened(page).get_by_role("button", name="Draw on the map…").click()
    strip = page.locator(".draw-strip")
    expect(strip).to_contain_text("Click the corners on the map")
    dock = PLANT.nodes[PLANT.node_of("M5")]
    around = [(-2.0, -2.0), (2.0, -2.0), (2.5, 1.0), (0.0, 2.5)]
    for x_m, y_m in around:
        page.mouse.click(*at_px(page, dock.x_m + x_m, dock.y_m + y_m))
    expect(strip).to_contain_text("4 corners of 12 at most")
    page.locator("#plant-map").focus()
    page.keyboard.press("Enter")
    expect(strip).to_contain_text("5 corners of 12 at most")
    strip.get_by_role("button", name="Take back a corner").click()
    expect(strip).to_contain_text("4 corners of 12 at most")
    sheet = opened(page)
    expect(sheet.get_by_label("What").locator("option").first).to_have_text("Drawn area, 4 corners")
    sheet.get_by_label("Reason").fill("a shelf has fallen over")
    sheet.get_by_role("button", name="Close lanes", exact=True).click()
    expect(sheet.get_by_role("alert").first).to_contain_text("No vehicle gets to M5")
    sheet.get_by_role("button", name="Close lanes all the same").click()
    line = page.locator(".card.closures").get_by_role("listitem").filter(has_text="a shelf has fallen over")
    expect(line).to_contain_text("Drawn area, 4 corners")
    expect(strip).to_have_count(0)
    screenshot(page, "closures-drawn")
    line.get_by_role("button", name=re.compile("^Open Drawn area")).click()
    expect(line).to_have_count(0)


@pytest.mark.slow
def test_it_is_told_in_german_too(quiet: Any, open_page: OpenPage, screenshot: Screenshot) -> None:
    page = open_page(quiet.url, locale="de-DE")
    page.evaluate(
        """async () => {
            const until = new Date(Date.now() + 50 * 60000).toISOString();
            const bodies = [
                {lane: {start: "c2.to-c3", end: "c3.from-c2"}, reason: "Palette liegt dort", until},
                {kind: "one_way", lane: {start: "d2.to-d3", end: "d3.from-d2"}, reason: "Baustelle"},
            ];
            for (const body of bodies) await fetch("/api/closures", {
                method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(body),
            });
        }"""
    )
    card = page.locator(".card.closures")
    expect(card).to_contain_text("Gesperrt")
    expect(card).to_contain_text("Einbahn")
    expect(card).to_contain_text("Palette liegt dort")
    screenshot(page, "closures-german")


@pytest.mark.slow
def test_a_pallet_is_put_on_the_chosen_lane_and_brought_away_again(quiet: Any, open_page: OpenPage) -> None:
    page = open_page(quiet.url)
    button = page.get_by_role("button", name="Something in the way…")
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    expect(button).to_have_count(0)
    choose_lane(page, *LANE)
    button.click()
    sheet = page.locator(".pop-sheet:popover-open")
    back = sheet.get_by_role("button", name="Bring back")
    sheet.get_by_role("button", name="Put a pallet on this lane").click()
    expect(back).to_be_visible()
    expect(sheet.get_by_role("button", name="Put a pallet on this lane")).to_be_disabled()
    back.click()
    button.click()
    expect(sheet.get_by_role("button", name="Put a pallet on this lane")).to_be_enabled()
