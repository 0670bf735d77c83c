"""What got lost on its way to the gateway is fetched again, and shown as if it had come in time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest
from fake_bus import FakeBus
from gateway_kit import PRODUCT, gateway
from heartbeats import events

from dray.messages import Event, EventsAsked, EventsKept, Message, Role, Transport
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderAccepted, TaskClosed, TaskOpened
from dray.store import historian
from dray.store.history import gaps

pytestmark = pytest.mark.anyio

TURNS = 200_000
"""Of the loop: some seconds, far more than a fetch takes."""

FETCH = Transport(item="steel", quantity=4, sources=("S1",), destination="M1", ability="tote")

OPENED = TaskOpened(
    task="M1-1",
    epoch=1,
    role=Role.PRIMARY,
    round=1,
    work=FETCH,
    radius_m=20.0,
    deadline_s=900.0,
    bids_until_s=105.0,
)
CLOSED = TaskClosed(task="M1-1", epoch=1, outcome="delivered", carrier="ATV1")


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """No waiting before an agent is asked."""
    monkeypatch.setattr(historian, "ASK_EVERY_S", 0.0)
    monkeypatch.setattr(gaps, "SETTLE_S", 0.0)


async def until(done: Callable[[], bool]) -> None:
    """Give the others their turn until it is so."""
    for _ in range(TURNS):
        if done():
            return
        await asyncio.sleep(0)
    pytest.fail("it never came to that")


def remember(bus: FakeBus, told: list[Event]) -> None:
    """Let the agent who told these join, and tell them again when it is asked."""
    agent, life = told[0].agent, told[0].incarnation

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, EventsAsked):
            for event in told:
                if message.incarnation == life and message.first <= event.number <= message.last:
                    bus.tell(agent, sender, event)
            answer = EventsKept(incarnation=message.incarnation, first=1, last=len(told), life=life)
            bus.tell(agent, sender, answer)

    bus.join(agent, receive)


async def test_an_order_whose_delivery_was_not_heard_is_shown_delivered_all_the_same(url: str) -> None:
    async with gateway(url) as house:
        name = (await house.place())["id"]
        contracted = GoalContracted(
            goal="G1", order=name, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=900.0
        )
        delivered = GoodsDelivered(goal="G1", order=name, item=0, product=PRODUCT, quantity=5, delivered=5)
        told = events("strategist", OrderAccepted(order=name, goals=("G1",)), contracted, delivered)
        remember(house.bus, told)
        # The last one is lost, and nothing comes after it.
        await house.say(told[:2])
        orders = house.projection.orders
        await until(lambda: (shown := orders.get(name)) is not None and shown.status.value == "delivered")
        await house.historian.written()
        assert (await house.get(f"/api/orders/{name}"))["status"] == "delivered"


async def test_a_task_whose_end_was_not_heard_does_not_stay_open(url: str) -> None:
    async with gateway(url) as house:
        told = events("M1", OPENED, CLOSED)
        remember(house.bus, told)
        await house.say(told[:1])
        tasks = house.projection.tasks
        await until(lambda: (shown := tasks.view("M1-1")) is not None and shown.state == "delivered")


async def test_a_task_whose_announcement_comes_after_its_end_does_not_stay_open(url: str) -> None:
    async with gateway(url) as house:
        told = events("M1", OPENED, CLOSED)
        remember(house.bus, told)
        await house.say(told[1:])
        tasks = house.projection.tasks
        await until(lambda: tasks.view("M1-1") is not None)
        shown = tasks.view("M1-1")
        assert shown is not None
        assert shown.state == "delivered"


async def test_what_happened_while_the_gateway_was_away_is_shown_when_it_is_back(url: str) -> None:
    told = events("M1", OPENED, CLOSED)
    async with gateway(url) as house:
        await house.say(told[:1])
    bus = FakeBus()
    remember(bus, told)
    async with gateway(url, bus=bus) as house:
        await until(lambda: house.historian.missing == 0 and bool(bus.sent_to("historian", EventsKept)))
        await house.historian.written()
        kinds = [row["kind"] for row in (await house.get("/api/events", agent="M1"))["items"]]
        assert sorted(kinds) == ["TaskClosed", "TaskOpened"]
