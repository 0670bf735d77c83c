"""A simulated controller on a wire that breaks: what each end hears meanwhile, and what is counted when the wire is whole again."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from yard import PLANT, Yard

from dray.adapters.signals.signal import Checked, Signal
from dray.adapters.signals.workcell import UNSURE
from dray.body import Admit, Book, CycleDone, Report, ResetFault, StartCycle
from dray.messages.keys import GATE
from dray.ports import Body
from dray_sim.bodies.gate import Gate
from dray_sim.bodies.workcell import SimWorkcell
from dray_sim.controllers.gate import GateController
from dray_sim.controllers.machine import MachineController
from dray_sim.controllers.wired import Moment, Wired, WiredBodies

GEAR_S, PUMP_S = 30.0, 60.0
"""Cycle times."""


class Stand:
    """A machine and a gate with controllers, over several lives of their agents.

    Attributes:
        then: the product that the machine's agent asks for after the next piece; empty for none.
    """

    def __init__(self) -> None:
        self.clock = (yard := Yard()).clock
        self._yard = yard
        self.workcell = SimWorkcell(PLANT.machines["M1"], PLANT, self.clock, {"shaft": 50, "seal": 40})
        self.floor_gate = Gate(self.clock)
        self.bodies = WiredBodies(PLANT, self.clock)
        self.reports: list[Report] = []
        self.then = ""
        self.gate = self.bodies.embody_gate(self.floor_gate, 1)
        self.begin()

    def begin(self) -> None:
        """Another life of the machine's agent."""
        self.machine = self.bodies.embody_machine(self.workcell, 1)
        self.machine.attach(self._hear)

    def _hear(self, report: Report) -> None:
        self.reports.append(report)
        if isinstance(report, CycleDone) and self.then:
            then, self.then = self.then, ""
            self.machine.instruct(StartCycle(product=then))

    def wait(self, for_s: float) -> None:
        self._yard.run(self.clock.now_s() + for_s)

    @property
    def wired(self) -> Wired:
        """The machine's."""
        return self.bodies.wired["M1"]

    @property
    def made(self) -> list[str]:
        """What was reported as made since this was asked last."""
        made = [report.product for report in self.reports if isinstance(report, CycleDone)]
        self.reports.clear()
        return made

    @property
    def counted(self) -> int:
        """Pieces that the machine's controller has counted."""
        assert isinstance(self.wired.controller, MachineController)
        return self.wired.controller.made[Signal.PIECES]


@pytest.fixture
def stand() -> Stand:
    return Stand()


def stock(body: Body) -> dict[str, int]:
    state = body.sense()
    return {item: pieces for item, pieces in state.stock.items() if pieces}  # type: ignore[union-attr]


def test_a_wire_that_breaks_with_a_piece_leaves_the_next_one_in_doubt_and_every_piece_counted(
    stand: Stand,
) -> None:
    stand.machine.instruct(StartCycle(product="gear"))
    stand.then = "pump"
    stand.wired.cut_at(Moment.PIECE, more=1)
    stand.wait(GEAR_S + 5.0)
    assert (stand.made, stand.wired.linked) == (["gear"], False)
    stand.wait(5 * GEAR_S)
    assert stand.counted == 2
    stand.wired.link()
    assert stand.made == ["gear"]
    assert UNSURE in stand.bodies.doubts()["M1"]
    assert stock(stand.machine) == stock(stand.workcell)
    stand.machine.instruct(ResetFault())
    stand.wait(2 * PUMP_S + PUMP_S + 5.0)
    assert (stand.made, stand.bodies.doubts()) == (["pump"], {})
    assert stock(stand.machine) == stock(stand.workcell)


def test_a_wire_that_breaks_at_no_moment_stays_whole(stand: Stand) -> None:
    stand.wired.cut_at(Moment.PIECE)
    stand.wait(10.0)
    stand.wired.link()
    stand.machine.instruct(StartCycle(product="gear"))
    stand.wait(GEAR_S + 5.0)
    assert (stand.made, stand.wired.linked) == (["gear"], True)


def test_a_life_that_has_ended_remembers_nothing_and_says_nothing(stand: Stand) -> None:
    ended = stand.machine
    stand.begin()
    stand.machine.instruct(StartCycle(product="gear"))
    kept = stand.wired.kept
    ended.instruct(Book("ATV1", "shaft", 7, task="M1-1", epoch=1))
    ended.instruct(StartCycle(product="pump"))
    assert stand.wired.kept is kept
    stand.wait(GEAR_S + 5.0)
    assert stand.made == ["gear"]


def test_without_its_agents_process_a_machine_finishes_its_piece_and_the_next_life_counts_it(
    stand: Stand,
) -> None:
    stand.machine.instruct(StartCycle(product="gear"))
    stand.wait(5.0)
    stand.bodies.runs = lambda _agent: False
    stand.wait(5 * GEAR_S)
    assert (stand.counted, stand.made, stand.wired.body) == (1, [], None)
    stand.bodies.runs = lambda _agent: True
    stand.begin()
    assert stock(stand.machine) == stock(stand.workcell)
    assert stock(stand.machine)["gear"] == 1


def test_what_people_have_counted_follows_a_damaged_memory(stand: Stand) -> None:
    stand.wired.is_damaged = True
    stand.begin()
    assert (stock(stand.machine), list(stand.bodies.doubts())) == ({}, ["M1"])
    stand.wired.count(replace(stand.wired.mapping, stock=stand.workcell.sense().stock), None)
    stand.begin()
    assert (stock(stand.machine), stand.bodies.doubts()) == (stock(stand.workcell), {})


def test_a_container_that_comes_in_as_the_wire_breaks_is_counted_when_it_is_whole(stand: Stand) -> None:
    gate = stand.bodies.wired[GATE]
    stand.gate.instruct(Admit("a", 5))
    gate.cut_at(Moment.PERMIT)
    assert stand.floor_gate.enter("a", 3) == ""
    stand.wait(20.0)
    assert (gate.linked, stand.bodies.arrived("a")) == (False, 3)
    assert stand.gate.sense().arrived == {"a": 0}  # type: ignore[union-attr]
    gate.link()
    assert stand.gate.sense().arrived == {"a": 3}  # type: ignore[union-attr]
    assert stand.bodies.doubts() == {}


def test_a_gate_whose_memory_was_damaged_goes_on_with_what_people_have_counted(stand: Stand) -> None:
    gate = stand.bodies.wired[GATE]
    stand.gate.instruct(Admit("a", 5))
    stand.floor_gate.enter("a", 3)
    stand.wait(20.0)
    gate.is_damaged = True
    stand.gate = stand.bodies.embody_gate(stand.floor_gate, 2)
    number, controller = getattr(gate.kept, "doubt_number", 0), gate.controller
    assert (number > 0, list(stand.bodies.doubts())) == (True, [GATE])
    assert isinstance(controller, GateController)
    gate.count(replace(gate.mapping, checked=Checked(number, dict(controller.let_in))), gate.kept)  # type: ignore[arg-type]
    stand.gate = stand.bodies.embody_gate(stand.floor_gate, 3)
    stand.gate.instruct(Admit("a", 5))
    stand.floor_gate.enter("a", 2)
    stand.wait(20.0)
    assert (stand.gate.sense().arrived, stand.bodies.doubts()) == ({"a": 5}, {})  # type: ignore[union-attr]
