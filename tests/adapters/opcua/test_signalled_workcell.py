"""A machine's body behind single values: each odd thing that a controller does ends in the right count, or in a problem with a name."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from odd_controllers import FAULTS, ODD, PIECE_S, Odd, P, away_and_back, tells
from signals_rig import (
    ALL,
    BILL,
    ITEM,
    OTHER,
    PLANT,
    PRODUCT,
    PULSE,
    SPEC,
    TWO_BITS,
    Rig,
)

from dray.adapters.signals.signal import Edge, Signal, SignalMapping, Tag
from dray.adapters.signals.workcell import DAMAGED
from dray.body import (
    Book,
    Broken,
    CloseDock,
    CycleDone,
    CycleFailed,
    DockReady,
    OpenDock,
    Repaired,
    ResetFault,
    SetPace,
    StockChanged,
)
from dray.messages import ProblemKind


def done(rig: Rig) -> int:
    """Good pieces that were reported since this was asked last."""
    return sum(isinstance(report, CycleDone) and not report.bad for report in rig.heard())


# --- a machine that works ---


def test_a_piece_uses_its_material_and_lies_in_the_goods() -> None:
    rig = Rig(TWO_BITS)
    rig.tell(Signal.DOCK_READY, False)
    rig.start()
    assert rig.state.cycling == PRODUCT
    assert rig.body.outputs[Signal.RUN] is True
    assert rig.state.stock[ITEM] == 100 - BILL[ITEM]
    rig.clock.pass_s(PIECE_S)
    rig.tell(Signal.PIECES, 1)
    assert rig.heard() == [CycleDone(product=PRODUCT, seq=1)]
    assert (rig.state.cycling, rig.state.stock[PRODUCT], rig.state.seq) == ("", 1, 1)
    assert rig.body.outputs[Signal.RUN] is False


def test_a_piece_that_nobody_has_asked_for_counts_and_uses_its_material() -> None:
    rig = Rig()
    rig.tell(Signal.PIECES, 2)
    assert done(rig) == 2
    assert rig.state.stock[PRODUCT] == 2
    assert rig.state.stock[ITEM] == 100 - 2 * BILL[ITEM]


def test_a_piece_that_comes_before_its_start_is_heard_makes_no_cycle_run_twice() -> None:
    rig = Rig()
    rig.start()
    rig.tell(Signal.PIECES, 2)
    rig.start()
    rig.start()
    rig.clock.pass_s(PIECE_S)
    rig.tell(Signal.PIECES, 3)
    assert done(rig) == 3
    assert (rig.state.cycling, rig.state.stock[ITEM]) == ("", 100 - 3 * BILL[ITEM])


def test_a_bad_piece_uses_material_and_lies_nowhere() -> None:
    rig = Rig({Signal.PIECES: Tag("good"), Signal.BAD: Tag("bad")})
    rig.tell(Signal.BAD, 7)
    rig.start()
    rig.clock.pass_s(PIECE_S)
    rig.tell(Signal.BAD, 8)
    assert rig.heard() == [CycleDone(product=PRODUCT, seq=1, bad=True)]
    assert rig.state.stock[PRODUCT] == 0


def test_what_cannot_be_made_is_said() -> None:
    rig = Rig(stock={})
    rig.start()
    rig.start("nothing-of-ours")
    assert [report.reason for report in rig.heard() if isinstance(report, CycleFailed)] == [
        f"missing {', '.join(BILL)}",
        "not made here",
    ]


def test_what_vehicles_say_is_booked() -> None:
    rig = Rig(stock={})
    rig.body.instruct(Book("ATV1", ITEM, 40, task="M1-1", epoch=1))
    assert rig.heard() == [StockChanged(item=ITEM, change=40, seq=1, vehicle="ATV1")]
    assert rig.state.stock[ITEM] == 40


def test_what_is_said_again_by_another_life_is_answered_again_and_booked_once() -> None:
    rig = Rig(stock={})
    book = Book("ATV1", ITEM, 40, task="M1-1", epoch=1)
    rig.body.instruct(book)
    rig.begin()
    for _ in range(2):
        rig.heard()
        rig.body.instruct(book)
        assert rig.heard() == [StockChanged(item=ITEM, change=40, seq=1, vehicle="ATV1")]
    rig.body.instruct(Book("ATV1", ITEM, 40, task="M1-1", epoch=2))
    assert (rig.state.stock[ITEM], rig.state.seq) == (80, 2)


def test_a_pace_is_written_in_the_controllers_unit() -> None:
    rig = Rig({Signal.PIECES: Tag("good"), Signal.SPEED: Tag("speed", scale=100)})
    assert rig.state.paces
    rig.body.instruct(SetPace(speed_frac=0.5))
    assert rig.body.outputs[Signal.SPEED] == 50
    assert not Rig().state.paces


# --- the dock ---


def test_a_vehicle_is_let_in_when_the_controller_says_so_and_once_for_each_time_it_is_asked() -> None:
    rig = Rig(TWO_BITS)
    rig.tell(Signal.DOCK_READY, False)
    rig.body.instruct(OpenDock(vehicle="ATV1", item=ITEM, quantity=10))
    assert (rig.body.outputs[Signal.DOCK_PERMIT], rig.body.outputs[Signal.DOCK_VEHICLE]) == (True, "ATV1")
    assert rig.heard() == []
    rig.tell(Signal.DOCK_READY, True)
    assert rig.heard() == [DockReady(vehicle="ATV1")]
    rig.body.instruct(OpenDock(vehicle="ATV1", item=ITEM, quantity=10))
    assert rig.heard() == [DockReady(vehicle="ATV1")]
    rig.body.instruct(Book("ATV1", ITEM, 10, task="M1-1", epoch=1))
    assert (rig.body.outputs[Signal.DOCK_PERMIT], rig.body.outputs[Signal.DOCK_VEHICLE]) == (False, "")


def test_a_life_that_begins_while_a_vehicle_unloads_keeps_the_dock_open_for_it() -> None:
    rig = Rig(TWO_BITS)
    rig.body.instruct(OpenDock(vehicle="ATV1", item=ITEM, quantity=10))
    rig.begin()
    assert (rig.body.outputs[Signal.DOCK_PERMIT], rig.body.outputs[Signal.DOCK_VEHICLE]) == (True, "ATV1")
    assert rig.state.opened == ("ATV1",)
    rig.body.instruct(CloseDock(vehicle="ATV1"))
    assert rig.body.outputs[Signal.DOCK_PERMIT] is False
    rig.begin()
    assert rig.state.opened == ()


@pytest.mark.parametrize("again", [False, True], ids=["cut", "begun-again"])
def test_a_ready_of_the_vehicle_before_is_waited_out_once_the_connection_is_back(*, again: bool) -> None:
    rig = Rig(TWO_BITS)
    for vehicle in ("ATV1", "ATV2"):
        rig.body.instruct(OpenDock(vehicle=vehicle, item=ITEM, quantity=10))
    rig.tell(Signal.DOCK_READY, True)
    rig.body.on_link_lost("it is away")
    if again:
        rig.begin()
    rig.body.instruct(Book("ATV1", ITEM, 10, task="M1-1", epoch=1))
    rig.body.on_link()
    rig.heard()
    rig.tell(Signal.DOCK_READY, True)
    assert (rig.body.outputs[Signal.DOCK_PERMIT], rig.heard()) == (False, [])
    rig.tell(Signal.DOCK_READY, False)
    assert (rig.body.outputs[Signal.DOCK_PERMIT], rig.body.outputs[Signal.DOCK_VEHICLE]) == (True, "ATV2")
    rig.tell(Signal.DOCK_READY, True)
    assert rig.heard() == [DockReady(vehicle="ATV2")]


def test_it_remembers_over_its_lives_whom_it_has_let_in_to_move_what() -> None:
    rig, asked = Rig(TWO_BITS), OpenDock(vehicle="ATV1", item=ITEM, quantity=10)
    rig.body.instruct(asked)
    assert rig.state.let_in is None
    rig.tell(Signal.DOCK_READY, True)
    assert rig.state.let_in == asked
    rig.begin()
    assert rig.state.let_in == asked
    rig.tell(Signal.DOCK_READY, True)
    rig.body.instruct(Book("ATV1", ITEM, 10, task="M1-1", epoch=1))
    rig.begin()
    assert rig.state.let_in is None


def test_a_dock_without_a_handshake_is_open_at_once() -> None:
    rig = Rig()
    rig.body.instruct(OpenDock(vehicle="ATV1", item=ITEM, quantity=10))
    assert rig.heard() == [DockReady(vehicle="ATV1")]
    rig.body.instruct(CloseDock(vehicle="ATV1"))
    rig.body.instruct(OpenDock(vehicle="ATV2", item=ITEM, quantity=10))
    assert rig.heard() == [DockReady(vehicle="ATV2")]


# --- what controllers do ---


@pytest.mark.parametrize("odd", ODD, ids=lambda odd: odd.name)
def test_what_a_controller_does_ends_in_the_right_count_or_in_a_problem_with_a_name(odd: Odd) -> None:
    rig = Rig(odd.signals)
    if odd.signals is PULSE:
        rig = Rig(odd.signals, linked=False)
        rig.tell(Signal.PIECES, False)
        rig.body.on_link()
        rig.heard()
    rig.start()
    odd.do(rig)
    assert odd.broken in rig.state.broken
    assert bool(odd.broken) == bool(rig.state.broken), rig.state.broken
    heard = rig.heard()
    assert sum(isinstance(report, CycleDone) for report in heard) == odd.pieces
    assert rig.state.stock[PRODUCT] == odd.pieces
    last = [report for report in heard if isinstance(report, Broken | Repaired)][-1:]
    assert [isinstance(report, Broken) for report in last] in ([], [bool(odd.broken)])


def test_a_doubted_count_stands_over_a_restart_until_somebody_says_that_it_was_seen_to() -> None:
    rig = Rig()
    rig.tell(Signal.PIECES, 10_000)
    assert rig.state.resettable
    rig.begin()
    rig.tell(Signal.PIECES, 10_000)
    rig.body.on_link()
    assert "went from 0 to 10,000" in rig.state.broken
    rig.body.instruct(ResetFault())
    assert rig.state.broken == ""
    rig.clock.pass_s(PIECE_S)
    rig.heard()
    rig.tell(Signal.PIECES, 10_001)
    assert done(rig) == 1


def test_a_fault_is_acknowledged_until_it_has_gone() -> None:
    rig = Rig(FAULTS)
    rig.tell(Signal.FAULT, True)
    assert rig.state.resettable
    rig.body.instruct(ResetFault())
    assert rig.body.outputs[Signal.RESET] is True
    rig.tell(Signal.FAULT, False)
    assert rig.body.outputs[Signal.RESET] is False
    assert rig.state.broken == ""


def test_a_fault_is_not_acknowledged_by_itself_where_the_bit_is_inverted() -> None:
    rig = Rig(FAULTS | {Signal.RESET: Tag("reset", invert=True)})
    for fault in (False, True, False, True):
        rig.tell(Signal.FAULT, fault)
        assert rig.body.outputs.get(Signal.RESET, True) is True
    rig.body.instruct(ResetFault())
    assert rig.body.outputs[Signal.RESET] is False


def test_a_connection_that_is_lost_is_a_problem_of_its_own_kind_and_lets_nobody_in() -> None:
    rig = Rig(TWO_BITS)
    rig.tell(Signal.DOCK_READY, False)
    rig.body.instruct(OpenDock(vehicle="ATV1", item=ITEM, quantity=10))
    rig.body.on_link_lost("the cable is out")
    assert rig.state.about_problem.kind is ProblemKind.LINK
    rig.heard()
    rig.tell(Signal.PIECES, 0)
    rig.tell(Signal.DOCK_READY, True)
    rig.body.on_link()
    assert rig.heard() == [DockReady(vehicle="ATV1"), Repaired()]


def test_pieces_are_counted_over_a_restart_of_the_agent() -> None:
    rig = Rig()
    rig.start()
    rig.clock.pass_s(PIECE_S)
    rig.tell(Signal.PIECES, 1)
    rig.start()
    rig.begin()
    assert (rig.state.cycling, rig.state.seq, rig.state.stock[PRODUCT]) == (PRODUCT, 1, 1)
    rig.clock.pass_s(10 * PIECE_S)
    rig.heard()
    rig.tell(Signal.PIECES, 4)
    rig.body.on_link()
    assert done(rig) == 3
    assert rig.state.stock[ITEM] == 100 - 4 * BILL[ITEM]


def test_a_reset_that_was_heard_is_known_to_the_next_life() -> None:
    rig = Rig()
    tells((P, 3), (P, 0))(rig)
    rig.begin()
    tells((P, 0))(rig)
    rig.body.on_link()
    tells((P, 1))(rig)
    assert (rig.state.broken, done(rig)) == ("", 4)


def test_a_piece_that_an_earlier_life_has_begun_is_wanted_in_the_next() -> None:
    rig = Rig({**TWO_BITS, Signal.PRODUCT: Tag("product")})
    rig.start()
    rig.begin()
    assert (rig.body.outputs[Signal.RUN], rig.body.outputs[Signal.PRODUCT]) == (True, PRODUCT)


def test_a_memory_that_is_damaged_is_a_problem_and_no_wrong_stock() -> None:
    rig = Rig()
    rig.kept = DAMAGED
    rig.begin()
    rig.tell(Signal.PIECES, 55)
    rig.body.on_link()
    assert "see what lies in its buffers" in rig.state.broken
    assert set(rig.state.stock.values()) == {0}


@given(st.lists(st.sampled_from(("start", "piece", "kill", "away", "book", "reset")), max_size=40))
def test_whatever_happens_no_piece_is_counted_twice_and_none_is_forgotten(steps: list[str]) -> None:
    rig = Rig(stock=dict.fromkeys(BILL, 10_000))
    shown = reported = 0
    for step in steps:
        rig.clock.pass_s(2 * PIECE_S)
        match step:
            case "start":
                rig.start()
            case "piece":
                shown += 1
                rig.tell(Signal.PIECES, shown)
            case "kill":
                rig.begin()
                rig.tell(Signal.PIECES, shown)
                rig.body.on_link()
            case "away":
                shown += 1
                away_and_back(shown, PIECE_S)(rig)
            case "book":
                rig.body.instruct(Book("ATV1", PRODUCT, -1, task=f"M1-{reported}", epoch=1))
                rig.body.instruct(Book("ATV1", PRODUCT, 1, task=f"M1-{reported}", epoch=1))
            case _:
                rig.body.instruct(ResetFault())
        reported += done(rig)
    assert reported == shown
    assert rig.state.stock[PRODUCT] >= shown
    begun = shown + bool(rig.state.cycling)
    assert rig.state.stock[ITEM] == 10_000 - begun * BILL[ITEM]


@pytest.mark.parametrize(
    ("signals", "why"),
    [
        ({Signal.FAULT: Tag("x")}, "`pieces` is missing"),
        ({P: Tag("x"), Signal.FAULT: Tag("y", edge=Edge.RISING)}, r"signals.fault: only `pieces` and `bad`"),
        ({P: Tag("x", edge=Edge.RISING, rolls_over_at=10)}, "no counter that rolls over"),
        ({P: Tag("x", invert=True)}, "say `edge: falling`"),
        ({P: Tag("x"), Signal.DOCK_READY: Tag("y")}, "`dock_ready` needs `dock_permit`"),
    ],
)
def test_a_mapping_that_makes_no_sense_is_refused(signals: dict[Signal, Tag], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        SignalMapping(signals).check_machine()


def test_a_machine_has_no_levels() -> None:
    with pytest.raises(ValueError, match="a machine's stock is reckoned"):
        SignalMapping({P: Tag("x")}, levels={ITEM: Tag("x")}).check_machine()


# --- a broken connection ---


def made(rig: Rig) -> list[str]:
    """What was reported as made since this was asked last."""
    return [report.product for report in rig.heard() if isinstance(report, CycleDone)]


def away_with_run(*, pieces: int) -> Rig:
    """A machine whose connection was broken while it had `run`; so many pieces are counted when it is back."""
    rig = Rig(TWO_BITS, ALL)
    rig.start()
    rig.clock.pass_s(1.0)
    rig.body.on_link_lost("the cable is out")
    rig.clock.pass_s(10 * PIECE_S)
    rig.tell(Signal.PIECES, pieces)
    rig.body.on_link()
    assert made(rig) == [PRODUCT] * pieces
    return rig


def test_a_piece_begun_without_a_connection_is_no_piece_of_the_next_product() -> None:
    rig = away_with_run(pieces=2)
    rig.start(OTHER)
    assert (rig.state.cycling, rig.body.outputs[Signal.RUN]) == (OTHER, False)
    rig.clock.pass_s(0.9 * PIECE_S)
    rig.tell(Signal.PIECES, 3)
    assert (made(rig), rig.state.cycling) == ([PRODUCT], OTHER)
    rig.clock.pass_s(2 * PIECE_S)
    assert rig.body.outputs[Signal.RUN] is True
    rig.clock.pass_s(PIECE_S)
    rig.tell(Signal.PIECES, 4)
    assert (made(rig), rig.state.cycling) == ([OTHER], "")
    assert (rig.state.stock[PRODUCT], rig.state.stock[OTHER]) == (3, 1)


def test_the_same_product_does_not_wait_after_a_broken_connection_and_another_one_waits_once() -> None:
    rig = away_with_run(pieces=1)
    rig.start()
    assert rig.body.outputs[Signal.RUN] is True
    rig.clock.pass_s(2 * PIECE_S)
    rig.tell(Signal.PIECES, 2)
    rig.start(OTHER)
    assert rig.body.outputs[Signal.RUN] is True


@pytest.mark.parametrize("restarts", [False, True])
def test_a_product_that_waits_waits_anew_after_a_broken_connection_and_over_a_restart(restarts: bool) -> None:
    rig = away_with_run(pieces=1)
    rig.start(OTHER)
    rig.clock.pass_s(PIECE_S)
    rig.body.on_link_lost("the cable is out")
    if restarts:
        rig.begin()
    rig.clock.pass_s(5 * PIECE_S)
    assert rig.body.outputs[Signal.RUN] is False
    rig.tell(Signal.PIECES, 2)
    rig.body.on_link()
    assert (made(rig), rig.state.cycling) == ([PRODUCT], OTHER)
    rig.clock.pass_s(1.9 * PIECE_S)
    assert rig.body.outputs[Signal.RUN] is False
    rig.clock.pass_s(0.2 * PIECE_S)
    assert rig.body.outputs[Signal.RUN] is True
    assert rig.state.stock[PRODUCT] == 2


def test_a_machine_that_begins_for_the_first_time_waits_for_nothing() -> None:
    rig = Rig(TWO_BITS, ALL)
    rig.start(OTHER)
    assert rig.body.outputs[Signal.RUN] is True


# --- a product that was asked for as the connection broke ---

TOLD_PRODUCT = {**TWO_BITS, Signal.PRODUCT: Tag("product")}


def asked_as_it_broke(stock: dict[str, int] | None = None, *, confirmed: bool = False) -> Rig:
    """A machine that has made a piece, and whose connection is broken as it is asked for another product."""
    rig = Rig(TOLD_PRODUCT, stock or ALL)
    rig.start()
    rig.confirm(Signal.PRODUCT)
    rig.clock.pass_s(PIECE_S)
    rig.tell(Signal.PIECES, 1)
    rig.start(OTHER)
    if confirmed:
        rig.confirm(Signal.PRODUCT)
    assert made(rig) == [PRODUCT]
    return rig


@pytest.mark.parametrize("restarts", [False, True])
def test_a_piece_of_which_nobody_knows_the_product_is_in_doubt_and_counts_as_the_confirmed_one(
    restarts: bool,
) -> None:
    rig = asked_as_it_broke()
    if restarts:
        rig.begin()
    else:
        rig.body.on_link_lost("the cable is out")
    assert (rig.state.cycling, rig.body.outputs[Signal.RUN]) == (OTHER, False)
    rig.clock.pass_s(10 * PIECE_S)
    rig.tell(Signal.PIECES, 2)
    rig.body.on_link()
    assert made(rig) == [PRODUCT]
    either = f"by {PRODUCT} or by {OTHER}"
    assert rig.state.broken == f"its count is in doubt: pieces grew after a broken connection, {either}"
    assert (rig.state.stock[PRODUCT], rig.state.stock[OTHER]) == (2, 0)
    rig.body.instruct(ResetFault())
    # One that it was still at may be of either product, too.
    rig.tell(Signal.PIECES, 3)
    assert either in rig.state.broken
    rig.body.instruct(ResetFault())
    rig.clock.pass_s(2 * max(making.cycle_s for making in SPEC.makes))
    assert (rig.body.outputs[Signal.RUN], rig.body.outputs[Signal.PRODUCT]) == (True, OTHER)
    rig.confirm(Signal.PRODUCT)
    rig.clock.pass_s(PIECE_S)
    rig.heard()
    rig.tell(Signal.PIECES, 4)
    assert (made(rig), rig.state.broken) == ([OTHER], "")


def test_without_a_piece_nothing_is_in_doubt() -> None:
    rig = asked_as_it_broke()
    rig.body.on_link_lost("the cable is out")
    rig.clock.pass_s(10 * PIECE_S)
    rig.tell(Signal.PIECES, 1)
    rig.body.on_link()
    rig.confirm(Signal.PRODUCT)
    rig.clock.pass_s(2 * max(making.cycle_s for making in SPEC.makes))
    assert (rig.state.broken, rig.body.outputs[Signal.RUN]) == ("", True)
    rig.tell(Signal.PIECES, 2)
    assert made(rig) == [OTHER]


def test_a_product_that_the_controller_has_confirmed_is_the_one_that_it_makes() -> None:
    rig = asked_as_it_broke(confirmed=True)
    rig.body.on_link_lost("the cable is out")
    assert rig.body.outputs[Signal.RUN] is True
    rig.clock.pass_s(10 * PIECE_S)
    rig.tell(Signal.PIECES, 2)
    rig.body.on_link()
    assert (made(rig), rig.state.broken) == ([OTHER], "")


def test_a_product_that_waits_begins_only_with_its_material() -> None:
    """What came of the last product has used it."""
    bills = {
        making.product: {line.material: line.quantity for line in PLANT.products[making.product].bill}
        for making in SPEC.makes
    }
    first, other = bills[PRODUCT], bills[OTHER]
    assert first.keys() & other.keys()
    # Enough for the first piece and one of either product.
    rig = asked_as_it_broke({item: first.get(item, 0) + other.get(item, 0) for item in {*first, *other}})
    rig.body.on_link_lost("the cable is out")
    rig.clock.pass_s(10 * PIECE_S)
    rig.tell(Signal.PIECES, 2)
    rig.body.on_link()
    rig.body.instruct(ResetFault())
    rig.heard()
    rig.clock.pass_s(2 * max(making.cycle_s for making in SPEC.makes))
    failed = [report for report in rig.heard() if isinstance(report, CycleFailed)]
    assert [(report.product, report.reason.split()[0]) for report in failed] == [(OTHER, "missing")]
    assert (rig.state.cycling, rig.body.outputs[Signal.RUN]) == ("", False)
    expected = {item: other.get(item, 0) - first.get(item, 0) for item in {*first, *other}}
    assert {item: rig.state.stock[item] for item in expected} == {
        item: max(0, pieces) for item, pieces in expected.items()
    }
