"""The body of a gate with a counter and a reader of labels: every piece counts once, for the goal that was let in, or it is a problem with a name."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from gate_rig import GEARS, SHAFTS, GateRig

from dray.adapters.signals.gate import (
    AGAIN,
    AGAIN_MOST,
    DAMAGED_SIGNALS,
    SETTLE_S,
    KeptSignals,
    SignalledGate,
    SignalledGoal,
    settle_s,
)
from dray.adapters.signals.signal import OF_A_GATE, Checked, Edge, Quality, Signal, SignalMapping, Tag, Value
from dray.body import Admit, GateProblem, GateState, GoodsArrived, OpenDock
from dray.errors import UnavailableError

NEEDED = {signal: Tag("x") for signal in (Signal.PIECES, *OF_A_GATE)}


def test_a_container_is_let_in_by_its_label_and_its_pieces_are_counted() -> None:
    rig = GateRig()
    assert rig.told == ("", 0)
    assert rig.show(SHAFTS) == (SHAFTS, 10)
    rig.counter(504)
    assert rig.reports == [GoodsArrived(SHAFTS, 4, 10)]
    assert rig.told == (SHAFTS, 10), "of the whole permit"
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
    assert rig.show("") == ("O-9-1.1", 0)
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


def said(rig: GateRig) -> GoodsArrived:
    """What was reported of goods last."""
    return [report for report in rig.reports if isinstance(report, GoodsArrived)][-1]


@pytest.mark.parametrize("is_cut", [True, False])
def test_a_goal_is_said_to_be_shut_when_its_permit_can_bring_nothing_in_any_more(*, is_cut: bool) -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    if is_cut:
        rig.body.on_link_lost("cut")
    rig.body.instruct(Admit(SHAFTS, 0))
    assert said(rig) == GoodsArrived(SHAFTS, 0, 10)
    rig.shown = 504
    if is_cut:
        rig.clock.pass_s(10 * SETTLE_S)
        rig.link()
    else:
        rig.counter(504)
    assert said(rig) == GoodsArrived(SHAFTS, 4, 10)
    rig.clock.pass_s(SETTLE_S)
    assert said(rig) == GoodsArrived(SHAFTS, 4, 0)
    assert rig.body.away == ""


def taken_back() -> GateRig:
    """The permit for the shafts was taken back; the wire is cut, and nobody has noticed."""
    rig = GateRig()
    rig.show(SHAFTS)
    rig.is_cut = True
    rig.body.instruct(Admit(SHAFTS, 0))
    return rig


def test_a_goal_is_not_said_to_be_shut_while_the_controller_refuses_the_end_of_its_permit() -> None:
    rig = taken_back()
    rig.body.on_refused(Signal.ADMITTED, "BadNotWritable")
    rig.clock.pass_s(5 * SETTLE_S)
    assert said(rig) == GoodsArrived(SHAFTS, 0, 10)
    rig.is_cut = False
    rig.write()
    rig.body.on_refused(Signal.ADMITTED, "")
    rig.clock.pass_s(SETTLE_S)
    assert said(rig) == GoodsArrived(SHAFTS, 0, 0)


def test_what_comes_in_as_the_end_of_its_permit_is_lost_with_the_wire_counts() -> None:
    rig = taken_back()
    rig.clock.pass_s(3 * SETTLE_S)
    assert said(rig) == GoodsArrived(SHAFTS, 0, 10)
    rig.body.on_link_lost("it does not answer")
    rig.clock.pass_s(10 * SETTLE_S)
    rig.shown, rig.label = 504, ""
    rig.link()
    rig.clock.pass_s(SETTLE_S)
    assert (said(rig), rig.body.away) == (GoodsArrived(SHAFTS, 4, 0), "")


def test_counts_may_come_for_a_second_after_the_end_of_their_permit_was_confirmed() -> None:
    rig = taken_back()
    rig.clock.pass_s(1.9 * SETTLE_S)
    rig.is_cut = False
    rig.write()
    rig.clock.pass_s(0.9 * SETTLE_S)
    rig.counter(504)
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 4}, "")
    rig.clock.pass_s(SETTLE_S)
    assert said(rig) == GoodsArrived(SHAFTS, 4, 0)


def test_a_permit_from_before_a_broken_connection_ends_when_its_end_is_confirmed() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.is_cut = True
    rig.body.on_link_lost("cut")
    rig.body.instruct(Admit(SHAFTS, 0))
    rig.tell(Signal.PIECES, 500)
    rig.tell(Signal.GOAL, SHAFTS)
    rig.body.on_link()
    rig.clock.pass_s(3 * SETTLE_S)
    rig.counter(504)
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 4}, "")


def test_a_permit_ends_by_mqtt_though_nothing_is_confirmed() -> None:
    rig = GateRig()
    rig.broker = "broker:1883"
    rig.begin()
    rig.clock.pass_s(SETTLE_S)
    rig.show(SHAFTS)
    rig.body.instruct(Admit(SHAFTS, 0))
    rig.clock.pass_s(SETTLE_S)
    assert said(rig) == GoodsArrived(SHAFTS, 0, 0)


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


@pytest.mark.parametrize("label", ["", "O-9-1.1"])
@pytest.mark.parametrize("is_new_life", [True, False])
def test_a_reset_of_a_shut_gate_has_lost_nothing(label: str, *, is_new_life: bool) -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    rig.show(label)
    rig.body.on_link_lost("cut")
    rig.shown = 0
    (rig.begin if is_new_life else rig.link)()
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 4}, "")


@pytest.mark.parametrize("is_new_life", [True, False])
def test_a_permit_ends_a_second_after_its_label_went(*, is_new_life: bool) -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    assert rig.kept is not None
    assert rig.kept.left == 0, "on the disk, too"
    if is_new_life:
        rig.begin()
    rig.counter(505)
    assert "0 pieces at most can have been let in" in rig.body.away
    assert rig.arrived == {SHAFTS: 4}


def test_a_permit_does_not_end_while_the_label_is_unknown() -> None:
    """By MQTT the counter may come before the label does."""
    rig = GateRig()
    rig.show(SHAFTS)
    rig.body.on_link_lost("cut")
    rig.body.on_link()
    rig.counter(502)
    assert rig.body.away == "its controller has no value for goal: nothing was said yet"
    rig.clock.pass_s(10 * SETTLE_S)
    rig.counter(504)
    assert rig.arrived == {SHAFTS: 4}
    assert rig.show(SHAFTS) == (SHAFTS, 6)
    assert rig.body.away == ""


class OneByOne:
    """A controller that lets in one piece after the other, whose counts are heard late.

    Args:
        rig: the gate that hears them.
        late: pieces that come in before one of them is heard.
    """

    def __init__(self, rig: GateRig, late: int) -> None:
        self._rig, self._late = rig, late
        assert isinstance(rig.shown, int)
        self.pieces = self._begun_at = rig.shown

    def let_in(self, pieces: int) -> int:
        """Returns how many of these came in."""
        before = self.pieces
        for _ in range(pieces):
            admitted = self._rig.told[1]
            assert isinstance(admitted, int)
            if not admitted:
                self._begun_at = self.pieces
            elif self.pieces - self._begun_at < admitted:
                self.pieces += 1
            self._rig.counter(max(before, self.pieces - self._late))
        self._rig.counter(self.pieces)
        return self.pieces - before


@pytest.mark.parametrize("late", [0, 1, 3])
def test_a_controller_that_lets_in_piece_by_piece_lets_in_as_many_as_are_admitted(late: int) -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    belt = OneByOne(rig, late)
    assert belt.let_in(12) == 10
    rig.body.instruct(Admit(SHAFTS, 11))
    assert belt.let_in(12) == 1
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 11}, "")


def test_a_permit_that_was_taken_back_is_given_anew_once_its_counts_have_come() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    belt = OneByOne(rig, late=0)
    assert belt.let_in(4) == 4
    rig.tell(Signal.FAULT, True)
    assert belt.let_in(1) == 0
    rig.tell(Signal.FAULT, False)
    assert rig.told == (SHAFTS, 0), "the controller must see that this is another permit"
    rig.clock.pass_s(SETTLE_S)
    assert rig.told == (SHAFTS, 6)
    assert belt.let_in(12) == 6
    assert (rig.arrived, rig.body.away) == ({SHAFTS: 10}, "")


def test_nothing_is_permitted_that_is_not_on_the_disk() -> None:
    class FullDisk(GateRig):
        is_full = False

        def remember(self, kept: KeptSignals) -> None:
            if self.is_full:
                raise UnavailableError("gate.signals.json", "no space left", "make room")
            super().remember(kept)

    rig = FullDisk()
    rig.is_full = True
    with pytest.raises(UnavailableError):
        rig.show(SHAFTS)
    with pytest.raises(UnavailableError):
        rig.tell(Signal.FAULT, False)
    assert rig.told == ("", 0)
    with pytest.raises(UnavailableError):
        rig.body.instruct(Admit(SHAFTS, 12))
    with pytest.raises(UnavailableError):
        rig.counter(501)
    rig.is_full = False
    rig.body.instruct(Admit(SHAFTS, 12))
    assert GoodsArrived(SHAFTS, 0, 12) in rig.reports
    assert rig.told == (SHAFTS, 12)


@pytest.mark.parametrize("quality", [Quality.BAD, Quality.UNCERTAIN])
def test_a_counter_without_a_value_may_have_been_reset_unheard(quality: Quality) -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(504)
    rig.tell(Signal.PIECES, 505, quality)
    rig.counter(2)
    assert "from 504 to 2 while nobody listened" in rig.body.away


def test_pulses_without_a_value_are_in_doubt() -> None:
    rig = GateRig(pieces=Tag("pulse", edge=Edge.RISING), first=False)
    rig.show(SHAFTS)
    rig.tell(Signal.PIECES, False, Quality.BAD)
    rig.counter(False)
    assert "pieces was not heard" in rig.body.away


def test_long_words_of_the_controller_are_cut() -> None:
    rig = GateRig()
    rig.tell(Signal.FAULT, "jam\n" * 20_000)
    assert rig.body.away.startswith("its controller has a fault: jam jam ")
    assert len(rig.body.away) < 300
    rig.tell(Signal.FAULT, "")
    rig.tell(Signal.PIECES, "x" * 60_000)
    assert rig.body.away.endswith("... is no count")
    assert len(rig.body.away) < 300


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
    said = f"its count is in doubt ({rig.doubt}): {why}; the last permit was for {SHAFTS}"
    assert rig.body.away == said
    assert rig.body.away_since_s == rig.clock.now_s()
    assert (rig.arrived, rig.told) == ({SHAFTS: counted}, (SHAFTS, 0))
    rig.begin()
    rig.clock.pass_s(SETTLE_S)
    assert rig.body.away == said, "the next life knows it, too"
    assert rig.told[1] == 0


def test_a_piece_of_a_shut_gate_is_in_doubt() -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    rig.counter(505)
    assert "0 pieces at most can have been let in" in rig.body.away
    assert rig.arrived == {SHAFTS: 4}


@pytest.mark.parametrize("label", [SHAFTS, "O-9-1.1", ""])
def test_pulses_that_nobody_heard_are_in_doubt_while_the_gate_was_open(label: str) -> None:
    rig = GateRig(pieces=Tag("pulse", edge=Edge.RISING), first=False)
    is_open = label == SHAFTS
    rig.show(SHAFTS)
    rig.show(label)
    rig.body.on_link_lost("cut")
    rig.link()
    assert ("pieces was not heard" in rig.body.away) == is_open


def test_people_count_and_the_gate_goes_on() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(9_000)
    rig.check({SHAFTS: 6})
    rig.begin()
    rig.clock.pass_s(SETTLE_S)
    assert (rig.body.away, rig.arrived, rig.told) == ("", {SHAFTS: 6}, (SHAFTS, 4))
    # The same count settles no new doubt.
    rig.counter(8_000)
    rig.begin()
    assert rig.body.away.startswith("its count is in doubt")


@pytest.mark.parametrize("kept", [None, DAMAGED_SIGNALS])
def test_a_count_settles_no_doubt_after_the_memory_was_lost(kept: KeptSignals | None) -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    rig.counter(9_000)
    rig.check({SHAFTS: 6})
    rig.begin()
    assert rig.body.away == ""
    rig.clock.pass_s(60.0)
    rig.kept = kept
    rig.begin()
    rig.counter(10_000)
    rig.begin()
    assert rig.body.away.startswith("its count is in doubt")


def is_damaged(rig: GateRig) -> None:
    """Its memory is lost after four shafts have come in."""
    rig.pass_by(SHAFTS, 4)
    rig.kept = DAMAGED_SIGNALS
    rig.begin()


def has_jumped(rig: GateRig) -> None:
    """More have come in than were admitted, and the container is gone."""
    rig.show(SHAFTS)
    rig.counter(9_000)
    rig.show("")


def is_reset_unheard(rig: GateRig) -> None:
    """Its counter is reset during a permit, while nobody listens, and the container is gone."""
    rig.show(SHAFTS)
    rig.body.on_link_lost("cut")
    rig.body.instruct(Admit(SHAFTS, 0))
    rig.shown, rig.label = 0, ""
    rig.link()


@pytest.mark.parametrize("doubt", [is_damaged, has_jumped, is_reset_unheard])
def test_no_goal_is_said_to_be_shut_before_people_have_counted(doubt: Callable[[GateRig], None]) -> None:
    rig = GateRig()
    doubt(rig)
    rig.body.instruct(Admit(SHAFTS, 0))
    rig.clock.pass_s(10 * SETTLE_S)
    assert said(rig).admitted > 0
    if doubt is is_damaged:
        rig.kept = DAMAGED_SIGNALS
    rig.begin()
    rig.body.instruct(Admit(SHAFTS, 0))
    rig.clock.pass_s(10 * SETTLE_S)
    assert said(rig).admitted > 0, "nor by the next life, nor after another damage"
    rig.check({SHAFTS: 4})
    rig.begin()
    rig.body.instruct(Admit(SHAFTS, 0))
    assert said(rig) == GoodsArrived(SHAFTS, 4, 0)


def test_what_is_admitted_is_confirmed_also_while_the_count_is_in_doubt() -> None:
    rig = GateRig()
    is_damaged(rig)
    rig.body.instruct(Admit(SHAFTS, 10))
    assert said(rig) == GoodsArrived(SHAFTS, 0, 10)


def test_a_count_of_people_takes_no_piece_away() -> None:
    rig = GateRig()
    rig.pass_by(SHAFTS, 4)
    rig.counter(9_000)
    rig.check({SHAFTS: 2})
    rig.begin()
    assert rig.body.away == ""
    assert rig.arrived == {SHAFTS: 4}


def test_a_damaged_memory_is_no_empty_gate() -> None:
    rig = GateRig()
    rig.kept = DAMAGED_SIGNALS
    rig.begin()
    assert rig.body.away == f"its count is in doubt ({rig.doubt}): what was remembered of it is damaged"
    number = rig.doubt
    rig.clock.pass_s(60.0)
    rig.begin()
    assert rig.doubt == number
    rig.check({SHAFTS: 3})
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


def refuse(rig: GateRig, signal: Signal) -> None:
    """The controller refuses a permit, and takes what it is told then."""
    rig.body.on_refused(signal, "BadOutOfRange")
    assert rig.body.away == f"its controller does not take {signal}: BadOutOfRange"
    assert rig.told == ("", 0)
    rig.body.on_refused(signal, "")
    assert rig.body.away == ""
    rig.clock.pass_s(SETTLE_S)


@pytest.mark.parametrize("signal", [Signal.ADMITTED, Signal.ADMITTED_GOAL])
def test_a_permit_that_is_refused_for_good_is_given_more_and_more_rarely(signal: Signal) -> None:
    rig, tries = GateRig(), 0
    rig.show(SHAFTS)
    for _ in range(3600):
        if rig.told[1]:
            tries += 1
            refuse(rig, signal)
            assert (
                rig.body.held
                == f"its controller refuses a permit for 10 of {SHAFTS} ({signal}): BadOutOfRange"
            )
        rig.clock.pass_s(SETTLE_S)
    doubling = (AGAIN_MOST // AGAIN).bit_length()
    assert doubling < tries <= doubling + 1 + 3600 // AGAIN_MOST


def test_a_permit_that_is_refused_holds_up_no_other_container() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    refuse(rig, Signal.ADMITTED)
    assert rig.told == ("", 0)
    rig.pass_by(GEARS, 3)
    assert (rig.body.held, rig.arrived) == ("", {GEARS: 3})
    # Another number may be taken.
    rig.body.instruct(Admit(SHAFTS, 9))
    assert rig.show(SHAFTS) == (SHAFTS, 9)
    rig.body.on_refused(Signal.ADMITTED, "")
    assert rig.body.held == ""


def test_a_permit_that_is_taken_later_lets_the_container_in() -> None:
    rig = GateRig()
    rig.show(SHAFTS)
    refuse(rig, Signal.ADMITTED_GOAL)
    rig.clock.pass_s(AGAIN * SETTLE_S)
    assert rig.told == (SHAFTS, 10)
    rig.body.on_refused(Signal.ADMITTED, "")
    assert rig.body.held, "the number is taken, and the label is not yet"
    rig.body.on_refused(Signal.ADMITTED_GOAL, "")
    rig.counter(504)
    assert (rig.body.held, rig.body.away, rig.arrived) == ("", "", {SHAFTS: 4})


def test_problems_are_reported_at_each_change_and_without_labels() -> None:
    rig = GateRig()
    rig.tell(Signal.FAULT, True)
    rig.tell(Signal.FAULT, True)
    rig.tell(Signal.FAULT, False)
    rig.show(SHAFTS)
    refuse(rig, Signal.ADMITTED)
    rig.show("")
    rig.counter(9_000)
    assert [report.problem for report in rig.reports if isinstance(report, GateProblem)] == [
        "its controller has a fault: a fault",
        "",
        "its controller does not take admitted: BadOutOfRange",
        "its controller refuses a permit (admitted): BadOutOfRange",
        "",
        f"its count is in doubt ({rig.doubt}): pieces went from 500 to 9,000: 0 pieces at most can have been let in since",
    ]
    assert rig.body.sense().problem == rig.body.problem
    rig.begin()
    assert rig.body.sense().problem.startswith("its count is in doubt")


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


@pytest.mark.parametrize("signal", OF_A_GATE)
@pytest.mark.parametrize("tag", [Tag("x", invert=True), Tag("x", scale=100.0)])
def test_a_label_and_a_permit_have_one_form_only(signal: Signal, tag: Tag) -> None:
    with pytest.raises(ValueError, match="it is neither inverted nor scaled"):
        SignalMapping({**NEEDED, signal: tag})
