"""The bars of an auction: as long as the prices beside them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from facts_kit import bid, opened
from gateway_kit import House
from heartbeats import events
from looks import LOCALES
from manager_kit import as_manager
from open_house import OpenHouse
from playwright.sync_api import Page, expect

from dray.messages import TransportCost

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

PRICES = {
    "ATV1": TransportCost(20.0, 40.0, 0.4, 0.4, 31.2),
    "ATV2": TransportCost(92.0, 0.0, 0.0, 0.0),
    "ATV3": TransportCost(10.0, 20.0, 8.0, 8.0, 0.2),
}
"""Two of 92 s, one with much waiting and parts of less than half a second; and one of half of it."""

LENGTHS = "all => all.map(bar => [...bar.children].reduce((sum, part) => sum + part.getBoundingClientRect().width, 0))"


@pytest.mark.parametrize(
    ("language", "theme", "reckoned"),
    [
        ("en", "light", "battery reckoned"),
        ("de", "dark", "Batterie errechnet"),
        ("es", "light", "batería calculada"),
    ],
)
def test_each_bar_is_as_long_as_its_price_and_a_reckoned_battery_is_marked(
    house: OpenHouse, open_page: OpenPage, screenshot: Screenshot, language: str, theme: str, reckoned: str
) -> None:
    async def auction(inside: House) -> None:
        bids = (
            bid(atv, cost.total_s, cost=cost, battery_reckoned=atv == "ATV2") for atv, cost in PRICES.items()
        )
        for event in events("M1", opened(), *bids):
            inside.bus.say(event)

    house.do(auction)
    page = as_manager(house, open_page, locale=LOCALES[language], color_scheme=theme)
    lines = page.locator(".bids .bid")
    expect(lines).to_have_count(len(PRICES))
    expect(page.locator(".bid-who small")).to_have_text([reckoned])
    expect(lines.filter(has_text=reckoned)).to_contain_text("ATV2")
    names = lines.locator(".bid-who .link").all_inner_texts()
    lengths = dict(zip(names, page.locator(".bid-bar").evaluate_all(LENGTHS), strict=True))
    px_per_s = lengths["ATV2"] / PRICES["ATV2"].total_s
    assert px_per_s > 1.0
    assert lengths == pytest.approx({atv: px_per_s * cost.total_s for atv, cost in PRICES.items()}, abs=0.5)
    screenshot(page, f"bids-{language}-{theme}")
