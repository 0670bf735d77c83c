"""The states of an order of ours at a vehicle, and every change that may be between them. Nothing else changes an order's state.

    OFFERED -> RUNNING -> DONE

is the order that goes well. One that is said and not shown by the vehicle is said again, unchanged. EXTENDING is an update
that is not shown yet. A REFUSED one is offered again, under another id, when the vehicle may be ready. docs/vehicles.md
draws the table.
"""

from __future__ import annotations

from enum import StrEnum

from dray.states import Transitions


class OrderState(StrEnum):
    """How far an order of ours has come."""

    OFFERED = "offered"
    """Said; the vehicle's state does not show it yet."""
    REFUSED = "refused"
    """Waits before it is offered again."""
    RUNNING = "running"
    """The vehicle's state shows it."""
    EXTENDING = "extending"
    """It runs, and an update of it is said that the state does not show yet."""
    CANCELLING = "cancelling"
    """cancelOrder is said; its end is waited for."""
    DONE = "done"
    """Its last node is reached and its action has ended well."""
    ENDED = "ended"
    """It has ended without that: failed, cancelled, forgotten by the vehicle, or given up."""


_S = OrderState

TRANSITIONS: Transitions[OrderState] = {
    _S.OFFERED: {
        _S.RUNNING: "the state shows it",
        _S.REFUSED: "an error names it, or it is not shown in time",
        _S.CANCELLING: "not wanted any more",
        _S.ENDED: "not wanted any more, and never shown",
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
"""The vehicle has it."""

OVER = frozenset({_S.DONE, _S.ENDED})
