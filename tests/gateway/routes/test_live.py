"""The factory as REST shows it: what agents have told, and the plant's own file."""

from __future__ import annotations

from typing import Any

import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import PRODUCT, House, gateway
from heartbeats import atv_heartbeat, events, machine_heartbeat
from makings import making
from wall_clock import NOW_S

from dray.gateway.access.principal import Scope
from dray.gateway.routes.factory import tasks as tasks_route
from dray.messages import (
    AtvStatus,
    Brief,
    BufferLevel,
    Event,
    GoalBrief,
    MachineStatus,
    Phase,
    Pose,
    Refusal,
    Role,
    TaskBrief,
    Transport,
    TransportCost,
)
from dray.messages.fact import (
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BidRefused,
    GoalContracted,
    OrderAccepted,
    PieceMade,
    TaskClosed,
    TaskOpened,
)

pytestmark = pytest.mark.anyio


def opened(task: str, order: str = "") -> TaskOpened:
    """The birth of a transport, or of an order's goal."""
    carry = Transport(item="steel", quantity=4, sources=("S1",), destination="M1", ability="tote")
    return TaskOpened(
        task=task,
        epoch=1,
        role=Role.PRIMARY,
        round=1,
        work=making(PRODUCT, 5, order) if order else carry,
        radius_m=20.0,
        deadline_s=900.0,
        bids_until_s=105.0,
    )


def auction(task: str = "M1-1") -> list[Event]:
    """M1 hires ATV2; ATV1 is busy."""
    cost = TransportCost(empty_way_s=10.0, loaded_way_s=20.0, energy_s=3.0, suitability_s=1.0)
    bid = BidReceived(
        task=task,
        epoch=1,
        role=Role.PRIMARY,
        round=1,
        bidder="ATV2",
        cost=cost,
        total_s=34.0,
        finish_s=140.0,
        source="S1",
    )
    given = AwardGiven(task=task, epoch=1, role=Role.PRIMARY, bidder="ATV2", rank=1)
    answered = AwardAnswered(task=task, epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    refused = BidRefused(task=task, epoch=1, role=Role.PRIMARY, reason=Refusal.BUSY)
    first, *rest = events("M1", opened(task), bid, given, answered)
    return [first, *events("ATV1", refused), *rest]


async def all_pages(house: House, path: str, **params: Any) -> list[dict[str, Any]]:
    items: list[dict[str, Any]] = []
    while True:
        page = await house.get(path, **params)
        items += page["items"]
        if page["next_cursor"] is None:
            return items
        params["cursor"] = page["next_cursor"]


# --- vehicles and machines -----------------------------------------------------------------------


async def test_before_anything_is_heard_lists_are_empty(house: House) -> None:
    assert await house.get("/api/orders") == {"items": [], "next_cursor": None, "total": 0}
    for noun in ("machines", "atvs", "tasks", "events"):
        assert await house.get(f"/api/{noun}") == {"items": [], "next_cursor": None}


async def test_a_vehicle_is_as_its_last_heartbeat_told(house: House) -> None:
    brief = Brief(
        task="M1-1",
        epoch=2,
        role=Role.PRIMARY,
        coordinator="M1",
        phase=Phase.CARRYING,
        item="steel",
        quantity=4,
        due_s=60.0,
    )
    late = atv_heartbeat(seq=2, battery_frac=0.1)
    newest = atv_heartbeat(
        seq=3,
        at_s=30.0,
        status=AtvStatus.WORKING,
        pose=Pose(3.0, 4.0, 0.5),
        load="steel",
        load_quantity=4,
        task=brief,
        way=("n2", "n3"),
    )
    house.bus.say(atv_heartbeat(seq=1), newest, late)
    atv = await house.get("/api/atvs/ATV1")
    assert (atv["status"], atv["battery_frac"], atv["x_m"]) == ("working", 0.8, 3.0)
    assert (atv["load"], atv["way"], atv["type"]) == ("steel", ["n2", "n3"], PLANT.fleet[0].type)
    assert atv["seen_at_s"] == NOW_S + 30.0
    assert atv["task"]["phase"] == "carrying"
    assert atv["task"]["due_at_s"] == NOW_S + 60.0


async def test_a_machine_is_as_its_last_heartbeat_told(house: House) -> None:
    task = TaskBrief(
        task="M1-1",
        epoch=1,
        item="steel",
        quantity=4,
        source="S1",
        destination="M1",
        deadline_s=900.0,
        primary="ATV2",
    )
    house.bus.say(
        machine_heartbeat(
            seq=2,
            status=MachineStatus.STARVED,
            goals=(GoalBrief("G1", PRODUCT, 5, 2, 1),),
            buffers=(BufferLevel("steel", 0, 60, 20, 4),),
            tasks=(task,),
        ),
        machine_heartbeat(seq=1),
    )
    machine = await house.get("/api/machines/M1")
    assert machine["status"] == "starved"
    assert machine["name"] == PLANT.machines[0].name
    goal = {"goal": "G1", "product": PRODUCT, "quantity": 5, "made": 2, "to_begin": 3, "delivered": 1}
    assert machine["goals"] == [
        {**goal, "deadline_at_s": None, "order_due_at_s": None, "order_name": "", "offered": False}
    ]
    assert machine["buffers"][0]["level"] == 0
    assert machine["buffers"][0]["on_order"] == 4
    assert machine["tasks"][0]["primary"] == "ATV2"
    assert machine["tasks"][0]["deadline_at_s"] == NOW_S + 900.0


async def test_a_restarted_agents_heartbeats_count_from_the_first(house: House) -> None:
    house.bus.say(atv_heartbeat(seq=500), atv_heartbeat(seq=1, incarnation=2, battery_frac=0.3))
    assert (await house.get("/api/atvs/ATV1"))["battery_frac"] == 0.3


async def test_vehicles_and_machines_come_in_pages_by_id(house: House) -> None:
    names = [f"A{number:02}" for number in range(7)]
    house.bus.say(*(atv_heartbeat(name) for name in reversed(names)))
    house.bus.say(*(machine_heartbeat(name) for name in reversed(names)))
    for noun in ("atvs", "machines"):
        for limit in (1, 3, 7, 500):
            found = await all_pages(house, f"/api/{noun}", limit=limit)
            assert [one["id"] for one in found] == names


async def test_the_plants_speed_does_not_touch_the_wall_clock(url: str) -> None:
    async with gateway(url, speed=50.0) as house:
        house.bus.say(atv_heartbeat(at_s=100.0))
        assert (await house.get("/api/atvs/ATV1"))["seen_at_s"] == NOW_S + 2.0
        assert (await house.get("/api/kpis"))["speed"] == 50.0


# --- tasks ---------------------------------------------------------------------------------------


async def test_a_task_tells_its_whole_auction(house: House) -> None:
    house.bus.say(*auction())
    task = await house.get("/api/tasks/M1-1")
    assert (task["kind"], task["coordinator"], task["item"]) == ("transport", "M1", "steel")
    assert (task["state"], task["primary"], task["source"]) == ("contracted", "ATV2", "S1")
    assert task["opened_at_s"] == NOW_S + 101.0
    assert task["promised_at_s"] == NOW_S + 140.0
    (bid,) = task["bids"]
    assert (bid["bidder"], bid["total_s"], bid["answer"]) == ("ATV2", 34.0, "accepted")
    assert bid["parts_s"] == {"empty_way": 10.0, "loaded_way": 20.0, "energy": 3.0, "suitability": 1.0}
    (refusal,) = task["refusals"]
    assert (refusal["agent"], refusal["reason"]) == ("ATV1", "busy")


async def test_tasks_come_newest_first_in_pages_and_by_state(house: House) -> None:
    for number in range(5):
        house.bus.say(*events("M1", opened(f"M1-{number}"), first=number + 1))
    closed = TaskClosed(task="M1-3", epoch=1, outcome="delivered", carrier="ATV2")
    house.bus.say(*events("M1", closed, first=6))
    newest_first = [f"M1-{number}" for number in (4, 3, 2, 1, 0)]
    for limit in (1, 2, 5):
        assert [task["id"] for task in await all_pages(house, "/api/tasks", limit=limit)] == newest_first
    delivered = await house.get("/api/tasks", state="delivered")
    assert [task["id"] for task in delivered["items"]] == ["M1-3"]
    assert len(await all_pages(house, "/api/tasks", state=["bidding", "delivered"], limit=2)) == 5
    assert await all_pages(house, "/api/tasks", state="withdrawn") == []


# --- events --------------------------------------------------------------------------------------


async def test_events_come_in_the_order_in_which_they_were_kept(house: House) -> None:
    await house.say(auction())
    found = await all_pages(house, "/api/events", limit=2)
    assert [event["position"] for event in found] == sorted(event["position"] for event in found)
    assert [event["kind"] for event in found] == [
        "TaskOpened",
        "BidRefused",
        "BidReceived",
        "AwardGiven",
        "AwardAnswered",
    ]
    first = found[0]
    assert (first["agent"], first["incarnation"], first["number"]) == ("M1", 1, 1)
    assert (first["plant_s"], first["at_s"]) == (101.0, NOW_S + 101.0)
    assert first["task"] == "M1-1"
    assert first["fact"]["work"]["kind"] == "transport"
    assert first["fact"]["deadline_s"] == 900.0


async def test_events_are_asked_for_since_the_last_one_seen(house: House) -> None:
    await house.say(auction())
    seen = (await house.get("/api/events", limit=3))["items"][-1]["position"]
    rest = await house.get("/api/events", since=seen)
    assert [event["kind"] for event in rest["items"]] == ["AwardGiven", "AwardAnswered"]
    assert (await house.get("/api/events", since=2**63 - 1))["items"] == []


async def test_the_newest_events_come_first_when_asked_for(house: House) -> None:
    await house.say(auction())
    forwards = await all_pages(house, "/api/events")
    assert await all_pages(house, "/api/events", newest_first=True, limit=2) == forwards[::-1]


async def test_events_are_found_by_kind_agent_and_task(house: House) -> None:
    await house.say([*auction("M1-1"), *events("M2", opened("M2-1"))])
    for question, expected in (
        ({"kind": "TaskOpened"}, 2),
        ({"kind": ["TaskOpened", "BidRefused"]}, 3),
        ({"agent": "ATV1"}, 1),
        ({"agent": ["ATV1", "M2"]}, 2),
        ({"agent": "M2", "kind": "BidRefused"}, 0),
        ({"task": "M1-1"}, 5),
        ({"task": "M1-1", "kind": "AwardGiven"}, 1),
        ({"kind": "NoSuchKind"}, 0),
    ):
        assert len(await all_pages(house, "/api/events", limit=2, **question)) == expected, question


async def test_the_events_of_an_order_are_those_of_its_goals_too(house: House) -> None:
    order = (await house.place())["id"]
    contracted = GoalContracted(
        goal="G1", order=order, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=900.0
    )
    await house.say(
        [
            *events("strategist", OrderAccepted(order=order, goals=("G1",)), opened("G1", order), contracted),
            *events("M1", PieceMade(goal="G1", product=PRODUCT, made=1)),
            *events("M2", PieceMade(goal="G2", product=PRODUCT, made=1)),
        ]
    )
    found = await house.get("/api/events", order=order)
    assert [event["kind"] for event in found["items"]] == [
        "OrderAccepted",
        "TaskOpened",
        "GoalContracted",
        "PieceMade",
    ]


async def test_who_may_not_read_orders_learns_no_order_from_events(house: House) -> None:
    order = (await house.place())["id"]
    goal = f"{order}-1.1"
    contracted = GoalContracted(
        goal=goal, order=order, item=0, product=PRODUCT, quantity=5, machine="M1", finish_s=900.0
    )
    await house.say(
        events("strategist", OrderAccepted(order=order, goals=(goal,)), opened(goal, order), contracted)
    )
    _, header = await house.key(Scope.FACTORY_READ)
    answer = await house.client.get("/api/events", headers=header)
    assert order not in answer.text
    assert order in (await house.client.get("/api/events")).text
    accepted, announced, taken = answer.json()["items"]
    alias = accepted["fact"]["goals"][0]
    assert {announced["task"], taken["goal"], taken["fact"]["goal"]} == {alias}
    assert accepted["order"] == accepted["fact"]["order"] == taken["fact"]["order"]
    for asked in ({"order": order}, {"task": goal}):
        problem(await house.client.get("/api/events", params=asked, headers=header), 403, "not-allowed")


async def test_events_that_were_heard_twice_are_told_once_and_survive_a_restart(url: str) -> None:
    async with gateway(url) as before:
        await before.say(auction())
        await before.say(auction())
    async with gateway(url) as after:
        assert len((await after.get("/api/events"))["items"]) == 5


# --- figures, products, plant --------------------------------------------------------------------


async def test_figures_count_what_was_heard(house: House) -> None:
    await house.place()
    house.bus.say(
        atv_heartbeat("ATV1"),
        atv_heartbeat("ATV2", status=AtvStatus.WORKING),
        machine_heartbeat("M1", status=MachineStatus.STARVED),
    )
    house.bus.say(*auction())
    closed = TaskClosed(task="M1-1", epoch=1, outcome="delivered", carrier="ATV2")
    house.bus.say(*events("M1", closed, first=5, at_s=146.0))
    house.wall.now_s = NOW_S + 200.0
    figures = await house.get("/api/kpis")
    assert figures["orders_open"] == 1
    assert figures["orders_delivered"] == 0
    assert figures["on_time_frac"] is None
    assert figures["atvs_by_status"] == {"idle": 1, "working": 1}
    assert figures["machines_by_status"] == {"starved": 1}
    assert figures["transport_p50_s"] == 50.0
    assert figures["transport_p95_s"] == 50.0
    assert figures["speed"] == 1.0


async def test_products_are_those_that_can_be_ordered(house: House) -> None:
    products = await all_pages(house, "/api/products", limit=3)
    assert [product["id"] for product in products] == sorted(product.id for product in PLANT.products)
    first = next(product for product in PLANT.products if product.id == PRODUCT)
    told = next(product for product in products if product["id"] == PRODUCT)
    assert (told["name"], told["lot"]) == (first.name, first.lot)
    assert told["bill"] == {line.material: line.quantity for line in first.bill}
    for product in products:
        await house.place(items=[{"product": product["id"], "quantity": 1}])


async def test_the_plant_is_told_as_its_file_has_it(house: House) -> None:
    plant = await house.get("/api/plant")
    assert plant["plant"] == PLANT.plant
    assert [machine["id"] for machine in plant["machines"]] == [machine.id for machine in PLANT.machines]
    assert [atv["id"] for atv in plant["fleet"]] == [atv.id for atv in PLANT.fleet]
    assert len(plant["nodes"]) == len(PLANT.nodes)


@pytest.mark.parametrize("path", ["/api/atvs/ATV1", "/api/machines/M1"])
async def test_what_stands_in_the_plant_and_was_never_heard_is_not_told_as_if_it_was(
    house: House, path: str
) -> None:
    problem(await house.client.get(path), 404, f"unknown-{path.split('/')[2][:-1]}")


@pytest.mark.parametrize("count", [50, 150])
@pytest.mark.parametrize("query", ["", "&format=csv"])
async def test_a_page_of_one_state_tells_no_task_that_has_left_it_meanwhile(
    house: House, monkeypatch: pytest.MonkeyPatch, count: int, query: str
) -> None:
    for event in events("M1", *(opened(f"M1-{number}") for number in range(count))):
        house.projection.fold(event)
    name = "table" if query else "listing_in_turns"
    write = getattr(tasks_route, name)

    def others_meanwhile(*args: Any) -> Any:
        """Others have their turn between the search and the answer."""
        answered = AwardAnswered(task="M1-7", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
        for event in events("M1", answered, first=1_000):
            house.projection.fold(event)
        return write(*args)

    monkeypatch.setattr(tasks_route, name, others_meanwhile)
    answer = await house.client.get(f"/api/tasks?state=bidding&limit=500{query}")
    assert answer.status_code == 200
    assert "M1-8" in answer.text
    assert "M1-7," not in answer.text.replace('"', "")
    if not query:
        assert len(answer.json()["items"]) == count - 1
