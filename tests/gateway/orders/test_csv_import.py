"""Orders out of a spreadsheet: all of them or none, and every fault with its row."""

from __future__ import annotations

import io
from typing import Any

import msgspec
import pytest
from answers import problem
from examples import examples
from gateway_kit import OTHER_PRODUCT, PRODUCT, House
from hypothesis import given, settings
from hypothesis import strategies as st

from dray.gateway.access.principal import Scope
from dray.gateway.http import csv_rows
from dray.gateway.http.csv_rows import MAX_ROWS
from dray.gateway.orders.csv_import import COLUMNS, read_orders

HEAD = "customer,reference,product,quantity,due_at,release\n"

GOOD = (
    HEAD
    + f"Hall 3,4711,{PRODUCT},5,2030-05-01T12:00:00Z,\n"
    + f"Hall 3,4711,{OTHER_PRODUCT},2,2030-05-01T12:00:00Z,\n"
    + f"Hall 4,,{PRODUCT},1,,no\n"
    + f"Hall 4,,{PRODUCT},1,,no\n"
)


def faults(text: str) -> list[tuple[int, str]]:
    return [(fault.row, fault.column) for fault in read_orders(text)[1]]


def test_rows_with_one_reference_are_one_order_and_rows_without_are_each_their_own() -> None:
    orders, wrong = read_orders(GOOD)
    assert wrong == []
    assert [(each.row, each.draft.reference, len(each.draft.items)) for each in orders] == [
        (2, "4711", 2),
        (4, None, 1),
        (5, None, 1),
    ]
    assert [each.draft.release for each in orders] == [True, False, False]


def test_a_priority_is_read_in_any_letters_and_an_unknown_one_is_named_with_its_row() -> None:
    text = f"customer,product,quantity,priority\nHall,{PRODUCT},5,Urgent\nHall,{PRODUCT},5,\n"
    orders, wrong = read_orders(text)
    assert [each.draft.priority.value for each in orders] == ["urgent", "normal"]
    assert wrong == []
    assert faults(text.replace("Urgent", "at once")) == [(2, "priority")]


@pytest.mark.parametrize(
    ("text", "code", "values"),
    [
        ("", "csv_empty", {"columns": ", ".join(COLUMNS)}),
        ("customer,product\nc,p\n", "column_missing", {}),
        ("customer,product,quantity,wishes\nc,p,1,x\n", "column_unknown", {"columns": ", ".join(COLUMNS)}),
        (f"customer,product,quantity\nc,{PRODUCT},many\n", "whole_number", {}),
        (f"customer,product,quantity\nc,{PRODUCT},0\n", "at_least", {"least": "1"}),
        (f"customer,product,quantity\n,{PRODUCT},1\n", "missing", {}),
        ("customer,product,quantity\nc,9x,1\n", "pattern", {}),
        (
            f"customer,product,quantity,priority\nc,{PRODUCT},1,now\n",
            "one_of",
            {"choices": "low, normal, high, urgent"},
        ),
        (f"customer,product,quantity,due_at\nc,{PRODUCT},1,soon\n", "moment_unreadable", {}),
        (f"customer,product,quantity,due_at\nc,{PRODUCT},1,2030-05-01T12:00:00\n", "moment_no_zone", {}),
        (f"customer,product,quantity,release\nc,{PRODUCT},1,perhaps\n", "yes_or_no", {}),
    ],
)
def test_a_fault_has_a_code_for_who_tells_it_in_other_words(
    text: str, code: str, values: dict[str, str]
) -> None:
    [fault] = read_orders(text)[1]
    assert (fault.code, fault.values) == (code, values)
    assert fault.reason


@pytest.mark.parametrize("change", [lambda t: t.replace(",", ";"), lambda t: "\ufeff" + t.upper()])
def test_semicolons_capitals_and_a_byte_order_mark_are_read_too(change: Any) -> None:
    text = f"customer,product,quantity\nHALL,{PRODUCT},5\n"
    orders, wrong = read_orders(change(text))
    assert (len(orders), wrong) == (1, [])


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("", [(1, "")]),
        (HEAD, [(1, "")]),
        ("customer,product\nc,p\n", [(1, "quantity")]),
        ("customer,product,quantity,colour\nc,p,1,red\n", [(1, "colour")]),
        ("customer,product,quantity,product\nc,p,1,p\n", [(1, "product"), (1, "product")]),
        (HEAD + "\n" + "c,,p,many,,\n", [(3, "quantity")]),
        (HEAD + ",,p,1,,\nc,,p,1,soon,\nc,,p,1,,perhaps\n", [(2, "customer"), (3, "due_at"), (4, "release")]),
        (HEAD + "c,r,p,1,,\nc,r,p,0,,\n", [(3, "quantity")]),
        (HEAD + "c,r,p,1,2030-05-01T12:00:00Z,\nc,r,p,1,,\n", [(3, "due_at")]),
        (HEAD + "c,r,p,1,,\n" * 51, [(52, ""), (2, "items")]),
        ("customer,product,quantity\n" + "x" * 140_000, [(2, "")]),
    ],
)
def test_a_fault_is_told_with_its_row_and_column(text: str, where: list[tuple[int, str]]) -> None:
    assert faults(text) == where


def test_a_file_is_no_longer_than_a_person_can_look_through(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(csv_rows, "MAX_ROWS", 2)
    assert faults(HEAD + "c,,p,1,,\n" * 3) == [(4, "")]


class Counted(str):
    """A cell that counts how often it is compared."""

    __slots__ = ()
    compared = 0

    def __eq__(self, other: object) -> bool:
        Counted.compared += 1
        return str.__eq__(self, other)

    __hash__ = str.__hash__


def comparisons(cells: int) -> int:
    """What it costs to look at a first row with so many cells, all of them called alike."""
    header: list[str] = [Counted("product") for _ in range(cells)]
    Counted.compared = 0
    assert len(list(csv_rows._wrong_header(header, COLUMNS, ("customer",)))) >= cells
    return Counted.compared


def test_the_work_on_a_first_row_grows_no_faster_than_the_row() -> None:
    assert comparisons(800) <= 2.1 * comparisons(400)


def test_a_first_row_that_is_too_wide_is_one_fault_and_not_thousands() -> None:
    (fault,) = read_orders(",".join(["product"] * 8_000) + "\nc,p,1\n")[1]
    assert "8000 columns" in fault.reason


def test_no_more_of_a_file_is_read_than_could_be_taken() -> None:
    class Rows(io.StringIO):
        read = 0

        def __next__(self) -> str:
            Rows.read += 1
            return super().__next__()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(csv_rows.io, "StringIO", Rows)
        assert faults(HEAD + "c,,p,1,,\n" * 100_000) == [(MAX_ROWS + 2, "")]
    assert Rows.read == MAX_ROWS + 2


@settings(deadline=None, max_examples=examples(100))
@given(st.text(max_size=200) | st.text(",;\n\"'abc1", max_size=200).map(lambda rows: HEAD + rows))
def test_no_text_is_too_odd_to_be_read(text: str) -> None:
    orders, wrong = read_orders(text)
    assert orders or wrong
    assert all(fault.row >= 1 and fault.reason for fault in wrong)
    assert all(fault.column in ("", "items", *COLUMNS) or fault.row == 1 for fault in wrong)


# --- over REST -----------------------------------------------------------------------------------


async def send(house: House, text: str, *, dry_run: bool = False, key: str = "") -> Any:
    headers = {"Idempotency-Key": key} if key else {}
    body = {"csv": text, "dry_run": dry_run}
    return await house.client.post("/api/orders/import", json=body, headers=headers)


@pytest.mark.anyio
async def test_a_dry_run_tells_what_is_there_and_keeps_nothing(house: House) -> None:
    answer = (
        await send(
            house, GOOD + f"Hall 5,,nothing,1,,\nHall 6,,{PRODUCT},1,2020-01-01T00:00:00Z,\n", dry_run=True
        )
    ).json()
    assert [(fault["row"], fault["column"]) for fault in answer["faults"]] == [(6, "product"), (7, "due_at")]
    assert [order["pieces"] for order in answer["orders"]] == [7, 1, 1, 1, 1]
    assert {order["id"] for order in answer["orders"]} == {""}
    assert await house.orders_kept() == 0


@pytest.mark.anyio
async def test_a_file_is_placed_whole_and_once_under_its_key(house: House) -> None:
    first, again = [(await send(house, GOOD, key="k1")).json() for _ in range(2)]
    assert first == again
    assert len({order["id"] for order in first["orders"]}) == await house.orders_kept() == 3
    listed = await house.get("/api/orders")
    assert [order["id"] for order in listed["items"]] == [order["id"] for order in reversed(first["orders"])]
    assert sorted(order["status"] for order in listed["items"]) == ["released", "stored", "stored"]
    problem(await send(house, GOOD + f"Hall 5,,{PRODUCT},1,,\n", key="k1"), 422, "key-used")


@pytest.mark.anyio
async def test_one_fault_refuses_the_whole_file(house: House) -> None:
    refused = problem(await send(house, GOOD + "Hall 5,,nothing,1,,\n"), 422, "unusable-fields")
    assert [error["field"] for error in refused["errors"]] == ["row 6, product"]
    assert await house.orders_kept() == 0


@pytest.mark.anyio
async def test_a_file_is_written_down_with_its_orders_and_a_dry_run_as_such(house: House) -> None:
    await send(house, GOOD, dry_run=True)
    first = (await send(house, GOOD, key="k1")).json()["orders"][0]["id"]
    placed, tried = await house.audit(action="order.import")
    assert (tried.target, msgspec.json.decode(tried.detail)) == ("", {"orders": 3, "dry_run": True})
    assert (placed.target, msgspec.json.decode(placed.detail)) == (first, {"orders": 3, "dry_run": False})


@pytest.mark.anyio
async def test_a_key_of_one_caller_is_not_the_key_of_another_and_not_of_a_single_order(house: House) -> None:
    text = f"customer,product,quantity\nHall 3,{PRODUCT},5\n"
    first = (await send(house, text, key="k1")).json()
    _, erp = await house.key(Scope.ORDERS_WRITE)
    answers = [
        await house.client.post(path, json=body, headers={"Idempotency-Key": "k1"} | who)
        for path, body, who in (
            ("/api/orders/import", {"csv": text}, erp),
            ("/api/orders", {"customer": "Hall 3", "items": [{"product": PRODUCT, "quantity": 5}]}, {}),
        )
    ]
    assert [answer.status_code for answer in answers] == [200, 201]
    ids = {first["orders"][0]["id"], answers[0].json()["orders"][0]["id"], answers[1].json()["id"]}
    assert len(ids) == await house.orders_kept() == 3
