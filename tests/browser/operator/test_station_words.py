"""People are the body of a storage, and of the delivery gate: they say on the tablet of its area what has happened there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from gateway_kit import House
from heartbeats import station_heartbeat
from open_house import OpenHouse
from playwright.sync_api import expect
from puppets import LATER_S, Puppet
from scanner import scan
from tablet_kit import LOOKS, Enter, assert_touchable

from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    MachineCommand,
    MachineCommandKind,
    Message,
    PeopleAsBody,
    StockLevel,
    UnconfirmedLoad,
)
from dray.messages.heartbeat import GoalToCome
from dray.messages.keys import GATE

Screenshot = Callable[..., Path]

KIND = MachineCommandKind
STORAGE, GATE_AREA = "S3", "AREA1"
LABEL = "O-7-1.1"

CODE = "4006381333931"
"""A code of something else."""

AT_STORAGE = {
    "lying-light-en": ("12 Rotor lie here", "Counted:", f"Nobody knows the code {CODE} here."),
    "upright-dark-de": ("12 Rotor liegen hier", "Gezählt:", f"Den Code {CODE} kennt hier niemand."),
    "phone-dark-es": ("hay aquí 12 Rotor", "Contado:", f"Nadie conoce aquí el código {CODE}."),
}
"""Of each look: what a scanner chooses at a storage, that it is counted, and that a code is not known."""

AT_GATE = {
    "lying-light-en": (f"4 {LABEL} arrived", "Counted:"),
    "upright-dark-de": (f"4 {LABEL} angekommen", "Gezählt:"),
    "phone-dark-es": (f"4 {LABEL} llegadas", "Contado:"),
}
"""Likewise, at the gate."""


class Place:
    """A station whose body is people: it takes words, and doubts more than 20."""

    def __init__(self, house: House, station: str) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._station, self._seq = house, station, 10
        self._waits = PeopleAsBody(goals=(GoalToCome(LABEL, 6),))
        self._stocks: tuple[StockLevel, ...] = ()
        if station != GATE:
            self._waits = PeopleAsBody(loads=(UnconfirmedLoad("ATV2", "shaft", 12, goes=True),))
            self._stocks = (StockLevel("shaft", 38, 240, on_order=12), StockLevel("rotor", 4, 90))
        house.bus.join(station, self._on_message)
        self.beat()

    def beat(self) -> None:
        self._seq += 1
        at_s = LATER_S + self._seq
        said = station_heartbeat(self._station, self._seq, at_s=at_s, stocks=self._stocks, people=self._waits)
        self._house.bus.say(said)

    def _on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, MachineCommand):
            return
        self.heard.append(message)
        far = message.quantity > 20 and not message.sure
        refused = CommandRefusal.UNLIKELY if far else None
        self._house.bus.tell(
            self._station, sender, CommandAnswered(message.command, not far, refused, "12" if far else "")
        )
        if not far:
            self._waits = PeopleAsBody()
            self.beat()

    @property
    def said(self) -> list[tuple[MachineCommandKind, str, int, str, bool]]:
        return [(each.kind, each.item, each.quantity, each.vehicle, each.sure) for each in self.heard]


async def at_storage(house: House) -> Place:
    return Place(house, STORAGE)


async def at_gate(house: House) -> Place:
    return Place(house, GATE)


def test_two_touches_confirm_what_was_taken_from_a_storage(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    storage = house.do(at_storage)
    card = enter().get_by_role("region", name=f"What has happened at {STORAGE}")
    expect(card.get_by_role("button", name="Piece finished")).to_have_count(0)
    expect(card).to_contain_text("12 Shaft are on their way here. Leave room for them.")
    card.get_by_role("button", name="ATV2 took 12 Shaft").click()
    assert storage.said == []
    card.get_by_role("button", name="12 Shaft taken by ATV2").click()
    expect(card).to_contain_text("Counted: 12 Shaft taken by ATV2.")
    assert storage.said == [(KIND.TAKEN, "shaft", 12, "ATV2", False)]


def test_a_scanner_counts_at_a_storage_and_a_number_far_off_is_asked_once(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    storage = house.do(at_storage)
    page = enter()
    card = page.get_by_role("region", name=f"What has happened at {STORAGE}")
    expect(card).to_be_visible()
    scan(page, "stock_is")
    scan(page, "rotor*40")
    scan(page, "ok")
    expect(card.get_by_role("alert")).to_contain_text("Is 40 right?")
    card.get_by_role("button", name="Yes, 40").click()
    expect(card).to_contain_text("Counted: 40 Rotor lie here.")
    assert [each[4] for each in storage.said] == [False, True]


def test_the_label_of_a_container_is_scanned_twice_at_the_gate(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    gate = house.do(at_gate)
    page = enter(area=GATE_AREA)
    card = page.get_by_role("region", name="What has arrived at the gate")
    expect(card.get_by_role("button", name=f"6 {LABEL} are to come.")).to_be_visible()
    scan(page, f"{LABEL}*4")
    assert gate.said == []
    scan(page, f"{LABEL}*4")
    expect(card).to_contain_text(f"Counted: 4 {LABEL} arrived.")
    assert gate.said == [(KIND.ARRIVED, LABEL, 4, "", False)]


@pytest.mark.parametrize("look", LOOKS)
def test_a_scanner_is_answered_in_the_language_of_the_tablet_at_a_storage(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    storage, (what, counted, unknown) = house.do(at_storage), AT_STORAGE[look]
    page = enter(**LOOKS[look])
    card = page.locator(".words")
    expect(card).to_be_visible()
    scan(page, CODE)
    expect(card.get_by_role("status")).to_have_text(unknown)
    scan(page, "stock_is")
    scan(page, "rotor*12")
    expect(card.get_by_role("button", name=what, exact=True)).to_be_visible()
    assert storage.said == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    card.scroll_into_view_if_needed()
    screenshot(page, f"scanner-storage-{look}")
    scan(page, "ok")
    expect(card.get_by_role("status")).to_have_text(f"{counted} {what}.")
    assert storage.said == [(KIND.STOCK_IS, "rotor", 12, "", False)]


@pytest.mark.parametrize("look", LOOKS)
def test_a_scanner_is_answered_in_the_language_of_the_tablet_at_the_gate(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    gate, (what, counted) = house.do(at_gate), AT_GATE[look]
    page = enter(area=GATE_AREA, **LOOKS[look])
    card = page.locator(".words")
    expect(card).to_be_visible()
    scan(page, f"{LABEL}*4")
    expect(card.get_by_role("button", name=what, exact=True)).to_be_visible()
    assert gate.said == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    card.scroll_into_view_if_needed()
    screenshot(page, f"scanner-gate-{look}")
    scan(page, f"{LABEL}*4")
    expect(card.get_by_role("status")).to_have_text(f"{counted} {what}.")
    assert gate.said == [(KIND.ARRIVED, LABEL, 4, "", False)]


def test_a_label_that_is_not_listed_is_taken_as_it_is_spelt_with_the_number_that_somebody_types(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot
) -> None:
    gate = house.do(at_gate)
    page = enter(area=GATE_AREA)
    card = page.get_by_role("region", name="What has arrived at the gate")
    expect(card).to_be_visible()
    scan(page, "O-9-3.1")
    expect(card.get_by_role("button", name="0 O-9-3.1 arrived")).to_be_disabled()
    card.get_by_role("spinbutton").fill("4")
    screenshot(page, "words-gate-unlisted")
    card.get_by_role("button", name="4 O-9-3.1 arrived").click()
    expect(card).to_contain_text("Counted: 4 O-9-3.1 arrived.")
    assert gate.said == [(KIND.ARRIVED, "O-9-3.1", 4, "", False)]


def test_who_works_elsewhere_is_not_shown_the_gate(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    house.do(at_gate)
    page = enter()
    expect(page.get_by_role("region", name="Material")).to_contain_text("Shaft")
    expect(page.locator(".words")).to_have_count(0)


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("where", ["storage", "gate"])
def test_it_fits_and_is_large(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    look: str,
    where: str,
) -> None:
    house.do(at_gate if where == "gate" else at_storage)
    page = enter(**({"area": GATE_AREA} if where == "gate" else {}), **LOOKS[look])
    card = page.locator(".words")
    card.locator(".words-load").click()
    assert_touchable(*card.get_by_role("button").all())
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    card.scroll_into_view_if_needed()
    screenshot(page, f"words-{where}-{look}")
