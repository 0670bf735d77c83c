"""The story of what a machine has brought for itself, over REST: who carried it and who took it over, also long after it has ended."""

from __future__ import annotations

import pytest
from gateway_kit import House
from heartbeats import events
from makings import making

from dray.gateway.access.principal import Scope
from dray.messages import Phase, Reason, Role, Transport
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    CarrierChanged,
    PhaseEntered,
    TaskClosed,
    TaskOpened,
)

pytestmark = pytest.mark.anyio

TASK = "M8.1-1"
PATH = f"/api/tasks/{TASK}/timeline"
BRING = Transport("shaft", 40, ("S2", "S3"), "M8", "tote")

CARRIED: tuple[tuple[str, AnyFact], ...] = (
    ("M8", TaskOpened(TASK, 1, Role.PRIMARY, 1, BRING, 20.0, 300.0, 5.0)),
    ("M8", AwardAnswered(TASK, 1, Role.PRIMARY, "ATV6", "accepted")),
    ("ATV6", PhaseEntered(TASK, 1, Phase.APPROACHING, "S3")),
    ("M8", CarrierChanged(TASK, 2, "ATV6", "ATV1", Reason.SILENT, 5.5)),
    ("ATV1", PhaseEntered(TASK, 2, Phase.APPROACHING, "S3")),
    ("ATV1", PhaseEntered(TASK, 2, Phase.CARRYING, "S3")),
    ("ATV1", PhaseEntered(TASK, 2, Phase.HANDING_OVER, "M8")),
    ("M8", TaskClosed(TASK, 2, "delivered", "ATV1", 45.0)),
)
"""ATV6 wins and falls silent, ATV1 takes over and brings it."""


async def carried(house: House) -> None:
    for number, (agent, fact) in enumerate(CARRIED, 1):
        await house.say(events(agent, fact, first=number, at_s=10.0 * number))


async def test_it_tells_who_has_ordered_who_won_who_took_over_and_who_brought_it(house: House) -> None:
    await carried(house)
    story = await house.get(PATH)
    transport = story["transport"]
    assert (transport["coordinator"], transport["carrier"], transport["order"]) == ("M8", "ATV1", "")
    assert [(each["kind"], each["agent"]) for each in story["moments"]] == [
        ("called", "M8"),
        ("won", "ATV6"),
        ("took_over", "ATV1"),
        ("fetched", "ATV1"),
        ("handed_over", "ATV1"),
        ("delivered", ""),
    ]
    (attempt,) = story["attempts"]
    # Of all that may have been its source the one that its carrier has chosen.
    assert (transport["source"], attempt["source"]) == ("S2/S3", "S3")
    assert [(leg["carrier"], leg["replaced"]) for leg in attempt["legs"]] == [
        ("ATV6", "silent"),
        ("ATV1", ""),
    ]
    assert story["is_whole"]


async def test_it_tells_who_brought_it_when_the_log_has_forgotten(house: House) -> None:
    await carried(house)
    async with house.store.write() as work:
        await work.events.forget(1, 1_000)
    story = await house.get(PATH)
    assert [each["kind"] for each in story["moments"]] == ["called", "delivered"]
    (attempt,) = story["attempts"]
    assert ([leg["carrier"] for leg in attempt["legs"]], attempt["outcome"]) == (["ATV1"], "delivered")
    assert not story["is_whole"]


async def test_one_that_is_under_way_has_no_end(house: House) -> None:
    for number, (agent, fact) in enumerate(CARRIED[:3], 1):
        await house.say(events(agent, fact, first=number, at_s=10.0 * number))
    story = await house.get(PATH)
    assert [each["kind"] for each in story["moments"]] == ["called", "won"]
    assert story["attempts"][0]["legs"][0]["until_at_s"] is None


async def test_there_is_no_story_of_what_nobody_knows(house: House) -> None:
    answer = await house.client.get(PATH)
    assert (answer.status_code, TASK in answer.text) == (404, True)


async def test_nor_of_what_is_made(house: House) -> None:
    await house.say(events("M8", TaskOpened("G-1", 1, Role.PRIMARY, 1, making("gear", 5), 20.0, 300.0, 5.0)))
    assert (await house.get("/api/tasks/history?kind=production"))["items"][0]["id"] == "G-1"
    assert (await house.client.get("/api/tasks/G-1/timeline")).status_code == 404


async def test_whoever_may_not_read_orders_is_not_told_for_which_one_it_is(house: House) -> None:
    work = Transport("gear", 8, ("M8",), "DELIVERY", "tote", goal="O-1-1.1")
    await house.say(events("M8", TaskOpened(TASK, 1, Role.PRIMARY, 1, work, 20.0, 300.0, 5.0)))
    _, viewer = await house.key(Scope.FACTORY_READ)
    answer = await house.visitor(**viewer).get(PATH)
    story = answer.json()
    assert "O-1-1.1" not in answer.text
    assert story["attempts"][0]["goal"] == story["transport"]["goal"] != ""
