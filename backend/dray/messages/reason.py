"""Why something has ended, or does not go on: one word of a list, which software compares. Words for people are made of it.

A reason that only people read is free text (`detail`, `problem`) beside it.
"""

from __future__ import annotations

from enum import StrEnum


class Reason(StrEnum):
    """Why a contract has ended, a carrier was replaced, or a task does not go on."""

    # Of a contract that was kept.
    HANDED_OVER = "handed_over"
    DELIVERED = "delivered"
    KEPT = "kept"
    LATE = "late"
    """Kept, later than promised."""
    NOT_CONFIRMED = "not_confirmed"
    """The load is down, and the coordinator has not answered the handover."""

    # A contractor has failed, as others see it.
    SILENT = "silent"
    IN_ERROR = "in_error"
    """It has reported a problem, and nobody has helped in time."""
    STALLED = "stalled"
    """It does not come nearer."""
    OVERDUE = "overdue"
    """Long past its promise."""
    NOT_COUNTED = "not_counted"
    """Its load was not counted where it was to go."""
    FORGOTTEN = "forgotten"
    """It does not name the task any more."""
    BROKEN = "broken"
    """A machine that reports a fault."""

    # A contractor gives a contract back, as it says itself.
    GRACEFUL_SHUTDOWN = "graceful_shutdown"
    PROBLEM = "problem"
    """It reports a problem."""
    STOPPED = "stopped"
    """By a person."""
    ON_MESH = "on_mesh"
    """It has the radio mesh only."""
    HAS_WORK = "has_work"
    """It has become a primary."""
    UNABLE = "unable"
    """It could not take the task over."""
    DOCK_HELD = "dock_held"
    """It has waited at the source for as long as its promise allowed."""
    SOURCE_SILENT = "source_silent"
    COORDINATOR_SILENT = "coordinator_silent"
    CLOSED = "closed"
    """What people have closed leaves no way to the load, or from there."""
    GATE_REFUSED = "gate_refused"
    """The gate of a delivery warehouse has not let the load in."""
    OTHER_LOAD = "other_load"
    """Something else is on board."""
    LOAD_GONE = "load_gone"
    """The load was taken off."""
    LOAD_UNKNOWN = "load_unknown"
    """It has a load on board of which nobody knows."""

    # A coordinator ends a contract, or does not agree to one.
    SUPERSEDED = "superseded"
    WITHDRAWN = "withdrawn"
    RELEASED = "released"
    NOT_NEEDED = "not_needed"
    TASK_ENDED = "task_ended"
    NO_ANSWER = "no_answer"
    """An award was not answered in time."""
    NOT_ASKED = "not_asked"
    """An award was accepted that is not the present one."""
    ANOTHER_CARRIES = "another_carries"
    ANOTHER_WATCHES = "another_watches"
    ANOTHER_TOOK_OVER = "another_took_over"
    LOAD_ABOARD = "load_aboard"
    """Nobody else can fetch it."""
    LOAD_DOWN = "load_down"
    IS_HEARD = "is_heard"
    """The primary that was to be replaced is heard."""
    BROUGHT_BACK = "brought_back"
    """The load of a task was brought back to its coordinator."""
    CLOCK_WRONG = "clock_wrong"

    # The end of a watch.
    RENEWED = "renewed"
    RESIGNED = "resigned"
    TAKEN_OVER = "taken_over"
    OVER = "over"
    """The primary does not name the task any more."""


class CommandRefusal(StrEnum):
    """Why a vehicle does not carry out a person's command."""

    NOT_GRANTED = "not_granted"
    """The command carries no grant."""
    NOT_TRUSTED = "not_trusted"
    """The grant is not signed by anybody whom the vehicle trusts, or not for these words."""
    EXPIRED = "expired"
    """The grant has expired."""
    NOT_HERE = "not_here"
    """The vehicle is outside of the areas that the grant names."""
    NOT_STOPPED = "not_stopped"
    """Nothing holds the vehicle that could be acknowledged or resumed."""
    NOT_ACKNOWLEDGED = "not_acknowledged"
    """The stop is to be acknowledged before the vehicle is resumed."""
    FAULTY = "faulty"
    """Its sensors still report a problem, which stands beside it."""
    NOT_WAITING = "not_waiting"
    """The vehicle has no task that waits for help."""
    LOAD_ABOARD = "load_aboard"
    """Goods that are on board exist once: no other vehicle can carry them."""
    WAIT_OUT_OF_RANGE = "wait_out_of_range"
    """Help within more than 0 and at most `PROMISE_MAX_S` seconds can be promised."""
    SPEED_OUT_OF_RANGE = "speed_out_of_range"
    """A speed is above 0 and at most 1 of the vehicle's own; 0 is a stop."""


class Implausible(StrEnum):
    """Why a coordinator does not believe what a contractor says."""

    CLOCK = "clock"
    """Its clock is wrong."""
    NOT_A_NUMBER = "not_a_number"
    NEGATIVE = "negative"
    """A part of the price is below 0."""
    OTHER_WORK = "other_work"
    """The bid is for another kind of work."""
    OTHER_SOURCE = "other_source"
    """The bid names a source that was not asked for."""
    TOO_CHEAP = "too_cheap"
    """The price is below the way as the crow flies."""
    TOO_SOON = "too_soon"
    """It would be done sooner than any vehicle could."""
    BEFORE_NOW = "before_now"
    """It would be done in the past."""
    TOO_LATE = "too_late"
    """It would be done much later than its price tells."""
