"""A database that is killed: orders are refused meanwhile, and in the end nobody lacks anything."""

from __future__ import annotations

import asyncio
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import pytest

from dray.errors import UnavailableError
from dray.gateway.live.timescale import TimeScale
from dray.messages import Event
from dray.messages.fact import PieceMade
from dray.plant import default_plant
from dray.store import Store, open_store
from dray_sim.bench import losses
from dray_sim.bench.losses import customer, outage
from dray_sim.bench.losses.customer import NO_ANSWER, Customer, Placing
from dray_sim.bench.losses.figures import outages_of
from dray_sim.bench.losses.outage import Breaker, Outage, caught_up, single_pieces
from dray_sim.bench.postgres import PostgresServer
from dray_sim.people.demand import Order

PLANT = default_plant()

FACTS = [
    Event("M8", 1, number, 0.0, PieceMade(goal="G1", product="pump-p3", made=number)) for number in (1, 2)
]


class Watch:
    """Has heard some facts."""

    def __init__(self, *facts: Event) -> None:
        self.told = {fact.agent: (fact.incarnation, fact.number) for fact in facts}


class Fleet:
    """Has one log."""

    def last_words(self, name: str) -> str:
        return f"the log of {name} ends with: no disk"


class Buyer:
    """A customer whose orders are accepted as soon as the database can be read.

    Attributes:
        orders: all that were placed, and what came before each was accepted.
    """

    def __init__(self, store: Store) -> None:
        self.orders: list[tuple[str, Counter[str]]] = []
        self._store = store

    async def order(self, order: Order) -> Placing:
        before: Counter[str] = Counter()
        while not await is_there(self._store):
            before["503"] += 1
        self.orders.append((order.id, before))
        return Placing(1.0, before)


async def is_there(store: Store) -> bool:
    try:
        async with store.read() as work:
            await work.events.known()
    except UnavailableError:
        return False
    return True


async def write_history(store: Store, watch: Watch) -> None:
    """Write the first fact now, and the second, told while the database is away, when it is back."""
    await write(store, FACTS[0])
    while await is_there(store):
        pass
    watch.told["M8"] = (1, 2)
    while not await is_there(store):
        pass
    await write(store, FACTS[1])


async def write(store: Store, fact: Event) -> None:
    async with store.write() as work:
        await work.events.add([fact], lambda at_s: at_s)


def test_an_outage_is_over_when_an_order_was_accepted_and_all_that_was_told_is_written(
    mortal_postgres: PostgresServer,
) -> None:
    async def story() -> None:
        store = await open_store(mortal_postgres.url())
        buyer = Buyer(store)
        watch = Watch(FACTS[0])
        paper: Any = Fleet(), watch, store, buyer
        writing = asyncio.create_task(write_history(store, watch))
        seen = await Breaker(mortal_postgres, *paper, single_pieces(PLANT), down_s=0.1).kill()
        await writing
        (before, quiet), (after, refused) = buyer.orders
        assert (before, after) == ("S1", "S2")
        assert not quiet
        assert seen.before == refused
        assert refused["503"]
        assert seen.away_s > 0.1
        assert seen.behind_s > 0.0
        async with store.read() as work:
            assert [known.last for known in await work.events.known()] == [2]
        await store.close()

    asyncio.run(story())


def test_a_historian_that_does_not_catch_up_is_named_with_its_last_words(
    monkeypatch: pytest.MonkeyPatch, sqlite_url: str
) -> None:
    monkeypatch.setattr(outage, "CATCH_UP_S", 0.1)

    async def story() -> None:
        store = await open_store(sqlite_url)
        await write(store, FACTS[1])
        paper: Any = Fleet(), Watch(FACTS[1]), store
        try:
            await caught_up(*paper)
        finally:
            await store.close()

    with pytest.raises(UnavailableError, match=r"historian: has not caught up in 0 s; .*: no disk"):
        asyncio.run(story())


def test_what_outages_cost_is_told_with_the_answers_that_customers_got() -> None:
    seen = [
        Outage(away_s=6.0, refused_s=7.0, before=Counter({"503": 2}), behind_s=1.0),
        Outage(away_s=8.0, refused_s=9.0, before=Counter({"503": 1, NO_ANSWER: 1}), behind_s=5.0),
    ]
    away, order, historian = outages_of(seen, 5.0)
    assert (away.figure, away.baseline, order.figure, historian.figure) == (7.0, 5.0, 8.0, 3.0)
    assert order.note == "at most 9.0 s; before that 3 x 503, 1 x no answer"


def test_a_database_that_is_not_killed_is_said_loudly_and_has_no_figure(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(losses, "installed", lambda: None)
    with ExitStack() as stack:
        assert losses.server_in(stack) is None
    assert "!!! no PostgreSQL" in caplog.text
    (away,) = outages_of([], 5.0)
    assert away.note.startswith("NOT KILLED: no PostgreSQL")


def test_orders_of_one_piece_go_through_all_products() -> None:
    orders = single_pieces(PLANT)
    chosen = [next(orders) for _ in PLANT.products]
    assert {item.product for order in chosen for item in order.items} == set(PLANT.products)
    assert len({order.id for order in chosen}) == len(chosen)


@contextmanager
def gateway(answers: Sequence[int]) -> Iterator[str]:
    """The address of a gateway that gives these answers, one after the other; with 0 it hangs up."""
    left = iter(answers)

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            self.rfile.read(int(self.headers["Content-Length"]))
            if status := next(left):
                self.send_response(status)
                self.end_headers()
                self.wfile.write(b'{"id": "O-1"}')

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (its name there)
            pass

    with HTTPServer(("127.0.0.1", 0), Handler) as server:
        serving = threading.Thread(target=server.serve_forever)
        serving.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        serving.join()


def test_an_order_is_sent_until_it_is_answered_and_what_came_before_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(customer, "AGAIN_S", 0.0)
    with gateway([503, 0, 503, 201]) as url:
        buyer = Customer(url, "t", TimeScale(0.0, 0.0))
        patience = asyncio.run(buyer.order(next(single_pieces(PLANT))))
    assert patience.before == {"503": 2, NO_ANSWER: 1}
    assert (buyer.accepted, buyer.refused) == ({"S1": "O-1"}, {})


def test_an_order_that_is_refused_for_good_is_not_sent_again() -> None:
    with gateway([422]) as url:
        buyer = Customer(url, "t", TimeScale(0.0, 0.0))
        patience = asyncio.run(buyer.order(next(single_pieces(PLANT))))
    assert not patience.before
    assert buyer.refused == {"S1": '{"id": "O-1"}'}
