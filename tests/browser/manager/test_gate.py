"""The delivery gate does not count, or lets a container not in: its card and an alert say why."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from looks import LOCALES
from manager_kit import GoingWall, as_manager, on_map
from open_house import OpenHouse, open_house
from playwright.sync_api import Page, expect

from dray.messages.keys import GATE

from fake_bus import PLANT  # isort: skip - their folder is on the path since `manager_kit` is
from gateway_kit import House  # isort: skip
from heartbeats import station_heartbeat  # isort: skip

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

WHY = "its controller refuses a permit (admitted): BadOutOfRange"

WORDS = {
    "en": "its controller refuses the permit for the container that stands there (admitted: BadOutOfRange)",
    "de": "seine Steuerung weist die Freigabe für den Behälter ab, der dort steht (admitted: BadOutOfRange)",
    "es": "su controlador rechaza el permiso para el contenedor que está allí (admitted: BadOutOfRange)",
}

NAMES = {"en": "Delivery gate", "de": "Versandtor", "es": "Puerta de expedición"}

CUT = """card => [...card.querySelectorAll(".tag")]
    .filter((tag) => tag.getBoundingClientRect().right > card.getBoundingClientRect().right)
    .map((tag) => tag.textContent)"""
"""Marks that the card does not show as a whole."""


@pytest.fixture
def house(sqlite_url: str) -> Iterator[OpenHouse]:
    with open_house(sqlite_url, wall=GoingWall()) as house:
        yield house


@pytest.mark.parametrize("language", LOCALES)
def test_the_card_of_the_gate_and_an_alert_say_why_no_container_comes_in(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot, language: str
) -> None:
    async def beat(inside: House, seq: int, problem: str) -> None:
        inside.bus.say(station_heartbeat(GATE, seq, at_s=3600.0 + seq, problem=problem))

    house.do(lambda inside: beat(inside, 1, WHY))
    page = as_manager(house, open_page, locale=LOCALES[language])
    gate = next(each for each in PLANT.warehouses if each.kind == "delivery")
    box = gate.box
    expect(page.locator("#plant-map canvas").first).to_be_visible()
    page.mouse.click(*on_map(page, PLANT, box.x_m, box.y_m))
    said = page.locator(".card.place .problem")
    expect(said).to_have_text(WORDS[language])
    assert page.locator(".card.place").evaluate(CUT) == []
    # The line of the selection calls it as the map and its card do.
    expect(page.locator(".story dd").get_by_role("button")).to_have_text([gate.name])
    screenshot(page, f"gate-card-{language}")
    page.locator(".alerts-button").click()
    expect(page.locator("main > section").first).to_contain_text(WORDS[language])
    expect(page.locator("main > section").first).to_contain_text(NAMES[language])
    screenshot(page, f"gate-alert-{language}")
    house.do(lambda inside: beat(inside, 2, ""))
    expect(page.locator("main > section").first).not_to_contain_text(WORDS[language])
