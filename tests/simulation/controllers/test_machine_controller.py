"""The controller of a simulated machine: what it shows, and what it does of what it is told."""

from __future__ import annotations

import math

import pytest
from controller_stand import ControllerStand
from yard import PLANT

from dray.adapters.signals.signal import Signal
from dray_sim.bodies.docks import SHUT
from dray_sim.bodies.stores import TOO_LITTLE
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.alive import STILL_S
from dray_sim.controllers.machine import MachineController

CYCLE_S = 30.0
"""Of a gear."""


class Stand(ControllerStand[MachineController]):
    """A machine."""

    def __init__(self, *, modulus: int = 16, rest_s: float = 0.0, still_s: float = math.inf) -> None:
        super().__init__()
        clock = self.yard.clock
        self.workcell = SimWorkcell(PLANT.machines["M1"], PLANT, clock, {"shaft": 50, "seal": 40})
        self.controller = MachineController(
            self.workcell, clock, self.on_told, modulus=modulus, rest_s=rest_s, still_s=still_s
        )


@pytest.fixture
def stand() -> Stand:
    return Stand()


def test_it_makes_one_piece_after_the_other_while_it_is_to_run_and_counts_them() -> None:
    stand = Stand(modulus=3)
    stand.tell(product="gear", run=True)
    assert stand.wait(4.5 * CYCLE_S) == [(Signal.PIECES, pieces) for pieces in (1, 2, 0, 1)]
    stand.tell(run=False)
    assert stand.wait(4 * CYCLE_S) == [(Signal.PIECES, 2)]
    assert stand.controller.made[Signal.PIECES] == stand.workcell.made["gear"] == 5


def test_it_rests_after_a_piece_so_that_a_late_word_is_in_time() -> None:
    stand = Stand(rest_s=10.0)
    stand.tell(product="gear", run=True)
    assert stand.wait(CYCLE_S + 5.0) == [(Signal.PIECES, 1)]
    stand.tell(run=False)
    assert stand.wait(3 * CYCLE_S) == []


def test_the_dock_opens_for_one_vehicle_whatever_it_brings_or_takes(stand: Stand) -> None:
    stand.tell(dock_permit=True)
    assert stand.wait(20.0) == []
    stand.tell(dock_vehicle="ATV1")
    assert stand.workcell.put("ATV1", "block", 2) == SHUT
    assert stand.wait(10.0) == [(Signal.DOCK_READY, True)]
    assert stand.workcell.put("ATV2", "block", 2) == SHUT
    # No bill of the machine has blocks: they are brought for the first time.
    assert stand.workcell.put("ATV1", "block", 2) == ""
    assert stand.workcell.put("ATV1", "block", 1) == SHUT
    stand.tell(dock_vehicle="ATV2")
    assert stand.wait(10.0) == [(Signal.DOCK_READY, False), (Signal.DOCK_READY, True)]
    assert stand.workcell.take("ATV2", "block", 3) == TOO_LITTLE
    assert stand.workcell.take("ATV2", "block", 2) == ""
    stand.tell(dock_permit=False)
    assert stand.wait(10.0) == [(Signal.DOCK_READY, False)]


def test_a_fault_stands_until_somebody_has_seen_to_it_and_it_is_acknowledged(stand: Stand) -> None:
    stand.workcell.break_down("tool broken")
    assert stand.wait(5.0) == [(Signal.FAULT_TEXT, "tool broken"), (Signal.FAULT, True)]
    stand.tell(reset=True)
    assert stand.wait(5.0) == []
    stand.workcell.mend()
    assert stand.wait(5.0) == [(Signal.FAULT, False), (Signal.FAULT_TEXT, "")]


def test_it_works_at_the_speed_that_it_is_told(stand: Stand) -> None:
    stand.tell(product="gear", run=True, speed=0.5)
    assert stand.wait(2 * CYCLE_S - 1.0) == []
    assert stand.wait(2.0) == [(Signal.PIECES, 1)]


def test_without_power_its_dock_is_shut_and_opens_anew(stand: Stand) -> None:
    stand.tell(dock_permit=True, dock_vehicle="ATV1")
    stand.wait(10.0)
    stand.workcell.power_off()
    assert stand.wait(10.0) == [(Signal.DOCK_READY, False)]
    stand.workcell.power_on()
    assert stand.workcell.put("ATV1", "shaft", 1) == SHUT
    assert stand.wait(10.0) == [(Signal.DOCK_READY, True)]


def test_it_begins_no_piece_while_alive_stands_still_but_for_those_before_it_notices(stand: Stand) -> None:
    stand.tell(product="gear", run=True)
    stand.wait(5.0)
    stand.controller.miss_alive(1)
    assert stand.wait(4 * CYCLE_S) == [(Signal.PIECES, 1), (Signal.PIECES, 2)]
    stand.tell(run=True)
    assert stand.wait(1.5 * CYCLE_S) == [(Signal.PIECES, 3)]


def test_it_watches_alive_by_itself_and_finishes_the_piece_that_it_has_begun() -> None:
    stand = Stand(still_s=STILL_S)
    stand.tell(product="gear", run=True, alive=1)
    stand.wait(STILL_S - 1.0)
    assert stand.wait(4 * CYCLE_S) == [(Signal.PIECES, 1)]
    stand.tell(alive=1)
    assert stand.wait(4 * CYCLE_S) == []
    stand.tell(alive=2)
    assert stand.wait(1.5 * CYCLE_S) == [(Signal.PIECES, 2)]
