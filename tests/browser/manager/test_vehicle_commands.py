"""A manager tells a vehicle what to do from its card, and pauses an area."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from manager_kit import choose
from playwright.sync_api import Locator, Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


def sheet_of(page: Page, atv: str) -> tuple[Locator, Locator]:
    """The card of a vehicle, and the sheet on which it is told something."""
    choose(page, atv)
    card = page.locator(".card.atv")
    card.get_by_role("button", name="Command…").click()
    return card, page.locator(".pop-sheet:popover-open")


def test_a_vehicle_is_stopped_and_goes_on_only_after_two_acts(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    card, sheet = sheet_of(page, "ATV3")
    expect(sheet.get_by_role("button", name="Resume")).to_be_disabled()
    with quiet.going():
        sheet.get_by_role("button", name="Stop", exact=True).click()
        expect(sheet.get_by_role("status")).to_have_text("ATV3 confirms: Stop.")
        expect(card.locator(".tag")).to_have_text("stopped")
    expect(sheet.get_by_role("button", name="Resume")).to_be_disabled()
    screenshot(page, "commands-stopped")
    half = sheet.get_by_role("button", name=re.compile("^50.*of its speed$"))
    with quiet.going():
        sheet.get_by_role("button", name="Fault is gone").click()
        sheet.get_by_role("button", name="Resume").click()
        expect(card.locator(".tag")).not_to_have_text("stopped")
        half.click()
        expect(half).to_have_attribute("aria-pressed", "true")


@pytest.mark.slow
def test_it_is_taken_out_of_service_with_a_reason_and_put_to_work_again(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    card, sheet = sheet_of(page, "ATV5")
    act = sheet.get_by_role("button", name="Out of service")
    expect(act).to_be_disabled()
    sheet.get_by_label("Reason").fill("brakes")
    sheet.get_by_label(re.compile("Back in")).fill("2")
    with quiet.going():
        act.click()
        expect(card).to_contain_text("out of service")
    screenshot(page, "commands-out")
    with quiet.going():
        sheet.get_by_role("button", name="Put to work again").click()
        expect(card).not_to_contain_text("out of service")
    page.keyboard.press("Escape")
    page.get_by_role("link", name="Audit").click()
    expect(page.get_by_role("row", name=re.compile("ATV5")).first).to_contain_text("vehicle command")


@pytest.mark.slow
@pytest.mark.parametrize(("language", "scheme"), [("en", "light"), ("de", "dark"), ("es", "light")])
def test_an_area_is_paused_and_let_go_on(
    language: str, scheme: str, quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    words = {
        "en": ("Pause an area…", "Reason", "Pause", "Let it go on", "Closed. Vehicles", "Open. Vehicles"),
        "de": ("Bereich anhalten…", "Grund", "Anhalten", "Weiterfahren lassen", "Gesperrt.", "Offen."),
        "es": ("Pausar una zona…", "Motivo", "Pausar", "Dejar seguir", "Cerrada.", "Abierta."),
    }[language]
    page = open_page(quiet.url, locale=language, color_scheme=scheme)
    page.get_by_role("button", name=words[0]).click()
    sheet = page.locator(".pop-sheet:popover-open")
    sheet.get_by_label(words[1]).fill("a visitor fell")
    sheet.get_by_role("button", name=words[2], exact=True).click()
    expect(sheet.get_by_role("status")).to_contain_text(words[4])
    expect(page.locator(".card.closures")).to_contain_text("a visitor fell")
    screenshot(page, f"pause-{language}-{scheme}")
    sheet.get_by_role("button", name=words[3]).click()
    expect(sheet.get_by_role("status")).to_contain_text(words[5])
    expect(page.locator(".card.closures")).to_have_count(0)
