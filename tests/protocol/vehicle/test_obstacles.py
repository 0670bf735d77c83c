"""A vehicle and what lies on lanes: it tells the others, goes round, looks again, and asks for people only where no way is left."""

from __future__ import annotations

from itertools import pairwise

import pytest
from atv1 import contracted, parked
from defaults import KEYS, PLANT
from effects import facts, instructed, listening, published
from rigs import VehicleRig

from dray.body import Drive, LinkNoticed, NodePassed, ProblemCleared, ProblemRaised, WayBlocked, WayFree
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Link,
    ObstacleCleared,
    ObstacleSeen,
    Problem,
    ProblemKind,
    Superseded,
)
from dray.messages.fact import HelpAsked
from dray.messages.floor.obstacle import FORGOTTEN_AT_MOST_S, FORGOTTEN_S, MOST_OF_ONE
from dray.plant import Door, LaneEnds
from dray.protocol.runtime.events import Effect
from dray.protocol.vehicle.atv import Atv


def floor(rig: VehicleRig) -> frozenset[tuple[str, str]]:
    assert isinstance(rig.agent, Atv)
    return rig.agent.floor.obstructed


def comes_to(rig: VehicleRig, index: int) -> Drive:
    """It passes the nodes of its way, and stands on one of them."""
    way = rig.last(Drive)
    for number in range(index + 1):
        rig.node = way.nodes[number]
        rig.report(NodePassed(order=way.order, node=rig.node, index=number, battery_frac=0.9))
    return way


def blocked(rig: VehicleRig, way: Drive, index: int, *, entered: bool = False) -> list[Effect]:
    """Something is on the lane after a node of its way."""
    start, end = way.nodes[index], way.nodes[index + 1]
    return rig.report(WayBlocked(order=way.order, start=start, end=end, entered=entered))


def told(effects: list[Effect]) -> list[ObstacleSeen]:
    return list(published(effects, ObstacleSeen))


def seen(start: str, end: str, *, by: str = "ATV5", for_s: float = FORGOTTEN_S) -> ObstacleSeen:
    return ObstacleSeen(atv=by, start=start, end=end, there=True, forget_in_s=for_s)


def test_what_it_meets_it_tells_and_goes_round() -> None:
    rig = contracted()
    assert KEYS.all_obstacles in listening(rig.all)
    way = comes_to(rig, 2)
    effects = blocked(rig, way, 2)
    assert told(effects) == [
        ObstacleSeen(atv="ATV1", start=way.nodes[2], end=way.nodes[3], there=True, forget_in_s=FORGOTTEN_S)
    ]
    round_it = rig.last(Drive)
    assert round_it.order > way.order
    assert (round_it.nodes[0], round_it.nodes[-1]) == (way.nodes[2], way.nodes[-1])
    assert (way.nodes[2], way.nodes[3]) not in pairwise(round_it.nodes)
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].status is AtvStatus.WORKING
    assert not facts(rig.all, HelpAsked)


def test_what_others_have_met_is_gone_round_before_it_is_seen() -> None:
    rig = contracted()
    way = comes_to(rig, 0).nodes
    rig.on_message("ATV5", seen(way[3], way[2]))
    round_it = rig.last(Drive).nodes
    assert (way[2], way[3]) not in pairwise(round_it)
    assert round_it[-1] == way[-1]


def test_where_no_way_leads_round_people_are_asked_and_it_goes_on_when_the_way_is_free() -> None:
    rig = contracted()
    last = len(rig.last(Drive).nodes) - 2
    way = comes_to(rig, last)
    effects = blocked(rig, way, last)
    [asked] = facts(effects, HelpAsked)
    assert asked.problem.kind is ProblemKind.WAY_BLOCKED
    assert not instructed(effects, Drive)
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].status is AtvStatus.ERROR
    freed = rig.report(WayFree(order=way.order, start=way.nodes[last], end=way.nodes[last + 1]))
    assert [message.there for message in told(freed)] == [False]
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].status is AtvStatus.WORKING
    assert floor(rig) == frozenset()


def test_on_a_lane_it_cannot_turn_round_and_waits() -> None:
    rig = contracted()
    way = comes_to(rig, 1)
    effects = blocked(rig, way, 1, entered=True)
    assert not instructed(effects, Drive)
    assert facts(effects, HelpAsked)


@pytest.mark.parametrize(
    ("entered", "reason"), [(False, "the door Hall gate does not open"), (True, "something")]
)
def test_who_stands_before_a_door_names_it_and_who_is_in_it_does_not(entered: bool, reason: str) -> None:
    rig = contracted()
    last = len(rig.last(Drive).nodes) - 2
    way = comes_to(rig, last)
    start, end = way.nodes[last], way.nodes[last + 1]
    assert isinstance(rig.agent, Atv)
    rig.agent.floor.door_on = {(start, end): Door("D1", "Hall gate", (LaneEnds(start, end),), 5.0)}
    [asked] = facts(blocked(rig, way, last, entered=entered), HelpAsked)
    assert asked.reason.startswith(reason)
    rig.report(WayFree(order=way.order, start=start, end=end))
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].status is AtvStatus.WORKING


def test_whose_task_has_passed_to_another_leaves_the_lane_where_nothing_leads_round() -> None:
    rig = contracted()
    last = len(rig.last(Drive).nodes) - 2
    way = comes_to(rig, last)
    blocked(rig, way, last)
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].status is AtvStatus.ERROR
    effects = rig.on_message("M8", Superseded("M8-1", 2))
    [back] = instructed(effects, Drive)
    assert back.nodes[0] == way.nodes[last]
    assert back.nodes[-1] in {PLANT.node_of(each) for each in PLANT.dwell_points}
    assert (way.nodes[last], way.nodes[last + 1]) not in pairwise(back.nodes)
    rig.run(rig.now_s)
    beat = rig.heartbeats(AtvHeartbeat)[-1]
    assert (beat.status, beat.problem) == (AtvStatus.IDLE, "")


def test_whoever_cannot_turn_before_a_door_says_so_and_stays() -> None:
    rig = contracted()
    way = rig.last(Drive)
    plant = rig.agent.floor  # type: ignore[attr-defined]
    index = next(
        index
        for index, (start, end) in enumerate(pairwise(way.nodes))
        if all(lane.end == end for lane in plant.roads.leaving[start])
    )
    comes_to(rig, index)
    start, end = way.nodes[index], way.nodes[index + 1]
    plant.door_on = {(start, end): Door("D1", "Hall gate", (LaneEnds(start, end),), 5.0)}
    [asked] = facts(blocked(rig, way, index), HelpAsked)
    assert asked.reason == f"the door Hall gate does not open, and no lane leads back from {start}"
    rig.on_message("M8", Superseded("M8-1", 2))
    rig.run(rig.now_s)
    beat = rig.heartbeats(AtvHeartbeat)[-1]
    assert (beat.status, beat.problem) == (AtvStatus.ERROR, asked.reason)


def test_it_is_forgotten_after_a_time_and_later_each_time_that_it_is_still_there() -> None:
    rig = contracted()
    spans_s = []
    for _ in range(6):
        start, end = rig.last(Drive).nodes[:2]
        way = comes_to(rig, 0)
        [said] = told(blocked(rig, way, 0))
        spans_s.append(said.forget_in_s)
        assert (start, end) in floor(rig)
        rig.run(rig.now_s + said.forget_in_s)
        assert floor(rig) == frozenset()
        comes_to(rig, 0)
        rig.on_message("ATV5", seen(*rig.last(Drive).nodes[:2], for_s=0.0))
        rig.run(rig.now_s)
    assert spans_s[0] == FORGOTTEN_S
    assert max(spans_s) <= FORGOTTEN_AT_MOST_S


def test_whoever_drives_there_knows_that_it_is_gone_and_tells() -> None:
    rig = contracted()
    way = comes_to(rig, 1)
    blocked(rig, way, 1, entered=True)
    assert floor(rig)
    rig.node = way.nodes[2]
    effects = rig.report(NodePassed(order=way.order, node=rig.node, index=2, battery_frac=0.9))
    assert [(message.start, message.end, message.there) for message in told(effects)] == [
        (way.nodes[1], way.nodes[2], False)
    ]
    assert floor(rig) == frozenset()


def test_who_has_entered_a_lane_does_not_forget_what_stands_before_it() -> None:
    rig = contracted()
    way = comes_to(rig, 1)
    effects = blocked(rig, way, 1, entered=True)
    [said] = told(effects)
    (asked,) = facts(effects, HelpAsked)
    for_s = said.forget_in_s
    for _ in range(4):
        effects = rig.run(rig.now_s + for_s)
        [said] = told(effects)
        assert (said.there, for_s < said.forget_in_s <= FORGOTTEN_AT_MOST_S) == (
            True,
            for_s < FORGOTTEN_AT_MOST_S,
        )
        for_s = said.forget_in_s
        assert not facts(effects, HelpAsked)
        assert not instructed(effects, Drive)
        assert rig.heartbeats(AtvHeartbeat)[-1].problem == asked.reason


def test_a_person_says_that_it_is_cleared() -> None:
    rig = parked()
    rig.on_message("ATV5", seen("b2", "b3"))
    assert floor(rig) == {("b2", "b3"), ("b3", "b2")}
    rig.on_message("gateway", ObstacleCleared(start="b3", end="b2", by="anna"))
    assert floor(rig) == frozenset()


def test_one_speaker_shuts_no_floor() -> None:
    rig = parked()
    assert isinstance(rig.agent, Atv)
    lanes = [(lane.start, lane.end) for lane in rig.agent.floor.lanes]
    for start, end in lanes:
        rig.on_message("ATV5", seen(start, end, for_s=FORGOTTEN_AT_MOST_S))
    assert len(floor(rig)) <= 2 * MOST_OF_ONE
    rig.run(rig.now_s + FORGOTTEN_AT_MOST_S + 1.0)
    assert floor(rig) == frozenset()


def test_what_it_meets_without_wlan_it_tells_when_it_is_back() -> None:
    rig = contracted()
    rig.report(LinkNoticed(link=Link.MESH))
    way = comes_to(rig, 2)
    assert told(blocked(rig, way, 2)) == []
    assert (way.nodes[2], way.nodes[3]) not in pairwise(rig.last(Drive).nodes)
    rig.now_s += 10.0
    [said] = told(rig.report(LinkNoticed(link=Link.WLAN)))
    assert (said.start, said.end, said.there, said.forget_in_s) == (
        way.nodes[2],
        way.nodes[3],
        True,
        FORGOTTEN_S - 10.0,
    )
    rig.report(LinkNoticed(link=Link.MESH))
    assert told(rig.report(LinkNoticed(link=Link.WLAN))) == []


def test_what_else_is_wrong_with_it_stays_wrong_when_the_way_is_free_and_the_other_way_round() -> None:
    rig = contracted()
    last = len(rig.last(Drive).nodes) - 2
    way = comes_to(rig, last)
    blocked(rig, way, last)
    dead = ProblemRaised(reason="dead", problem=Problem(kind=ProblemKind.DRIVE))
    rig.report(dead)
    rig.report(ProblemCleared())
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].problem.startswith("something is in the way")
    rig.report(dead)
    rig.report(WayFree(order=way.order, start=way.nodes[last], end=way.nodes[last + 1]))
    rig.run(rig.now_s + 1.0)
    assert rig.heartbeats(AtvHeartbeat)[-1].problem == "dead"
    rig.report(ProblemCleared())
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].status is AtvStatus.WORKING
