"""A vehicle that tells no place calls a person, and is a vehicle as any other once it tells one."""

from __future__ import annotations

from atv1 import contracted
from defaults import PLANT
from effects import committed, facts, published
from rigs import VehicleRig

from dray.body import UnplacedVehicle, VehicleState
from dray.memory import WHOLE, AtvMemory
from dray.messages import AtvHeartbeat, CallPlace, CallState, HelpCall, ProblemKind
from dray.messages.fact import HelpCallEnded
from dray.protocol.vehicle.unplaced import CALL_AFTER_S

WHY = "the vehicle has not said where it is"


class UnplacedRig(VehicleRig):
    """ATV1, whose body tells no place until the test says so."""

    is_placed = False

    def sense(self) -> VehicleState | UnplacedVehicle:  # type: ignore[override]
        return super().sense() if self.is_placed else UnplacedVehicle(WHY)


def unplaced(memory: AtvMemory | None = None) -> UnplacedRig:
    rig = UnplacedRig()
    if memory is not None:
        rig.memory = {WHOLE: memory}
    rig.start()
    return rig


def calls(rig: VehicleRig) -> list[HelpCall]:
    return published(rig.all, HelpCall)


def test_a_vehicle_that_has_never_told_a_place_calls_a_person_after_a_minute() -> None:
    rig = unplaced()
    rig.run(CALL_AFTER_S - 1.0)
    assert not calls(rig)
    rig.run(CALL_AFTER_S + 1.0)
    call = calls(rig)[-1]
    assert (call.caller, call.problem.kind, call.problem.needs_person) == (
        "ATV1",
        ProblemKind.LOST_POSITION,
        True,
    )
    assert (call.place, call.reason) == (CallPlace.UNTOLD, f"it has not told any place yet: {WHY}")
    assert not rig.heartbeats(AtvHeartbeat), "a heartbeat would name a position that nobody has told"


def test_the_call_names_where_it_was_last() -> None:
    rig = unplaced(AtvMemory(node="p1"))
    rig.run(CALL_AFTER_S + 1.0)
    call, spot = calls(rig)[-1], PLANT.nodes["p1"]
    assert (call.place, call.x_m, call.y_m) == (CallPlace.LAST, spot.x_m, spot.y_m)
    assert call.reason == f"it does not tell its place, and was last at p1: {WHY}"


def test_the_call_ends_when_it_tells_a_place_and_it_beats() -> None:
    rig = unplaced()
    rig.run(CALL_AFTER_S + 1.0)
    rig.is_placed = True
    rig.run(CALL_AFTER_S + 10.0)
    assert calls(rig)[-1].state is CallState.ENDED
    assert facts(rig.all, HelpCallEnded)
    assert rig.heartbeats(AtvHeartbeat)[-1].node == "p3"


def test_a_place_that_is_told_in_time_calls_nobody() -> None:
    rig = unplaced()
    rig.run(CALL_AFTER_S / 2)
    rig.is_placed = True
    rig.run(3.0 * CALL_AFTER_S)
    assert not calls(rig)
    assert rig.heartbeats(AtvHeartbeat)


def test_it_may_leave_without_a_place() -> None:
    rig = unplaced()
    rig.run(CALL_AFTER_S + 1.0)
    rig.leave()
    assert rig.has_left
    assert calls(rig)[-1].state is CallState.ENDED


def test_its_memory_names_the_node_that_it_was_at() -> None:
    note = committed(contracted().all)[WHOLE]
    assert isinstance(note, AtvMemory)
    assert note.node == "p3"
