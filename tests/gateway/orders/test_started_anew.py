"""A factory that was started without a memory: what its former life left open has ended, and orders go on from what has arrived."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from gateway_kit import PRODUCT, House, gateway
from heartbeats import events
from tracking_kit import GOAL, OTHER_MACHINE, VEHICLE, WAY_OUT, Story, iso
from wall_clock import NOW_S, Wall

from dray.messages import Event, TransportOrdered, TransportState
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderAccepted, TransportProgressed
from dray.store import open_store

pytestmark = pytest.mark.anyio

ANEW_S = NOW_S + 1000.0

NEW_GOAL = "strategist.2-1"


async def begun(house: House) -> Story:
    """Of eight pieces four are made, one of which has arrived; a vehicle is on its way with the others."""
    story = await Story.begin(house, quantity=8)
    await story.planned()
    now_s = await story.making(4)
    await story.arrived(1, now_s + 1.0)
    await story.leaving(now_s + 2.0)
    return story


@asynccontextmanager
async def later(url: str, story: Story, *, anew: bool) -> AsyncIterator[House]:
    """A gateway that starts later, with the factory or alone."""
    store = await open_store(url)
    try:
        incarnation = await (store.begin_anew("plant", ANEW_S) if anew else store.next_incarnation("plant"))
    finally:
        await store.close()
    wall = Wall()
    wall.now_s = ANEW_S + 5.0
    async with gateway(url, incarnation=incarnation, wall=wall) as house:
        story.house = house
        yield house


async def taken_again(house: House, order: str) -> None:
    """A machine of the new life takes what has not arrived."""
    facts = (
        OrderAccepted(order=order, goals=(NEW_GOAL,)),
        GoalContracted(NEW_GOAL, order, 0, PRODUCT, 7, OTHER_MACHINE, 1600.0),
    )
    await house.say(
        Event(agent="strategist", incarnation=2, number=each.number, at_s=1010.0, fact=each.fact)
        for each in events("strategist", *facts)
    )


async def timeline_of(house: House, story: Story) -> Any:
    return await house.get(f"/api/orders/{story.order['id']}/timeline")


async def test_goals_and_transports_of_the_former_life_have_ended_with_their_reason(url: str) -> None:
    async with gateway(url) as house:
        story = await begun(house)
    async with later(url, story, anew=True) as house:
        told = await timeline_of(house, story)
        (goal,), (way,) = told["goals"], told["transports"]
        assert (goal["ended"], goal["ended_at_s"], goal["promised_at_s"]) == ("started_anew", ANEW_S, None)
        assert (way["outcome"], way["closed_at_s"]) == ("started_anew", ANEW_S)
        assert [(leg["carrier"], leg["until_at_s"]) for leg in way["legs"]] == [(VEHICLE, ANEW_S)]
        assert [(each["kind"], each["at_s"]) for each in told["moments"]][-1] == ("started_anew", ANEW_S)
        await taken_again(house, story.order["id"])
        told = await timeline_of(house, story)
        assert [(each["goal"], each["ended"], each["quantity"]) for each in told["goals"]] == [
            (GOAL, "started_anew", 8),
            (NEW_GOAL, "", 7),
        ]
        assert sum(each["quantity"] for each in told["goals"] if not each["ended"]) == 7
        assert [each["kind"] for each in told["moments"]].count("started_anew") == 1


async def test_lists_show_nothing_of_the_former_life_as_open(url: str) -> None:
    async with gateway(url) as house:
        story = await begun(house)
        before = (await house.get("/api/tasks/history"))["items"]
        assert [(each["id"], each["state"]) for each in before] == [(WAY_OUT, "bidding")]
    async with later(url, story, anew=True) as house:
        (task,) = (await house.get("/api/tasks/history"))["items"]
        assert (task["state"], task["closed_at_s"]) == ("withdrawn", ANEW_S)
        kinds = [each["kind"] for each in (await house.get(f"/api/tasks/{WAY_OUT}/timeline"))["moments"]]
        assert "started_anew" in kinds


async def test_an_order_counts_what_has_arrived_and_nothing_that_was_only_made(url: str) -> None:
    async with gateway(url) as house:
        story = await begun(house)
        (item,) = (await house.get(f"/api/orders/{story.order['id']}"))["items"]
        assert (item["made"], item["delivered"]) == (4, 1)
    async with later(url, story, anew=True) as house:
        (item,) = (await house.get(f"/api/orders/{story.order['id']}"))["items"]
        assert (item["made"], item["delivered"]) == (1, 1)
        (line,) = (await house.get("/api/orders"))["items"]
        assert [line["items"][0][name] for name in ("made", "delivered")] == [1, 1]


async def test_the_customer_is_told_why_it_takes_longer(url: str) -> None:
    async with gateway(url) as house:
        story = await begun(house)
        assert (await story.state())["reasons"] == []
    async with later(url, story, anew=True) as house:
        state = await story.state()
        assert (state["reasons"], state["eta"]) == (["started_anew"], None)
        assert "The factory was started anew" in await story.page()
        await taken_again(house, story.order["id"])
        assert (await story.state())["reasons"] == ["started_anew"]
        last = GoodsDelivered(NEW_GOAL, story.order["id"], 0, PRODUCT, 7, 7)
        await house.say([Event(agent="gate", incarnation=2, number=1, at_s=1500.0, fact=last)])
        state = await story.state()
        assert (state["status"], state["reasons"]) == ("delivered", [])


async def test_an_order_of_which_nothing_has_arrived_is_planned_once_more(url: str) -> None:
    async with gateway(url) as house:
        story = await Story.begin(house, quantity=8)
        await story.planned()
        await story.making(4)
    async with later(url, story, anew=True) as house:
        assert [each["name"] for each in (await story.state())["stages"] if each["reached"]] == ["placed"]
        await taken_again(house, story.order["id"])
        _, planned, *_ = (await story.state())["stages"]
        assert (planned["reached"], planned["at"]) == (True, iso(NOW_S + 1010.0))


async def test_a_gateway_that_starts_alone_ends_nothing(url: str) -> None:
    async with gateway(url) as house:
        story = await begun(house)
        before = await timeline_of(house, story)
        tasks = await house.get("/api/tasks/history")
    async with later(url, story, anew=False) as house:
        told = await timeline_of(house, story)
        assert [each["ended"] for each in told["goals"]] == [""]
        assert (told["transports"], told["moments"]) == (before["transports"], before["moments"])
        assert await house.get("/api/tasks/history") == tasks
        assert (await story.state())["reasons"] == []


async def test_agents_with_journals_go_on_with_lower_numbers_after_a_beginning_of_another_factory(
    url: str,
) -> None:
    """A fleet may use the database of an earlier simulation; its agents count their lives themselves, from 1."""
    store = await open_store(url)
    try:
        assert await store.begin_anew("plant", NOW_S - 10.0) == 1
        assert await store.begin_anew("plant", NOW_S - 5.0) == 2
    finally:
        await store.close()
    async with gateway(url) as house:
        story = await begun(house)
        told = await timeline_of(house, story)
        assert [each["ended"] for each in told["goals"]] == [""]
        assert [each["outcome"] for each in told["transports"]] == [""]


async def test_a_plain_transport_is_called_for_once_more_and_nobody_carries_it(url: str) -> None:
    draft = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 40}
    async with gateway(url) as house:
        story = await Story.begin(house)
        name = (await house.client.post("/api/transports", json=draft)).json()["id"]
        fact = TransportProgressed(
            name,
            TransportState.ASSIGNED,
            item="shaft",
            quantity=40,
            source="S3",
            destination="M8",
            carrier="ATV6",
            expected_s=90.0,
            task=f"{name}-1",
        )
        await house.say(events("M8", fact))
        assert (await house.get(f"/api/transports/{name}"))["carrier"] == "ATV6"
    async with later(url, story, anew=True) as house:
        told = await house.get(f"/api/transports/{name}")
        assert (told["status"], told["carrier"], told["expected_at"], told["task"]) == (
            "waiting",
            None,
            None,
            None,
        )
        assert [asked.transport for asked in house.bus.sent_to("M8", TransportOrdered)] == [name]
