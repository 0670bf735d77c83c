"""A vehicle that is asked to leave: what it still carries, what it gives back, and when it goes (paper, 4.2 case 6)."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from defaults import PLANT
from effects import committed, facts, instructed, published, sent
from rigs import Rig, VehicleRig
from seals import granted
from spoken import announcement, award, transport

from dray.body import Drive, Pick, ProblemRaised
from dray.memory import WHOLE, AtvMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    CommandKind,
    Declined,
    DockOpened,
    HandoverAccepted,
    Reason,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    VehicleCommand,
)
from dray.messages.fact import BidRefused, ContractEnded
from dray.protocol.runtime.events import Leave
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.runtime.shutdown import CARRIER_LEAVES_WITHIN_S
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER

GOODS = transport(item="pump-p3", quantity=24, sources=("M8",), destination="DELIVERY", goal="G8")


# --- a vehicle --------------------------------------------------------------------------------------


def idle() -> VehicleRig:
    rig = VehicleRig()
    rig.start()
    return rig


def approaching(**changes: object) -> VehicleRig:
    """ATV1 on its way to fetch M8-1."""
    rig = idle()
    rig.on_message("M8", award(**changes))
    return rig


def carrying() -> VehicleRig:
    """ATV1 with the load of M8-1 on board."""
    rig = approaching()
    rig.arrive()
    rig.picked()
    return rig


def relieve(rig: VehicleRig) -> None:
    """M8 has heard that ATV1 gives its task back."""
    rig.on_message("M8", Superseded(task="M8-1", epoch=2))


def newest(rig: Rig) -> AtvHeartbeat:
    return rig.heartbeats(AtvHeartbeat)[-1]


def test_one_that_stands_idle_leaves_at_once_and_says_so_with_its_last_word() -> None:
    rig = idle()
    *_, last_word, leave = rig.leave()
    assert isinstance(leave, Leave)
    [heartbeat] = published([last_word], AtvHeartbeat)
    assert heartbeat.draining


def test_until_it_is_asked_nobody_hears_of_leaving() -> None:
    rig = approaching()
    rig.run(20.0)
    assert not any(heartbeat.draining for heartbeat in rig.heartbeats(AtvHeartbeat))


def test_on_its_way_to_a_place_to_stand_it_stops_at_the_next_node() -> None:
    rig = VehicleRig(node="a1", battery_frac=0.4)
    rig.start()
    rig.run(20.0)
    assert len(rig.last(Drive).nodes) > 1
    rig.leave()
    assert not rig.has_left
    assert rig.last(Drive).nodes == (rig.node,)
    rig.arrive()
    assert rig.has_left


def test_it_looks_for_no_place_to_stand_any_more() -> None:
    rig = approaching()
    rig.leave()
    relieve(rig)
    ways = len(instructed(rig.all, Drive))
    rig.run(100.0)
    assert len(instructed(rig.all, Drive)) == ways


def test_its_watches_are_given_back() -> None:
    rig = idle()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    [resigned] = sent(rig.leave(), Resigned, to="M8")
    assert (resigned.role, resigned.reason) == (Role.SECONDARY, Reason.GRACEFUL_SHUTDOWN)


@pytest.mark.parametrize("role", Role)
def test_it_bids_for_nothing_and_declines_what_it_is_asked(role: Role) -> None:
    rig = carrying()
    rig.leave()
    primary = "ATV2" if role is Role.SECONDARY else ""
    effects = rig.on_message("M9", announcement(task="M9-1", coordinator="M9", role=role, primary=primary))
    assert not sent(effects, Bid)
    assert [refused.reason for refused in facts(effects, BidRefused)] == [Refusal.NOT_FIT]
    [declined] = sent(rig.on_message("M9", award(task="M9-1", role=role, primary=primary)), Declined)
    assert declined.reason is Refusal.NOT_FIT


def test_a_task_whose_load_is_not_on_board_is_given_back_and_it_waits_to_be_relieved() -> None:
    rig = approaching()
    [resigned] = sent(rig.leave(), Resigned, to="M8")
    assert (resigned.task, resigned.epoch, resigned.role, resigned.reason) == (
        "M8-1",
        1,
        Role.PRIMARY,
        Reason.GRACEFUL_SHUTDOWN,
    )
    assert rig.last(Drive).nodes == (rig.node,), "it stops"
    rig.arrive()
    rig.run(rig.now_s)
    assert not rig.has_left
    brief = newest(rig).task
    assert brief is not None
    assert brief.task == "M8-1", "it is bound until M8 has heard"
    relieve(rig)
    assert rig.has_left
    assert newest(rig).task is None
    [ended] = facts(rig.all, ContractEnded)
    assert (ended.task, ended.reason) == ("M8-1", Reason.GRACEFUL_SHUTDOWN)
    assert committed(rig.all[-8:]) == {WHOLE: AtvMemory(node=rig.node)}


def test_it_says_so_until_it_was_heard() -> None:
    rig = approaching()
    rig.leave()
    rig.arrive()
    rig.run(2.5 * ASK_AGAIN_S)
    assert len(sent(rig.all, Resigned)) == 3
    relieve(rig)
    rig.run(rig.now_s + 5 * ASK_AGAIN_S)
    assert len(sent(rig.all, Resigned)) == 3


def test_a_machine_that_answers_nothing_is_waited_for_as_at_its_dock() -> None:
    rig = approaching()
    rig.leave()
    rig.arrive()
    rig.run(GIVE_UP_AFTER * ASK_AGAIN_S - 0.1)
    assert not rig.has_left
    rig.run(GIVE_UP_AFTER * ASK_AGAIN_S)
    assert rig.has_left


def test_an_open_dock_does_not_make_it_take_what_it_has_given_back() -> None:
    rig = approaching(work=GOODS)
    rig.arrive()
    rig.leave()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    assert not instructed(rig.all, Pick)
    relieve(rig)
    assert rig.has_left


def test_a_takeover_that_is_not_confirmed_yet_is_given_back_too() -> None:
    rig = idle()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    rig.run(60.0)
    [resigned] = sent(rig.leave(), Resigned, to="M8")
    assert (resigned.role, resigned.epoch) == (Role.PRIMARY, 2)
    rig.on_message("M8", Superseded(task="M8-1", epoch=1))
    assert not rig.has_left, "M8 does not know of the takeover yet"
    rig.on_message("M8", Superseded(task="M8-1", epoch=3))
    rig.arrive()
    assert rig.has_left


def test_with_a_load_it_leaves_after_the_handover() -> None:
    rig = carrying()
    rig.leave()
    assert not sent(rig.all, Resigned)
    rig.arrive()
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    assert not rig.has_left
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    assert rig.has_left
    assert [ended.reason for ended in facts(rig.all, ContractEnded)] == ["handed_over"]


def test_a_pick_that_has_begun_is_carried_to_its_end() -> None:
    rig = approaching()
    rig.arrive()
    rig.leave()
    assert not sent(rig.all, Resigned)
    rig.picked()
    assert rig.last(Drive).nodes[-1] == PLANT.node_of("M8")
    assert not rig.has_left


def test_after_a_pick_that_fails_the_task_is_given_back() -> None:
    rig = approaching()
    rig.arrive()
    rig.leave()
    rig.failed(Pick)
    assert [resigned.reason for resigned in sent(rig.all, Resigned)] == [Reason.GRACEFUL_SHUTDOWN]
    relieve(rig)
    assert rig.has_left


def test_a_load_that_nobody_wants_any_more_is_brought_back_first() -> None:
    rig = carrying()
    relieve(rig)
    rig.leave()
    rig.arrive()
    assert not rig.has_left
    rig.dropped()
    assert rig.has_left


def stop(rig: VehicleRig) -> None:
    rig.on_message("operator", granted("ATV1", VehicleCommand(command="c1", kind=CommandKind.STOP)))


@pytest.mark.parametrize("holds", [stop, lambda rig: rig.report(ProblemRaised(reason="way blocked"))])
def test_one_that_cannot_move_leaves_as_it_is(holds: Callable[[VehicleRig], object]) -> None:
    rig = carrying()
    holds(rig)
    rig.leave()
    assert rig.has_left
    assert isinstance(rig.agent._memory(), AtvMemory)  # type: ignore[attr-defined]
    assert rig.agent._memory().contract is not None  # type: ignore[attr-defined]


def test_one_that_cannot_move_gives_back_what_is_not_on_board() -> None:
    rig = approaching()
    stop(rig)
    rig.leave()
    assert not rig.has_left
    relieve(rig)
    assert rig.has_left


def test_one_that_gets_stuck_while_it_leaves_goes() -> None:
    rig = carrying()
    rig.leave()
    rig.report(ProblemRaised(reason="way blocked"))
    assert rig.has_left


def test_whatever_holds_it_it_goes_in_bounded_time() -> None:
    rig = carrying()
    rig.run(7.0)
    rig.leave()
    rig.run(7.0 + CARRIER_LEAVES_WITHIN_S - 0.01)
    assert not rig.has_left
    rig.run(7.0 + CARRIER_LEAVES_WITHIN_S)
    assert rig.has_left


def test_asking_twice_changes_nothing() -> None:
    rig = approaching()
    rig.leave()
    rig.run(1.0)
    assert rig.leave() == []
    relieve(rig)
    rig.arrive()
    assert rig.leave() == []
    rig.run(rig.now_s + 2 * CARRIER_LEAVES_WITHIN_S)
    assert sum(isinstance(effect, Leave) for effect in rig.all) == 1


# --- a secondary becomes the carrier ----------------------------------------------------------------


def test_a_watch_becomes_a_contract_when_its_vehicle_is_asked() -> None:
    rig = idle()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    rig.on_message("M8", Release(task="M8-1", epoch=1, role=Role.SECONDARY, reason=Reason.GRACEFUL_SHUTDOWN))
    [answer] = sent(rig.on_message("M8", award(epoch=2, source="S3")), Accepted, to="M8")
    assert (answer.role, answer.epoch) == (Role.PRIMARY, 2)
    rig.run(rig.now_s)
    assert newest(rig).watches == ()
