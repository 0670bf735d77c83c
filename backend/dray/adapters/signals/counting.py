"""The number of pieces that a controller has counted since the last reading.

A counter that

    grows by a possible number                 counts that
    falls because it has reached its end       has rolled over: it counts on from 0
    falls to a possible number                 was reset: its value is counted
    does anything else                         is doubted: nothing is counted, and counting continues from there
    is read from another place than before     is doubted likewise: the two values have nothing to do with one another

and after a gap in listening a reset is doubted as well: pieces before it may be missing.
"""

from __future__ import annotations

import math

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.signals.signal import UP_TO, Edge, brief

ROOM_FRAC, ROOM_PIECES = 1.5, 2
"""Maximum pieces in a span: this factor times the fastest cycle's rate, plus a few, since values come late and together."""

HELD_UP_S = 60.0
"""Maximum delay of a change while the listener is connected, however busy it is. A counter that stood for hours and jumps has not made
hours' pieces."""


class Reading(Struct, frozen=True):
    """The result of one reading of a counter."""

    pieces: int = 0
    doubt: str = ""
    """Why pieces may be missing or too many; empty for none."""


class CounterState(Struct, frozen=True):
    """The memory of a counter."""

    value: int
    at_s: float
    of: str = ""
    """What shows it, in words: its address, form and end. Empty in the memory of an older version."""
    broker: str = ""
    """The address of its broker by MQTT. Empty by OPC UA, and in the memory of an older version."""


def doubt_of_another(last: CounterState, now: CounterState, verb: str) -> str:
    """Why two readings are not of the same counter; empty if they are.

    Args:
        last: the last reading.
        now: the present reading.
        verb: what is done with pieces, in words.
    """
    if "" not in (last.broker, now.broker) and last.broker != now.broker:
        last, now = (replace(each, of=f"{each.of} of {each.broker}") for each in (last, now))
    elif last.of in ("", now.of) or now.of.startswith(f"{last.of}{UP_TO}"):
        return ""  # The same one, or it is known by now where it ends.
    return f"is read from {brief(now.of)}, and was read from {brief(last.of)}: pieces {verb} in between may be missing"


def count(
    last: CounterState, now: CounterState, fastest_s: float, moduli: tuple[int, ...], *, gap: bool
) -> Reading:
    """Compare two readings of a counter.

    Args:
        last: the last reading.
        now: the present reading.
        fastest_s: the shortest cycle time.
        moduli: the possible numbers at which it rolls over; empty where unknown.
        gap: whether values may have been missed in between.
    """
    span_s = max(0.0, now.at_s - last.at_s)
    most = ROOM_PIECES + math.ceil(ROOM_FRAC * (span_s if gap else min(span_s, HELD_UP_S)) / fastest_s)
    return grown(last.value, now.value, most, moduli, gap=gap, verb="made")


def grown(last: int, now: int, most: int, moduli: tuple[int, ...], *, gap: bool, verb: str) -> Reading:
    """Compare two values of a counter.

    Args:
        last: the last value.
        now: the present value.
        most: maximum pieces in between.
        moduli: the possible numbers at which it rolls over; empty where unknown.
        gap: whether values may have been missed in between.
        verb: what is done with pieces, in words.
    """
    change = now - last
    if 0 <= change <= most:
        return Reading(change)
    shown = f"went from {last:,} to {now:,}"
    if change > 0:
        return Reading(0, f"{shown}: {most:,} pieces at most can have been {verb} since")
    for modulus in moduli:
        if last < modulus and change + modulus <= most:
            return Reading(change + modulus)
    if 0 <= now <= most:
        missing = f"{shown} while nobody listened: pieces {verb} before that may be missing" if gap else ""
        return Reading(now, missing)
    return Reading(0, f"{shown}: it counts backwards")


def count_pulse(last: bool, now: bool, edge: Edge, *, gap: bool) -> Reading:
    """Compare two readings of a pulse.

    Args:
        last: the last reading.
        now: the present reading.
        edge: the change that counts.
        gap: whether pulses may have been missed in between.
    """
    if gap:
        return Reading(0, "was not heard for a while: pieces may be missing")
    return Reading(int(last != now and now is (edge is Edge.RISING)))
