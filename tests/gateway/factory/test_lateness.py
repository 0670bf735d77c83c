"""Why a transport was late: what held its carrier up is kept, and told where its lateness is."""

from __future__ import annotations

from typing import Any

import pytest
from gateway_kit import House, gateway
from heartbeats import events
from wall_clock import NOW_S

from dray.gateway.factory.lateness import Span, held
from dray.messages.fact import TaskClosed
from dray.store.orders.tasks import TaskRow, row_of_task, tasks
from dray.store.replay.spells import Spell

pytestmark = pytest.mark.anyio

SPAN = Span("M1-1", "ATV1", 100.0, 500.0, late_s=200.0)


def spell(doing: str, from_s: float, until_s: float, **fields: Any) -> Spell:
    """What ATV1 did (wall clock)."""
    return Spell(agent="ATV1", doing=doing, from_at_s=from_s, until_at_s=until_s, **fields)  # type: ignore[arg-type]


def test_the_longest_hold_is_the_cause_and_names_for_whom_it_waited_longest() -> None:
    done = [
        spell("carries", 100, 200, task="M1-1"),
        spell("waits", 200, 260, task="M1-1", other="ATV2"),
        spell("waits", 260, 290, task="M1-1", other="ATV3"),
        spell("stopped", 300, 370),
    ]
    hold = held([SPAN], done)["M1-1"]
    assert (hold.doing, hold.by, hold.lasted_s) == ("waits", "ATV2", 90.0)


def test_what_was_before_after_or_for_another_task_is_no_cause() -> None:
    done = [
        spell("waits", 0, 110, task="M1-1", other="ATV2"),
        spell("waits", 120, 300, task="M9-9", other="ATV3"),
        spell("stopped", 490, 900),
    ]
    assert held([SPAN], done) == {}


def test_a_short_wait_is_not_told_as_the_cause_of_a_long_delay() -> None:
    assert held([SPAN], [spell("waits", 100, 149, task="M1-1")]) == {}
    assert held([SPAN], [spell("waits", 100, 150, task="M1-1")])["M1-1"].lasted_s == 50.0


def test_of_a_machine_the_material_that_was_missing_longest_is_told() -> None:
    goal = Span("O-1-1", "M1", 100.0, 500.0, late_s=200.0)
    starved = Spell(agent="M1", doing="starves", from_at_s=200.0, until_at_s=280.0, other="rotor")
    made = Spell(agent="M1", doing="makes", from_at_s=280.0, until_at_s=500.0)
    hold = held([goal], [made, starved])["O-1-1"]
    assert (hold.doing, hold.by, hold.lasted_s) == ("starves", "rotor", 80.0)


async def late_transport(house: House, **fields: Any) -> None:
    """One that came 200 s later than promised, and its carrier, which waited for 150 s."""
    usual = {"kind": "transport", "coordinator": "M1", "item": "steel", "quantity": 8, "state": "delivered"}
    times = {"opened_at_s": NOW_S - 500, "contracted_at_s": NOW_S - 490, "deadline_at_s": NOW_S - 100}
    ends = {"promised_at_s": NOW_S - 300, "closed_at_s": NOW_S - 100, "carrier": "ATV1"}
    row = TaskRow(**{"id": "M1-1"} | usual | times | ends | fields)  # type: ignore[arg-type]
    async with house.store.write() as work:
        await work.tasks._connection.execute(tasks.insert(), row_of_task(row, ""))
        waited = spell("waits", NOW_S - 400, NOW_S - 250, task=row.id, other="ATV4")
        await work.spells.add([waited, spell("carries", NOW_S - 250, NOW_S - 100, task=row.id)])


async def test_the_list_of_tasks_tells_it_of_late_ones_only(house: House) -> None:
    await late_transport(house)
    await late_transport(house, id="M1-2", promised_at_s=NOW_S - 99)
    by_task = {each["id"]: each for each in (await house.get("/api/tasks/history"))["items"]}
    late, punctual = by_task["M1-1"], by_task["M1-2"]
    assert (late["held"], late["held_by"], late["held_s"]) == ("waits", "ATV4", 150.0)
    assert (punctual["held"], punctual["held_by"], punctual["held_s"]) == ("", "", 0.0)


async def test_the_ledger_tells_it_of_the_worst(url: str) -> None:
    async with gateway(url) as house:
        await late_transport(house)
        fact = TaskClosed(task="M1-1", epoch=1, outcome="delivered", carrier="ATV1", promised_s=100.0)
        await house.say(events("M1", fact, at_s=300.0))
        # The historian has written the row anew: nothing but its end was told of it.
        await house.historian.written()
        ledger = await house.get("/api/promises")
        [own] = ledger["items"]
        for line in (own, ledger["fleet"]):
            assert (line["worst_task"], line["worst_held"], line["worst_held_by"]) == (
                "M1-1",
                "waits",
                "ATV4",
            )
