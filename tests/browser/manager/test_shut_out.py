"""A manager shuts a vehicle and a machine out in the panel, and readmits them."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

WHY = "accepts transports and does not move"


@pytest.mark.slow
def test_a_vehicle_is_shut_out_with_a_reason_and_readmitted(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    page.get_by_role("link", name="Fleet").click()
    page.get_by_role("button", name="Show ATV3").or_(page.get_by_role("link", name="Show ATV3")).click()
    card = page.locator(".card.atv")
    card.get_by_role("button", name="Shut out…").click()
    sheet = page.locator(".pop-sheet:popover-open")
    act = sheet.get_by_role("button", name="Shut ATV3 out")
    expect(act).to_be_disabled()
    expect(sheet.get_by_label("Reason")).to_be_focused()
    sheet.get_by_label("Reason").fill(WHY)
    screenshot(page, "shut-out-sheet")
    with quiet.going():
        act.click()
        expect(card).to_contain_text(re.compile(f"Shut out by .+: {WHY}"))
    expect(card.locator(".tag")).to_have_text("shut out")
    expect(card.get_by_role("button", name="Shut out…")).to_have_count(0)
    screenshot(page, "shut-out-card")
    with quiet.going():
        card.get_by_role("button", name="Readmit ATV3").click()
        # It was asked to stop, and stays stopped.
        expect(card.locator(".tag")).to_have_text("stopped")
        expect(card).not_to_contain_text("Shut out by")


@pytest.mark.slow
def test_a_machine_is_shut_out_and_the_alerts_and_the_log_tell_by_whom(
    quiet: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    page = open_page(quiet.url)
    page.get_by_role("link", name="Fleet").click()
    expect(page.get_by_role("row", name=re.compile("ATV2"))).to_be_visible()
    page.evaluate(
        """async (why) => {
            for (const agent of ["M8", "ATV2"]) await fetch(`/api/agents/${agent}/shut-out`, {
                method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify({reason: why}),
            });
        }""",
        WHY,
    )
    expect(page.get_by_role("row", name=re.compile("ATV2"))).to_contain_text(f": {WHY}")
    screenshot(page, "shut-out-fleet")
    page.locator(".alerts-button").click()
    for agent in ("M8", "ATV2"):
        expect(page.get_by_role("row", name=re.compile(agent)).first).to_contain_text("Shut out by")
    screenshot(page, "shut-out-alerts")
    page.get_by_role("link", name="Audit").click()
    expect(page.get_by_role("row", name=re.compile("M8"))).to_contain_text("agent shut out")
    screenshot(page, "shut-out-audit")
