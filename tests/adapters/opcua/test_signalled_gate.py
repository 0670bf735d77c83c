"""The body of a gate with a counter and a reader of labels: every piece counts once, for the goal that was let in, or it is a problem with a name."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from plc import PATIENCE_S, Plc, mapping
from signals_rig import HandClock

from dray.adapters.mapping_file import parse_mapping
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.signals.gate import (
    DAMAGED_SIGNALS,
    SETTLE_S,
    KeptSignals,
    SignalledGate,
    SignalledGoal,
    settle_s,
)
from dray.adapters.signals.signal import (
    OF_A_GATE,
    Checked,
    Edge,
    Quality,
    Sample,
    Signal,
    SignalMapping,
    Tag,
    Value,
)
from dray.body import Admit, GateState, GoodsArrived, OpenDock, Report

SHAFTS, GEARS = "O-7-1.1", "O-8-1.1"

SIGNALS = {signal: Tag(signal.value) for signal in (Signal.PIECES, *OF_A_GATE, Signal.FAULT)}

NEEDED = {signal: Tag("x") for signal in (Signal.PIECES, *OF_A_GATE)}


class GateRig:
    """One gate, over several lives of its agent; 10 shafts and 10 gears are admitted."""

    def __init__(self, pieces: Tag | None = None, first: Value = 500) -> None:
        self.mapping = SignalMapping(SIGNALS | ({} if pieces is None else {Signal.PIECES: pieces}))
        self.clock, self.reports = HandClock(), list[Report]()
        self.kept: KeptSignals | None = None
        self.shown: Value = first
        self.label = ""
        self.begin()
        for goal in (SHAFTS, GEARS):
            self.body.instruct(Admit(goal, 10))
        self.reports.clear()

    def begin(self) -> None:
        self.body = SignalledGate(self.mapping, self.clock, self, self.kept)
        self.body.attach(self.reports.append)
        self.link()

    def link(self) -> None:
        self.tell(Signal.PIECES, self.shown)
        self.tell(Signal.GOAL, self.label)
        self.body.on_link()

    def remember(self, kept: KeptSignals) -> None:
        self.kept = kept

    def write(self) -> None:
        """The link would."""

    def tell(self, signal: Signal, value: Value, quality: Quality = Quality.GOOD) -> None:
        self.body.on_sample(signal, Sample(value, quality))

    def show(self, label: str) -> tuple[Value, Value]:
        """A container stands there; returns what the controller is told."""
        self.label = label
        self.tell(Signal.GOAL, label)
        self.clock.pass_s(SETTLE_S)
        return self.told

    def counter(self, value: Value) -> None:
        self.shown = value
        self.tell(Signal.PIECES, value)

    def pass_by(self, label: str, pieces: int) -> None:
        """A container comes in as it should."""
        goal, admitted = self.show(label)
        assert goal == label
        assert isinstance(admitted, int)
        assert admitted >= pieces
        assert isinstance(self.shown, int)
        self.counter(self.shown + pieces)
        self.show("")

    @property
    def told(self) -> tuple[Value, Value]:
        return self.body.outputs[Signal.ADMITTED_GOAL], self.body.outputs[Signal.ADMITTED]

    @property
    def arrived(self) -> dict[str, int]:
        return {goal: pieces for goal, pieces in self.body.sense().arrived.items() if pieces}


def test_a_container_is_let_in_by_its_label_and_its_pieces_are_counted() -> None:
    rig = GateRig()
    assert rig.told == ("", 0)
    assert rig.show(SHAFTS) == (SHAFTS, 10)
    rig.counter(504)
    assert rig.reports == [GoodsArrived(SHAFTS, 4, 10)]
    assert rig.told == (SHAFTS, 6)
    assert rig.show("") == (SHAFTS, 0)
    rig.pass_by(GEARS, 3)
    assert rig.reports[1:] == [GoodsArrived(GEARS, 3, 10)]
    assert rig.body.sense() == GateState({SHAFTS: 4, GEARS: 3}, late=True)
    assert (rig.body.away, rig.body.away_since_s) == ("", None)


def test_nothing_is_let_in_that_is_not_admitted_and_it_is_as_soon_as_it_is() -> None:
    rig = GateRig()
    assert rig.show("O-9-1.1") == ("", 0)
    rig.body.instruct(Admit("O-9-1.1", 2))
    assert rig.told == ("O-9-1.1", 2)
    rig.counter(502)
    assert rig.told == ("O-9-1.1", 0)
    rig.show("")
    # A surplus container of the same goal.
    assert rig.show("O-9-1.1") == ("O-9-1.1", 0)


def test_a_count_that_comes_after_the_next_label_belongs_to_the_container_before() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.label = GEARS
    rig.tell(Signal.GOAL, GEARS)
    assert rig.told == (SHAFTS, 0)
    rig.counter(504)
    rig.clock.pass_s(SETTLE_S)
    assert rig.told == (GEARS, 10)
    rig.counter(505)
    assert rig.arrived == {SHAFTS: 4, GEARS: 1}


def test_a_label_is_believed_once_it_was_shown_for_a_second() -> None:
    rig = GateRig()
    rig.tell(Signal.GOAL, SHAFTS)
    rig.clock.pass_s(SETTLE_S / 2)
    rig.tell(Signal.GOAL, GEARS)
    rig.clock.pass_s(SETTLE_S / 2)
    assert rig.told == ("", 0)
    rig.clock.pass_s(SETTLE_S / 2)
    assert rig.told == (GEARS, 10)


def test_a_second_is_a_real_one_where_the_plants_clock_runs_faster() -> None:
    assert (settle_s(1.0), settle_s(20.0)) == (SETTLE_S, 20 * SETTLE_S)


def test_what_is_on_its_way_in_counts_though_its_goal_was_shut_meanwhile() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.body.instruct(Admit(SHAFTS, 0))
    assert rig.told == (SHAFTS, 0)
    rig.counter(504)
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 4}, "")


def test_a_counter_that_rolls_over_counts_on() -> None:
    rig = GateRig(first=65_534)
    rig.body.on_range(Signal.PIECES, (65_536,))
    rig.show(SHAFTS)
    rig.counter(1)
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 3}, "")


def test_a_counter_that_was_reset_while_it_was_heard_counts_on() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(0)
    rig.counter(2)
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 2}, "")


def test_what_came_in_while_nobody_listened_belongs_to_the_last_permit() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.body.on_link_lost("cut")
    assert rig.told == (SHAFTS, 0)
    rig.shown, rig.label = 503, GEARS
    rig.link()
    assert rig.arrived == {SHAFTS: 3}
    rig.clock.pass_s(SETTLE_S)
    assert rig.told == (GEARS, 10)


def test_nothing_is_let_in_before_the_counter_was_heard() -> None:
    """By MQTT a label may come before a count does."""
    rig = GateRig()
    rig.show(SHAFTS)
    rig.body.on_link_lost("cut")
    rig.body.on_link()
    assert rig.show(GEARS) == (SHAFTS, 0)
    assert rig.body.away == "its controller has no value for pieces: nothing was said yet"
    rig.counter(503)
    rig.clock.pass_s(SETTLE_S)
    assert (rig.body.away, rig.arrived, rig.told) == ("", {SHAFTS: 3}, (GEARS, 10))


def test_a_life_that_begins_anew_counts_what_came_in_meanwhile_once() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(502)
    rig.shown = 503
    rig.begin()
    assert (rig.arrived, rig.told) == ({SHAFTS: 3}, (SHAFTS, 0))
    rig.begin()
    assert rig.arrived == {SHAFTS: 3}
    rig.clock.pass_s(SETTLE_S)
    assert rig.told == (SHAFTS, 7)


def test_a_reset_of_a_shut_gate_has_lost_nothing() -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    rig.show("O-9-1.1")
    rig.body.on_link_lost("cut")
    rig.shown = 0
    rig.link()
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 4}, "")


def test_pulses_are_counted_one_by_one() -> None:
    rig = GateRig(pieces=Tag("pulse", edge=Edge.RISING), first=False)
    rig.show(SHAFTS)
    for value in (True, False, True, True, False):
        rig.counter(value)
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 2}, "")


@pytest.mark.parametrize(
    ("value", "gap", "counted", "why"),
    [
        (10_500, False, 4, "pieces went from 504 to 10,500: 6 pieces at most can have been let in since"),
        (511, False, 4, "pieces went from 504 to 511: 6 pieces at most can have been let in since"),
        (490, False, 4, "pieces went from 504 to 490: it counts backwards"),
        (
            2,
            True,
            6,
            "pieces went from 504 to 2 while nobody listened: pieces let in before that may be missing",
        ),
    ],
)
def test_a_count_that_no_permit_explains_shuts_the_gate_and_says_both_figures(
    value: int, gap: bool, counted: int, why: str
) -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(504)
    if gap:
        rig.body.on_link_lost("cut")
        rig.shown = value
        rig.link()
    else:
        rig.counter(value)
    assert rig.body.away == f"its count is in doubt (1): {why}; the last permit was for {SHAFTS}"
    assert rig.body.away_since_s == rig.clock.now_s()
    assert (rig.arrived, rig.told) == ({SHAFTS: counted}, (SHAFTS, 0))
    rig.begin()
    rig.clock.pass_s(SETTLE_S)
    assert rig.body.away.startswith("its count is in doubt (1)"), "the next life knows it, too"
    assert rig.told[1] == 0


def test_a_piece_of_a_shut_gate_is_in_doubt() -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    rig.show("O-9-1.1")
    rig.counter(505)
    assert "0 pieces at most can have been let in" in rig.body.away
    assert rig.arrived == {SHAFTS: 4}


@pytest.mark.parametrize("is_open", [True, False])
def test_pulses_that_nobody_heard_are_in_doubt_while_the_gate_was_open(is_open: bool) -> None:
    rig = GateRig(pieces=Tag("pulse", edge=Edge.RISING), first=False)
    rig.show(SHAFTS if is_open else "O-9-1.1")
    rig.body.on_link_lost("cut")
    rig.link()
    assert ("its pulses could not be heard" in rig.body.away) == is_open


def test_people_count_and_the_gate_goes_on() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(9_000)
    rig.mapping = msgspec.structs.replace(rig.mapping, checked=Checked(1, {SHAFTS: 6}))
    rig.begin()
    rig.clock.pass_s(SETTLE_S)
    assert (rig.body.away, rig.arrived, rig.told) == ("", {SHAFTS: 6}, (SHAFTS, 4))
    # The same count settles no new doubt.
    rig.counter(8_000)
    rig.begin()
    assert rig.body.away.startswith("its count is in doubt (2)")


def test_a_count_of_people_takes_no_piece_away() -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    rig.counter(9_000)
    rig.mapping = msgspec.structs.replace(rig.mapping, checked=Checked(1, {SHAFTS: 2}))
    rig.begin()
    assert rig.arrived == {SHAFTS: 4}


def test_a_damaged_memory_is_no_empty_gate() -> None:
    rig = GateRig()
    rig.kept = DAMAGED_SIGNALS
    rig.begin()
    assert rig.body.away == "its count is in doubt (0): what was remembered of it is damaged"
    rig.mapping = msgspec.structs.replace(rig.mapping, checked=Checked(0, {SHAFTS: 3}))
    rig.begin()
    rig.body.instruct(Admit(SHAFTS, 10))
    assert (rig.body.away, rig.arrived) == ("", {SHAFTS: 3})
    assert rig.show(SHAFTS) == (SHAFTS, 7)


@pytest.mark.parametrize(
    ("signal", "value", "quality", "why"),
    [
        (Signal.PIECES, 501, Quality.BAD, "its controller has no value for pieces: it is bad"),
        (Signal.PIECES, 501, Quality.UNCERTAIN, "its controller has no value for pieces: it is uncertain"),
        (Signal.PIECES, -3, Quality.GOOD, "its controller has no value for pieces: -3 is no count"),
        (
            Signal.PIECES,
            float("nan"),
            Quality.GOOD,
            "its controller has no value for pieces: nan is no count",
        ),
        (Signal.PIECES, True, Quality.GOOD, "its controller has no value for pieces: True is no count"),
        (Signal.PIECES, "many", Quality.GOOD, "its controller has no value for pieces: 'many' is no count"),
        (Signal.GOAL, SHAFTS, Quality.BAD, "its controller has no value for goal: it is bad"),
        (Signal.GOAL, 7, Quality.GOOD, "its controller has no value for goal: 7 is no label"),
        (Signal.FAULT, True, Quality.GOOD, "its controller has a fault: a fault"),
        (Signal.FAULT, "belt jammed", Quality.GOOD, "its controller has a fault: belt jammed"),
        (Signal.FAULT, False, Quality.BAD, "its controller has no value for fault: it is bad"),
    ],
)
def test_what_is_no_value_shuts_the_gate_until_there_is_one(
    signal: Signal, value: Value, quality: Quality, why: str
) -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.tell(signal, value, quality)
    assert (rig.body.away, rig.told) == (why, (SHAFTS, 0))
    rig.tell(Signal.PIECES, 500)
    rig.tell(Signal.GOAL, SHAFTS)
    rig.tell(Signal.FAULT, False)
    rig.clock.pass_s(SETTLE_S)
    assert (rig.body.away, rig.told, rig.arrived) == ("", (SHAFTS, 10), {})


def test_a_permit_that_is_refused_is_a_problem() -> None:
    rig = GateRig()
    rig.body.on_refused(Signal.ADMITTED, "BadNotWritable")
    assert rig.body.away == "its controller does not take admitted: BadNotWritable"
    rig.body.on_refused(Signal.ADMITTED, "")
    assert rig.body.away == ""


def test_a_goal_is_forgotten_after_thousands_and_a_finished_one_first() -> None:
    kept = KeptSignals({"a": SignalledGoal(4, 1), "b": SignalledGoal(4, 4), "c": SignalledGoal(4)})
    rig = GateRig()
    body = SignalledGate(rig.mapping, rig.clock, rig, kept, kept_goals=3)
    body.instruct(Admit("d", 1))
    assert [*body.sense().arrived] == ["a", "c", "d"]
    body.instruct(OpenDock("ATV1", "shaft", 1))


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (SignalMapping({Signal.PIECES: Tag("x")}), "`goal` is missing: without the label nobody knows whose"),
        (
            SignalMapping({Signal.GOAL: Tag("x")}),
            "`pieces` is missing: without it nobody knows that pieces came in",
        ),
        (SignalMapping({**NEEDED, Signal.RUN: Tag("x")}), "signals.run: the gate has pieces, goal"),
        (
            SignalMapping({**NEEDED, Signal.DOCK_PERMIT: Tag("x")}),
            "dock_permit: vehicles ask nobody at the gate",
        ),
        (SignalMapping(NEEDED, {"shaft": 1}), "stock: nothing is kept at the gate"),
        (SignalMapping(NEEDED, levels={"shaft": Tag("x")}), "levels: nothing is kept at the gate"),
    ],
)
def test_a_mapping_that_is_no_gates_is_refused(said: SignalMapping, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        said.check_gate()


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (SignalMapping(NEEDED), "signals.goal: only the gate has it, and this is a machine"),
        (SignalMapping({Signal.PIECES: Tag("x")}, checked=Checked(1)), "checked: only the gate has it"),
    ],
)
def test_a_gates_mapping_is_no_machines(said: SignalMapping, why: str) -> None:
    SignalMapping(NEEDED).check_gate()
    with pytest.raises(ValueError, match=why):
        said.check_machine()


def test_it_may_be_on_topics() -> None:
    text = b"""
silent_after_s: 5
signals:
  pieces: {topic: gate/in, path: pieces}
  goal: {topic: gate/in, path: label}
  admitted: {topic: gate/do, path: pieces}
  admitted_goal: {topic: gate/do, path: label}
"""
    parse_mapping(text, "gate.yaml", MqttMapping).check_gate()


NODES = (Signal.PIECES, Signal.GOAL, Signal.ADMITTED, Signal.ADMITTED_GOAL)


def test_the_gate_of_a_real_controller_begins_and_a_doubt_ends_it_and_is_said(tmp_path: Path) -> None:
    async def story() -> None:
        async with Plc(pieces=70) as plc:
            file = tmp_path / "gate.yaml"
            file.write_bytes(msgspec.yaml.encode({"url": plc.url, "signals": mapping(NODES)}))
            process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "dray", "agent", "gate"),
                *("--body", "opcua", "--mapping", str(file)),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env={**os.environ, "DRAY_BUS_PLAIN": "true", "DRAY_JOURNAL_FOLDER": str(tmp_path)},
                cwd=tmp_path,
            )
            assert process.stdout is not None
            assert (await process.stdout.readline()).decode() == "gate is ready\n"
            # Nobody has admitted it.
            await plc.put(Signal.GOAL, SHAFTS)
            await plc.put(Signal.PIECES, 75)
            _, told = await asyncio.wait_for(process.communicate(), PATIENCE_S)
            assert process.returncode == 1
            assert "pieces went from 70 to 75: 0 pieces at most can have been let in" in told.decode()
            kept = msgspec.json.decode((tmp_path / "gate.signals.json").read_bytes(), type=KeptSignals)
            assert (kept.doubts, kept.pieces.value if kept.pieces else None) == (1, 75)

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))
