"""How an order's estimate moves: what is kept of it, with which cause, and how its page reads it, also of an ended order."""

from __future__ import annotations

from typing import Any

import pytest
from gateway_kit import PRODUCT, House
from heartbeats import machine_heartbeat
from tracking_kit import GOAL, MACHINE, OTHER_MACHINE, VEHICLE, WAY_OUT, Story
from wall_clock import NOW_S

from dray.gateway.factory import estimate_keeper
from dray.gateway.factory.estimate_keeper import ORDERS_AT_ONCE, EstimateKeeper
from dray.gateway.factory.estimates import Since, estimate, moved
from dray.gateway.factory.lateness import Hold
from dray.gateway.http.provided import provided
from dray.gateway.tracking.eta import Range
from dray.gateway.tracking.reasons import Doing
from dray.messages import Reason
from dray.messages.fact import CarrierChanged, GoalContracted, GoalLost
from dray.messages.heartbeat import GoalBrief, MachineStatus
from dray.store.orders.estimates import ESTIMATES_MOST, Estimate
from dray.store.replay.spells import Spell

pytestmark = pytest.mark.anyio

MINUTE_S = 60.0


def kept(from_s: float | None, to_s: float | None, at_s: float = 0.0) -> Estimate:
    return Estimate(at_s=at_s, from_at_s=from_s, to_at_s=to_s, cause="first")


def at(from_min: float, to_min: float) -> Range:
    return Range(from_min * MINUTE_S, to_min * MINUTE_S)


BEFORE = kept(600.0, 900.0)


# --- pure -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("before", "now", "is_kept"),
    [
        (None, None, False),
        (None, at(10, 15), True),
        (BEFORE, at(10, 15), False),
        # One step of the clock is how it is rounded.
        (BEFORE, at(11, 16), False),
        (BEFORE, at(10, 17), True),
        (BEFORE, at(12, 15), True),
        (BEFORE, None, True),
        (kept(None, None), None, False),
        (kept(None, None), at(10, 15), True),
        # A wide range is told in steps of five minutes.
        (kept(0.0, 3600.0), at(4, 64), False),
        (kept(0.0, 3600.0), at(0, 70), True),
    ],
)
def test_what_moves_by_more_than_a_step_of_its_clock_is_kept(
    before: Estimate | None, now: Range | None, is_kept: bool
) -> None:
    assert moved(before, now) is is_kept


LATER = at(15, 20)
STARVED = ("M4", Hold(doing="starves", by="bearing", lasted_s=200.0))
BROKEN = ("M4", Hold(doing="broken", by="", lasted_s=200.0))


@pytest.mark.parametrize(
    ("since", "told"),
    [
        (Since(), ("later", "", "")),
        (Since(hold=STARVED), ("material", "M4", "bearing")),
        (Since(hold=BROKEN), ("stands", "M4", "")),
        (Since(hold=("M4", Hold(doing="silent", lasted_s=200.0))), ("silent", "M4", "")),
        # Too short to be why it is five minutes later.
        (Since(hold=("M4", Hold(doing="broken", lasted_s=60.0))), ("later", "", "")),
        (Since(passed="O-2"), ("passed", "", "O-2")),
        (Since(replaced=("ATV3", "ATV1")), ("replaced", "ATV3", "ATV1")),
        (Since(held_up=True), ("held_up", "", "")),
        (Since(moved=("M4", "M5"), hold=BROKEN), ("moved", "M4", "M5")),
        (Since(changed=True, moved=("M4", "M5")), ("changed", "", "")),
    ],
)
def test_a_later_estimate_has_a_cause_by_name(since: Since, told: tuple[str, str, str]) -> None:
    found = estimate(BEFORE, LATER, since, 50.0)
    assert (found.cause, found.agent, found.other) == told
    assert (found.at_s, found.from_at_s, found.to_at_s) == (50.0, LATER.from_s, LATER.to_s)


@pytest.mark.parametrize(
    ("now", "cause"), [(at(12, 15), "closer"), (at(12, 13), "closer"), (at(5, 9), "sooner")]
)
def test_what_is_no_later_is_sooner_or_known_more_exactly(now: Range, cause: str) -> None:
    assert estimate(BEFORE, now, Since(hold=BROKEN), 50.0).cause == cause


@pytest.mark.parametrize(
    ("since", "told"),
    [
        (Since(waits=True, doings={"M4": Doing.BROKEN}), ("no_machine", "")),
        (Since(doings={"M4": Doing.SILENT, "M5": Doing.BROKEN}), ("stands", "M5")),
        (Since(doings={"M4": Doing.SILENT}), ("silent", "M4")),
        (Since(doings={"M4": Doing.MAKING}), ("unknown", "")),
    ],
)
def test_what_cannot_be_told_any_more_says_why(since: Since, told: tuple[str, str]) -> None:
    found = estimate(BEFORE, None, since, 50.0)
    assert (found.cause, found.agent, found.to_at_s) == (*told, None)


def test_what_can_be_told_again_is_so_or_goes_on_elsewhere() -> None:
    assert estimate(kept(None, None), LATER, Since(), 50.0).cause == "again"
    found = estimate(kept(None, None), LATER, Since(moved=("M4", "M5")), 50.0)
    assert (found.cause, found.agent, found.other) == ("moved", "M4", "M5")


# --- with a gateway and a database --------------------------------------------------------------------


@pytest.fixture(autouse=True)
def looks_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the test looks, however long it takes."""
    monkeypatch.setattr(estimate_keeper, "LOOK_EVERY_S", 3_600.0)


async def look(house: House) -> None:
    await provided(house.app, EstimateKeeper).look()


async def told(house: House, order: str) -> list[dict[str, Any]]:
    story = await house.get(f"/api/orders/{order}/timeline")
    return list(story["estimates"])


async def test_the_first_estimate_is_kept_once_and_nothing_while_it_stays(house: House) -> None:
    story = await Story.begin(house)
    await look(house)
    assert await told(house, story.order["id"]) == []
    story.now(100.0)
    await story.planned(finish_s=600.0)
    for _ in range(3):
        await look(house)
    (first,) = await told(house, story.order["id"])
    assert (first["cause"], first["at_s"]) == ("first", NOW_S + 100.0)
    expected = (await house.get(f"/api/orders/{story.order['id']}/timeline"))["expected"]
    assert (first["from_at_s"], first["to_at_s"]) == (expected["from_at_s"], expected["to_at_s"])


async def test_a_machine_that_stands_is_named_and_so_is_who_goes_on(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    await look(house)
    story.now(200.0)
    story.beat(MACHINE, 200.0, MachineStatus.ERROR)
    await look(house)
    order = story.order["id"]
    assert [(each["cause"], each["agent"], each["to_at_s"]) for each in await told(house, order)][1:] == [
        ("stands", MACHINE, None)
    ]
    # Another one goes on.
    story.now(300.0)
    await story.tell("strategist", 250.0, GoalLost(GOAL, MACHINE, 0, f"{GOAL}b"))
    again = GoalContracted(f"{GOAL}b", order, 0, PRODUCT, story.quantity, OTHER_MACHINE, 1500.0)
    await story.tell("strategist", 260.0, again)
    story.beat(OTHER_MACHINE, 300.0, goal=f"{GOAL}b")
    await look(house)
    newest = (await told(house, order))[-1]
    assert (newest["cause"], newest["agent"], newest["other"]) == ("moved", MACHINE, OTHER_MACHINE)
    assert newest["to_at_s"] > NOW_S + 1500.0


async def later(story: Story, at_s: float, finish_s: float) -> None:
    """The machine promises anew, and the estimate is looked at."""
    fact = GoalContracted(GOAL, story.order["id"], 0, PRODUCT, story.quantity, MACHINE, finish_s)
    await story.tell("strategist", at_s - 5.0, fact)
    story.now(at_s)
    await look(story.house)


async def test_material_that_was_waited_for_is_named(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    await look(house)
    starved = Spell(
        agent=MACHINE,
        doing="starves",
        from_at_s=NOW_S + 110,
        until_at_s=NOW_S + 390,
        task=GOAL,
        other="bearing",
    )
    async with house.store.write() as work:
        await work.spells.add([starved])
    story.now(400.0)
    story.beat(MACHINE, 400.0)
    await later(story, 400.0, 1000.0)
    newest = (await told(house, story.order["id"]))[-1]
    assert (newest["cause"], newest["agent"], newest["other"]) == ("material", MACHINE, "bearing")


async def test_a_carrier_that_was_replaced_is_named(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    await look(house)
    await story.leaving(150.0)
    await story.tell(MACHINE, 160.0, CarrierChanged(WAY_OUT, 2, VEHICLE, "ATV1", Reason.SILENT, 5.0))
    story.beat(MACHINE, 200.0)
    await later(story, 200.0, 1100.0)
    newest = (await told(house, story.order["id"]))[-1]
    assert (newest["cause"], newest["agent"], newest["other"]) == ("replaced", VEHICLE, "ATV1")


async def test_an_order_that_is_made_before_it_now_is_named(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    await look(house)
    urgent = (await house.place(priority="urgent"))["id"]
    await story.tell("strategist", 150.0, GoalContracted("G-urgent", urgent, 0, PRODUCT, 5, MACHINE, 400.0))
    queue = (
        GoalBrief("G-urgent", PRODUCT, 5, 0, 0),
        GoalBrief(GOAL, PRODUCT, story.quantity, 0, 0),
    )
    house.bus.say(machine_heartbeat(MACHINE, 50, at_s=200.0, status=MachineStatus.PRODUCING, goals=queue))
    await later(story, 200.0, 1100.0)
    newest = (await told(house, story.order["id"]))[-1]
    assert (newest["cause"], newest["other"]) == ("passed", urgent)


async def test_two_gateways_keep_a_move_once(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    other = EstimateKeeper(house.store, house.projection, house.wall)
    await look(house)
    await other.look()
    assert len(await told(house, story.order["id"])) == 1


async def test_every_open_order_has_its_turn(house: House) -> None:
    stories = [await Story.begin(house, quantity=5) for _ in range(ORDERS_AT_ONCE + 3)]
    for number, story in enumerate(stories):
        fact = GoalContracted(f"G-{number}", story.order["id"], 0, PRODUCT, 5, MACHINE, 600.0)
        await story.tell("strategist" if number == 0 else f"strategist{number + 1}", 90.0, fact)
    stories[0].now(100.0)
    stories[0].beat(MACHINE, 100.0, goal="G-0")
    await look(house)
    counts = [len(await told(house, story.order["id"])) for story in stories]
    assert sum(counts) == ORDERS_AT_ONCE
    await look(house)
    assert all([len(await told(house, story.order["id"])) == 1 for story in stories])


async def test_an_ended_order_keeps_how_it_moved(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    await look(house)
    await house.client.post(f"/api/orders/{story.order['id']}/cancel")
    await look(house)
    answer = await house.get(f"/api/orders/{story.order['id']}/timeline")
    assert [each["cause"] for each in answer["estimates"]] == ["first"]
    assert answer["expected"] is None


async def test_of_one_order_so_many_are_kept_with_the_first_of_all(house: House) -> None:
    order = (await house.place())["id"]
    async with house.store.write() as work:
        for number in range(ESTIMATES_MOST + 5):
            await work.estimates.add(order, kept(0.0, float(number), at_s=float(number)))
        rows = await work.estimates.of_order(order)
    assert len(rows) == ESTIMATES_MOST
    assert [row.at_s for row in rows[:2]] == [0.0, 6.0]
    assert rows[-1].at_s == ESTIMATES_MOST + 4


async def test_while_the_clock_stands_or_is_set_back_nothing_is_kept(house: House) -> None:
    story = await Story.begin(house)
    story.now(100.0)
    await story.planned(finish_s=600.0)
    await look(house)
    order = story.order["id"]
    (first,) = await told(house, order)
    for at_s in (100.0, 50.0):
        story.now(at_s)
        story.beat(MACHINE, at_s, MachineStatus.ERROR)
        await look(house)
    assert await told(house, order) == [first]
    story.now(101.0)
    story.beat(MACHINE, 101.0, MachineStatus.ERROR)
    await look(house)
    assert len(await told(house, order)) == 2
