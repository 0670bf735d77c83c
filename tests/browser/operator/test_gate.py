"""The delivery gate does not count, or lets a container not in: the tablet of its area says why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from gateway_kit import House
from heartbeats import station_heartbeat
from open_house import OpenHouse
from playwright.sync_api import expect
from puppets import LATER_S
from tablet_kit import LOOKS, Enter

from dray.messages.keys import GATE

Screenshot = Callable[..., Path]

AT_GATE = "AREA1"

WHY = "its count is in doubt (1796032800): pieces went from 70 to 21,075: 3 pieces at most can have been let in since"

WORDS = {
    "lying-light-en": (
        "Delivery gate",
        "its count is in doubt (number 1796032800): pieces went from 70 to 21,075: 3 pieces at most",
    ),
    "upright-dark-de": (
        "Versandtor",
        "seine Zählung ist zweifelhaft (Nummer 1796032800): pieces sprang von 70 auf 21.075: höchstens 3 Stück",
    ),
    "phone-dark-es": (
        "Puerta de expedición",
        "su cuenta está en duda (número 1796032800): pieces pasó de 70 a 21.075: desde entonces",
    ),
}


@pytest.mark.parametrize("look", LOOKS)
def test_the_tablet_at_the_gate_says_why_nothing_is_counted(
    house: OpenHouse, enter: Enter, screenshot: Screenshot, look: str
) -> None:
    async def beat(inside: House, seq: int, problem: str) -> None:
        inside.bus.say(station_heartbeat(GATE, seq, at_s=LATER_S + seq, problem=problem))

    house.do(lambda inside: beat(inside, 1, WHY))
    page = enter(area=AT_GATE, **LOOKS[look])
    card, (title, why) = page.locator("#gate-problem"), WORDS[look]
    expect(card.get_by_role("heading")).to_have_text(title)
    expect(card).to_contain_text(why)
    screenshot(page, f"gate-problem-{look}")
    house.do(lambda inside: beat(inside, 2, ""))
    expect(card).to_have_count(0)
