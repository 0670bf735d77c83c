"""People are the body of a machine: they say on the tablet of its area what has happened, by touch and by scanner, in two touches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from complaints import Complaints
from gateway_kit import House
from heartbeats import machine_heartbeat
from open_house import OpenHouse
from playwright.sync_api import expect
from puppets import LATER_S, Puppet
from scanner import scan
from tablet_kit import LOOKS, STATION, Enter, assert_touchable, forgive

from dray.messages import (
    BufferLevel,
    CommandAnswered,
    CommandRefusal,
    MachineCommand,
    MachineCommandKind,
    MachineStatus,
    Message,
    PeopleAsBody,
    UnconfirmedLoad,
)

Screenshot = Callable[..., Path]

KIND = MachineCommandKind
SIGNS = {
    "lying-light-en": ("One less", "One more"),
    "upright-dark-de": ("Eins weniger", "Eins mehr"),
    "phone-dark-es": ("Una menos", "Una más"),
}

DOUBTS = {
    "lying-light-en": (
        "That is far from 12, which was expected. Is 120 right?",
        "Yes, 120",
        "Counted: 120 Shaft arrived with ATV2.",
    ),
    "upright-dark-de": (
        "Das ist weit von 12 entfernt, was erwartet war. Stimmt 120?",
        "Ja, 120",
        "Gezählt: 120 Shaft mit ATV2 angekommen.",
    ),
    "phone-dark-es": (
        "Eso está lejos de 12, que era lo esperado. ¿Es correcto 120?",
        "Sí, 120",
        "Contado: 120 Shaft llegadas con ATV2.",
    ),
}
"""Of each look: what is asked about a scanned number far off, the answer, and that it is counted."""

LOAD = UnconfirmedLoad(vehicle="ATV2", item="shaft", quantity=12)


class Workplace:
    """M8, whose body is people: it takes words once it is there, and doubts more than 20."""

    def __init__(self, house: House) -> None:
        self.heard: list[MachineCommand] = []
        self._house, self._seq, self._loads = house, 10, (LOAD,)
        self.is_there = True
        house.bus.join(STATION, self._on_message)
        self.beat()

    def beat(self) -> None:
        self._seq += 1
        said = machine_heartbeat(
            STATION,
            self._seq,
            at_s=LATER_S + self._seq,
            status=MachineStatus.PRODUCING,
            product="pump-p3",
            buffers=(
                BufferLevel(item="housing", level=11, capacity=72, reorder_point=20),
                BufferLevel(item="shaft", level=38, capacity=120, reorder_point=20),
            ),
            goods=(BufferLevel(item="pump-p3", level=2, capacity=48),),
            people=PeopleAsBody(loads=self._loads),
        )
        self._house.bus.say(said)

    def _on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, MachineCommand) or not self.is_there:
            return
        self.heard.append(message)
        far = message.quantity > 20 and not message.sure
        refused = CommandRefusal.UNLIKELY if far else None
        answer = CommandAnswered(message.command, not far, refused, "12" if far else "")
        self._house.bus.tell(STATION, sender, answer)
        if not far and message.vehicle:
            self._loads = ()
            self.beat()


def said(workplace: Workplace) -> list[tuple[MachineCommandKind, str, int, str, bool]]:
    return [(each.kind, each.item, each.quantity, each.vehicle, each.sure) for each in workplace.heard]


def test_two_touches_confirm_a_load_and_count_a_piece(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    workplace = house.do(_begun)
    page = enter()
    card = page.get_by_role("region", name=f"What has happened at {STATION}")
    card.get_by_role("button", name="ATV2 brought 12 Shaft").click()
    assert said(workplace) == []
    card.get_by_role("button", name="12 Shaft arrived with ATV2").click()
    expect(card).to_contain_text("Counted: 12 Shaft arrived with ATV2.")
    expect(card.get_by_role("button", name="ATV2 brought")).to_have_count(0)
    card.get_by_role("button", name="Piece finished").click()
    card.get_by_role("button", name="One more").click()
    card.get_by_role("button", name="2 Pump P3 finished").click()
    expect(card).to_contain_text("Counted: 2 Pump P3 finished.")
    assert said(workplace) == [
        (KIND.ARRIVED, "shaft", 12, "ATV2", False),
        (KIND.MADE, "pump-p3", 2, "", False),
    ]


def test_a_scanner_says_the_same_and_a_number_far_off_is_asked_once(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    workplace = house.do(_begun)
    page = enter()
    card = page.get_by_role("region", name=f"What has happened at {STATION}")
    expect(card).to_be_visible()
    # What has the focus is not pressed by the Enter of a scanner.
    card.get_by_role("button", name="Bad piece").focus()
    scan(page, "shaft*120")
    expect(card.get_by_role("button", name="120 Shaft arrived with ATV2")).to_be_visible()
    scan(page, "ok")
    expect(card.get_by_role("alert")).to_contain_text(
        "That is far from 12, which was expected. Is 120 right?"
    )
    card.get_by_role("button", name="No").click()
    scan(page, "shaft")
    scan(page, "shaft")
    expect(card).to_contain_text("Counted: 12 Shaft arrived with ATV2.")
    scan(page, "4006381333931")
    expect(card).to_contain_text("Nobody knows the code 4006381333931 here.")
    assert said(workplace) == [
        (KIND.ARRIVED, "shaft", 120, "ATV2", False),
        (KIND.ARRIVED, "shaft", 12, "ATV2", False),
    ]


@pytest.mark.parametrize("look", LOOKS)
def test_a_scanner_is_answered_in_the_language_of_the_tablet_at_a_machine(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    workplace, (doubt, yes, counted) = house.do(_begun), DOUBTS[look]
    page = enter(**LOOKS[look])
    card = page.locator(".words")
    expect(card).to_be_visible()
    for _ in range(2):
        scan(page, "shaft*120")
    expect(card.get_by_role("alert")).to_contain_text(doubt)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    card.scroll_into_view_if_needed()
    screenshot(page, f"scanner-machine-{look}")
    card.get_by_role("button", name=yes, exact=True).click()
    expect(card.get_by_role("status")).to_have_text(counted)
    assert [(each[2], each[4]) for each in said(workplace)] == [(120, False), (120, True)]


def test_a_word_that_nobody_answers_is_kept_over_a_reload_and_said_again_under_its_name(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    workplace = house.do(_begun)
    workplace.is_there = False
    page = enter()
    card = page.get_by_role("region", name=f"What has happened at {STATION}")
    card.get_by_role("button", name="Piece finished").click()
    with page.expect_response(lambda response: response.status == 504):
        card.get_by_role("button", name="1 Pump P3 finished").click()
    expect(card).to_contain_text("Not answered yet: 1. Kept here, and said again.")
    page.reload()
    expect(card).to_contain_text("Not answered yet: 1. Kept here, and said again.")
    workplace.is_there = True
    expect(card).to_contain_text("Counted: 1 Pump P3 finished.", timeout=60_000)
    expect(card).not_to_contain_text("Not answered yet")
    assert {each.command for each in workplace.heard} == {workplace.heard[0].command}
    forgive(complaints, "status of 504")


def test_a_machine_with_a_controller_has_no_such_card(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    expect(page.get_by_role("region", name="Material")).to_contain_text("Shaft")
    expect(page.locator(".words")).to_have_count(0)


@pytest.mark.parametrize("look", LOOKS)
def test_it_fits_and_is_large(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    house.do(_begun)
    page = enter(**LOOKS[look])
    card = page.locator(".words")
    card.locator(".words-load").click()
    assert_touchable(*card.get_by_role("button").all())
    around = [card.get_by_role("button", name=sign, exact=True).bounding_box() for sign in SIGNS[look]]
    assert len({box["y"] for box in around if box is not None}) == 1, "less and more stand in one row"
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    card.scroll_into_view_if_needed()
    screenshot(page, f"words-{look}")


async def _begun(house: House) -> Workplace:
    return Workplace(house)
