"""A vehicle goes round what is closed, leaves it when it is inside, and says so when there is no other way."""

from __future__ import annotations

from itertools import pairwise

from atv1 import SETTLED_S, contracted, parked, unloading
from closed import closure, closures
from defaults import KEYS, PLANT
from effects import facts, instructed, listening, sent
from msgspec import UNSET
from rigs import VehicleRig
from spoken import announcement, award

from dray.body import Charge, Drive, NodePassed
from dray.memory import CLOSURES, ClosuresMemory
from dray.messages import (
    AtvHeartbeat,
    Bid,
    ClosureKind,
    Closures,
    Declined,
    DockOpened,
    HandoverAccepted,
    Reason,
    Refusal,
    Resigned,
    Superseded,
)
from dray.messages.fact import BidRefused, ClosuresKnown
from dray.protocol.closures.known_floor import KNOWN, NOT_SIGNED
from dray.protocol.runtime.events import Commit, Effect, Ignore, Started

S3, M8 = PLANT.node_of("S3"), PLANT.node_of("M8")


def told(rig: VehicleRig, number: int, *closed: object) -> list[Effect]:
    return rig.on_message("gateway", closures(number, *closed))  # type: ignore[arg-type]


def ignored(effects: list[Effect]) -> list[str]:
    return [effect.reason for effect in effects if isinstance(effect, Ignore)]


def on_the_way(rig: VehicleRig, passed: int) -> None:
    """The vehicle passes some nodes of its way and is on the lane after them."""
    way = rig.last(Drive)
    for index in range(passed + 1):
        rig.node = way.nodes[index]
        rig.report(NodePassed(order=way.order, node=rig.node, index=index, battery_frac=0.9))


def test_a_vehicle_listens_for_closures_and_tells_which_it_knows() -> None:
    rig = parked()
    assert KEYS.closures in listening(rig.all)
    rig.run(0.0)
    effects = told(rig, 7, closure(node="c3"))
    assert [fact.number for fact in facts(effects, ClosuresKnown)] == [7]
    rig.run(rig.now_s + 5.0)
    assert rig.heartbeats(AtvHeartbeat)[-1].closures == 7
    assert rig.heartbeats(AtvHeartbeat)[0].closures is UNSET
    assert ignored(told(rig, 7, closure(node="c3"))) == [KNOWN]
    assert ignored(told(rig, 6)) == [KNOWN]


def test_a_vehicle_obeys_no_list_that_nobody_has_signed() -> None:
    rig = parked()
    forged = Closures(number=9, signature=bytes(64), closures=(closure(node="p3"),))
    effects = rig.on_message("gateway", forged)
    assert ignored(effects) == [NOT_SIGNED]
    assert not facts(effects, ClosuresKnown)


def test_what_is_ahead_is_gone_round_from_the_next_node_on() -> None:
    rig = contracted()
    way = rig.last(Drive).nodes
    told(rig, 1, closure(start=way[2], end=way[3]))
    round_it = rig.last(Drive).nodes
    assert (round_it[0], round_it[-1]) == (way[0], S3)
    assert (way[2], way[3]) not in pairwise(round_it)


def test_a_vehicle_on_its_way_finishes_its_lane_and_turns_off_there() -> None:
    rig = contracted()
    way = rig.last(Drive).nodes
    on_the_way(rig, 1)
    told(rig, 1, closure(node=way[3]))
    round_it = rig.last(Drive).nodes
    assert round_it[0] == way[2]
    assert way[3] not in round_it
    assert round_it[-1] == S3


def test_the_time_that_it_needs_now_is_in_its_heartbeat_at_once() -> None:
    rig = contracted()
    before_s = _due_s(rig)
    way = rig.last(Drive).nodes
    told(rig, 1, closure(start=way[2], end=way[3]))
    assert _due_s(rig) > before_s


def _due_s(rig: VehicleRig) -> float:
    rig.run(rig.now_s)
    brief = rig.heartbeats(AtvHeartbeat)[-1].task
    assert brief is not None
    return brief.due_s


def test_a_slow_lane_is_driven_slowly_and_counted_so() -> None:
    rig = contracted()
    before_s = _due_s(rig)
    way = rig.last(Drive).nodes
    told(rig, 1, closure(kind=ClosureKind.SLOW, start=way[0], end=way[1], speed_mps=0.2))
    drive = rig.last(Drive)
    assert drive.nodes == way
    assert drive.limits_mps == (0.2, *(None,) * (len(way) - 2))
    assert _due_s(rig) > before_s


def test_who_has_no_way_to_its_load_gives_the_task_back_with_the_reason() -> None:
    rig = contracted()
    effects = told(rig, 1, closure(node=S3))
    assert [message.reason for message in sent(effects, Resigned, to="M8")] == [Reason.CLOSED]
    rig.on_message("M8", Superseded(task="M8-1", epoch=2))
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].task is None


def test_who_could_fetch_but_not_bring_gives_the_task_back_too() -> None:
    rig = contracted()
    assert [message.reason for message in sent(told(rig, 1, closure(node=M8)), Resigned)] == [Reason.CLOSED]


def test_a_load_on_board_waits_for_the_way_and_goes_on_when_it_opens() -> None:
    rig = contracted()
    rig.arrive()
    rig.picked()
    on_the_way(rig, 1)
    stands = rig.last(Drive).nodes[2]
    effects = told(rig, 1, closure(node=M8))
    assert not sent(effects, Resigned)
    assert rig.last(Drive).nodes == (stands,)
    rig.arrive()
    drives = len(instructed(rig.all, Drive))
    rig.run(rig.now_s + 60.0)
    assert {drive.nodes for drive in instructed(rig.all, Drive)[drives:]} <= {(stands,)}
    told(rig, 2)
    assert rig.last(Drive).nodes[-1] == M8
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    rig.run(rig.now_s)
    assert rig.heartbeats(AtvHeartbeat)[-1].task is None


def test_a_closure_with_an_end_opens_by_the_vehicles_own_clock() -> None:
    rig = contracted()
    rig.arrive()
    rig.picked()
    told(rig, 1, closure(node=M8, until_s=rig.now_s + 30.0))
    assert rig.last(Drive).nodes[-1] != M8
    rig.run(rig.now_s + 29.0)
    assert rig.last(Drive).nodes[-1] != M8
    rig.run(rig.now_s + 2.0)
    assert rig.last(Drive).nodes[-1] == M8


def test_who_is_at_its_dock_finishes_there_and_leaves() -> None:
    rig = unloading()
    drives = len(instructed(rig.all, Drive))
    told(rig, 1, closure(node=M8))
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    assert len(instructed(rig.all, Drive)) == drives
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    rig.run(rig.now_s + 10.0)
    assert rig.last(Drive).nodes[0] == M8
    assert rig.last(Drive).nodes[-1] != M8


def test_an_idle_vehicle_leaves_at_once_and_parks_elsewhere() -> None:
    rig = parked(node="p3")
    rig.run(SETTLED_S)
    told(rig, 1, closure(node="p3"))
    assert rig.last(Drive).nodes[0] == "p3"
    assert len(rig.last(Drive).nodes) == 2
    rig.arrive()
    rig.run(rig.now_s + 30.0)
    parks = rig.last(Drive).nodes[-1]
    assert parks in {place.node for place in PLANT.parkings.values()} - {"p3"}


def test_a_charging_vehicle_leaves_a_charger_that_is_closed() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    assert rig.last(Charge).charger == "CH2"
    told(rig, 1, closure(node="ch2"))
    assert rig.last(Drive).nodes[0] == "ch2"
    rig.arrive()
    rig.run(rig.now_s + 30.0)
    assert rig.last(Drive).nodes[-1] in {charger.node for charger in PLANT.chargers.values()} - {"ch2"}


def test_bids_count_the_way_round_and_refuse_with_the_reason_where_there_is_none() -> None:
    rig = parked()
    [before] = sent(rig.on_message("M8", announcement()), Bid)
    way = PLANT.routes("light").way(S3, M8).nodes
    middle = len(way) // 2
    told(rig, 1, closure(start=way[middle], end=way[middle + 1]))
    [after] = sent(rig.on_message("M8", announcement(round=2)), Bid)
    assert after.cost.total_s > before.cost.total_s
    assert after.finish_s > before.finish_s
    told(rig, 2, closure(node=M8))
    effects = rig.on_message("M8", announcement(round=3))
    assert not sent(effects, Bid)
    assert [fact.reason for fact in facts(effects, BidRefused)] == [Refusal.CLOSED]
    assert [answer.reason for answer in sent(rig.on_message("M8", award()), Declined)] == [Refusal.CLOSED]


def test_the_next_life_knows_what_is_closed_before_it_hears_anybody() -> None:
    rig = parked()
    said = closures(5, closure(node=M8))
    [written] = [each for each in rig.on_message("gateway", said) if isinstance(each, Commit)]
    assert (written.name, written.note) == (CLOSURES, ClosuresMemory(said))
    again = VehicleRig(incarnation=2)
    again.handle(Started(again.sense(), {CLOSURES: ClosuresMemory(said)}))
    assert [answer.reason for answer in sent(again.on_message("M8", award()), Declined)] == [Refusal.CLOSED]
    assert ignored(again.on_message("gateway", closures(4))) == [KNOWN]


def test_closing_all_chargers_ends_no_work() -> None:
    rig = parked()
    told(rig, 1, *(closure(f"K{i}", node=charger.node) for i, charger in enumerate(PLANT.chargers.values())))
    assert sent(rig.on_message("M8", announcement()), Bid)
