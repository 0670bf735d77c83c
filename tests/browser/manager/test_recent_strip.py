"""What a vehicle or a machine did in the last half hour, on its card: live, in words, and fit for everybody."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]


@pytest.fixture
def factory(busy: Any) -> str:
    return str(busy.url)


@pytest.mark.parametrize(
    ("width", "theme", "locale", "said"),
    [
        (390, "light", "de-DE", "in den letzten 30 Minuten"),
        (1440, "dark", "es-ES", "en los últimos 30 minutos"),
        (2560, "light", "en-GB", "in the last 30 minutes"),
    ],
)
def test_a_card_says_what_its_vehicle_and_its_machine_did(
    factory: str,
    open_page: OpenPage,
    screenshot: Screenshot,
    width: int,
    theme: str,
    locale: str,
    said: str,
) -> None:
    look = {"viewport": {"width": width, "height": 900}, "color_scheme": theme, "locale": locale}
    page = open_page(f"{factory}/#plant?at=atv:ATV2", **look)
    strip = page.locator(".atv .recent [role=img]")
    expect(strip).to_have_attribute("aria-label", re.compile(rf"ATV\d {said}"))
    # What goes on is in it, and grows; what ends is followed by what comes then.
    expect(strip.locator(".doing").nth(1)).to_be_attached()
    expect(strip.locator(".doing").first).to_have_attribute("title", re.compile(r"\d\d:\d\d:\d\d .+ \(.+\)"))
    # It is audited as it is shown.
    screenshot(page, f"recent-strip-{width}-{theme}-{locale[:2]}")
