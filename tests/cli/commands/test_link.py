"""`dray link`: makes and takes back links to orders and plain transports in the database that a gateway uses."""

from __future__ import annotations

import asyncio

import pytest

from dray.plant.model import BillLine, Product
from dray.store import open_store
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray.store.orders.tracking_links import Link
from dray.store.orders.transports import TransportRow

GEAR = Product(id="P1", name="Gear unit", lot=4, bill=(BillLine("steel", 1),))
ORDER = Order(
    id="O-1",
    status=OrderStatus.STORED,
    customer="Hall 3",
    token="first",
    items=(Item("P1", 4),),
    created_at_s=1.0,
)

TRANSPORT = TransportRow(
    id="T-1",
    source="S1",
    destination="M1",
    item="steel",
    quantity=1,
    priority="normal",
    called_by="anna",
    caller="user anna",
    created_at_s=1.0,
    due_at_s=900.0,
    updated_at_s=1.0,
)


@pytest.fixture
def database(database: str) -> str:
    """A database with one order, the link that came with it, and a plain transport."""

    async def fill() -> None:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with store.write() as work:
            await work.products.replace([GEAR])
            await work.orders.add(ORDER)
            await work.links.add("first", Link("O-1", 1.0))
            await work.transports.add(TRANSPORT)
        await store.close()

    asyncio.run(fill())
    return database


@pytest.fixture
def dray(call, database):
    """Run `dray link` on that database; its exit code and what it printed."""

    def run(*args: str) -> tuple[int, str, str]:
        return call("link", *args, "--db", database)

    return run


def found(database: str, token: str) -> Link | None:
    async def find() -> Link | None:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with store.read() as work:
            link = await work.links.find(token) or await work.transport_links.find(token)
        await store.close()
        return link

    return asyncio.run(find())


def test_a_link_that_is_made_leads_to_its_order(dray, database) -> None:
    code, out, _ = dray("create", "O-1", "--url", "https://dray.test/")
    assert code == 0
    assert out.startswith("https://dray.test/track/")
    link = found(database, out.strip().rpartition("/")[2])
    assert link is not None
    assert (link.subject, link.expires_at_s, link.revoked_at_s) == ("O-1", None, None)


def test_a_link_for_some_days_ends_after_them(dray, database) -> None:
    link = found(database, dray("create", "O-1", "--days", "2")[1].strip().rpartition("/")[2])
    assert link is not None
    assert link.expires_at_s == link.created_at_s + 2 * 86_400


def test_one_link_is_taken_back_and_the_other_stays(dray, database) -> None:
    url = dray("create", "O-1")[1].strip()
    assert dray("revoke", url)[:2] == (0, "1 link taken back\n")
    assert dray("revoke", url)[:2] == (0, "0 links taken back\n")
    other = found(database, "first")
    assert other is not None
    assert other.revoked_at_s is None
    assert dray("revoke", "first")[:2] == (0, "1 link taken back\n")


def test_all_links_of_an_order_are_taken_back_at_once(dray, database) -> None:
    dray("create", "O-1")
    assert dray("revoke", "O-1")[:2] == (0, "2 links taken back\n")


def test_links_lead_to_a_plain_transport_as_well_and_are_taken_back_alone_and_together(
    dray, database
) -> None:
    url = dray("create", "T-1", "--days", "2")[1].strip()
    link = found(database, url.rpartition("/")[2])
    assert link is not None
    assert (link.subject, link.expires_at_s) == ("T-1", link.created_at_s + 2 * 86_400)
    assert dray("revoke", url)[:2] == (0, "1 link taken back\n")
    dray("create", "T-1")
    dray("create", "T-1")
    assert dray("revoke", "T-1")[:2] == (0, "2 links taken back\n")
    other = found(database, "first")
    assert other is not None
    assert other.revoked_at_s is None
    assert [(action, about) for action, about, _, _ in log(database)] == [
        *(("link.create", "T-1"), ("link.revoke", "T-1")),
        *(("link.create", "T-1"), ("link.create", "T-1"), ("link.revoke", "T-1")),
    ]


def log(database: str) -> list[tuple[str, str, str, bytes]]:
    """The audit log, oldest first: action, what it was about, by what, and the rest."""

    async def read() -> list[AuditRow]:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with store.read() as work:
            rows = await work.audit.page(AuditFilter(), None, 10)
        await store.close()
        return rows

    return [
        (row.action, row.target, row.who_kind, bytes(row.detail)) for row in reversed(asyncio.run(read()))
    ]


def test_who_makes_links_and_takes_them_back_is_in_the_audit_log_and_no_token_is(dray, database) -> None:
    token = dray("create", "O-1", "--days", "2")[1].strip().rpartition("/")[2]
    dray("revoke", token)
    dray("revoke", token)
    dray("revoke", "O-1")
    lines = log(database)
    assert lines == [
        ("link.create", "O-1", "console", b'{"days":2}'),
        ("link.revoke", "O-1", "console", b'{"links":1}'),
        ("link.revoke", "O-1", "console", b'{"links":1}'),
    ], "what changed nothing has no line"
    assert token not in str(lines)


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("create", "O-2"), "there is no order and no transport 'O-2'; the newest are O-1, T-1"),
        (("create", "O-2"), "management panel's lists of orders and transports"),
        (("create", "O-1", "--days", "0"), "--days"),
        (("revoke", "nothing"), "neither an order's or transport's id nor a link"),
        (("revoke", "-nothing"), "neither an order's or transport's id nor a link"),
    ],
)
def test_what_is_not_there_is_named(dray, args: tuple[str, ...], told: str) -> None:
    code, out, err = dray(*args)
    assert code == 2
    assert out == ""
    assert told in err


def test_without_an_address_a_link_leads_to_the_gateway_that_was_started_last(
    dray, database, monkeypatch
) -> None:
    assert dray("create", "O-1")[1].startswith("http://127.0.0.1:8000/track/"), "before any was started"

    async def start() -> None:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with store.write() as work:
            await work.addresses.put("gateway", "http://127.0.0.1:8123", 2.0)
            await work.addresses.put("gateway", "http://127.0.0.1:8077", 3.0)
            await work.addresses.put("spare", "http://10.0.0.7:8000", 1.0)
        await store.close()

    asyncio.run(start())
    assert dray("create", "O-1")[1].startswith("http://127.0.0.1:8077/track/")
    monkeypatch.setenv("DRAY_PUBLIC_URL", "https://dray.example.com")
    assert dray("create", "O-1")[1].startswith("https://dray.example.com/track/")
