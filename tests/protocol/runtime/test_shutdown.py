"""An agent that is asked to leave: what it still does, what it gives back, and when it goes (paper, 4.2 case 6)."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import msgspec
import pytest
from kit import (
    PLANT,
    MachineRig,
    Rig,
    StrategistRig,
    VehicleRig,
    accepted,
    announcement,
    award,
    award_number,
    committed,
    facts,
    goal_bid,
    instructed,
    production,
    published,
    rhb,
    sent,
    transport,
)
from office import Office, watched
from seals import granted

from dray.body import Drive, Pick, ProblemRaised
from dray.memory import WHOLE, AtvMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Award,
    Bid,
    Brief,
    CommandKind,
    Declined,
    DockOpened,
    HandoverAccepted,
    MachineHeartbeat,
    OrderItem,
    OrderReleased,
    OrderTaken,
    Phase,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    TaskAnnounced,
    VehicleCommand,
)
from dray.messages.fact import BidRefused, CarrierChanged, ContractEnded
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.events import NEVER_S, Leave
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.runtime.shutdown import (
    CARRIER_LEAVES_WITHIN_S,
    COORDINATOR_LEAVES_WITHIN_S,
    GRACEFUL_SHUTDOWN,
)
from dray.protocol.vehicle.transport_job import GIVE_UP_AFTER

GOODS = transport(item="pump-p3", quantity=24, sources=("M8",), destination="DELIVERY", goal="G8")

# --- a vehicle ---------------------------------------------------------------------------------------


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
    assert (resigned.role, resigned.reason) == (Role.SECONDARY, GRACEFUL_SHUTDOWN)


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
        GRACEFUL_SHUTDOWN,
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
    assert (ended.task, ended.reason) == ("M8-1", GRACEFUL_SHUTDOWN)
    assert committed(rig.all[-8:]) == {WHOLE: AtvMemory()}


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
    assert [resigned.reason for resigned in sent(rig.all, Resigned)] == [GRACEFUL_SHUTDOWN]
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


# --- its coordinator ---------------------------------------------------------------------------------


def gives_back(office: Office, atv: str = "ATV2", epoch: int = 1) -> None:
    resigned = Resigned(task="T1", epoch=epoch, role=Role.PRIMARY, reason=GRACEFUL_SHUTDOWN)
    office.desk.on_resigned(atv, resigned, office.now_s)


def test_in_a_planned_takeover_the_secondary_is_asked_and_nobody_else() -> None:
    office = watched()
    gives_back(office)
    assert sent(office.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)]
    [asked] = sent(office.out, Award, to="ATV1")[-1:]
    assert (asked.task, asked.epoch, asked.role) == ("T1", 2, Role.PRIMARY)
    office.accepts("ATV1", epoch=2)
    assert (office.task.primary, office.task.epoch) == ("ATV1", 2)
    assert office.asked(Role.PRIMARY) == ["ATV2", "ATV1"]
    announced = published(office.out, TaskAnnounced)
    assert [said.epoch for said in announced if said.role is Role.PRIMARY] == [1]
    [changed] = facts(office.out, CarrierChanged)
    assert (changed.replaced, changed.carrier, changed.reason) == ("ATV2", "", GRACEFUL_SHUTDOWN)


def test_a_secondary_that_declines_lets_the_task_be_announced() -> None:
    office = watched()
    gives_back(office)
    declined = Declined(
        task="T1", epoch=2, role=Role.PRIMARY, reason=Refusal.BUSY, number=award_number(office.out, "ATV1")
    )
    office.desk.on_declined("ATV1", declined, office.now_s)
    office.run(office.now_s + 1.0)
    assert published(office.out, TaskAnnounced)[-1].epoch == 2


def test_a_secondary_that_is_silent_is_released_and_the_task_announced() -> None:
    office = watched()
    gives_back(office)
    office.run(office.now_s + 2.0)
    assert office.released()[-1] == ("ATV1", Role.PRIMARY)
    assert published(office.out, TaskAnnounced)[-1].epoch == 2


def test_without_a_secondary_the_task_is_announced_at_once() -> None:
    office = watched()
    office.resigns("ATV1")
    gives_back(office)
    [announced] = [said for said in published(office.out, TaskAnnounced) if said.epoch == 2]
    assert (announced.role, announced.round) == (Role.PRIMARY, 1)


def test_who_did_not_hear_that_it_was_relieved_is_told_again() -> None:
    office = watched()
    gives_back(office)
    gives_back(office)
    assert sent(office.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=2)] * 2
    assert len(facts(office.out, CarrierChanged)) == 1


@pytest.mark.parametrize("answers", [False, True])
def test_who_has_given_it_back_is_not_acknowledged_by_an_older_heartbeat(answers: bool) -> None:
    office = watched()
    gives_back(office)
    if answers:
        declined = Declined(
            task="T1",
            epoch=2,
            role=Role.PRIMARY,
            reason=Refusal.BUSY,
            number=award_number(office.out, "ATV1"),
        )
        office.desk.on_declined("ATV1", declined, office.now_s)
    brief = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M8", phase=Phase.RETURNING)
    office.desk.adopt("ATV2", brief, office.now_s)
    assert (office.task.primary, office.task.epoch) == ("", 2)


def test_who_gives_back_what_has_ended_is_told_so() -> None:
    office = watched()
    office.desk.close(office.task, "delivered")
    gives_back(office)
    assert sent(office.out, Superseded, to="ATV2") == [Superseded(task="T1", epoch=1)]


# --- a secondary becomes the carrier -----------------------------------------------------------------


def test_a_watch_becomes_a_contract_when_its_vehicle_is_asked() -> None:
    rig = idle()
    rig.on_message("M8", award(role=Role.SECONDARY, primary="ATV2"))
    rig.on_message("M8", Release(task="M8-1", epoch=1, role=Role.SECONDARY, reason=GRACEFUL_SHUTDOWN))
    [answer] = sent(rig.on_message("M8", award(epoch=2, source="S3")), Accepted, to="M8")
    assert (answer.role, answer.epoch) == (Role.PRIMARY, 2)
    rig.run(rig.now_s)
    assert newest(rig).watches == ()


# --- a machine ---------------------------------------------------------------------------------------


def supplied(**stock: int) -> MachineRig:
    """M7 with a goal, and with material but for what is said."""
    full = {material: PLANT.materials[material].buffer for material in PLANT.materials_of("M7")}
    rig = MachineRig("M7", full | stock)
    rig.start()
    rig.take_goal("G1", production())
    return rig


def test_a_machine_that_waits_for_nobody_leaves_at_once() -> None:
    rig = supplied()
    rig.leave()
    assert rig.has_left
    assert rig.heartbeats(MachineHeartbeat)[-1].draining


def test_it_takes_no_goals_any_more() -> None:
    rig = supplied(housing=0)
    rig.leave()
    assert not rig.has_left, "somebody may be about to bid for the housings"
    goal = announcement(task="G2", coordinator="STRATEGIST", work=production())
    effects = rig.on_message("STRATEGIST", goal)
    assert not sent(effects, Bid)
    assert [refused.detail for refused in facts(effects, BidRefused)] == [GRACEFUL_SHUTDOWN]
    [declined] = sent(rig.award_goal("G2", production()), Declined)
    assert declined.reason is Refusal.NOT_FIT


def test_it_goes_on_making_and_announces_nothing() -> None:
    rig = supplied(housing=0)
    rig.leave()
    rig.stocked("housing", 1, "ATV9")
    announced = {said.task for said in published(rig.all, TaskAnnounced)}
    while rig.is_cycling:
        rig.cycle()
    assert {said.task for said in published(rig.all, TaskAnnounced)} == announced


def test_an_auction_that_has_begun_is_brought_to_its_end() -> None:
    rig = supplied(housing=0)
    [task] = {said.task for said in published(rig.all, TaskAnnounced)}
    rig.leave()
    rig.hire(task, "ATV1")
    assert rig.has_left


def test_an_auction_in_which_nobody_bids_holds_nobody() -> None:
    rig = supplied(housing=0)
    rig.leave()
    rig.run(rig.now_s + 5.0)
    assert rig.has_left


def at_the_dock(rig: MachineRig, task: str, seq: int, phase: Phase) -> None:
    brief = Brief(task=task, epoch=1, role=Role.PRIMARY, coordinator="M7", phase=phase)
    heartbeat = rhb("ATV1", seq, rig.now_s, task=task, coordinator="M7")
    rig.on_message("ATV1", msgspec.structs.replace(heartbeat, task=brief))


def with_a_carrier() -> tuple[MachineRig, str]:
    rig = supplied(housing=0)
    [task] = {said.task for said in published(rig.all, TaskAnnounced)}
    rig.hire(task, "ATV1")
    return rig, task


def test_a_vehicle_on_its_way_does_not_hold_it() -> None:
    rig, task = with_a_carrier()
    at_the_dock(rig, task, 1, Phase.CARRYING)
    rig.leave()
    assert rig.has_left


@pytest.mark.parametrize("phase", [Phase.UNLOADING, Phase.HANDING_OVER])
def test_a_vehicle_at_its_dock_holds_it_for_a_bounded_time(phase: Phase) -> None:
    rig, task = with_a_carrier()
    at_the_dock(rig, task, 1, phase)
    rig.leave()
    asked_s = rig.now_s
    for seq in range(2, 30):
        rig.run(asked_s + seq - 1)
        at_the_dock(rig, task, seq, phase)
        assert not rig.has_left
    rig.run(asked_s + COORDINATOR_LEAVES_WITHIN_S)
    assert rig.has_left
    said_s = [heartbeat.at_s for heartbeat in rig.heartbeats(MachineHeartbeat)]
    assert max(later_s - earlier_s for earlier_s, later_s in pairwise(said_s)) < GOAL_SILENCE_S
    assert said_s[-1] == rig.now_s, "only its absence counts as silence"


# --- the strategist ----------------------------------------------------------------------------------

ORDER = OrderReleased(order="O1", items=(OrderItem(product="pump-p3", quantity=24),), due_s=7200.0)


def test_a_strategist_that_waits_for_nobody_leaves_at_once() -> None:
    rig = StrategistRig()
    rig.start()
    rig.leave()
    assert rig.has_left


def test_it_leaves_orders_unanswered_so_that_they_come_again() -> None:
    rig = StrategistRig()
    rig.start()
    rig.on_message("gateway", ORDER)
    rig.leave()
    assert not rig.has_left
    effects = rig.on_message("gateway", OrderReleased(order="O2", items=ORDER.items, due_s=7200.0))
    assert not sent(effects, OrderTaken)


def test_it_hears_the_answer_that_it_waits_for_and_puts_nothing_more_up() -> None:
    rig = StrategistRig()
    rig.start()
    items = (OrderItem(product="pump-p3", quantity=48),)
    rig.on_message("gateway", OrderReleased(order="O1", items=items, due_s=7200.0))
    [goal] = {said.task for said in published(rig.all, TaskAnnounced)}
    rig.leave()
    rig.on_message("M7", goal_bid(goal, 100.0))
    rig.run(1.0)
    rig.on_message("M7", accepted(goal))
    assert rig.has_left
    assert {said.task for said in published(rig.all, TaskAnnounced)} == {goal}


# --- all of them -------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [VehicleRig, MachineRig, StrategistRig])
def test_an_agent_that_has_left_asks_for_no_time_to_leave(make: Callable[[], Rig]) -> None:
    rig = make()
    rig.start()
    rig.leave()
    assert rig.has_left
    assert rig.agent._shutdown.latest_s == NEVER_S  # type: ignore[attr-defined]
