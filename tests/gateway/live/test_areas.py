"""The area rule on the stream: an operator sees what is in the own areas, and hears of nothing else."""

from __future__ import annotations

import json
from typing import Any

import msgspec
import pytest
from areas_kit import (
    AREAS,
    ATV,
    FLOOR,
    GOAL,
    MACHINE,
    NODE,
    ORDER,
    STORAGE,
    TASK,
    every_area,
    everything,
    making,
    orders_wait,
    secrets_of,
    standing,
    told_of,
    words,
)
from fake_bus import PLANT
from heartbeats import events, station_heartbeat
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import ADMIN, SCOPES, Principal, Role
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import Client, Hub
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import CommandView, ScenarioView, StepView
from dray.gateway.live.visibility import ELSEWHERE, AreaVisibility
from dray.messages import Message, Refusal
from dray.messages import Role as Part
from dray.messages.fact import BidRefused
from dray.scenario_steps import ScenarioStep

pytestmark = pytest.mark.anyio


def operator(*areas: str, station: str = "") -> Principal:
    return Principal(
        kind="person",
        id="-".join(("operator", *areas)),
        name="Operator",
        role=Role.OPERATOR,
        scopes=SCOPES[Role.OPERATOR],
        areas=frozenset(areas),
        station=station,
    )


class Stage:
    """A projection and a hub without a server."""

    def __init__(self, *told: Message) -> None:
        self.wall = Wall()
        self.projection = Projection(PLANT, TimeScale(0.0, NOW_S))
        self.hub = Hub(
            self.projection,
            wall_s=self.wall,
            steady_s=self.wall,
            rate_hz=10.0,
            queue_frames=50,
            clients=20,
            each=20,
        )
        self.tell(*told)

    def tell(self, *messages: Message) -> None:
        for message in messages:
            self.projection.fold(message)

    def join(self, who: Principal) -> Client:
        client = self.hub.join(who)
        assert client is not None
        return client


async def next_of(client: Client) -> dict[str, Any]:
    frame: dict[str, Any] = json.loads(await client.next_frame())
    return frame


async def waiting(client: Client) -> list[dict[str, Any]]:
    """All frames that wait for a client."""
    return [await next_of(client) for _ in range(len(client._frames) + client._lost)]


def ids(frame: dict[str, Any], kind: str) -> list[str]:
    return [each["id"] for each in frame[kind]]


@every_area
async def test_a_snapshot_holds_what_is_in_the_area(area: str) -> None:
    stage = Stage(*everything())
    stage.projection.look(NOW_S + 1.0)
    frame = await next_of(stage.join(operator(area)))
    assert ids(frame, "atvs") == [ATV[area]]
    assert ids(frame, "machines") == [MACHINE[area]]
    assert ids(frame, "tasks") == [TASK[area]]
    assert {each["agent"] for each in frame["news"]} == {ATV[area]}
    assert {each["kind"] for each in frame["news"]} == {"took_over", "help_asked", "link_lost"}
    assert {each["agent"] for each in frame["alerts"]} == {ATV[area]}
    assert frame["orders"] == frame["faults"] == []
    assert frame["fault_injection"] is False
    assert frame["factory"]["atvs_by_status"] == {}


@every_area
async def test_an_area_is_told_once_when_the_plant_has_changed_and_of_nothing_else_in_the_factory(
    area: str,
) -> None:
    stage = Stage(*everything())
    client = stage.join(operator(area))

    async def told() -> list[dict[str, Any]]:
        stage.wall.now_s += 2.0
        stage.hub.tick()
        stage.wall.now_s += 2.0
        stage.hub.tick()
        return [frame["factory"] for frame in await waiting(client) if frame["factory"] is not None]

    assert (await next_of(client))["factory"]["plant_at_s"] == NOW_S
    assert all(factory["plant_at_s"] == NOW_S for factory in await told())
    assert await told() == []
    stage.projection.site.change_products([], ["G1"])
    (changed,) = await told()
    assert changed["plant_at_s"] == stage.wall.now_s - 2.0
    assert changed["atvs_by_status"] == {}
    # Who comes later is told of it, and takes it from nobody.
    stage.projection.site.change_products([], ["G2"])
    late = await next_of(stage.join(operator(area)))
    (changed,) = await told()
    assert late["factory"]["plant_at_s"] == changed["plant_at_s"]


@every_area
async def test_the_station_of_a_storage_is_seen_with_its_alarm_where_the_storage_stands(area: str) -> None:
    fell_silent = {storage: -60.0 - 30.0 * place for place, storage in enumerate(STORAGE.values())}
    stage = Stage(*everything(), *(station_heartbeat(each, at_s=at_s) for each, at_s in fell_silent.items()))
    stage.projection.look(NOW_S + 1.0)
    client = stage.join(operator(area))
    frame = await next_of(client)
    assert ids(frame, "stations") == [STORAGE[area]]
    assert [each["agent"] for each in frame["alerts"] if each["kind"] == "station_lost"] == [STORAGE[area]]
    stage.tell(*(station_heartbeat(storage, 2) for storage in STORAGE.values()))
    stage.wall.now_s += 1.0
    stage.hub.tick()
    assert ids(await next_of(client), "stations") == [STORAGE[area]]


@every_area
async def test_of_many_that_fell_silent_at_once_only_those_of_the_area_are_named(area: str) -> None:
    stage = Stage(*everything(), *(station_heartbeat(storage, at_s=-60.0) for storage in STORAGE.values()))
    stage.projection.look(NOW_S + 1.0)
    frame = await next_of(stage.join(operator(area)))
    (alert,) = (each for each in frame["alerts"] if each["kind"] == "part_lost")
    assert sorted(alert["agents"]) == [*[ELSEWHERE] * (len(STORAGE) - 1), STORAGE[area]]
    assert words(frame) & secrets_of(area) == set()


@every_area
async def test_a_snapshot_names_nothing_of_other_areas(area: str) -> None:
    stage = Stage(*everything())
    stage.projection.look(NOW_S + 1.0)
    text = await stage.join(operator(area)).next_frame()
    assert words(text) & secrets_of(area) == set()
    assert words(text) >= {ATV[area], MACHINE[area], TASK[area]}


async def test_the_whole_plant_is_shown_as_before() -> None:
    stage = Stage(*everything())
    text = await stage.join(ADMIN).next_frame()
    for area in AREAS:
        assert words(text) >= {ATV[area], MACHINE[area], TASK[area], GOAL, ORDER}


async def test_who_has_not_bid_for_a_task_is_told_by_name_only_of_the_area() -> None:
    area, other = AREAS[:2]
    refused = BidRefused(task=TASK[area], epoch=2, role=Part.PRIMARY, reason=Refusal.NO_WAY, detail=ORDER)
    stage = Stage(
        *everything(), *(each for atv in (ATV[area], ATV[other]) for each in events(atv, refused, first=900))
    )
    (task,) = (await next_of(stage.join(operator(area))))["tasks"]
    told = [(each["agent"], each["reason"], each["detail"]) for each in task["refusals"]]
    assert sorted(told) == [(ELSEWHERE, "no_way", ""), (ATV[area], "no_way", "")]


async def test_of_a_task_its_way_is_seen_and_nothing_of_its_bids() -> None:
    area = AREAS[0]
    frame = await next_of(Stage(*everything()).join(operator(area)))
    (task,) = frame["tasks"]
    assert (task["primary"], task["destination"], task["item"]) == (ATV[area], MACHINE[area], "shaft")
    assert task["bids"] == task["carriers"] == []
    assert (task["order"], task["goal"], task["why"]["text"]) == ("", "", "")
    (machine,) = frame["machines"]
    (brief,) = machine["tasks"]
    assert (brief["primary"], brief["secondary"]) == (ATV[area], ELSEWHERE)
    assert brief["trouble"]["detail"] == f"{ATV[area]} waits for {ELSEWHERE}."
    (goal,) = machine["goals"]
    assert (goal["goal"], goal["product"], goal["made"]) == ("1", "pump-p3", 2)
    (atv,) = frame["atvs"]
    assert (atv["via"], atv["watches"]) == ([ELSEWHERE], [])


async def test_frames_are_made_per_audience_and_encoded_once_for_all_in_it() -> None:
    stage = Stage(*everything())
    clients = [stage.join(operator(area)) for area in (AREAS[0], AREAS[0], AREAS[1])]
    for client in clients:
        await next_of(client)
    stage.tell(making(AREAS[0], seq=2), standing(AREAS[1], seq=2))
    stage.wall.now_s += 0.5
    stage.hub.tick()
    first, twin, other = [client._frames[0] for client in clients]
    assert first is twin
    assert first != other


async def test_a_snapshot_says_who_is_shown_it() -> None:
    stage = Stage()
    here = operator(AREAS[1], AREAS[0], station="M1")
    first, second = stage.join(here), stage.join(ADMIN)
    assert (await next_of(first))["audience"] == {
        "role": "operator",
        "name": "Operator",
        "areas": [AREAS[0], AREAS[1]],
        "station": "M1",
    }
    assert (await next_of(second))["audience"] == {
        "role": "",
        "name": "Administrator",
        "areas": None,
        "station": "",
    }


async def test_several_areas_are_seen_together() -> None:
    frame = await next_of(Stage(*everything()).join(operator(*AREAS[:2])))
    assert set(ids(frame, "atvs")) == {ATV[area] for area in AREAS[:2]}


async def test_whoever_has_no_area_sees_nothing() -> None:
    frame = await next_of(Stage(*everything()).join(operator()))
    assert all(frame[kind] == [] for kind in ("atvs", "machines", "tasks", "orders", "news", "alerts"))


async def test_a_vehicle_that_crosses_the_border_leaves_here_and_comes_there() -> None:
    home, there = AREAS[0], AREAS[1]
    stage = Stage(*everything())
    left, reached, third = (stage.join(operator(area)) for area in (home, there, AREAS[2]))
    stage.hub.tick()
    for client in (left, reached, third):
        await waiting(client)
    stage.tell(standing(home, there, seq=2))
    stage.wall.now_s += 0.5
    stage.hub.tick()
    (frame,) = await waiting(left)
    assert frame["atvs"] == []
    assert f"atv:{ATV[home]}" in frame["gone"]
    # Its machine is still served, by somebody elsewhere; the vehicle's own news left with it.
    assert [task["primary"] for task in frame["tasks"]] == [ELSEWHERE]
    assert frame["machines"][0]["tasks"][0]["primary"] == ELSEWHERE
    assert set(frame["gone"]) > {f"news:link-{ATV[home]}", f"news:help-{ATV[home]}"}
    (frame,) = await waiting(reached)
    assert ids(frame, "atvs") == [ATV[home]]
    assert ids(frame, "tasks") == [TASK[home]]
    assert frame["gone"] == []
    assert await waiting(third) == [], "it is told nothing, not even that something has happened"


async def test_what_was_never_shown_is_never_gone() -> None:
    home, there = AREAS[0], AREAS[1]
    stage = Stage(*everything())
    early = stage.join(operator(home))
    await next_of(early)
    stage.tell(standing(home, there, seq=2))
    # The frame that lets it go is not made yet: who joins now is shown what holds until then.
    late = stage.join(operator(home))
    snapshot = await next_of(late)
    assert ids(snapshot, "atvs") == [ATV[home]]
    stage.wall.now_s += 0.5
    stage.hub.tick()
    for client in (early, late):
        (frame,) = await waiting(client)
        assert f"atv:{ATV[home]}" in frame["gone"]
    stage.projection.tasks.changes.drop("M99-1")
    stage.wall.now_s += 2.0
    stage.hub.tick()
    for client in (early, late):
        (frame,) = await waiting(client)
        assert frame["gone"] == []


@every_area
async def test_no_delta_names_anything_of_other_areas(area: str) -> None:
    stage = Stage()
    client = stage.join(operator(area))
    said = [await client.next_frame()]
    for other in AREAS:
        stage.tell(*told_of(other))
        stage.wall.now_s += 0.2
        stage.projection.look(stage.wall.now_s)
        stage.hub.tick()
    stage.tell(*orders_wait())
    for other in AREAS:
        stage.tell(making(other, seq=2), standing(other, seq=2))
        stage.wall.now_s += 0.2
        stage.hub.tick()
    said += [client._frames.popleft() for _ in range(len(client._frames))]
    for frame in said:
        assert words(frame) & secrets_of(area) == set(), frame
    numbers = [json.loads(frame)["number"] for frame in said]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers))), "and no gap tells of a frame"


@every_area
async def test_who_waits_for_one_elsewhere_says_so_and_not_for_whom(area: str) -> None:
    stage = Stage(*everything())
    stage.tell(*(standing(other, seq=40) for other in AREAS))
    stage.projection.look(NOW_S + 40.0)
    frame = await next_of(stage.join(operator(area)))
    (wait,) = frame["waits"]
    assert (wait["id"], wait["place"], wait["cause"]["chain"]) == (ATV[area], NODE[area], [ELSEWHERE])
    assert wait["text"] == "waits for *, in a circle"
    (jam,) = (each for each in frame["alerts"] if each["kind"] == "jam")
    assert sorted(set(jam["agents"])) == [ELSEWHERE, ATV[area]]
    (atv,) = frame["atvs"]
    seen = {
        node["id"]
        for node in msgspec.to_builtins(AreaVisibility(stage.projection, frozenset([area])).plant())["nodes"]
    }
    assert 0 < len(atv["holds"]) < len(FLOOR.nodes)
    assert set(atv["holds"]) <= seen
    assert words(frame) & secrets_of(area) == set()


async def test_a_mirror_of_the_deltas_is_the_same_as_a_fresh_snapshot() -> None:
    stage = Stage(*everything())
    client = stage.join(operator(AREAS[0]))
    kinds = {"atv": "atvs", "machine": "machines", "task": "tasks", "news": "news", "alert": "alerts"}
    kinds["wait"] = "waits"
    mirror: dict[str, dict[str, Any]] = {kind: {} for kind in kinds.values()}
    for seq in range(2, 30):
        mover = AREAS[seq % len(AREAS)]
        stage.tell(standing(mover, AREAS[seq // 2 % len(AREAS)], seq=seq), making(mover, seq=seq))
        stage.wall.now_s += 0.3
        stage.projection.look(stage.wall.now_s)
        stage.hub.tick()
        for frame in await waiting(client):
            if frame["type"] == "snapshot":
                mirror = {kind: {} for kind in kinds.values()}
            for name in frame.get("gone", ()):
                kind, _, entity = name.partition(":")
                del mirror[kinds[kind]][entity]
            for kind, known in mirror.items():
                known |= {each["id"]: known.get(each["id"], {}) | each for each in frame[kind]}
    fresh = Hub(
        stage.projection,
        wall_s=stage.wall,
        steady_s=stage.wall,
        rate_hz=10.0,
        queue_frames=5,
        clients=1,
        each=1,
    ).join(operator(AREAS[0]))
    assert fresh is not None
    snapshot = await next_of(fresh)
    assert mirror == {kind: {each["id"]: each for each in snapshot[kind]} for kind in kinds.values()}


async def test_a_command_is_seen_by_those_who_answered_for_the_vehicle_when_it_was_given() -> None:
    stage = Stage(*everything())
    here, there = (stage.join(operator(area)) for area in AREAS[:2])
    for client in (here, there):
        await next_of(client)
    stage.projection.commands.put(
        CommandView(id="c-1", atv=ATV[AREAS[0]], kind="stop", by="Operator", at_s=NOW_S), (AREAS[0],)
    )
    stage.tell(standing(AREAS[0], AREAS[1], seq=2))
    stage.projection.commands.end("c-1", "confirmed")
    stage.wall.now_s += 0.5
    stage.hub.tick()
    (frame,) = await waiting(here)
    assert [(each["id"], each["state"]) for each in frame["commands"]] == [("c-1", "confirmed")]
    (frame,) = await waiting(there)
    assert frame["commands"] == []


async def test_an_empty_room_is_forgotten() -> None:
    stage = Stage(*everything())
    client = stage.join(operator(AREAS[0]))
    stage.hub.leave(client)
    assert stage.hub._rooms == {}
    assert (await next_of(stage.join(operator(AREAS[0]))))["type"] == "snapshot"


# --- a scenario that is played ----------------------------------------------------------------------

BEFORE = ScenarioView(id="case-5", shows="", steps=(StepView(step=ScenarioStep.STOPPED),))
AFTER = ScenarioView(
    id="case-5",
    shows="",
    steps=(StepView(step=ScenarioStep.STOPPED, after_s=61.5, agents=("ATV3",)),),
    state="held",
    after_s=90.0,
)


async def test_a_manager_is_told_of_each_step() -> None:
    stage = Stage()
    stage.projection.scenarios.put(BEFORE)
    client = stage.join(ADMIN)
    (seen,) = (await next_of(client))["scenarios"]
    assert seen["steps"] == [{"step": "stopped", "after_s": None, "expected_s": None, "agents": []}]
    stage.projection.scenarios.put(AFTER)
    stage.wall.now_s += 0.2
    stage.hub.tick()
    (seen,) = (await next_of(client))["scenarios"]
    assert seen["steps"] == [{"step": "stopped", "after_s": 61.5, "expected_s": None, "agents": ["ATV3"]}]
    assert seen["state"] == "held"


async def test_an_operator_hears_nothing_of_it() -> None:
    stage = Stage()
    stage.projection.scenarios.put(BEFORE)
    client = stage.join(operator(AREAS[0]))
    stage.projection.scenarios.put(AFTER)
    stage.wall.now_s += 2.0
    stage.hub.tick()
    assert [frame["scenarios"] for frame in await waiting(client)] == [[]]
    stage.hub.tick()
    stage.projection.scenarios.put(BEFORE)
    stage.wall.now_s += 2.0
    stage.hub.tick()
    assert all(frame["scenarios"] == [] for frame in await waiting(client))
