"""An order that was placed before an upgrade has its pages after it: every route that opens it, on both databases.

It keeps them when the log forgets what was told before the upgrade, and has them where the older Dray's log had forgotten it already.
"""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from gateway_kit import PRODUCT, House, gateway
from sqlalchemy import Connection, MetaData, Table, insert
from wall_clock import NOW_S

from dray.messages import Phase, Reason, Role, Transport
from dray.messages.fact import (
    AnyFact,
    CarrierChanged,
    GoalContracted,
    GoodsDelivered,
    OrderFulfilled,
    PhaseEntered,
    PieceMade,
    TaskClosed,
    TaskOpened,
)
from dray.store import downgrade, open_store
from dray.store.access.digest import digest

pytestmark = [
    pytest.mark.anyio,
    # Its columns are wanted here, and not its indexes.
    pytest.mark.filterwarnings("ignore:Skipped unsupported reflection of expression-based index"),
]

OPEN, ENDED, FORGOTTEN = "O-1M9K3X2A4-0001", "O-1M9K3X2A4-0002", "O-1M9K3X2A4-0003"
"""One that is made, one that was delivered, and one that was delivered so long ago that no event tells of it."""

OLDER = ("0002", "0008", "0015", "0022", "0026", "0034", "0036")
"""Databases of older Drays: the first with customers' links, then with ever more of what an order's page is made of."""


def told(order: str) -> list[tuple[str, AnyFact]]:
    """What agents told of one order until it was delivered, oldest first."""
    goal, task = f"{order}-1", f"M4-{order[-4:]}"
    work = Transport(PRODUCT, 2, ("M4",), "DELIVERY", "tote", goal=goal)
    return [
        ("strategist", GoalContracted(goal, order, 0, PRODUCT, 2, "M4", 300.0)),
        ("M4", PieceMade(goal, PRODUCT, 1)),
        ("M4", PieceMade(goal, PRODUCT, 2)),
        ("M4", TaskOpened(task, 1, Role.PRIMARY, 1, work, 20.0, 300.0, 5.0)),
        ("ATV3", PhaseEntered(task, 1, Phase.APPROACHING, "M4")),
        ("M4", CarrierChanged(task, 2, "ATV3", "ATV1", Reason.SILENT, 5.5)),
        ("ATV1", PhaseEntered(task, 2, Phase.APPROACHING, "M4")),
        ("ATV1", PhaseEntered(task, 2, Phase.CARRYING, "M4")),
        ("ATV1", PhaseEntered(task, 2, Phase.HANDING_OVER, "DELIVERY")),
        ("M4", TaskClosed(task, 2, "delivered", "ATV1", 200.0)),
        ("M4", GoodsDelivered(goal, order, 0, PRODUCT, 2, 2)),
        ("strategist", OrderFulfilled(order)),
    ]


def put(connection: Connection, name: str, *rows: dict[str, Any]) -> None:
    """Write rows into a table as it was then: what it did not have is left out."""
    table = Table(name, MetaData(), autoload_with=connection)
    for row in rows:
        connection.execute(insert(table).values({c.name: row[c.name] for c in table.c if c.name in row}))


def an_order(connection: Connection, order: str, status: str) -> None:
    """One as that Dray kept it, with its customer's link and its events."""
    is_ended = status == "delivered"
    at_s, token = NOW_S - 500.0, f"token-of-{order}"
    row: dict[str, Any] = {
        "id": order,
        "status": status,
        "customer": "Waterworks South",
        "reference": f"PO-{order[-4:]}",
        "token": token,
        "created_at_s": at_s,
        "due_at_s": NOW_S + 500.0,
        "released_at_s": at_s,
        "delivered_at_s": NOW_S - 300.0 if is_ended else None,
        "incarnation": 1,
        "releases": 1,
        "search": f"{order.casefold()} po-{order[-4:]} waterworks south",
    }
    put(connection, "orders", row)
    counts = {"made": 2 * is_ended, "delivered": 2 * is_ended}
    put(
        connection,
        "order_items",
        {"order_id": order, "item": 0, "product": PRODUCT, "quantity": 2, **counts},
    )
    link = {"token_hash": digest(token), "order_id": order, "created_at_s": at_s}
    put(connection, "tracking_links", link)
    goal = {
        "id": f"{order}-1",
        "order_id": order,
        "item": 0,
        "product": PRODUCT,
        "quantity": 2,
        "machine": "M4",
        "promised_at_s": NOW_S + 100.0,
        "incarnation": 1,
        "number": 1,
        "delivered_at_s": row["delivered_at_s"],
        **counts,
    }
    put(connection, "goals", goal)
    facts = [] if order == FORGOTTEN else told(order) if is_ended else told(order)[:1]
    put(
        connection,
        "events",
        *(
            {
                "agent": agent,
                "incarnation": 1,
                "number": number + 100 * is_ended,
                "at_s": at_s + 10.0 * number,
                "plant_s": 10.0 * number,
                "kind": type(fact).__name__,
                "task": getattr(fact, "task", None),
                "goal": getattr(fact, "goal", None) or getattr(getattr(fact, "work", None), "goal", None),
                "order_id": getattr(fact, "order", None),
                "fact": msgspec.json.encode(fact).decode(),
            }
            for number, (agent, fact) in enumerate(facts, 1)
        ),
    )


@pytest.mark.parametrize("revision", OLDER)
async def test_an_order_from_before_the_upgrade_has_its_pages_after_it(url: str, revision: str) -> None:
    store = await open_store(url)
    await downgrade(store.database, revision)

    def write(connection: Connection) -> None:
        product = {"id": PRODUCT, "name": "Gear unit"}
        put(connection, "products", product)
        an_order(connection, OPEN, "in_production")
        an_order(connection, ENDED, "delivered")
        an_order(connection, FORGOTTEN, "delivered")

    async with store.database.write() as connection:
        await connection.run_sync(write)
    await store.close()
    # As at every start.
    await (await open_store(url)).close()
    async with gateway(url) as house:
        for order, status in ((OPEN, "in_production"), (ENDED, "delivered"), (FORGOTTEN, "delivered")):
            kept = await house.get(f"/api/orders/{order}")
            assert (kept["status"], kept["reference"], kept["priority"]) == (
                status,
                f"PO-{order[-4:]}",
                "normal",
            )
            story = await house.get(f"/api/orders/{order}/timeline")
            made = 0 if order == OPEN else 2
            goals = [(goal["machine"], goal["made"], goal["delivered"]) for goal in story["goals"]]
            assert goals == [("M4", made, made)]
            assert story["estimates"] == []
            assert len(story["links"]) == 1
            track = await house.get(f"/api/track/token-of-{order}")
            assert track["reference"] == f"PO-{order[-4:]}"
            assert (await house.client.get(f"/track/token-of-{order}")).status_code == 200
            found = await house.get("/api/orders", q=f"PO-{order[-4:]}")
            assert [each["id"] for each in found["items"]] == [order]
        pages = await pages_of(house)
        ended = pages[ENDED][0]
        [way] = ended["transports"]
        legs = [(leg["carrier"], leg["replaced"]) for leg in way["legs"]]
        assert legs == [("ATV3", "silent"), ("ATV1", "")]
        kinds = [moment["kind"] for moment in ended["moments"]]
        assert kinds == ["planned", "began", "took_over", "fetched", "handed_over", "arrived", "delivered"]
        assert [moment["kind"] for moment in pages[FORGOTTEN][0]["moments"]] == []
        # What the older Dray's log has of them is kept with them, too, before it is forgotten.
        await house.forget_everything()
        assert await pages_of(house) == pages
        # What can still be done about the open one can be done.
        link = await house.client.post(f"/api/orders/{OPEN}/links", json={})
        assert link.status_code == 201
        assert (await house.client.post(f"/api/orders/{OPEN}/cancel")).status_code == 200


async def pages_of(house: House) -> dict[str, tuple[Any, Any]]:
    """What the page of every order and its customer's page tell."""
    return {
        order: (
            await house.get(f"/api/orders/{order}/timeline"),
            await house.get(f"/api/track/token-of-{order}"),
        )
        for order in (OPEN, ENDED, FORGOTTEN)
    }
