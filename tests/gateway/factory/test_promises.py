"""The promise ledger: promised against real, per vehicle, out of the facts that are on disk."""

from __future__ import annotations

import csv
import io
from typing import Any

import pytest
from gateway_kit import House, gateway
from heartbeats import events

from dray.gateway.factory import promises as promises_module
from dray.messages import Event, Reason
from dray.messages.fact import AnyFact, CarrierChanged, TaskClosed

pytestmark = pytest.mark.anyio

PROMISED_S = 200.0


def closed(late_s: float, atv: str = "ATV1", number: int = 1, by: str = "M1", **fields: Any) -> list[Event]:
    """A delivery that came so much later than promised (plant clock)."""
    usual: dict[str, Any] = {"epoch": 1, "outcome": "delivered", "carrier": atv, "promised_s": PROMISED_S}
    fact = TaskClosed(**usual | {"task": f"{by}-{number}"} | fields)
    return at(PROMISED_S + late_s, by, number, fact)


def at(plant_s: float, agent: str, number: int, fact: AnyFact) -> list[Event]:
    """One fact of an agent at a moment."""
    return events(agent, fact, first=number, at_s=plant_s - number)


async def line(house: House, atv: str) -> dict[str, Any]:
    items = (await house.get("/api/promises"))["items"]
    (found,) = (each for each in items if each["atv"] == atv)
    return dict(found)


async def test_a_vehicle_is_judged_by_what_it_promised_and_when_it_delivered(house: House) -> None:
    for number, late_s in enumerate((-10.0, 0.0, 3.0, 5.0, 42.0), 1):
        await house.say(closed(late_s, number=number))
    told = await line(house, "ATV1")
    assert (told["delivered"], told["on_time"], told["on_time_frac"]) == (5, 4, 0.8)
    assert (told["median_s"], told["p95_s"], told["worst_s"]) == (3.0, 42.0, 42.0)
    assert told["worst_task"] == "M1-5"


async def test_lateness_is_in_factory_seconds_whatever_the_speed(url: str) -> None:
    async with gateway(url, speed=20.0) as house:
        await house.say(closed(12.0))
        assert (await line(house, "ATV1"))["worst_s"] == 12.0


async def test_the_fleet_has_a_line_of_its_own(house: House) -> None:
    await house.say([*closed(1.0, "ATV1", 1), *closed(9.0, "ATV10", 2), *closed(2.0, "ATV2", 3)])
    told = await house.get("/api/promises")
    assert (told["fleet"]["delivered"], told["fleet"]["on_time"], told["fleet"]["worst_s"]) == (3, 2, 9.0)
    assert told["on_time_within_s"] == 5.0


async def test_what_was_not_promised_not_delivered_or_is_no_transport_does_not_count(house: House) -> None:
    await house.say(closed(1.0, number=1, promised_s=0.0))
    await house.say(closed(1.0, number=2, outcome="withdrawn"))
    await house.say(closed(1.0, "M7", 1, by="strategist"))
    assert (await house.get("/api/promises"))["items"] == []


async def test_who_was_replaced_has_lost_a_transport_and_its_successor_made_the_promise(house: House) -> None:
    changed = CarrierChanged(
        task="M1-1", epoch=2, replaced="ATV1", carrier="ATV2", reason=Reason.SILENT, silent_s=3.6
    )
    await house.say(at(150.0, "M1", 1, changed))
    await house.say(closed(2.0, "ATV2", 2, task="M1-1", epoch=2))
    lost = await line(house, "ATV1")
    assert (lost["lost"], lost["delivered"], lost["on_time_frac"]) == (1, 0, None)
    assert ((await line(house, "ATV2"))["lost"], (await line(house, "ATV2"))["delivered"]) == (0, 1)


async def test_a_fact_that_is_said_twice_counts_once(house: House) -> None:
    await house.say(closed(1.0))
    await house.say(closed(1.0))
    assert (await line(house, "ATV1"))["delivered"] == 1


async def test_it_goes_on_where_it_was_read_to_also_over_many_pages(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(promises_module, "ROWS_AT_ONCE", 2)
    for number in range(1, 6):
        await house.say(closed(1.0, number=number))
    assert (await line(house, "ATV1"))["delivered"] == 5
    await house.say(closed(1.0, number=6))
    assert (await line(house, "ATV1"))["delivered"] == 6


async def test_figures_are_made_of_the_newest_transports(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(promises_module, "KEPT", 2)
    for number, late_s in enumerate((99.0, 1.0, 2.0), 1):
        await house.say(closed(late_s, number=number))
    assert (await line(house, "ATV1"))["worst_s"] == 2.0


async def test_it_is_the_same_after_a_restart(url: str) -> None:
    async with gateway(url) as house:
        await house.say([*closed(1.0, number=1), *closed(9.0, number=2)])
        before = await house.get("/api/promises")
    async with gateway(url, incarnation=2) as house:
        assert await house.get("/api/promises") == before


async def test_a_spreadsheet_gets_the_same_figures(house: House) -> None:
    await house.say([*closed(-3.0, number=1), *closed(42.04, number=2)])
    response = await house.client.get("/api/promises", params={"format": "csv"})
    assert response.headers["content-type"] == "text/csv; charset=utf-8"
    assert 'filename="promises.csv"' in response.headers["content-disposition"]
    own, fleet = csv.DictReader(io.StringIO(response.text))
    assert (own["atv"], fleet["atv"]) == ("ATV1", "fleet")
    assert (own["delivered"], own["on_time_frac"], own["median_s"], own["worst_s"]) == (
        "2",
        "0.5000",
        "-3.0",
        "42.0",
    )
