"""Every check of an invariant can fail: it is shown what it must not accept."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import msgspec
import pytest
from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey
from dray.body import Admit, Drive
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CommandKind,
    Event,
    HandoverAccepted,
    MachineHeartbeat,
    MachineStatus,
    Message,
    OrderItem,
    OrderReleased,
    OrderTaken,
    Pose,
    Production,
    Role,
    Transport,
    VehicleCommand,
)
from dray.messages.fact import (
    AtvStatusChanged,
    AwardAnswered,
    CarrierChanged,
    CommandObeyed,
    ContractEnded,
    ContractTaken,
    Fact,
    GoodsDelivered,
    OrderDropped,
    OrderFulfilled,
    TaskClosed,
    TaskOpened,
)
from dray.plant import default_plant
from dray_sim.bodies.vehicle import SimVehicle
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import VirtualClock
from dray_sim.factory.sim_factory import SimFactory

WORK = Transport(item="shaft", quantity=40, sources=("S3",), destination="M8", ability="tote")
OPENED = TaskOpened(
    task="M8-1",
    epoch=1,
    role=Role.PRIMARY,
    round=1,
    work=WORK,
    radius_m=25.0,
    deadline_s=100.0,
    bids_until_s=1.0,
)
CLOSED = TaskClosed(task="M8-1", epoch=1, outcome="delivered", carrier="ATV2")


class Watched:
    """A factory that does not run, its invariants, and what is said to them."""

    def __init__(self) -> None:
        self.factory = SimFactory(default_plant(), VirtualClock(), seed=1)
        self.checks = Invariants(self.factory)
        self._at_s = 0.0
        self._counted: dict[str, int] = {}

    def say(self, sender: str, said: Fact | Message, address: str = "*") -> None:
        self._at_s += 1.0
        message = said
        if isinstance(said, Fact):
            message = Event(agent=sender, incarnation=1, number=1, at_s=self._at_s, fact=said)
        assert isinstance(message, Message)
        self.checks.on_message(self._at_s, sender, address, message)

    def put_up(self, goal: str, quantity: int) -> None:
        """The strategist asks who makes pumps for order O1."""
        work = Production(product="pump-p3", quantity=quantity, order="O1", item=0)
        self.say("strategist", replace(OPENED, task=goal, work=work))

    def bring(self, goal: str, pieces: int) -> None:
        """Pumps of a goal get in at the gate, and the strategist counts them."""
        gate = self.factory.gate
        gate.instruct(Admit(goal=goal, quantity=1000))
        assert gate.enter(goal, pieces) == ""
        self.count(goal, pieces)

    def count(self, goal: str, pieces: int) -> None:
        total = self._counted[goal] = self._counted.get(goal, 0) + pieces
        fact = GoodsDelivered(
            goal=goal, order="O1", item=0, product="pump-p3", quantity=pieces, delivered=total
        )
        self.say("strategist", fact)

    @property
    def broken(self) -> int:
        """The number of the broken invariant; 0 while all hold."""
        return self.checks.broken.number if self.checks.broken is not None else 0


@pytest.fixture
def watched() -> Watched:
    return Watched()


def machine_heartbeat() -> MachineHeartbeat:
    return MachineHeartbeat(machine="M8", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)


def command(what: str) -> CommandObeyed:
    return CommandObeyed(command=what, what=what, done=True)


def give(
    watched: Watched,
    atv: str,
    *kinds: str,
    key: SigningKey | None = None,
    areas: tuple[str, ...] | None = None,
    valid_until_s: float = 1e6,
) -> None:
    """Somebody commands a vehicle, with a grant."""
    for kind in kinds:
        granted = (key or watched.factory.authority).grant(
            atv,
            VehicleCommand(command=kind, kind=CommandKind(kind)),
            person="operator",
            areas=areas,
            valid_until_s=valid_until_s,
        )
        watched.say("operator", granted, f">{atv}")


def test_a_whole_task_breaks_nothing(watched: Watched) -> None:
    watched.say("M8", OPENED)
    taken = ContractTaken(task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8")
    watched.say("ATV2", taken)
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    watched.say("M8", CLOSED)
    ended = ContractEnded(task="M8-1", epoch=1, role=Role.PRIMARY, reason="handed_over")
    watched.say("ATV2", ended)
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 0


def test_a_forgotten_task_is_noticed(watched: Watched) -> None:
    watched.say("M8", OPENED)
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 1


def test_a_task_that_ends_twice_is_noticed(watched: Watched) -> None:
    watched.say("M8", OPENED)
    watched.say("M8", CLOSED)
    watched.say("M8", CLOSED)
    assert watched.broken == 1


def test_a_handover_to_two_carriers_is_noticed(watched: Watched) -> None:
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=2), ">ATV3")
    assert watched.broken == 2


def test_what_two_carriers_have_written_down_as_theirs_is_noticed(watched: Watched) -> None:
    ended = ContractEnded(task="M8-1", epoch=1, role=Role.PRIMARY, reason="handed_over")
    watched.say("ATV2", ended)
    watched.say("M8", HandoverAccepted(task="M8-1", epoch=1), ">ATV2")
    assert watched.broken == 0
    watched.say("ATV3", ended)
    assert watched.broken == 2


def test_a_task_that_changes_its_carrier_within_an_epoch_is_noticed(watched: Watched) -> None:
    watched.say("M8", OPENED)
    answered = AwardAnswered(task="M8-1", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    watched.say("M8", answered)
    changed = CarrierChanged(task="M8-1", epoch=2, replaced="ATV2", carrier="", reason="silent")
    watched.say("M8", changed)
    watched.say("M8", replace(answered, epoch=2, bidder="ATV3"))
    assert watched.broken == 0
    watched.say("M8", replace(changed, replaced="ATV3"))
    assert watched.broken == 2


def _steal_from_a_storage(factory: SimFactory) -> None:
    factory.storages["S3"].stock["shaft"] -= 1


def _conjure_into_a_warehouse(factory: SimFactory) -> None:
    factory.delivery["DELIVERY"].arrived["gear-unit-g2"] += 1


def _lose_on_the_way(factory: SimFactory) -> None:
    factory.storages["S3"].take("", "shaft", 5)


def _set_aside_what_nobody_made(factory: SimFactory) -> None:
    factory.delivery["DELIVERY"].aside["gear-unit-g2"] += 1


def _take_in_hand_what_was_not_there(factory: SimFactory) -> None:
    factory.in_hands["shaft"] += 1


@pytest.mark.parametrize(
    "tamper",
    [
        _steal_from_a_storage,
        _conjure_into_a_warehouse,
        _lose_on_the_way,
        _set_aside_what_nobody_made,
        _take_in_hand_what_was_not_there,
    ],
)
def test_a_piece_that_vanishes_or_appears_is_noticed(
    watched: Watched, tamper: Callable[[SimFactory], None]
) -> None:
    tamper(watched.factory)
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 2


def test_what_people_carry_is_not_lost(watched: Watched) -> None:
    watched.factory.storages["S3"].take("", "shaft", 5)
    watched.factory.in_hands["shaft"] += 5
    watched.say("M8", machine_heartbeat())
    assert watched.broken == 0


def test_a_vehicle_with_two_tasks_is_noticed(watched: Watched) -> None:
    watched.say("ATV2", ContractTaken(task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8"))
    watched.say("ATV2", ContractTaken(task="M9-1", epoch=1, role=Role.PRIMARY, coordinator="M9"))
    assert watched.broken == 3


def test_a_vehicle_may_watch_while_it_is_free(watched: Watched) -> None:
    watched.say("ATV2", ContractTaken(task="M8-1", epoch=1, role=Role.SECONDARY, coordinator="M8"))
    watched.say("ATV2", ContractTaken(task="M9-1", epoch=1, role=Role.SECONDARY, coordinator="M9"))
    assert watched.broken == 0


@pytest.fixture
def ordered(watched: Watched) -> Watched:
    """Forty-eight pumps were ordered, and M8 makes them all."""
    items = (OrderItem(product="pump-p3", quantity=48),)
    watched.say("desk", OrderReleased(order="O1", items=items, due_s=3600.0), ">strategist")
    watched.put_up("G1", 48)
    return watched


def test_an_order_that_is_delivered_to_the_piece_breaks_nothing(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    ordered.bring("G1", 24)
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 0


def test_pieces_of_a_lost_goal_and_of_its_successor_add_up(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    ordered.put_up("G2", 24)
    ordered.bring("G2", 24)
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 0


def test_more_than_was_ordered_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 48)
    ordered.put_up("G2", 24)
    ordered.bring("G2", 24)
    assert ordered.broken == 4


def test_a_count_of_pieces_that_never_came_is_noticed(ordered: Watched) -> None:
    ordered.count("G1", 24)
    assert ordered.broken == 4


def test_a_goal_closed_too_early_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    work = Production(product="pump-p3", quantity=48, order="O1", item=0)
    ordered.say("strategist", msgspec.structs.replace(OPENED, task="G1", work=work))
    ordered.say("strategist", msgspec.structs.replace(CLOSED, task="G1"))
    assert ordered.broken == 4


def test_an_order_fulfilled_too_early_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 47)
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 4


def test_an_order_that_is_said_to_be_fulfilled_and_is_not_is_noticed(ordered: Watched) -> None:
    ordered.bring("G1", 48)
    ordered.say("strategist", OrderTaken(order="O1"), ">desk")
    ordered.say("strategist", OrderFulfilled(order="O1"))
    ordered.say("strategist", OrderTaken(order="O1", fulfilled=True), ">desk")
    assert ordered.broken == 0
    ordered.say("strategist", OrderTaken(order="O2", fulfilled=True), ">desk")
    assert ordered.broken == 4


def test_an_order_that_was_dropped_is_not_counted(ordered: Watched) -> None:
    ordered.bring("G1", 24)
    ordered.say("strategist", OrderDropped(order="O1"))
    ordered.say("strategist", OrderFulfilled(order="O1"))
    assert ordered.broken == 0


def test_a_resume_without_an_acknowledge_is_noticed(watched: Watched) -> None:
    give(watched, "ATV2", "stop", "resume")
    watched.say("ATV2", command("stop"))
    watched.say("ATV2", command("resume"))
    assert watched.broken == 5


def test_a_stop_that_ends_by_itself_is_noticed(watched: Watched) -> None:
    give(watched, "ATV2", "stop")
    watched.say("ATV2", command("stop"))
    watched.say("ATV2", AtvStatusChanged(status=AtvStatus.WORKING))
    assert watched.broken == 5


def stopped_heartbeat(vehicle: SimVehicle) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=vehicle.id,
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.STOPPED,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node=vehicle.sense().node,
        speed_mps=0.0,
        battery_frac=1.0,
    )


def stop(watched: Watched, vehicle: SimVehicle) -> None:
    """Stop it, and let it stand for longer than braking takes."""
    give(watched, vehicle.id, "stop")
    watched.say(vehicle.id, command("stop"))
    for _ in range(15):
        watched.say(vehicle.id, stopped_heartbeat(vehicle))


def drive_off(watched: Watched, vehicle: SimVehicle) -> None:
    here = vehicle.sense().node
    way = watched.factory.plant.routes("heavy").way(here, "c3")
    vehicle.instruct(Drive(order=1, nodes=way.nodes, released=len(way.nodes)))
    watched.factory.clock.time_s += 5.0
    watched.say(vehicle.id, stopped_heartbeat(vehicle))


def test_a_stopped_vehicle_that_moves_is_noticed(watched: Watched) -> None:
    vehicle = watched.factory.vehicles["ATV2"]
    stop(watched, vehicle)
    assert watched.broken == 0
    drive_off(watched, vehicle)
    assert watched.broken == 5


def test_a_stop_is_not_forgotten_with_the_power(watched: Watched) -> None:
    vehicle = watched.factory.vehicles["ATV2"]
    stop(watched, vehicle)
    vehicle.power_off()
    vehicle.power_on()
    drive_off(watched, vehicle)
    assert watched.broken == 5


def test_people_may_carry_a_stopped_vehicle(watched: Watched) -> None:
    vehicle = watched.factory.vehicles["ATV2"]
    stop(watched, vehicle)
    vehicle.place_at("c3")
    watched.say(vehicle.id, stopped_heartbeat(vehicle))
    assert watched.broken == 0


ATV1_IN = "AREA2"


def test_a_command_that_was_granted_for_here_and_now_breaks_nothing(watched: Watched) -> None:
    give(watched, "ATV1", "stop", areas=(ATV1_IN,))
    watched.say("ATV1", command("stop"))
    assert watched.broken == 0


def test_a_refused_command_breaks_nothing(watched: Watched) -> None:
    watched.say("ATV1", replace(command("stop"), done=False))
    assert watched.broken == 0


def test_a_command_that_nobody_has_given_is_noticed(watched: Watched) -> None:
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


def test_a_command_without_a_grant_is_noticed(watched: Watched) -> None:
    watched.say("operator", VehicleCommand(command="stop", kind=CommandKind.STOP), ">ATV1")
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


@pytest.mark.parametrize(
    "grant",
    [
        {"areas": ("AREA4",)},
        {"areas": ()},
        {"valid_until_s": 1.0},
        {"key": SigningKey(b"a stranger's key, 32 bytes long.")},
    ],
    ids="".join,
)
def test_a_grant_for_another_place_or_time_or_by_a_stranger_is_noticed(
    watched: Watched, grant: dict[str, Any]
) -> None:
    give(watched, "ATV1", "stop", **grant)
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


def test_a_grant_for_another_vehicle_is_noticed(watched: Watched) -> None:
    give(watched, "ATV3", "stop")
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


def test_the_chances_of_a_factory_do_not_depend_on_one_another() -> None:
    """One generator per concern: drawing more of one leaves the others as they were."""
    assert Random("1 network").random() != Random("1 stock").random()
