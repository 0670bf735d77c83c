"""A manager closes a lane on the map, is told what an area would cut off, and opens again."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from dray.plant import default_plant

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PLANT = default_plant()
LANE = ("b3.to-m4-lane", "m4-lane.from-b3")
WHY = "pallet dropped"

PAD_PX = {"left": 12, "right": 12, "top": 10, "bottom": 32}
"""Around the floor, as the map draws it at first (`frontend/src/plant/draw/renderer.ts`)."""

CLICKS = 20
"""A vehicle that stands over the lane is chosen instead of it, and drives on."""


@pytest.fixture(scope="module")
def factory(start_dray) -> Iterator[str]:
    dray = start_dray("--speed", "10", "--seed", "3")
    yield dray.url
    assert dray.stop() == 0, dray.output()


def choose_lane(page: Page, start: str, end: str) -> None:
    """Click on the middle of a lane."""
    box = page.locator("#plant-map").bounding_box()
    assert box is not None
    width_px = box["width"] - PAD_PX["left"] - PAD_PX["right"]
    height_px = box["height"] - PAD_PX["top"] - PAD_PX["bottom"]
    scale = min(width_px / PLANT.width_m, height_px / PLANT.height_m)
    left_px = PAD_PX["left"] + (width_px - PLANT.width_m * scale) / 2
    low_px = PAD_PX["top"] + (height_px + PLANT.height_m * scale) / 2
    a, b = PLANT.nodes[start], PLANT.nodes[end]
    x_px = box["x"] + left_px + (a.x_m + b.x_m) / 2 * scale
    y_px = box["y"] + low_px - (a.y_m + b.y_m) / 2 * scale
    page.mouse.click(x_px, y_px)


def opened(page: Page) -> Locator:
    """The form in which something is closed."""
    page.get_by_role("button", name="Close lanes…").click()
    return page.locator(".pop-sheet:popover-open")


@pytest.mark.slow
def test_a_lane_is_chosen_on_the_map_closed_with_a_reason_and_opened(
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    card = page.locator(".card.closures")
    expect(page.get_by_role("button", name="Close lanes…")).to_be_visible()
    expect(card).to_have_count(0)
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    for _ in range(CLICKS):
        choose_lane(page, *LANE)
        sheet = opened(page)
        what = sheet.get_by_label("What")
        if "m4-lane" in what.locator("option").first.inner_text():
            break
        page.keyboard.press("Escape")
        page.wait_for_timeout(200)
    expect(what.locator("option").first).to_have_text(re.compile("b3|m4-lane"))
    act = sheet.get_by_role("button", name="Close", exact=True)
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
    factory: str, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(factory)
    sheet = opened(page)
    area = next(iter(PLANT.areas.values()))
    sheet.get_by_label("What").select_option(f"area:{area.id}")
    sheet.get_by_label("Reason").fill("cleaning")
    sheet.get_by_role("button", name="Close", exact=True).click()
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
    sheet.get_by_role("button", name="Close", exact=True).click()
    expect(page.locator(".card.closures").get_by_role("listitem")).to_contain_text("0.5 m/s")
    screenshot(page, "closures-slow")


@pytest.mark.slow
def test_it_is_told_in_german_too(factory: str, open_page: OpenPage, screenshot: Screenshot) -> None:
    page = open_page(factory, locale="de-DE")
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
