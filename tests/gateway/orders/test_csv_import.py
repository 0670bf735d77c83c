"""Orders out of a spreadsheet: all of them or none, and every fault with its row."""

from __future__ import annotations

import base64
import io
from datetime import UTC, datetime
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
from dray.gateway.orders.csv_import import COLUMNS, read_orders, twice_in_file
from dray.store.orders import orders as orders_module

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
        (f"customer,product,quantity\nc,{PRODUCT},-1\n", "at_least", {"least": "1"}),
        (f"customer,product,quantity\nc,{PRODUCT},--1\n", "whole_number", {}),
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


@pytest.mark.parametrize(
    "change",
    [
        lambda t: "sep=;\r\n" + t.replace(",", ";"),
        lambda t: '"sep=\t"\n' + t.replace(",", "\t"),
        lambda t: "SEP=,\n" + t,
        lambda t: t.replace(",", "\t"),
        lambda t: t.replace(",", "|"),
        lambda t: t.replace("\n", "\r"),
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("\n", ";;;\n").replace(",", ";"),
        lambda t: t.replace("\n", ",,\n"),
        lambda t: t.replace(",", ";").replace("product", '"product"').replace("Hall", '"Hall, west, 1"'),
    ],
)
def test_separators_and_ends_of_lines_of_any_spreadsheet_are_read(change: Any) -> None:
    text = change(f"customer,product,quantity\nHall,{PRODUCT},5\nHall,{PRODUCT},6\n")
    orders, wrong = read_orders(text)
    assert wrong == []
    assert [(each.row, each.draft.items[0].quantity) for each in orders] == [(2, 5), (3, 6)]


@pytest.mark.parametrize(
    ("row", "code", "column"),
    [
        (f"M\ufffdller,{PRODUCT},5", "csv_lost_character", "customer"),
        (f"Hall\x00,{PRODUCT},5", "csv_control_character", "customer"),
        (f'"Hall\n2",{PRODUCT},5', "csv_cell_of_lines", "customer"),
        (f'"Hall,{PRODUCT},5\nHall,{PRODUCT},6', "csv_cell_of_lines", "customer"),
        (f"Hall, west,{PRODUCT},5", "csv_row_too_wide", ""),
        ("x" * 140_000, "csv_cell_too_long", ""),
    ],
)
def test_a_cell_that_came_broken_is_named_for_what_it_is(row: str, code: str, column: str) -> None:
    orders, [fault] = read_orders(f"customer,product,quantity\n{row}\n")
    assert (fault.row, fault.column, fault.code, orders) == (2, column, code, [])


@pytest.mark.parametrize(
    ("text", "where"),
    [
        (f"cust\x00omer,product,quantity\nHall,{PRODUCT},5\n", [(1, "customer", "csv_control_character")]),
        (f"customer,product,quantity,Quantity\nHall,{PRODUCT},5,6\n", [(1, "quantity", "column_twice")] * 2),
        (f"customer,product,quantity\nHall,{PRODUCT},\n", [(2, "quantity", "missing")]),
        (f"customer,product,quantity\nHall,{PRODUCT}\n", [(2, "quantity", "missing")]),
        (f"customer,product,quantity\nHall,{PRODUCT},-5\n", [(2, "quantity", "at_least")]),
        (f"customer;product;quantity\nHall;{PRODUCT};5,0\n", [(2, "quantity", "whole_number")]),
    ],
)
def test_a_fault_has_its_own_name_and_place(text: str, where: list[tuple[int, str, str]]) -> None:
    orders, wrong = read_orders(text)
    assert [(fault.row, fault.column, fault.code) for fault in wrong] == where
    assert orders == []


def test_characters_without_width_around_a_cell_are_no_part_of_it() -> None:
    [order], wrong = read_orders(
        f"\u200bcustomer,product\u00ad,quantity\n\u200eHall,{PRODUCT}\u200b,\ufeff5\n"
    )
    assert wrong == []
    assert (order.draft.customer, order.draft.items[0].product) == ("Hall", PRODUCT)


def test_a_column_with_cells_and_no_name_is_a_fault_and_one_without_both_is_none() -> None:
    [fault] = read_orders("customer,,product,quantity\nHall,x,p,5\n")[1]
    assert (fault.row, fault.code, fault.values) == (1, "column_unnamed", {"number": "2"})


@pytest.mark.parametrize(
    "row",
    [
        "c,9x,1",
        "c\x7f,p,1",
        "c,p,many",
        "c,p,0",
        "c,p,20000",
        ",p,1",
        "x" * 300 + ",p,1",
        '"c,p,1',
        "c,p,1,2",
    ],
)
def test_no_pattern_and_no_sentence_of_a_library_is_told(row: str) -> None:
    _, wrong = read_orders(f"customer,product,quantity\n{row}\n")
    assert wrong
    for fault in wrong:
        assert fault.code
        assert not set("^$\\") & set(fault.reason)
        assert not any(word in fault.reason for word in ("should", "nput", "tring", "byte"))


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


async def send_bytes(house: House, content: bytes) -> Any:
    body = {"base64": base64.b64encode(content).decode(), "dry_run": True}
    return await house.client.post("/api/orders/import", json=body)


UMLAUTS = f"customer;product;quantity\r\nMüller Söhne;{PRODUCT};5\r\n"


@pytest.mark.anyio
@pytest.mark.parametrize(
    ("content", "read_as"),
    [
        (UMLAUTS.encode(), []),
        (UMLAUTS.encode("utf-8-sig"), []),
        (UMLAUTS.encode("utf-16"), []),
        (b"\xfe\xff" + UMLAUTS.encode("utf-16-be"), []),
        (UMLAUTS.encode("utf-16-le"), []),
        (UMLAUTS.encode("utf-32"), []),
        (UMLAUTS.encode("windows-1252"), ["windows-1252"]),
    ],
)
async def test_a_file_is_read_in_its_own_encoding(house: House, content: bytes, read_as: list[str]) -> None:
    answer = (await send_bytes(house, content)).json()
    assert [order["customer"] for order in answer["orders"]] == ["Müller Söhne"]
    assert answer["faults"] == []
    assert [hint["values"]["encoding"] for hint in answer["hints"]] == read_as


@pytest.mark.anyio
@pytest.mark.parametrize("encoding", ["cp850", "utf-16-le", "mac_roman"])
async def test_an_encoding_that_nobody_can_tell_is_refused_by_name(house: House, encoding: str) -> None:
    content = UMLAUTS.encode(encoding)
    cut = content[:-1] if encoding == "utf-16-le" else content
    answer = (await send_bytes(house, cut)).json()
    assert [(fault["row"], fault["code"]) for fault in answer["faults"]] == [(1, "csv_encoding")]
    body = {"base64": base64.b64encode(cut).decode()}
    refused = problem(await house.client.post("/api/orders/import", json=body), 422, "unusable-fields")
    assert [error["code"] for error in refused["errors"]] == ["csv_encoding"]


@pytest.mark.anyio
@pytest.mark.parametrize("begin", [b"PK\x03\x04\x14\x00", b"\xd0\xcf\x11\xe0\xa1\xb1"])
async def test_a_workbook_is_refused_as_one(house: House, begin: bytes) -> None:
    answer = (await send_bytes(house, begin + bytes(100))).json()
    assert [(fault["row"], fault["code"]) for fault in answer["faults"]] == [(1, "csv_workbook")]


@pytest.mark.anyio
async def test_a_request_has_one_file(house: House) -> None:
    for body, code in (
        ({}, "file_needed"),
        ({"csv": "", "base64": ""}, "file_needed"),
        ({"base64": "ü"}, "no_base64"),
    ):
        refused = problem(await house.client.post("/api/orders/import", json=body), 422, "unusable-fields")
        assert refused["errors"][0]["code"] == code


@pytest.mark.anyio
async def test_a_file_that_is_sent_again_when_it_is_due_gets_its_first_answer(house: House) -> None:
    first = await send(house, GOOD, key="k1")
    house.wall.now_s = datetime(2030, 6, 1, tzinfo=UTC).timestamp()
    again = await send(house, GOOD, key="k1")
    assert (again.status_code, again.content) == (200, first.content)
    assert await house.orders_kept() == 3
    problem(await send(house, GOOD.replace(",5,", ",6,"), key="k1"), 422, "key-used")
    problem(await send(house, GOOD, key="k2"), 422, "unusable-fields")


@pytest.mark.anyio
async def test_an_order_with_the_reference_of_a_young_one_gets_a_hint_and_is_placed(house: House) -> None:
    first = (await send(house, GOOD)).json()
    assert first["hints"] == []
    house.wall.now_s += 720.0
    (hint,) = (await send(house, GOOD, dry_run=True)).json()["hints"]
    assert (hint["row"], hint["column"], hint["code"]) == (2, "reference", "placed_already")
    assert hint["values"] == {"customer": "Hall 3", "order": first["orders"][0]["id"], "minutes": "12"}
    other = (await send(house, GOOD.replace("Hall 3", "Hall 7"), dry_run=True)).json()
    assert other["hints"] == []
    placed = (await send(house, GOOD)).json()
    assert (len(placed["orders"]), placed["hints"]) == (3, [hint])
    for order in (first["orders"][0], placed["orders"][0]):
        await house.client.post(f"/api/orders/{order['id']}/cancel")
    assert (await send(house, GOOD, dry_run=True)).json()["hints"] == []
    house.wall.now_s += 3601.0
    assert (await send(house, GOOD, dry_run=True)).json()["hints"] == []


@pytest.mark.anyio
async def test_all_references_of_a_file_are_looked_for_and_the_newest_order_is_told(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(orders_module, "REFERENCES_AT_ONCE", 7)
    rows = [f"c,{number},{PRODUCT},1,,\n" for number in range(30)]
    await send(house, HEAD + "".join(rows[20:]))
    hints = (await send(house, HEAD + "".join(rows), dry_run=True)).json()["hints"]
    assert [hint["row"] for hint in hints] == list(range(22, 32))
    monkeypatch.setattr(orders_module, "REFERRED_MOST", 1)
    house.wall.now_s += 60.0
    newest = (await send(house, HEAD + rows[29])).json()["orders"][0]["id"]
    (hint,) = (await send(house, HEAD + rows[29], dry_run=True)).json()["hints"]
    assert hint["values"]["order"] == newest


def test_an_order_whose_rows_do_not_follow_one_another_gets_a_hint() -> None:
    orders, wrong = read_orders(HEAD + f"c,r,{PRODUCT},1,,\nd,r,{PRODUCT},1,,\nc,r,{PRODUCT},1,,\n")
    assert wrong == []
    (hint,) = twice_in_file(orders)
    assert (hint.row, hint.column, hint.code, hint.values) == (
        4,
        "reference",
        "in_file_already",
        {"row": "2"},
    )
