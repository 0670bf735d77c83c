"""Case 1 on the tablet of the area: a machine asks for help, and people promise, say that it is mended, or hand its goals over."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from gateway_kit import House
from heartbeats import machine_heartbeat
from msgspec import UNSET
from open_house import OpenHouse
from playwright.sync_api import expect
from puppets import LATER_S, Puppet
from tablet_kit import LOOKS, STATION, Enter, assert_touchable, press_and_hold
from variants import variants
from wall_clock import NOW_S

from dray.messages import (
    BufferLevel,
    CommandAnswered,
    CommandRefusal,
    GoalBrief,
    HelpWanted,
    MachineCommand,
    MachineCommandKind,
    MachineStatus,
    Message,
    OutOfService,
    Problem,
    ProblemKind,
    TaskBrief,
)
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import Goal, OrderStatus

Screenshot = Callable[..., Path]

KIND = MachineCommandKind

GOALS = (
    GoalBrief(goal="G1", product="pump-p3", quantity=24, made=8, delivered=0, deadline_s=LATER_S + 900.0),
    GoalBrief(
        goal="G2", product="gear-unit-g2", quantity=12, made=0, delivered=0, deadline_s=LATER_S + 1800.0
    ),
)
TASK = TaskBrief(
    task="M8-1",
    epoch=1,
    item="housing",
    quantity=24,
    source="S3",
    destination=STATION,
    deadline_s=LATER_S + 300.0,
    primary="ATV2",
    secondary="ATV6",
)


class Machine:
    """M8, moved by hand: it obeys, and says so."""

    def __init__(self, house: House) -> None:
        self.heard: list[MachineCommand] = []
        self.state: dict[str, Any] = {}
        self._house, self._seq = house, 10
        house.bus.join(STATION, self._on_message)

    def beat(self, **state: Any) -> None:
        self.state |= state
        self._seq += 1
        fields = {"goals": GOALS, "tasks": (TASK,), "status": MachineStatus.PRODUCING} | self.state
        self._house.bus.say(machine_heartbeat(STATION, self._seq, at_s=LATER_S + self._seq, **fields))

    def break_down(self) -> None:
        about = Problem(kind=ProblemKind.JAM, needs_person=True)
        wanted = HelpWanted(until_s=LATER_S + 180.0)
        self.beat(status=MachineStatus.ERROR, problem="a part is stuck", about_problem=about, help=wanted)

    def _on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, MachineCommand):
            return
        self.heard.append(message)
        refused = CommandRefusal.NOT_SUPPORTED if message.kind is KIND.UPDATE else None
        self._house.bus.tell(STATION, sender, CommandAnswered(message.command, refused is None, refused))
        if message.kind is KIND.PROMISE:
            until_s = LATER_S + (message.wait_s or 0.0)
            self.beat(help=HelpWanted(until_s=until_s, promised_by=message.issued_by))
        elif message.kind is KIND.CLEAR_FAULT:
            mended = {"problem": "", "about_problem": UNSET, "help": UNSET, "resettable": UNSET}
            self.beat(status=MachineStatus.PRODUCING, **mended)
        elif message.kind is KIND.TAKE_OUT:
            self.beat(
                out_of_service=OutOfService(by=message.issued_by, since_s=LATER_S, reason=message.reason)
            )
        elif message.kind is KIND.PUT_IN:
            self.beat(out_of_service=UNSET)


@pytest.mark.slow
@pytest.mark.parametrize("look", ["upright-dark-de", pytest.param("lying-light-en", marks=pytest.mark.slow)])
def test_a_broken_machine_is_seen_to_by_a_person_and_taken_out_of_service(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    async def join(inside: House) -> Machine:
        machine = Machine(inside)
        machine.break_down()
        return machine

    async def mended(_inside: House) -> None:
        machine.beat(resettable=True)

    machine = house.do(join)
    page = enter(**LOOKS[look])
    card = page.locator(f"#machine-{STATION}")
    expect(card).to_contain_text("ATV2")
    expect(card).to_contain_text("ATV6")
    expect(card.locator(".fault-gone")).to_be_disabled()
    expect(card.locator(".steps")).to_contain_text(re.compile("^(Speed|Tempo)"))
    assert_touchable(*card.locator("button").all())
    screenshot(page, f"machine-help-{look}")

    card.locator(".promises button").nth(1).tap()
    expect(card.locator(".command-confirmed")).to_have_count(1)
    expect(card.locator(".patience")).to_contain_text("operator", ignore_case=True)
    house.do(mended)
    card.locator(".fault-gone").tap()
    expect(card).to_have_count(0)

    house.do(lambda inside: _break(machine))
    # Twice at once, however slow the computer is: kept, and nothing is sent.
    card.locator(".hand-over").evaluate("button => { button.click(); button.click(); }")
    card.locator(".software button").nth(1).tap()
    expect(card.locator(".command-refused")).to_have_count(1)
    card.locator(".hand-over").tap()
    expect(card.locator(".command-confirmed")).to_have_count(1)

    card.locator(".service-open").tap()
    choice = card.locator(".service")
    choice.locator("button").nth(1).tap()
    choice.locator("button").last.scroll_into_view_if_needed()
    choice.locator("button:not([aria-pressed])").nth(1).tap()
    house.do(mended)
    card.locator(".fault-gone").tap()
    expect(card.locator(".fault-gone")).to_have_count(0)
    back = card.locator(".service-back")
    expect(back.locator("> button")).to_be_disabled()
    screenshot(page, f"machine-out-{look}")
    for check in back.locator(".checks button").all():
        check.tap()
        expect(check).to_have_attribute("aria-pressed", "true")
    press_and_hold(page, back.locator("> button"))
    expect(card).to_have_count(0)
    said = [command.kind for command in machine.heard]
    assert said == [
        *(KIND.PROMISE, KIND.CLEAR_FAULT, KIND.UPDATE, KIND.HAND_OVER),
        *(KIND.TAKE_OUT, KIND.CLEAR_FAULT, KIND.PUT_IN),
    ]
    assert all(command.grant is not None for command in machine.heard)


async def _break(machine: Machine) -> None:
    machine.break_down()


@pytest.mark.parametrize("look", variants(LOOKS, "upright-dark-de"))
def test_the_page_of_the_station_tells_what_figure_5_shows(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, screenshot: Screenshot, look: str
) -> None:
    async def join(inside: House) -> None:
        order = Order(
            id="O-1",
            status=OrderStatus.RELEASED,
            customer="Hall 3",
            token="token",
            items=(Item("pump-p3", 24),),
            created_at_s=NOW_S,
            due_at_s=NOW_S + LATER_S + 7200.0,
        )
        goal = Goal(id="G1", order_id="O-1", item=0, product="pump-p3", quantity=24)
        inside.projection.orders.put(order, (goal,))
        stock = BufferLevel(item="housing", level=11, capacity=72, reorder_point=20, on_order=24)
        Machine(inside).beat(buffers=(stock,))

    house.do(join)
    page = enter(**LOOKS[look])
    station = page.locator(".station")
    first = station.locator(".goals li").first
    locale = str(LOOKS[look]["locale"])

    def at(wall_s: float) -> str:
        clock = "([at, locale]) => new Intl.DateTimeFormat(locale, {hour: '2-digit', minute: '2-digit'}).format(at * 1000)"
        return str(page.evaluate(clock, [wall_s, locale]))

    for said in ("Pump P3", "8", "24", at(NOW_S + LATER_S + 900.0), at(NOW_S + LATER_S + 7200.0)):
        expect(first).to_contain_text(said)
    expect(station.locator("header .tag")).not_to_be_empty()
    row = station.locator(".stock li").first
    for said in ("Housing", "11", "72", "24", "ATV2", "ATV6"):
        expect(row).to_contain_text(said)
    station.scroll_into_view_if_needed()
    screenshot(page, f"station-{look}")
