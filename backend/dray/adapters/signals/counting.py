"""How many pieces a controller has counted since it was read last.

A counter that

    grows by what can have been made since     counts that
    falls because it has reached its end       has rolled over: it counts on from 0
    falls to what can have been made since     was reset: what it shows is counted
    does anything else                         is doubted: nothing is counted, and it is counted on from there

and after a gap, while nobody listened, a reset is doubted as well: pieces of before it may be missing.
"""

from __future__ import annotations

import math

from msgspec import Struct

from dray.adapters.signals.signal import Edge

ROOM_FRAC, ROOM_PIECES = 1.5, 2
"""What can have been made in a span: so many times what the fastest cycle allows, and a few more, since values come late and together."""

HELD_UP_S = 60.0
"""Somebody who listens all the time hears of a change within this time, however busy he is: a counter that stood for hours and jumps has
not made hours' pieces."""


class Reading(Struct, frozen=True):
    """What one look at a counter says."""

    pieces: int = 0
    doubt: str = ""
    """Why pieces may be missing or too many; empty for none."""


class CounterState(Struct, frozen=True):
    """What is remembered of a counter."""

    value: int
    at_s: float


def count(
    last: CounterState, now: CounterState, fastest_s: float, moduli: tuple[int, ...], *, gap: bool
) -> Reading:
    """Compare two looks at a counter.

    Args:
        last: before.
        now: at this moment.
        fastest_s: the shortest time that a piece takes.
        moduli: each may be the first number that it does not reach; empty where nothing is known.
        gap: somebody may have missed values between the two.
    """
    span_s = max(0.0, now.at_s - last.at_s)
    most = ROOM_PIECES + math.ceil(ROOM_FRAC * (span_s if gap else min(span_s, HELD_UP_S)) / fastest_s)
    grown = now.value - last.value
    if 0 <= grown <= most:
        return Reading(grown)
    shown = f"went from {last.value:,} to {now.value:,}"
    if grown > 0:
        return Reading(0, f"{shown}: {most:,} pieces at most can have been made since")
    for modulus in moduli:
        if last.value < modulus and grown + modulus <= most:
            return Reading(grown + modulus)
    if 0 <= now.value <= most:
        missing = f"{shown} while nobody listened: pieces made before that may be missing" if gap else ""
        return Reading(now.value, missing)
    return Reading(0, f"{shown}: it counts backwards")


def count_pulse(last: bool, now: bool, edge: Edge, *, gap: bool) -> Reading:
    """Compare two looks at a pulse.

    Args:
        last: before.
        now: at this moment.
        edge: which change counts.
        gap: somebody may have missed pulses between the two.
    """
    if gap:
        return Reading(0, "its pulses could not be heard for a while: pieces may be missing")
    return Reading(int(last != now and now is (edge is Edge.RISING)))
