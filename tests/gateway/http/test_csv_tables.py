"""Tables for spreadsheets: whole, readable, and without formulas."""

from __future__ import annotations

import csv
import io
from collections.abc import AsyncIterator
from typing import Any

import pytest
from facts_kit import opened
from fake_bus import PLANT
from gateway_kit import PRODUCT, House
from heartbeats import atv_heartbeat, events
from wall_clock import NOW_S

from dray.gateway.http.csv_tables import CUT_SHORT, header_of, line, table
from dray.gateway.routes.orders import orders as orders_module
from dray.messages import AtvStatus, Transport

pytestmark = pytest.mark.anyio


async def rows(house: House, path: str, **params: Any) -> list[dict[str, str]]:
    response = await house.client.get(path, params=params | {"format": "csv"})
    assert response.status_code == 200, response.text
    assert response.headers["content-type"] == "text/csv; charset=utf-8"
    return list(csv.DictReader(io.StringIO(response.text)))


@pytest.mark.parametrize(
    "text", ["=1+1", "+49 30 1", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "=cmd|' /C calc'!A0"]
)
def test_a_cell_that_a_program_would_take_for_a_formula_is_made_text(text: str) -> None:
    [[cell]] = csv.reader(io.StringIO(line([text]), newline=""))
    assert cell.startswith("'")
    assert cell.replace("'", "") == text.replace("'", "")


SIGNS = "=+-@＝＋－＠"  # noqa: RUF001


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("before", ["", "a;", "a\t", "a\n", "a; ", "a\r\n", ' "', 'a;"'])
@pytest.mark.parametrize("sign", SIGNS)
def test_no_program_finds_a_formula_wherever_it_parts_cells(delimiter: str, before: str, sign: str) -> None:
    written = line(["O-1", f"{before}{sign}cmd|' /C calc'!A0", "x"])
    # Strict programs and those that know nothing of quotes.
    for quoting in (csv.QUOTE_MINIMAL, csv.QUOTE_NONE):
        for cells in csv.reader(io.StringIO(written, newline=""), delimiter=delimiter, quoting=quoting):
            for cell in cells:
                assert not cell.strip(' "').startswith(tuple(SIGNS)), written


@pytest.mark.parametrize(("cell", "written"), [("-3.5", "-3.5"), (-3.5, "-3.5"), ("a=b", "a=b"), (None, "")])
def test_any_other_cell_stays_as_it_is(cell: object, written: str) -> None:
    assert line([cell, "x"]) == f"{written},x\r\n"


def test_a_moment_that_is_written_for_people_is_in_no_unit() -> None:
    assert header_of(["at_s", "seen_at_s", "span_s"]) == ["at", "seen_at", "span_s"]


async def test_all_orders_are_in_the_table_with_a_row_for_each_item(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(orders_module, "ROWS_AT_ONCE", 2)
    lines = [{"product": PRODUCT, "quantity": 5}, {"product": PRODUCT, "quantity": 1}]
    names = []
    for number in range(5):
        house.wall.now_s = NOW_S + number
        names.append((await house.place(items=lines, reference=f"R{number}", release=number != 0))["id"])
    found = await rows(house, "/api/orders")
    assert [row["order"] for row in found] == [name for name in reversed(names) for _ in lines]
    assert [row["quantity"] for row in found[:2]] == ["5", "1"]
    assert (found[0]["created_at"], found[0]["due_at"]) == ("2030-03-17T17:46:44.000Z", "")
    stored = await rows(house, "/api/orders", status="stored")
    assert [(row["order"], row["status"], row["released_at"]) for row in stored] == [
        (names[0], "stored", "")
    ] * 2


async def test_a_customers_name_is_no_formula(house: House) -> None:
    await house.place(customer='=HYPERLINK("http://evil.test","click")')
    [row] = await rows(house, "/api/orders")
    assert row["customer"].startswith("'=HYPERLINK")


async def test_the_fleet_is_a_table(house: House) -> None:
    vehicle = PLANT.fleet[0]
    house.bus.say(atv_heartbeat(vehicle.id, status=AtvStatus.CHARGING, battery_frac=0.5))
    [row] = await rows(house, "/api/atvs")
    assert (row["id"], row["type"], row["status"]) == (vehicle.id, vehicle.type, "charging")
    assert (row["battery_frac"], row["seen_at"]) == ("0.5000", "2030-03-17T17:46:41.000Z")


async def test_the_tasks_are_a_table(house: House) -> None:
    work = Transport(item="shaft", quantity=20, sources=("S1",), destination="M1", ability="tote")
    house.bus.say(*events("M1", opened("M1-1", work=work)))
    [row] = await rows(house, "/api/tasks", state="bidding")
    assert (row["id"], row["item"], row["quantity"], row["state"]) == ("M1-1", "shaft", "20", "bidding")
    assert await rows(house, "/api/tasks", state="delivered") == []


async def test_a_table_that_fails_says_so_in_its_last_row_and_has_no_end() -> None:
    async def broken() -> AsyncIterator[tuple[str]]:
        yield ("O-1",)
        raise OverflowError("date value out of range")

    written: list[object] = []

    async def read() -> None:
        async for part in table("orders", ["id"], broken()).body_iterator:
            written.append(part)  # noqa: PERF401 - what came before it failed counts

    with pytest.raises(OverflowError):
        await read()
    assert written == ["id\r\n", "O-1\r\n", f"{CUT_SHORT}\r\n"]
