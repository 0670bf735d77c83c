"""Odd things that a machine's controller does: what must have been counted then, and which problem must be named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from signals_rig import CYCLE_S, PRODUCT, PULSE, TWO_BITS, Rig

from dray.adapters.signals.signal import Quality, Signal, Tag
from dray.adapters.signals.workcell import LATE_MIN_S

PIECE_S = CYCLE_S


@dataclass(frozen=True)
class Odd:
    """Something odd that a controller does.

    Attributes:
        name: of it.
        do: makes it happen to a machine that has begun its first piece.
        pieces: that must have been counted then.
        broken: words of the problem that must be named; empty for none.
        signals: what the controller has.
    """

    name: str
    do: Callable[[Rig], object]
    pieces: int
    broken: str = ""
    signals: dict[Signal, Tag] | None = None


def tells(*values: tuple[Signal, object], quality: Quality = Quality.GOOD) -> Callable[[Rig], None]:
    def do(rig: Rig) -> None:
        for signal, value in values:
            rig.clock.pass_s(PIECE_S)
            rig.tell(signal, value, quality)  # type: ignore[arg-type]

    return do


def away_and_back(value: object, away_s: float) -> Callable[[Rig], None]:
    def do(rig: Rig) -> None:
        rig.body.on_link_lost("the cable is out")
        rig.clock.pass_s(away_s)
        rig.tell(Signal.PIECES, value)  # type: ignore[arg-type]
        rig.body.on_link()

    return do


P = Signal.PIECES
FAULTS = {
    P: Tag("good"),
    Signal.FAULT: Tag("fault"),
    Signal.FAULT_TEXT: Tag("text"),
    Signal.RESET: Tag("reset"),
}
STATES = {P: Tag("good"), Signal.STATE: Tag("state")}

ODD = (
    Odd("the same value twice", tells((P, 1), (P, 1)), 1),
    Odd("two pieces at once", tells((P, 2)), 2),
    Odd("a counter that was reset", tells((P, 3), (P, 0), (P, 1)), 4),
    Odd("a counter that rolls over", tells((P, 3), (P, 0)), 4, "", {P: Tag("good", rolls_over_at=4)}),
    Odd("a counter with a sign that goes below 0", tells((P, 1), (P, -65_534)), 2, "", {P: Tag("good", rolls_over_at=65_536)}),
    Odd("a counter that jumps by 10,000", tells((P, 10_000)), 0, "pieces went from 0 to 10,000"),
    Odd("a counter that counts backwards", tells((P, 3), (P, 6), (P, 9), (P, 8)), 9, "it counts backwards"),
    Odd("a counter in tenths", tells((P, 10.0), (P, 20.0)), 2, "", {P: Tag("good", scale=10)}),
    Odd("a counter that is no number", tells((P, float("nan"))), 0, "no value for pieces: nan is no count"),
    Odd("a counter that is a text", tells((P, "1")), 0, "no value for pieces: '1' is no count"),
    Odd("a value of bad quality", tells((P, 7), quality=Quality.BAD), 0, "no value for pieces: it is bad"),
    Odd("a value that is uncertain", tells((P, 7), quality=Quality.UNCERTAIN), 0, "it is uncertain"),
    Odd("a bad value that becomes good", lambda rig: (tells((P, 0), quality=Quality.BAD)(rig), tells((P, 1))(rig)), 1),
    Odd(
        "reset while it had no value",
        lambda rig: (tells((P, 3))(rig), tells((P, 3), quality=Quality.BAD)(rig), tells((P, 1))(rig)),
        4,
        "pieces made before that may be missing",
    ),
    Odd(
        "pulses without a value",
        lambda rig: (tells((P, False), quality=Quality.UNCERTAIN)(rig), tells((P, True))(rig)),
        0,
        "pieces may be missing",
        PULSE,
    ),
    Odd("words without an end", tells((Signal.FAULT, "jam " * 20_000)), 0, "jam jam...", FAULTS),
    Odd("away, and pieces were made meanwhile", away_and_back(5, 20 * PIECE_S), 5),
    Odd("away, and more than can have been made", away_and_back(500, PIECE_S), 0, "pieces at most can have been made"),
    Odd(
        "reset while it was away",
        lambda rig: (tells((P, 3))(rig), away_and_back(1, 20 * PIECE_S)(rig)),
        4,
        "pieces made before that may be missing",
    ),
    Odd("away, and never back", lambda rig: rig.body.on_link_lost("the cable is out"), 0, "is not heard: the cable is out"),
    Odd("a pulse that stays", tells((P, True), (P, True), (P, False)), 1, "", PULSE),
    Odd("pulses that nobody could hear", lambda rig: (rig.body.on_link_lost("x"), rig.tell(P, True), rig.body.on_link()), 0, "pieces may be missing", PULSE),
    Odd("a fault with its number", tells((Signal.FAULT, 17)), 0, "fault 17", FAULTS),
    Odd("a fault with words", tells((Signal.FAULT_TEXT, " guard open "), (Signal.FAULT, True)), 0, "guard open", FAULTS),
    Odd("a fault that goes by itself", tells((Signal.FAULT, True), (Signal.FAULT, False)), 0, "", FAULTS),
    Odd("out of service by OPC 40001-1", tells((Signal.STATE, "OutOfService")), 0, "out of service", STATES),
    Odd("not available, as a number", tells((Signal.STATE, 0)), 0, "not available", STATES),
    Odd("a state that nobody knows", tells((Signal.STATE, "Dancing")), 0, "no value for state: 'Dancing' is no state", STATES),
    Odd("a value that is not taken", lambda rig: rig.body.on_refused(Signal.RUN, "BadNotWritable"), 0, "does not take run: BadNotWritable", TWO_BITS),
    Odd("no piece at all", lambda rig: rig.clock.pass_s(LATE_MIN_S + 5 * PIECE_S), 0, f"no piece of {PRODUCT} was counted for"),
    Odd("a ready that is no bit", tells((Signal.DOCK_READY, "yes")), 0, "", TWO_BITS),
)  # fmt: skip
