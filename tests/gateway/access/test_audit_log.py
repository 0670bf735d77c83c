"""The audit log: who has done what, and what was refused to whom."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Sequence
from typing import Any

import httpx
import pytest
from answers import problem, vehicle
from gateway_kit import House, draft
from heartbeats import atv_heartbeat
from sqlalchemy.exc import OperationalError
from wall_clock import NOW_S, Wall

from dray.errors import UnavailableError
from dray.gateway.access.audit_log import CAUGHT_UP, AuditLog, Line
from dray.gateway.access.principal import Role, Scope
from dray.messages import CommandRefusal
from dray.store import Store, open_store
from dray.store.access import audit as audit_module
from dray.store.access.audit import AuditFilter, AuditLines, AuditRow
from dray.store.database.database import Database

pytestmark = pytest.mark.anyio


async def test_who_did_what_is_written_down_with_what_came_of_it(house: House) -> None:
    boss = await house.log_in("boss")
    house.bus.say(atv_heartbeat("ATV1"))
    vehicle(house, refusal=CommandRefusal.NOT_ACKNOWLEDGED)
    placed = (await boss.post("/api/orders", json=draft())).json()
    await boss.post(f"/api/orders/{placed['id']}/cancel")
    await boss.post("/api/orders", json=draft(customer=""))
    await boss.post("/api/atvs/ATV1/commands", json={"kind": "resume"})
    await boss.post("/api/atvs/ATV99/commands", json={"kind": "stop"})
    rows = [row for row in await house.audit(who="boss") if row.action != "login"][::-1]
    assert [(row.action, row.target, row.result) for row in rows] == [
        ("order.place", placed["id"], "done"),
        ("order.cancel", placed["id"], "done"),
        ("order.place", "", "refused"),
        ("vehicle.command", "ATV1", "refused"),
        ("vehicle.command", "ATV99", "refused"),
    ]
    assert len({row.session for row in rows}) == 1
    told = (await boss.get("/api/audit", params={"target": "ATV1"})).json()["items"][0]
    assert told["detail"]["kind"] == "resume"
    assert told["detail"]["reason"] == "acknowledge the stop first"
    assert (told["who"], told["who_kind"], told["from_ip"]) == ("boss", "person", "127.0.0.1")


async def test_a_line_about_an_order_tells_what_its_customer_calls_it(
    house: House, visitor: httpx.AsyncClient
) -> None:
    placed = (await house.client.post("/api/orders", json=draft(reference="PO-17"))).json()
    bare = (await house.client.post("/api/orders", json=draft(reference=None))).json()
    await house.client.post("/api/atvs/ATV99/commands", json={"kind": "stop"})
    lines = (await house.get("/api/audit", oldest_first=True))["items"]
    told = [(line["target"], line["is_order"], line["reference"]) for line in lines]
    assert told == [(placed["id"], True, "PO-17"), (bare["id"], True, None), ("ATV99", False, None)]
    # Who may read no orders is told no customer's numbers either.
    _, header = await house.key(Scope.AUDIT_READ)
    kept = (await visitor.get("/api/audit", headers=header)).json()["items"]
    assert {(line["is_order"], line["reference"]) for line in kept} == {(False, None)}


async def test_what_the_rules_refuse_is_written_down_too(house: House, visitor: httpx.AsyncClient) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    await ana.post("/api/orders", json=draft())
    _, header = await house.key(Scope.ORDERS_READ)
    await visitor.post("/api/orders", json=draft(), headers=header)
    await visitor.post("/api/orders", json=draft())
    rows = await house.audit(action="order.place")
    assert [(row.who_kind, row.result) for row in rows] == [("key", "refused"), ("person", "refused")]


async def test_reading_is_not_written_down(house: House) -> None:
    for path in ("/api/orders", "/api/atvs", "/api/audit"):
        await house.get(path)
    assert await house.audit() == []


async def test_a_line_is_on_disk_before_its_answer_leaves(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, written = asyncio.Event(), asyncio.Event()
    add = AuditLines.add

    async def slowly(lines: AuditLines, row: AuditRow) -> None:
        begun.set()
        await written.wait()
        await add(lines, row)

    order = await house.place()
    monkeypatch.setattr(AuditLines, "add", slowly)
    asking = asyncio.create_task(house.client.post(f"/api/orders/{order['id']}/cancel"))
    await begun.wait()
    assert not asking.done()
    written.set()
    assert (await asking).status_code == 200
    assert len(await house.audit(action="order.cancel")) == 1


async def test_an_order_and_its_line_are_on_disk_together_before_the_answer_leaves(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on = asyncio.Event(), asyncio.Event()
    do = Database.do

    async def slowly(database: Database, *work: Any) -> Any:
        begun.set()
        await go_on.wait()
        return await do(database, *work)

    monkeypatch.setattr(Database, "do", slowly)
    asking = asyncio.create_task(house.client.post("/api/orders", json=draft()))
    await begun.wait()
    assert not asking.done()
    assert (await house.orders_kept(), await house.audit(action="order.place")) == (0, [])
    go_on.set()
    placed = await asking
    assert placed.status_code == 201
    lines = await house.audit(action="order.place")
    assert [(line.result, line.target) for line in lines] == [("done", placed.json()["id"])]
    assert await house.orders_kept() == 1


async def test_a_stop_waits_for_no_disk_and_its_line_is_written_when_there_is_one(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    house.bus.say(atv_heartbeat("ATV1"))
    vehicle(house)

    with monkeypatch.context() as broken:
        broken.setattr(audit_module, "row_of_line", _fail)
        for _ in range(2):
            assert (
                await house.client.post("/api/atvs/ATV1/commands", json={"kind": "stop"})
            ).status_code == 200
            house.wall.now_s += 1.0
        audit_log = house.access.audit_log
        with pytest.raises(UnavailableError):
            await audit_log.catch_up()
        assert audit_log.waiting == 2
    lines = await house.audit(action="vehicle.command")
    assert [(line.target, line.result, line.at_s) for line in lines] == [
        ("ATV1", "done", NOW_S + 1.0),
        ("ATV1", "done", NOW_S),
    ]


async def test_whoever_reads_waits_for_the_lines_of_stops_until_then_and_not_for_those_that_come_meanwhile(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, add_all, written = AuditLog(house.store, house.wall), AuditLines.add_all, 0

    async def and_another_comes(lines: AuditLines, rows: Sequence[AuditRow]) -> None:
        nonlocal written
        written += len(rows)
        if written < 100:
            log.write_later(_line())
        await add_all(lines, rows)

    monkeypatch.setattr(AuditLines, "add_all", and_another_comes)
    log.write_later(_line())
    await log.catch_up()
    assert (written, log.waiting) == (1, 1)
    log.write_later(_line())
    await log.catch_up()
    assert (written, log.waiting) == (3, 1)


@pytest.fixture
async def store(url: str) -> AsyncIterator[Store]:
    opened = await open_store(url)
    yield opened
    await opened.close()


@pytest.fixture
def transactions(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """One item per transaction that writes."""
    counted: list[str] = []

    def counting(name: str) -> None:
        method = getattr(Database, name)

        def counted_one(*given: Any) -> Any:
            counted.append(name)
            return method(*given)

        monkeypatch.setattr(Database, name, counted_one)

    for name in ("do", "write"):
        counting(name)
    return counted


async def test_lines_that_come_at_once_share_a_transaction_and_each_is_on_disk_before_its_answer(
    store: Store, transactions: list[str]
) -> None:
    log = AuditLog(store, Wall())
    await asyncio.gather(*(log.write(_line(f"ATV{number}")) for number in range(40)))
    assert len(transactions) <= 2
    assert await _targets(store) == [f"ATV{number}" for number in range(40)]


async def test_a_line_that_cannot_be_written_keeps_no_other_from_being_written(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, row_of_line = AuditLog(store, Wall()), audit_module.row_of_line

    def one_fails(row: AuditRow) -> dict[str, object]:
        if row.target == "ATV2":
            raise ValueError
        return row_of_line(row)

    monkeypatch.setattr(audit_module, "row_of_line", one_fails)
    came = await asyncio.gather(
        *(log.write(_line(f"ATV{number}")) for number in range(4)), return_exceptions=True
    )
    assert [type(each) for each in came] == [type(None), type(None), ValueError, type(None)]
    assert await _targets(store) == ["ATV0", "ATV1", "ATV3"]


async def test_many_lines_of_stops_need_few_transactions_and_keep_their_order(
    store: Store, transactions: list[str]
) -> None:
    log = AuditLog(store, Wall())
    many = [f"ATV{number}" for number in range(2 * CAUGHT_UP + 1)]
    for target in many:
        log.write_later(_line(target))
    await log.catch_up()
    assert len(transactions) == 3
    assert await _targets(store) == many


async def test_a_line_is_written_once_though_its_writer_is_cancelled_after_the_commit(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, do = AuditLog(store, Wall()), Database.do
    committed, go_on = asyncio.Event(), asyncio.Event()

    async def slowly(database: Database, *work: Any) -> Any:
        done = await do(database, *work)
        committed.set()
        await go_on.wait()
        return done

    monkeypatch.setattr(Database, "do", slowly)
    log.write_later(_line())
    first = asyncio.create_task(log.catch_up())
    await committed.wait()
    first.cancel()
    again = asyncio.create_task(log.catch_up())
    await asyncio.wait([first])
    go_on.set()
    await again
    assert first.cancelled()
    assert await _targets(store) == ["ATV1"]


def _line(target: str = "ATV1") -> Line:
    return Line(who=None, address="", action="vehicle.command", target=target, result="done", detail={})


async def _targets(store: Store) -> list[str]:
    async with store.read() as work:
        return [row.target for row in await work.audit.page(AuditFilter(), None, 2_000, oldest_first=True)]


def _fail(_row: AuditRow) -> dict[str, object]:
    raise OperationalError("INSERT", {}, Exception("disk full"))


async def test_an_action_that_cannot_be_written_down_is_done_and_said_so(
    house: House, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    house.bus.say(atv_heartbeat("ATV1"))
    heard = vehicle(house)

    monkeypatch.setattr(audit_module, "row_of_line", _fail)
    answer = await house.client.post("/api/atvs/ATV1/commands", json={"kind": "resume"})
    problem(answer, 503, "not-recorded")
    assert len(heard) == 1
    assert "not in the audit log: vehicle.command by admin, about ATV1" in caplog.text


async def test_a_bug_is_written_down_as_failed(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_all: Any, **_more: Any) -> None:
        raise RuntimeError

    monkeypatch.setattr("dray.gateway.routes.orders.orders.order_answer", broken)
    problem(await house.client.post("/api/orders", json=draft()), 500, "bug")
    (row,) = await house.audit()
    assert (row.action, row.result) == ("order.place", "failed")


async def test_the_log_is_read_in_pages_and_as_a_table_without_formulas(house: House) -> None:
    for _ in range(5):
        await house.client.post("/api/atvs/=HYPERLINK(1)/commands", json={"kind": "stop"})
    first = await house.get("/api/audit", limit=3)
    assert len(first["items"]) == 3
    assert first["total"] == 5
    rest = await house.get("/api/audit", limit=3, cursor=first["next_cursor"])
    assert rest["total"] == 5
    assert (len(rest["items"]), rest["next_cursor"]) == (2, None)
    assert await house.get("/api/audit", since=NOW_S + 1) == {
        "items": [],
        "next_cursor": None,
        "total": 0,
    }
    assert len((await house.get("/api/audit", until=NOW_S + 1, result="refused"))["items"]) == 5
    table = await house.client.get("/api/audit", params={"format": "csv"})
    assert table.headers["content-type"].startswith("text/csv")
    lines = table.text.splitlines()
    assert lines[0].startswith("position,at,who,who_kind,from_ip,session,action,target,result,detail")
    assert len(lines) == 6
    assert "'=HYPERLINK(1)" in lines[1]


@pytest.mark.parametrize("query", ["since=-1", "since=x", "until=nan", "result=lost", "who=" + "x" * 129])
async def test_a_question_to_the_log_that_cannot_be_answered_is_refused(house: House, query: str) -> None:
    problem(await house.client.get(f"/api/audit?{query}"), 422, "unusable-fields")


async def test_words_are_looked_for_in_all_of_a_line_and_in_what_its_order_is_called(house: House) -> None:
    order = (await house.place(reference="PO-48213", customer="Waterworks South"))["id"]
    await house.client.post(f"/api/orders/{order}/cancel")
    other = (await house.place(reference="PO-7"))["id"]

    async def found(words: str, **more: Any) -> list[tuple[str, str]]:
        answer = await house.get("/api/audit", q=words, **more)
        assert answer["total"] == len(answer["items"])
        return [(each["action"], each["target"]) for each in answer["items"]]

    assert await found("po-48213") == [("order.cancel", order), ("order.place", order)]
    assert await found("PO-48213 cancel") == [("order.cancel", order)]
    assert await found("po-7") == [("order.place", other)]
    assert await found(other.lower()) == [("order.place", other)]
    assert await found("order.place", target=order) == [("order.place", order)]
    assert await found("100%") == []
    # On several pages nobody counts them.
    assert (await house.get("/api/audit", q="order", limit=1))["total"] is None


async def test_words_do_not_tell_of_orders_who_may_not_read_them(house: House) -> None:
    await house.place(reference="PO-48213")
    _, auditor = await house.key(Scope.AUDIT_READ)
    answer = await house.visitor(**auditor).get("/api/audit", params={"q": "waterworks"})
    assert (answer.status_code, answer.json()["items"]) == (200, [])
