"""The states of our order at a vehicle, with all transitions. Nothing else changes an order's state.

    OFFERED -> RUNNING -> DONE

is a successful order. An order that the vehicle does not show is sent again, unchanged. EXTENDING means that an update is not shown
yet. A REFUSED order is offered again, under another id, when the vehicle may be ready. docs/vehicles.md draws the table.
"""

from __future__ import annotations

from enum import StrEnum

from dray.states import Transitions


class OrderState(StrEnum):
    """The progress of our order."""

    OFFERED = "offered"
    """Sent; the vehicle's state does not show it yet."""
    REFUSED = "refused"
    """It waits before the next offer."""
    RUNNING = "running"
    """The vehicle's state shows it."""
    EXTENDING = "extending"
    """Running; an update was sent that the state does not show yet."""
    CANCELLING = "cancelling"
    """cancelOrder was sent; the end is not confirmed yet."""
    DONE = "done"
    """Its last node is reached and its action has ended well."""
    ENDED = "ended"
    """Ended without success: failed, cancelled, forgotten by the vehicle, or given up."""


_S = OrderState

TRANSITIONS: Transitions[OrderState] = {
    _S.OFFERED: {
        _S.RUNNING: "the state shows it",
        _S.REFUSED: "an error names it, or it is not shown in time",
        _S.CANCELLING: "not wanted any more",
        _S.ENDED: "not wanted any more, or an earlier life's way, and never shown",
    },
    _S.REFUSED: {
        _S.OFFERED: "the vehicle is idle: under another id",
        _S.RUNNING: "the state shows it after all",
        _S.ENDED: "refused too often, or not wanted any more",
    },
    _S.RUNNING: {
        _S.EXTENDING: "more is released",
        _S.CANCELLING: "not wanted any more, or its action only waits",
        _S.DONE: "its last node is reached, its action is FINISHED",
        _S.ENDED: "failed, stopped short, or the vehicle shows another one",
    },
    _S.EXTENDING: {
        _S.RUNNING: "the state shows the update, or refuses it",
        _S.CANCELLING: "not wanted any more",
        _S.DONE: "its last node is reached",
        _S.ENDED: "failed, stopped short, or the vehicle shows another one",
    },
    _S.CANCELLING: {
        _S.DONE: "it had ended before",
        _S.ENDED: "cancelOrder is FINISHED, or nothing is left to cancel",
    },
    _S.DONE: {},
    _S.ENDED: {},
}

ACTIVE = frozenset({_S.RUNNING, _S.EXTENDING})
"""States in which the vehicle has the order."""

OVER = frozenset({_S.DONE, _S.ENDED})
