"""Orders that come together are written and committed together, and none fails for another one's sake."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

import asyncpg
import pytest
from history import GEAR, PUMP, order
from sqlalchemy import Engine, event, text
from sqlalchemy.exc import IntegrityError

from dray.errors import UnavailableError
from dray.store import Store
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.database.database import Database
from dray.store.orders.order_filter import EVERY_ORDER
from dray.store.orders.orders import Order
from dray.store.orders.placing import Placement, Placing, Wish

pytestmark = pytest.mark.anyio


@pytest.fixture
async def placing(store: Store) -> Placing:
    async with store.write() as work:
        await work.products.replace([GEAR, PUMP])
    return Placing(store.database, keys_kept_s=100.0)


def wish(number: int, key: str = "", prepare: Callable[[], Order] | None = None) -> Wish:
    def placed() -> Placement:
        return Placement([order(number) if prepare is None else prepare()], f"answer {number}")

    def line(target: str) -> AuditRow:
        return AuditRow(
            at_s=1.0, who="erp", who_kind="key", action="order.place", target=target, result="done"
        )

    return Wish(key=key, fingerprint="body", prepare=placed, line=line)


async def kept(store: Store) -> list[str]:
    async with store.read() as work:
        return sorted(each.id for each in await work.orders.page(EVERY_ORDER, None, None))


async def lines(store: Store) -> list[str]:
    async with store.read() as work:
        return sorted(each.target for each in await work.audit.page(AuditFilter(), None, 500))


@pytest.fixture
def commits(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One item per transaction."""
    counted: list[int] = []
    do = Database.do

    async def counting(database: Database, *work: Any) -> Any:
        counted.append(1)
        return await do(database, *work)

    monkeypatch.setattr(Database, "do", counting)
    return counted


async def test_what_comes_while_a_commit_is_on_its_way_shares_the_next(
    store: Store, placing: Placing, commits: list[int]
) -> None:
    answers = await asyncio.gather(*(placing.place(wish(number, f"k{number}")) for number in range(1, 41)))
    assert [answer.answer for _, answer in answers] == [f"answer {number}" for number in range(1, 41)]
    assert len(commits) <= 2
    assert len(await kept(store)) == 40
    assert await lines(store) == await kept(store)
    async with store.read() as work:
        found = await work.keys.get("k7")
        assert found is not None
        assert (found.order_id, found.answer) == ("O-7", "answer 7")
        assert (await work.links.find("token-7")) is not None


@pytest.fixture
def statements(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """All that is said to any database, by SQLAlchemy or past it."""
    said: list[str] = []

    def noting(name: str) -> None:
        ask = getattr(asyncpg.Connection, name)

        async def asking(driver: asyncpg.Connection, statement: str, *rest: object, **more: object) -> Any:
            said.append(statement)
            return await ask(driver, statement, *rest, **more)

        monkeypatch.setattr(asyncpg.Connection, name, asking)

    def note(_connection: object, _cursor: object, statement: str, *_rest: object) -> None:
        said.append(statement)

    for name in ("execute", "fetchval"):
        noting(name)
    event.listen(Engine, "before_cursor_execute", note)
    yield said
    event.remove(Engine, "before_cursor_execute", note)


async def test_orders_are_as_few_statements_as_one_however_many_are_there(
    store: Store, placing: Placing, statements: list[str]
) -> None:
    """PostgreSQL is gone to once; at hand, each table is a statement."""
    await placing.place(wish(1, "k1"))
    most = 1 if store.database.engine.dialect.name == "postgresql" else 7
    costs = []
    for first in (100, 200, 300):
        statements.clear()
        await asyncio.gather(
            *(placing.place(wish(number, f"k{number}")) for number in range(first, first + 50))
        )
        costs.append(len(statements))
    assert costs == [most] * 3


async def test_an_order_that_cannot_be_written_fails_alone(store: Store, placing: Placing) -> None:
    await placing.place(wish(1))
    done = await asyncio.gather(
        *(placing.place(wish(number)) for number in (2, 1, 3)), return_exceptions=True
    )
    assert [isinstance(each, IntegrityError) for each in done] == [False, True, False]
    assert await kept(store) == await lines(store) == ["O-1", "O-2", "O-3"]


async def test_an_order_that_is_refused_fails_alone_and_leaves_nothing(
    store: Store, placing: Placing, commits: list[int]
) -> None:
    def refuse() -> Order:
        raise UnavailableError("the plant", "is full", "come again")

    done = await asyncio.gather(
        placing.place(wish(1)),
        placing.place(wish(2, "k", refuse)),
        placing.place(wish(3)),
        return_exceptions=True,
    )
    assert [isinstance(each, UnavailableError) for each in done] == [False, True, False]
    assert len(commits) == 1
    assert await kept(store) == await lines(store) == ["O-1", "O-3"]
    async with store.read() as work:
        assert await work.keys.get("k") is None


async def test_a_key_that_is_known_places_nothing_and_is_answered_as_before(
    store: Store, placing: Placing
) -> None:
    await placing.place(wish(1, "k"))

    def refuse() -> Order:
        raise UnavailableError("the plant", "is full", "come again")

    orders, answer = await placing.place(wish(2, "k", refuse))
    assert (orders, answer.answer, answer.order_id) == ((), "answer 1", "O-1")
    assert await kept(store) == ["O-1"]
    assert await lines(store) == ["O-1", "O-1"], "that it was asked again is a line of its own"


async def test_two_gateways_that_are_asked_under_one_key_place_one_order(
    store: Store, placing: Placing
) -> None:
    url = store.database.engine.url.render_as_string(hide_password=False)
    other = await Database.open(url)
    try:
        gateways = (placing, Placing(other, keys_kept_s=100.0))
        for number in range(20, 60, 2):
            tried = [
                gateway.place(wish(number + place, f"k{number}")) for place, gateway in enumerate(gateways)
            ]
            (_, one), (_, two) = await asyncio.gather(*tried)
            assert one == two
    finally:
        await other.close()
    assert len(await kept(store)) == 20


@pytest.mark.parametrize("url", ["postgresql"], indirect=True)
async def test_the_next_order_is_placed_after_the_server_has_closed_the_connection(
    store: Store, placing: Placing
) -> None:
    for number in (1, 2, 3):
        await placing.place(wish(number, f"k{number}"))
        async with store.write() as work:
            others = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() "
            await work.orders._connection.execute(text(others + "AND datname = current_database()"))
    assert await kept(store) == ["O-1", "O-2", "O-3"]


@pytest.mark.parametrize("url", ["postgresql"], indirect=True)
async def test_an_order_whose_commit_was_not_told_is_not_placed_again(
    store: Store, placing: Placing, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its connection breaks after the commit: whoever asked is told that nobody knows, and asks again under its key."""
    await placing.place(wish(1, "k1"))
    await placing.place(wish(2, "k2"))
    ask = asyncpg.Connection.fetchval
    breaks = [True]

    async def broken(driver: asyncpg.Connection, statement: str, *rest: object) -> object:
        done = await ask(driver, statement, *rest)
        if breaks:
            breaks.clear()
            driver.terminate()
            raise asyncpg.ConnectionDoesNotExistError("connection was closed in the middle of operation")
        return done

    monkeypatch.setattr(asyncpg.Connection, "fetchval", broken)
    with pytest.raises(UnavailableError):
        await placing.place(wish(3))
    assert await kept(store) == await lines(store) == ["O-1", "O-2", "O-3"]


async def test_whoever_goes_before_the_answer_spoils_nothing(store: Store, placing: Placing) -> None:
    first, second = (asyncio.create_task(placing.place(wish(number))) for number in (1, 2))
    await asyncio.sleep(0)
    first.cancel()
    await second
    assert await kept(store) == ["O-1", "O-2"]


async def test_a_database_that_is_away_is_told_to_all_who_wait_and_the_next_is_written(
    store: Store, placing: Placing, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def away(_database: Database, *_work: Any) -> Any:
        raise UnavailableError("database", "away", "wait")

    with monkeypatch.context() as patch:
        patch.setattr(Database, "do", away)
        done = await asyncio.gather(
            *(placing.place(wish(number)) for number in (1, 2)), return_exceptions=True
        )
    assert [type(each) for each in done] == [UnavailableError] * 2
    await placing.place(wish(3))
    assert await kept(store) == ["O-3"]


async def test_only_so_many_wait(placing: Placing, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.store.database.together.WAITING", 2)
    done = await asyncio.gather(
        *(placing.place(wish(number)) for number in (1, 2, 3)), return_exceptions=True
    )
    assert [isinstance(each, UnavailableError) for each in done] == [False, False, True]
