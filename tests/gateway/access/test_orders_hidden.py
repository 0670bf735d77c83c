"""Who may read no orders is told of none, whatever is asked: neither their names nor for whom they are."""

from __future__ import annotations

import asyncio
import re

import pytest
from gateway_kit import PRODUCT, House
from heartbeats import events, machine_heartbeat
from makings import ANY
from recurring_kit import DRAFT, SIX_S, look

from dray.gateway.access.principal import Scope
from dray.gateway.access.rules import RULES
from dray.gateway.schedules.scheduler import Scheduler
from dray.messages import GoalBrief, Production, Transport
from dray.messages import Role as Part
from dray.messages.fact import AwardAnswered, AwardGiven, ContractTaken, TaskOpened

pytestmark = pytest.mark.anyio

CUSTOMER, REFERENCE = "Geheimrat", "PO-99117"

MACHINE = "M9"


@pytest.fixture(autouse=True)
def asked_by_the_test_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the test looks at what recurs."""
    monkeypatch.setattr(Scheduler, "run", lambda _: asyncio.Event().wait())


APART = ("/api/stream", "/api/audit")
"""The stream has tests of its own; the audit log tells what was asked for, word by word, to who may read it."""

READ = sorted({path for method, path in RULES if method == "GET" and path not in APART})


async def test_who_may_read_no_orders_is_told_of_none_whatever_is_asked(house: House) -> None:
    order = str((await house.place(customer=CUSTOMER, reference=REFERENCE))["id"])
    recurring = {"customer": CUSTOMER, "items": [{"product": PRODUCT, "quantity": 1}], "reference": REFERENCE}
    schedule = {name: value for name, value in DRAFT.items() if name != "transport"} | {"order": recurring}
    assert (await house.client.post("/api/schedules", json=schedule)).status_code == 201
    await look(house, SIX_S)
    goal, goods = f"{order}.1", f"{MACHINE}-7"
    work = Production(PRODUCT, 5, order, 0, ANY)
    carried = Transport(PRODUCT, 5, (MACHINE,), "D1", "tote", goal=goal)
    told = [
        TaskOpened(goal, 1, Part.PRIMARY, 1, work, 0.0, 900.0, 2.0),
        AwardGiven(goal, 1, Part.PRIMARY, MACHINE, 1),
        AwardAnswered(goal, 1, Part.PRIMARY, MACHINE, "accepted"),
    ]
    await house.say(
        [
            *events("strategist", *told),
            *events(
                MACHINE,
                ContractTaken(goal, 1, Part.PRIMARY, "strategist"),
                TaskOpened(goods, 1, Part.PRIMARY, 1, carried, 0.0, 900.0, 2.0),
            ),
            machine_heartbeat(
                MACHINE, goals=(GoalBrief(goal=goal, product=PRODUCT, quantity=5, made=1, delivered=0),)
            ),
        ]
    )
    house.wall.now_s += 1.0
    house.hub.tick()
    _, header = await house.key(*set(Scope) - {Scope.ORDERS_READ, Scope.ORDERS_WRITE})
    visitor, names = house.visitor(**header), {"agent": MACHINE, "machine": MACHINE, "task": goods}
    secrets = re.compile("|".join((CUSTOMER, REFERENCE, re.escape(order))))
    found, seen = [], 0
    for path in READ:
        address = re.sub(r"{(\w+)}", lambda part: names.get(part[1], "unknown"), path)
        for query in ({}, {"format": "csv"}, {"q": CUSTOMER}):
            answer = await visitor.get(address, params=query)
            seen += answer.status_code == 200
            if secrets.search(answer.text.replace(str(query.get("q")), "")):
                found.append((address, query))
    assert found == []
    assert seen > 60
