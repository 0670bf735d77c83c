"""An operator's habits: speed, care and presence."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

Range = tuple[float, float]
"""Lowest and highest value; chance takes any value in between."""


@dataclass(frozen=True, slots=True)
class Habits:
    """An operator's habits. Ranges of seconds have a lowest and a highest value.

    Attributes:
        present_frac: the chance that an alarm finds the operator present.
        away_s: length of an absence.
        react_s: from seeing an alarm to the first action.
        promises_frac: the chance that the operator promises a vehicle to come.
        estimate: the promised time relative to the real one; above 1 is cautious.
        walk_s: to the vehicle.
        mend_s: to put a problem right.
        carry_s: to bring a dead vehicle's load to where it belongs.
        push_s: to bring a dead vehicle to a charger.
        silent_s: silence after which the operator looks for a vehicle; well above the time of a takeover, so that
            people come after the agents have helped themselves.
        slow_frac: a shifted load is driven on with this part of the top speed; 1 for as before.
        slow_s: how long.
        hands_over_frac: the chance that goods of a dead vehicle are handed to another one, and not carried back by
            hand.
        hold_s: how long the operator holds goods out; then the operator carries them back.
        forgets_frac: the chance that an operator who has taken a call does not come.
        on_duty_s, off_duty_s: durations on duty and off duty; None for always.
        careless_until_s: until then operators forget and go off duty (plant clock).
    """

    present_frac: float = 1.0
    away_s: Range = (300.0, 900.0)
    react_s: Range = (3.0, 15.0)
    promises_frac: float = 1.0
    estimate: Range = (1.0, 1.5)
    walk_s: Range = (15.0, 60.0)
    mend_s: Range = (15.0, 90.0)
    carry_s: Range = (30.0, 90.0)
    push_s: Range = (30.0, 120.0)
    silent_s: float = 30.0
    slow_frac: float = 0.5
    slow_s: float = 60.0
    hands_over_frac: float = 0.0
    hold_s: Range = (60.0, 300.0)
    forgets_frac: float = 0.0
    on_duty_s: Range | None = None
    off_duty_s: Range = (30.0, 300.0)
    careless_until_s: float = inf
