"""The states of a task, as its coordinator knows it, and their transitions.

A transport has all of them. A production goal is only unassigned, assigned, or closed.
"""

from __future__ import annotations

from enum import StrEnum

from dray.states import Transitions


class TaskState(StrEnum):
    """The state of a task."""

    UNASSIGNED = "unassigned"
    """No contractor: it is up for auction, or will be."""
    ASSIGNED = "assigned"
    """A primary has the contract."""
    SUSPECTED = "suspected"
    """Its primary has failed; its secondary may take over for a moment."""
    IN_TRANSIT = "in_transit"
    """Goods have left with its primary: no other vehicle could fetch them."""
    STRANDED = "stranded"
    """Its primary has failed with the goods on board: they wait for a person's decision (`takeover.stranded`)."""
    HELD = "held"
    """Only a person can tell whether its load is there, or what is wrong at a dock: no vehicle carries it before one has
    looked (`transports.held`)."""
    COUNTED = "counted"
    """The coordinator has counted the load in its own buffer; the handover is still to come."""
    DELIVERED = "delivered"
    WITHDRAWN = "withdrawn"


_S = TaskState

TRANSITIONS: Transitions[TaskState] = {
    _S.UNASSIGNED: {
        _S.ASSIGNED: "accepted, or named by its carrier after a restart",
        _S.HELD: "an earlier life has held it",
        _S.DELIVERED: "what was ordered has arrived all the same",
        _S.WITHDRAWN: "not needed any more",
    },
    _S.ASSIGNED: {
        _S.ASSIGNED: "taken over",
        _S.SUSPECTED: "its primary has failed, and somebody watches",
        _S.UNASSIGNED: "failed, given back, forgotten, or without progress",
        _S.IN_TRANSIT: "goods have left",
        _S.COUNTED: "the load is counted",
        _S.HELD: "its handover is disputed again, its load is perhaps down, or carriers fail at a dock",
        _S.DELIVERED: "handed over",
        _S.WITHDRAWN: "not needed any more, or lost",
    },
    _S.SUSPECTED: {
        _S.ASSIGNED: "heard again, or taken over",
        _S.UNASSIGNED: "nobody has taken over",
        _S.IN_TRANSIT: "goods have left",
        _S.COUNTED: "the load is counted",
        _S.HELD: "its handover is disputed again",
        _S.DELIVERED: "handed over",
        _S.WITHDRAWN: "not needed any more",
    },
    _S.IN_TRANSIT: {
        _S.UNASSIGNED: "the goods are back, or its primary has a thing no more",
        _S.DELIVERED: "handed over",
        _S.STRANDED: "its primary has failed",
        _S.COUNTED: "a thing is counted",
        _S.HELD: "its handover is disputed again",
        _S.WITHDRAWN: "lost, or not needed any more",
    },
    _S.STRANDED: {
        _S.IN_TRANSIT: "its primary goes on",
        _S.COUNTED: "a thing is counted",
        _S.UNASSIGNED: "they can be handed over, or are back",
        _S.DELIVERED: "handed over",
        _S.HELD: "its handover is disputed again",
        _S.WITHDRAWN: "written off, or not needed any more",
    },
    _S.HELD: {
        _S.UNASSIGNED: "a person says that the load is not there, or that a dock is in order; or it is back",
        _S.DELIVERED: "a person says that it is there",
        _S.WITHDRAWN: "goods are not there, or it is not needed any more",
    },
    _S.COUNTED: {
        _S.DELIVERED: "handed over, or its carrier has failed",
        _S.WITHDRAWN: "not needed any more",
    },
    _S.DELIVERED: {},
    _S.WITHDRAWN: {},
}
