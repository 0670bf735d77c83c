"""The timeline of an order: goals, transports, carriers, and what went otherwise."""

from __future__ import annotations

import random
from typing import Any

import msgspec
import pytest
from answers import problem
from gateway_kit import PRODUCT, House
from heartbeats import machine_heartbeat
from tracking_kit import GOAL, MACHINE, OTHER_MACHINE, PACE_S, VEHICLE, WAY_OUT, Story, iso
from wall_clock import NOW_S

from dray.gateway.orders.timeline import TimelineView, timeline
from dray.messages import GoalBrief, MachineStatus, Phase, Reason, Role, Transport
from dray.messages.fact import (
    AnyFact,
    CarrierChanged,
    GoalContracted,
    GoalLost,
    GoalWithdrawn,
    OrderDropped,
    OrderFulfilled,
    PhaseEntered,
    PieceMade,
    PromiseMoved,
    TaskClosed,
    TaskOpened,
)
from dray.store.history.events import EventRow
from dray.store.orders.progress import Goal

pytestmark = pytest.mark.anyio

WORK = Transport("shaft", 8, ("M4",), "DELIVERY", "tote", goal="G1")

OPENED = TaskOpened("M4-1", 1, Role.PRIMARY, 1, WORK, 20.0, 300.0, 5.0)


def rows(*told: tuple[float, str, AnyFact]) -> list[EventRow]:
    """Events of the plant's clock, which is the wall's."""
    return [
        EventRow(
            position=place,
            agent=agent,
            incarnation=1,
            number=place,
            at_s=at_s,
            plant_s=at_s,
            kind=type(fact).__name__,
            task=None,
            goal=None,
            order_id=None,
            fact=msgspec.Raw(msgspec.json.encode(fact)),
        )
        for place, (at_s, agent, fact) in enumerate(told, 1)
    ]


def phase(atv: str, at_s: float, name: Phase, epoch: int = 1) -> tuple[float, str, AnyFact]:
    return at_s, atv, PhaseEntered("M4-1", epoch, name, "M4")


def brought() -> list[EventRow]:
    """ATV3 falls silent with nothing aboard, ATV1 takes over and brings it."""
    return rows(
        (1.0, "strategist", GoalContracted("G1", "O-1", 0, "shaft", 8, "M4", 90.0)),
        (10.0, "M4", PieceMade("G1", "shaft", 1)),
        (20.0, "M4", PieceMade("G1", "shaft", 2)),
        (21.0, "M4", OPENED),
        phase("ATV3", 22.0, Phase.APPROACHING),
        (30.0, "M4", CarrierChanged("M4-1", 2, "ATV3", "ATV1", Reason.SILENT, 5.5)),
        phase("ATV1", 31.0, Phase.APPROACHING, 2),
        phase("ATV1", 40.0, Phase.CARRYING, 2),
        phase("ATV1", 50.0, Phase.HANDING_OVER, 2),
        (51.0, "M4", TaskClosed("M4-1", 2, "delivered", "ATV1", 45.0)),
        (52.0, "strategist", OrderFulfilled("O-1")),
    )


def kinds(view: TimelineView) -> list[str]:
    return [each.kind for each in view.moments]


# --- pure -------------------------------------------------------------------------------------------


def test_a_transport_tells_who_carried_it_and_why_another_went_on() -> None:
    told = timeline(brought(), [])
    (way,) = told.transports
    assert (way.source, way.destination, way.outcome) == ("M4", "DELIVERY", "delivered")
    assert (way.opened_at_s, way.closed_at_s) == (21.0, 51.0)
    first, second = way.legs
    assert (first.carrier, first.since_at_s, first.aboard_at_s, first.until_at_s) == (
        "ATV3",
        22.0,
        None,
        30.0,
    )
    assert first.replaced == "silent"
    assert (second.carrier, second.aboard_at_s, second.until_at_s) == ("ATV1", 40.0, 50.0)
    assert second.replaced == ""


def test_an_order_is_delivered_once_however_many_strategists_tell_it() -> None:
    told = timeline(
        rows((9.0, "strategist2", OrderFulfilled("O-1")), (5.0, "strategist", OrderFulfilled("O-1"))), []
    )
    assert [(each.kind, each.at_s) for each in told.moments] == [("delivered", 5.0)]


def test_what_happened_is_told_in_its_order() -> None:
    told = timeline(brought(), [])
    assert kinds(told) == ["planned", "began", "took_over", "fetched", "handed_over", "delivered"]
    change = told.moments[2]
    assert (change.agent, change.other, change.silent_s, change.task) == ("ATV1", "ATV3", 5.5, "M4-1")


def test_a_simulated_factory_that_was_started_again_goes_on_in_the_story() -> None:
    """Its plant's clock began anew: 1,000 s of the wall lie between the two."""
    later = [
        msgspec.structs.replace(each, plant_s=each.plant_s - 30.0, at_s=each.at_s + 1000.0)
        for each in brought()[5:]
    ]
    told = timeline(later + brought()[:5], [])
    assert kinds(told) == ["planned", "began", "took_over", "fetched", "handed_over", "delivered"]
    assert [each.at_s for each in told.moments] == sorted(each.at_s for each in told.moments)


def test_events_may_come_in_any_order() -> None:
    told, shuffled = brought(), brought()
    random.Random(7).shuffle(shuffled)
    assert timeline(shuffled, []) == timeline(told, [])


def test_a_cancelled_order_ends_the_goals_that_are_not_all_made_those_of_its_parts_too() -> None:
    told = timeline(
        rows(
            (1.0, "strategist", GoalContracted("G1", "O-1", 0, "gearbox", 4, "ASSEMBLY1", 90.0)),
            (2.0, "strategist", GoalContracted("G2", "O-1", 0, "gear-set", 6, "PRESS1", 60.0, "gearbox")),
            (3.0, "strategist", GoalContracted("G3", "O-1", 0, "gear", 8, "MILL1", 30.0, "gear-set")),
            (4.0, "strategist", GoalContracted("G4", "O-1", 0, "shaft", 1, "LATHE1", 30.0, "gear-set")),
            (5.0, "MILL1", PieceMade("G3", "gear", 3)),
            (6.0, "LATHE1", PieceMade("G4", "shaft", 1)),
            (9.0, "strategist", GoalWithdrawn("G2", "PRESS1", 0)),
            (9.0, "strategist", GoalWithdrawn("G3", "MILL1", 0)),
            (9.0, "strategist", OrderDropped("O-1")),
        ),
        [],
    )
    assert [(goal.goal, goal.ended, goal.ended_at_s, goal.made) for goal in told.goals] == [
        ("G1", "withdrawn", 9.0, 0),
        ("G2", "withdrawn", 9.0, 0),
        ("G3", "withdrawn", 9.0, 3),
        ("G4", "", None, 1),
    ]
    assert [each.goal for each in told.moments if each.kind == "withdrawn"] == ["G2", "G3"]
    assert kinds(told)[-1] == "dropped"


def test_a_goal_that_was_lost_goes_on_at_another_machine() -> None:
    told = timeline(
        rows(
            (1.0, "strategist", GoalContracted("G1", "O-1", 0, "shaft", 8, "M4", 90.0)),
            (9.0, "strategist", GoalLost("G1", "M4", 2, "G2")),
            (11.0, "strategist", GoalContracted("G2", "O-1", 0, "shaft", 6, "M5", 120.0)),
        ),
        [],
    )
    lost, after = told.goals
    assert (lost.ended, lost.ended_at_s, lost.successor) == ("lost", 9.0, "G2")
    assert (after.machine, after.quantity, after.ended) == ("M5", 6, "")
    assert [(each.kind, each.agent, each.other) for each in told.moments] == [
        ("planned", "M4", ""),
        ("moved", "M5", "M4"),
    ]


def test_a_task_that_is_announced_again_is_one_transport_and_has_nobody_meanwhile() -> None:
    told = timeline(
        rows(
            (1.0, "M4", OPENED),
            phase("ATV3", 2.0, Phase.APPROACHING),
            (9.0, "M4", CarrierChanged("M4-1", 2, "ATV3", "", Reason.IN_ERROR)),
            (9.0, "M4", TaskOpened("M4-1", 2, Role.PRIMARY, 1, WORK, 40.0, 300.0, 12.0)),
        ),
        [],
    )
    (way,) = told.transports
    assert (way.opened_at_s, way.closed_at_s) == (1.0, None)
    assert [(leg.carrier, leg.until_at_s, leg.replaced) for leg in way.legs] == [("ATV3", 9.0, "in_error")]
    assert kinds(told) == ["announced_anew"]


def test_what_a_replaced_vehicle_tells_late_is_no_leg_of_its_own() -> None:
    late = [*brought(), *rows(phase("ATV3", 60.0, Phase.RETURNING))]
    assert [leg.carrier for leg in timeline(late, []).transports[0].legs] == ["ATV3", "ATV1"]


def test_of_what_was_pruned_the_goals_are_told() -> None:
    known = Goal(id="G1", order_id="O-1", product="shaft", quantity=8, machine="M4", made=8, delivered=8)
    told = timeline([], [known])
    assert [(each.goal, each.machine, each.made, each.delivered) for each in told.goals] == [
        ("G1", "M4", 8, 8)
    ]
    assert told.moments == ()


# --- over REST --------------------------------------------------------------------------------------


async def test_an_order_tells_its_timeline_and_when_it_is_expected(house: House) -> None:
    story = await Story.begin(house, quantity=4)
    await story.planned()
    now_s = await story.making(2)
    await story.leaving(now_s + 1.0)
    told = await house.get(f"/api/orders/{story.order['id']}/timeline")
    (goal,) = told["goals"]
    assert (goal["machine"], goal["made"], goal["begun_at_s"]) == (MACHINE, 2, NOW_S + 110.0 + PACE_S)
    (way,) = told["transports"]
    assert (way["task"], [leg["carrier"] for leg in way["legs"]]) == (WAY_OUT, [VEHICLE])
    assert [each["kind"] for each in told["moments"]] == ["planned", "began", "fetched"]
    assert told["is_whole"]
    assert NOW_S < told["expected"]["from_at_s"] <= told["expected"]["to_at_s"]


async def test_a_goal_tells_what_its_machine_does_and_since_when(house: House) -> None:
    story = await Story.begin(house, quantity=4)
    path = f"/api/orders/{story.order['id']}"
    await story.planned()
    other = GoalBrief("strategist.1-1", PRODUCT, 3, 0, 0)
    own = GoalBrief(GOAL, PRODUCT, 4, 0, 0)

    async def tells(
        seq: int, *goals: GoalBrief, status: MachineStatus = MachineStatus.PRODUCING
    ) -> list[Any]:
        story.now(100.0 + seq)
        beat = machine_heartbeat(MACHINE, seq, at_s=100.0 + seq, status=status, goals=goals)
        house.bus.say(beat)
        (goal,) = (await house.get(f"{path}/timeline"))["goals"]
        begun = (await house.get(path))["begun"]
        reached = [stage["name"] for stage in (await story.state())["stages"] if stage["reached"]]
        assert begun == ("in_production" in reached), "the customer's page says the same"
        return [goal["doing"], goal["doing_since_at_s"], goal["behind"], begun]

    assert await tells(10, other, own) == ["busy", None, 1, False]
    assert await tells(11, own) == ["making", NOW_S + 111.0, 0, True]
    assert await tells(12, own, status=MachineStatus.STARVED) == ["starved", None, 0, True]
    assert await tells(13, own, status=MachineStatus.ERROR) == ["broken", None, 0, False]
    assert await tells(14, msgspec.structs.replace(own, made=4)) == ["busy", None, 0, False]


async def test_an_order_and_its_customers_page_are_the_same_when_the_log_has_forgotten_everything(
    house: House,
) -> None:
    story = await Story.begin(house, quantity=4)
    await story.planned()
    now_s = await story.making(4)
    await story.leaving(now_s + 1.0)
    await story.arrived(4, now_s + 30.0)
    path = f"/api/orders/{story.order['id']}/timeline"
    before, state, page = await house.get(path), await story.state(), await story.page()
    assert [each["kind"] for each in before["moments"]] == ["planned", "began", "fetched", "arrived"]
    await house.forget_everything()
    assert await house.get(path) == before
    assert await story.state() == state
    assert await story.page() == page


async def test_a_moved_goal_is_told_over_rest(house: House) -> None:
    story = await Story.begin(house, quantity=4)
    await story.planned()
    await story.lost(120.0)
    await story.planned("strategist.1-8", OTHER_MACHINE)
    told = await house.get(f"/api/orders/{story.order['id']}/timeline")
    assert [(each["goal"], each["ended"]) for each in told["goals"]] == [
        (GOAL, "lost"),
        ("strategist.1-8", ""),
    ]


async def test_of_an_order_that_is_not_there_nothing_is_told(house: House) -> None:
    for method, path in (("GET", "timeline"), ("POST", "links"), ("DELETE", "links")):
        answer = await house.client.request(method, f"/api/orders/O-NONE/{path}", json={})
        assert problem(answer, 404, "unknown-order")["detail"]


async def test_links_are_made_followed_and_taken_back(house: House) -> None:
    story = await Story.begin(house)
    path = f"/api/orders/{story.order['id']}"
    made = (await house.client.post(f"{path}/links", json={"days": 30})).json()
    assert made["expires_at_s"] == NOW_S + 30 * 86_400.0
    page = "/track/" + made["tracking_url"].rpartition("/")[2]
    assert (await house.client.get(page)).status_code == 200
    first, second = (await house.get(f"{path}/timeline"))["links"]
    assert {first["expires_at_s"], second["expires_at_s"]} == {made["expires_at_s"], None}
    assert made["tracking_url"] not in str(await house.get(f"{path}/timeline")), "it is told once"
    assert (await house.client.delete(f"{path}/links")).json() == {"count": 2}
    assert (await house.client.delete(f"{path}/links")).json() == {"count": 0}
    for each in (page, story.path):
        assert (await house.client.get(each)).status_code == 410
    links = (await house.get(f"{path}/timeline"))["links"]
    assert all(each["revoked_at_s"] == NOW_S for each in links)


@pytest.mark.parametrize("draft", [{"days": 0}, {"days": 3651}, {"days": "soon"}, {"until": 3}])
async def test_a_link_for_no_days_is_refused_at_its_field(house: House, draft: dict[str, Any]) -> None:
    story = await Story.begin(house)
    answer = await house.client.post(f"/api/orders/{story.order['id']}/links", json=draft)
    (error,) = problem(answer, 422, "unusable-fields")["errors"]
    assert error["field"] == next(iter(draft))


# --- promises ---------------------------------------------------------------------------------------


def test_a_moved_promise_is_told_with_the_first_one() -> None:
    contracted = GoalContracted("G1", "O-1", 0, "shaft", 8, "M4", 90.0)
    goal = Goal("G1", "O-1", 0, "shaft", 8, "M4", promised_at_s=90.0, incarnation=1, number=1)
    [plain] = timeline(rows((1.0, "strategist", contracted)), [goal]).goals
    assert (plain.promised_at_s, plain.first_promised_at_s, plain.came_before) == (90.0, None, 0)
    told = rows(
        (1.0, "strategist", contracted),
        (2.0, "M4", PromiseMoved("G1", 300.0, 1)),
        (4.0, "M4", PromiseMoved("G1", 604.0, 3)),
    )
    [moved] = timeline(told, [goal]).goals
    assert (moved.promised_at_s, moved.first_promised_at_s, moved.came_before) == (604.0, 90.0, 3)
    # In a simulated plant at double speed the same time passes in half.
    [fast] = timeline(told, [goal], speed=2.0).goals
    assert fast.promised_at_s == 304.0


def test_the_next_machine_promises_anew() -> None:
    first, second = (
        GoalContracted(name, "O-1", 0, "shaft", 8, machine, finish_s)
        for name, machine, finish_s in (("G1", "M4", 90.0), ("G2", "M5", 900.0))
    )
    told = rows(
        (1.0, "strategist", first),
        (2.0, "M4", PromiseMoved("G1", 300.0, 1)),
        (3.0, "strategist", GoalLost("G1", "M4", 0, "G2")),
        (4.0, "strategist", second),
    )
    goals = [
        Goal("G1", "O-1", 0, "shaft", 8, incarnation=1, number=3),
        Goal("G2", "O-1", 0, "shaft", 8, "M5", promised_at_s=900.0, incarnation=1, number=4),
    ]
    lost, anew = timeline(told, goals).goals
    assert (lost.promised_at_s, lost.first_promised_at_s) == (None, None)
    assert (anew.promised_at_s, anew.first_promised_at_s, anew.came_before) == (900.0, None, 0)


async def test_the_page_and_the_table_of_orders_tell_the_promise_that_holds_and_the_first_one(
    house: House,
) -> None:
    story = await Story.begin(house)
    await story.planned(finish_s=600.0)
    await story.tell(MACHINE, 120.0, PromiseMoved(GOAL, 900.0, 3))
    told = await house.get(f"/api/orders/{story.order['id']}/timeline")
    [goal] = told["goals"]
    assert (goal["promised_at_s"], goal["first_promised_at_s"]) == (NOW_S + 900.0, NOW_S + 600.0)
    assert goal["came_before"] == 3
    head, row = (await house.client.get("/api/orders", params={"format": "csv"})).text.splitlines()
    cells = dict(zip(head.lstrip("\ufeff").split(","), row.split(","), strict=True))
    assert cells["promised_at"][:19] == iso(NOW_S + 900.0)[:19]
    assert cells["first_promised_at"][:19] == iso(NOW_S + 600.0)[:19]
    assert cells["came_before"] == "3"
