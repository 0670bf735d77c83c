"""Who may read no orders is told of none, whatever is asked: neither their names nor for whom they are."""

from __future__ import annotations

import asyncio
import re
from http import HTTPStatus

import pytest
from gateway_kit import PRODUCT, House
from heartbeats import events, machine_heartbeat
from makings import ANY
from recurring_kit import BRING, DRAFT, SIX_S, TRANSPORTS, look

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
    recurs = await house.client.post("/api/schedules", json=schedule)
    assert recurs.status_code == 201
    called = await house.client.post(TRANSPORTS, json=BRING)
    assert called.status_code == 201
    draft = await house.client.post("/api/plant-drafts", json={"name": "Line 4"})
    assert draft.status_code == 201
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
    names = {
        "agent": MACHINE,
        "machine": MACHINE,
        "atv": "ATV1",
        "product": PRODUCT,
        "draft": draft.json()["id"],
        "order": order,
        "schedule": recurs.json()["id"],
        "transport": called.json()["id"],
    }
    addresses = {
        (path, re.sub(r"{(\w+)}", lambda part, of=of: of.get(part[1], "unknown"), path))
        for path in READ
        for of in (names | {"task": goods}, names | {"task": goal})
    }
    found, answered = [], dict[str, set[int]]()
    for path, address in sorted(addresses):
        # A key of its own each, as one alone may not ask so often.
        visitor = house.visitor(**await blind(house))
        for query in ({}, {"format": "csv"}, *({"q": each[:-2]} for each in (CUSTOMER, REFERENCE, order))):
            answer = await visitor.get(address, params=query)
            answered.setdefault(path, set()).add(answer.status_code)
            # A refusal may say again what was asked for. All of a name stands in no question but in its address.
            text = answer.text if answer.status_code == 200 else re.sub(f"{goal}|{order}", "", answer.text)
            if told := leak(text, order):
                found.append((address, query, told))
    assert found == []
    assert not any(HTTPStatus.TOO_MANY_REQUESTS in statuses for statuses in answered.values())
    # A question that a route does not know is refused.
    assert sum(200 in statuses for statuses in answered.values()) > 35
    assert 200 in answered["/api/transports/{transport}"]
    refused = {path for path, statuses in answered.items() if statuses <= {403, 422}}
    assert {"/api/orders/{order}", "/api/orders/{order}/timeline"} <= refused
    # Nor whether there is one.
    visitor = house.visitor(**await blind(house))
    for path in ("/api/schedules/{}", "/api/orders/{}", "/api/orders/{}/timeline", "/api/tasks/{}"):
        names_of = {"/api/schedules/{}": names["schedule"], "/api/tasks/{}": goal}
        there, nowhere = [
            await visitor.get(path.format(name)) for name in (names_of.get(path, order), "S-000000000000")
        ]
        assert there.status_code == nowhere.status_code, path


async def blind(house: House) -> dict[str, str]:
    """The header of a key that may do all but read and place orders."""
    return (await house.key(*set(Scope) - {Scope.ORDERS_READ, Scope.ORDERS_WRITE}))[1]


def leak(text: str, order: str) -> str:
    """What is told of an order, if anything."""
    secrets = "|".join((CUSTOMER, REFERENCE, re.escape(order)))
    return told[0] if (told := re.search(secrets, text)) else ""
