"""Orders that come together are written and committed together, and none fails for another one's sake."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from history import GEAR, PUMP, order
from sqlalchemy import Engine, event
from sqlalchemy.exc import IntegrityError

from dray.errors import UnavailableError
from dray.store import Store
from dray.store.audit import AuditFilter, AuditRow
from dray.store.database import Database
from dray.store.orderfilter import EVERY_ORDER
from dray.store.orders import Order
from dray.store.placing import Placement, Placing, Wish

pytestmark = pytest.mark.anyio


@pytest.fixture
async def placing(store: Store) -> Placing:
    async with store.write() as work:
        await work.products.replace([GEAR, PUMP])
    return Placing(store.database, keys_kept_s=100.0, lines_kept=10)


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

    async def counting(database: Database, work: Any) -> Any:
        counted.append(1)
        return await do(database, work)

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
def statements() -> Iterator[list[str]]:
    """All that is said to any database."""
    said: list[str] = []

    def note(_connection: object, _cursor: object, statement: str, *_rest: object) -> None:
        said.append(statement)

    event.listen(Engine, "before_cursor_execute", note)
    yield said
    event.remove(Engine, "before_cursor_execute", note)


async def test_orders_are_as_few_statements_as_one_however_many_are_there(
    store: Store, placing: Placing, statements: list[str]
) -> None:
    """PostgreSQL is told of the beginning and the end besides: four times there and back in all."""
    await placing.place(wish(1, "k1"))
    most = 2 if store.database.engine.dialect.name == "postgresql" else 7
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

    def never() -> Order:
        raise AssertionError

    orders, answer = await placing.place(wish(2, "k", never))
    assert (orders, answer.answer, answer.order_id) == ((), "answer 1", "O-1")
    assert await kept(store) == ["O-1"]
    assert await lines(store) == ["O-1", "O-1"], "that it was asked again is a line of its own"


async def test_whoever_goes_before_the_answer_spoils_nothing(store: Store, placing: Placing) -> None:
    first, second = (asyncio.create_task(placing.place(wish(number))) for number in (1, 2))
    await asyncio.sleep(0)
    first.cancel()
    await second
    assert await kept(store) == ["O-1", "O-2"]


async def test_a_database_that_is_away_is_told_to_all_who_wait_and_the_next_is_written(
    store: Store, placing: Placing, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def away(_database: Database, _work: Any) -> Any:
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
    monkeypatch.setattr("dray.store.together.WAITING", 2)
    done = await asyncio.gather(
        *(placing.place(wish(number)) for number in (1, 2, 3)), return_exceptions=True
    )
    assert [isinstance(each, UnavailableError) for each in done] == [False, False, True]


async def test_old_lines_of_the_audit_log_are_pruned(
    store: Store, placing: Placing, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.store.placing.PRUNED_EVERY", 15)
    for number in range(1, 16):
        await placing.place(wish(number))
    assert await lines(store) == sorted(f"O-{number}" for number in range(6, 16))
