"""The controller of a simulated gate: one label after the other, and a counter."""

from __future__ import annotations

import pytest
from controller_stand import ControllerStand

from dray.adapters.signals.signal import Signal, Value
from dray_sim.bodies.gate import Gate
from dray_sim.controllers.alive import STILL_S
from dray_sim.controllers.gate import ASIDE_S, BEAT_S, GateController


class Stand(ControllerStand[GateController]):
    """A gate."""

    def __init__(self) -> None:
        super().__init__()
        self.gate, self.beats = Gate(self.yard.clock), 0
        self.controller = GateController(self.gate, self.yard.clock, self.on_told)

    def admit(self, goal: str, admitted: int) -> None:
        self.beats += 1
        self.tell(admitted_goal=goal, admitted=admitted, alive=self.beats)


@pytest.fixture
def stand() -> Stand:
    return Stand()


def test_containers_come_in_one_by_one_each_with_a_permit_of_its_own(stand: Stand) -> None:
    assert stand.gate.enter("a", 3, "ATV1") == ""
    assert stand.gate.enter("b", 2, "ATV2") == ""
    assert stand.wait() == [(Signal.GOAL, "a")]
    stand.admit("b", 9)
    assert stand.wait() == [], "the permit is for another one"
    stand.admit("a", 2)
    assert stand.wait() == [], "a container comes in as a whole"
    stand.admit("a", 3)
    assert stand.wait() == [(Signal.PIECES, 3), (Signal.GOAL, "")]
    stand.admit("a", 0)
    assert stand.wait() == [(Signal.GOAL, "b")]
    stand.admit("b", 2)
    assert stand.wait() == [(Signal.PIECES, 5), (Signal.GOAL, "")]


def test_a_container_that_nobody_admits_goes_aside(stand: Stand) -> None:
    stand.gate.enter("a", 3)
    stand.gate.enter("b", 1)
    shown: list[tuple[Signal, Value]] = []
    for beat in range(int(1.5 * ASIDE_S / BEAT_S)):
        stand.controller.on_write(Signal.ALIVE, beat + 1)
        shown += stand.wait(BEAT_S)
    assert shown == [(Signal.GOAL, "a"), (Signal.GOAL, ""), (Signal.GOAL, "b")]
    assert stand.controller.aside == {"a": 3}


def test_nothing_goes_aside_while_the_agent_is_away(stand: Stand) -> None:
    stand.gate.enter("a", 3)
    stand.controller.on_write(Signal.ALIVE, 1)
    assert stand.wait(2 * ASIDE_S) == [(Signal.GOAL, "a")]
    # It is there again.
    stand.controller.on_write(Signal.ALIVE, 2)
    assert stand.wait(BEAT_S) == []


def test_nothing_is_let_in_while_alive_stands_still(stand: Stand) -> None:
    stand.admit("a", 3)
    stand.wait(STILL_S + 1.0)
    stand.gate.enter("a", 3)
    stand.tell(admitted=0)
    assert stand.wait() == [(Signal.GOAL, "a")]
    # The permit is there, and whoever has given it is not.
    stand.tell(admitted=3, alive=stand.beats)
    assert stand.wait() == []
    stand.admit("a", 3)
    assert stand.wait() == [(Signal.PIECES, 3), (Signal.GOAL, "")]
