"""Good and bad pieces: each counted once, in the hour in which it was made, and told in the words of ISO 22400-2."""

from __future__ import annotations

import csv
import io

import pytest
from gateway_kit import PRODUCT, House, gateway
from heartbeats import events
from wall_clock import NOW_S

from dray.gateway.access.principal import Role
from dray.messages import Event
from dray.messages.fact import PieceMade, PieceScrapped, SparePieceMade

pytestmark = pytest.mark.anyio


async def keep(house: House, told: list[Event]) -> None:
    """As the historian does."""
    async with house.store.write() as work:
        await work.piece_hours.add(told, lambda at_s: at_s)
        await work.events.add(told, lambda at_s: at_s)


def told(machine: str = "M1") -> list[Event]:
    """Three good pieces and a bad one, and two that lay there."""
    facts = (
        PieceMade("G1", PRODUCT, 2, from_stock=True),
        PieceMade("G1", PRODUCT, 3),
        PieceScrapped(PRODUCT, "G1"),
        PieceMade("G1", PRODUCT, 4),
        SparePieceMade(PRODUCT),
    )
    return events(machine, *facts, at_s=NOW_S - 60.0)


async def test_pieces_are_counted_by_machine_and_product(url: str) -> None:
    async with gateway(url) as house:
        await keep(house, [*told(), *events("M2", PieceScrapped(PRODUCT), at_s=NOW_S)])
        answer = await house.get("/api/kpis/quality")
        assert [(each["machine"], each["product"], each["quality_ratio"]) for each in answer["items"]] == [
            ("M1", PRODUCT, 0.75),
            ("M2", PRODUCT, 0.0),
        ]
        assert (answer["good_quantity"], answer["scrap_quantity"], answer["produced_quantity"]) == (3, 2, 5)
        assert answer["quality_ratio"] == 0.6


async def test_what_is_told_again_is_counted_once(url: str) -> None:
    async with gateway(url) as house:
        await keep(house, told()[:3])
        await keep(house, told())
        await keep(house, told())
        [line] = (await house.get("/api/kpis/quality"))["items"]
        assert (line["good_quantity"], line["scrap_quantity"]) == (3, 1)


async def test_pieces_stay_in_the_hour_in_which_they_were_made(url: str) -> None:
    async with gateway(url) as house:
        await keep(house, events("M1", PieceScrapped(PRODUCT), at_s=NOW_S - 10 * 3600.0))
        assert (await house.get("/api/kpis/quality"))["items"] == []
        long_ago = "1970-01-01T00:00:00Z"
        found = await house.client.get("/api/kpis/quality", params={"since": long_ago})
        assert (found.status_code, "35 days" in found.text) == (422, True)
        async with house.store.read() as work:
            [count] = await work.piece_hours.between(0.0, 2 * NOW_S)
        assert (count.good, count.bad) == (0, 1)
        async with house.store.write() as work:
            assert await work.piece_hours.prune(NOW_S, 10) == 1
            assert await work.piece_hours.between(0.0, 2 * NOW_S) == []


async def test_where_nothing_was_made_there_is_no_ratio(url: str) -> None:
    async with gateway(url) as house:
        answer = await house.get("/api/kpis/quality")
        assert (answer["produced_quantity"], answer["quality_ratio"]) == (0, None)


async def test_pieces_as_a_table(url: str) -> None:
    async with gateway(url) as house:
        await keep(house, told())
        table = (await house.client.get("/api/kpis/quality?format=csv")).text
        [row] = csv.DictReader(io.StringIO(table))
        assert (row["good_quantity"], row["scrap_quantity"], row["quality_ratio"]) == ("3", "1", "0.7500")


async def test_of_one_machine_only_its_pieces_are_told(url: str) -> None:
    async with gateway(url) as house:
        await keep(house, [*told("M1"), *told("M2")])
        answer = await house.get("/api/kpis/quality", machine="M2")
        assert [each["machine"] for each in answer["items"]] == ["M2"]
        assert answer["produced_quantity"] == 4
        assert (await house.get("/api/kpis/quality", machine="M99"))["items"] == []


async def test_an_operator_reads_of_the_machines_in_the_own_areas(url: str) -> None:
    async with gateway(url) as house:
        await keep(house, [*told("M1"), *told("M8")])
        ana = await house.log_in("ana", Role.OPERATOR, "AREA3")
        for question in ("", "?machine=M1&machine=M8"):
            answer = (await ana.get(f"/api/kpis/quality{question}")).json()
            assert [each["machine"] for each in answer["items"]] == ["M8"]
            assert answer["produced_quantity"] == 4
