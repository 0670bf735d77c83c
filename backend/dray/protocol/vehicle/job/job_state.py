"""The states of a transport job, and their transitions. Only this module changes a job's state.

    BOUND -> APPROACHING -> AT_SOURCE -> PICKING -> CARRYING -> AT_DESTINATION -> DROPPING -> HANDING_OVER -> ENDED

is a job without problems. It stands in GIVING_BACK if another vehicle is to carry it and its load is not on board.
If the contract becomes void during a manoeuvre, the job waits for the manoeuvre's end (VOID_PICKING,
VOID_DROPPING), also where an earlier life may have begun a pick (VOID_AT_SOURCE). A load without a receiver is RETURNING to a storage, asks for its dock (AT_REFUGE) and is
PUTTING_BACK there. docs/states.md draws the table.
"""

from __future__ import annotations

from enum import StrEnum

from dray.messages import Phase
from dray.states import States, Transitions


class JobState(StrEnum):
    """The state of a transport job."""

    BOUND = "bound"
    """The contract is made, or comes from an earlier life; nothing is done yet in this life."""
    APPROACHING = "approaching"
    """Empty, on its way to the source."""
    AT_SOURCE = "at_source"
    """Asks for the dock of the source."""
    PICKING = "picking"
    CARRYING = "carrying"
    """Loaded, on its way to the destination."""
    AT_DESTINATION = "at_destination"
    """Asks for the dock of the destination."""
    DROPPING = "dropping"
    HANDING_OVER = "handing_over"
    """The load is down; its coordinator has not confirmed that yet."""
    GIVING_BACK = "giving_back"
    """Stands empty until its coordinator has found another carrier."""
    VOID_PICKING = "void_picking"
    """The contract is void; a pick is still under way."""
    VOID_AT_SOURCE = "void_at_source"
    """The contract is void; a pick that an earlier life began may still be under way."""
    VOID_DROPPING = "void_dropping"
    """The contract is void; a drop is still under way."""
    RETURNING = "returning"
    """The contract is void; the load is on its way to a storage."""
    AT_REFUGE = "at_refuge"
    """Asks for the dock of that storage."""
    PUTTING_BACK = "putting_back"
    ENDED = "ended"


_S = JobState

TRANSITIONS: Transitions[JobState] = {
    _S.BOUND: {
        _S.APPROACHING: "sets off",
        _S.CARRYING: "started again, with the load on board",
        _S.HANDING_OVER: "started again, after the drop",
        _S.RETURNING: "started again, void, with the load on board",
        _S.VOID_AT_SOURCE: "started again, void, where it was loading",
        _S.ENDED: "started again, void or without its goods",
    },
    _S.APPROACHING: {
        _S.AT_SOURCE: "arrives",
        _S.CARRYING: "the load is found on board",
        _S.GIVING_BACK: "another one is to carry it",
        _S.VOID_AT_SOURCE: "void, after a restart where it was loading",
        _S.ENDED: "void",
    },
    _S.AT_SOURCE: {
        _S.PICKING: "the dock opens",
        _S.CARRYING: "the load is found on board",
        _S.GIVING_BACK: "another one is to carry it",
        _S.VOID_AT_SOURCE: "void, after a restart where it was loading",
        _S.ENDED: "void",
    },
    _S.PICKING: {
        _S.CARRYING: "picked",
        _S.AT_SOURCE: "the pick fails",
        _S.VOID_PICKING: "void",
    },
    _S.CARRYING: {
        _S.AT_DESTINATION: "arrives",
        _S.APPROACHING: "the material was taken off",
        _S.RETURNING: "void",
        _S.ENDED: "the goods were taken off",
    },
    _S.AT_DESTINATION: {
        _S.DROPPING: "the dock opens",
        _S.HANDING_OVER: "an earlier life's drop has ended",
        _S.APPROACHING: "the material was taken off",
        _S.RETURNING: "void",
        _S.ENDED: "the goods were taken off",
    },
    _S.DROPPING: {
        _S.HANDING_OVER: "dropped",
        _S.AT_DESTINATION: "the drop fails",
        _S.VOID_DROPPING: "void",
    },
    _S.HANDING_OVER: {
        _S.CARRYING: "the load is found on board",
        _S.ENDED: "confirmed, void, or nobody answers",
    },
    _S.GIVING_BACK: {
        _S.CARRYING: "the load is found on board",
        _S.VOID_AT_SOURCE: "void, after a restart where it was loading",
        _S.ENDED: "void",
    },
    _S.VOID_PICKING: {
        _S.RETURNING: "picked",
        _S.ENDED: "the pick fails",
    },
    _S.VOID_AT_SOURCE: {
        _S.RETURNING: "the load is found on board",
        _S.ENDED: "no pick is under way any more",
    },
    _S.VOID_DROPPING: {
        _S.RETURNING: "the drop fails",
        _S.ENDED: "dropped",
    },
    _S.RETURNING: {
        _S.AT_REFUGE: "arrives at a storage",
        _S.PUTTING_BACK: "arrives at a delivery warehouse",
        _S.ENDED: "the load was taken off",
    },
    _S.AT_REFUGE: {
        _S.PUTTING_BACK: "the dock opens",
        _S.RETURNING: "nobody answers",
        _S.ENDED: "the load was taken off",
    },
    _S.PUTTING_BACK: {
        _S.RETURNING: "the drop fails",
        _S.ENDED: "dropped",
    },
    _S.ENDED: {},
}

PHASES = {
    _S.APPROACHING: Phase.APPROACHING,
    _S.AT_SOURCE: Phase.LOADING,
    _S.PICKING: Phase.LOADING,
    _S.VOID_PICKING: Phase.LOADING,
    _S.VOID_AT_SOURCE: Phase.LOADING,
    _S.CARRYING: Phase.CARRYING,
    _S.AT_DESTINATION: Phase.UNLOADING,
    _S.DROPPING: Phase.UNLOADING,
    _S.VOID_DROPPING: Phase.UNLOADING,
    _S.HANDING_OVER: Phase.HANDING_OVER,
    _S.RETURNING: Phase.RETURNING,
    _S.AT_REFUGE: Phase.RETURNING,
    _S.PUTTING_BACK: Phase.RETURNING,
}
"""The phase that other agents see; a state without an entry keeps the phase before."""

MANOEUVRES = frozenset({_S.PICKING, _S.DROPPING, _S.VOID_PICKING, _S.VOID_DROPPING, _S.PUTTING_BACK})
"""States with a pick or drop under way."""

LOADED = frozenset(
    {
        _S.CARRYING,
        _S.AT_DESTINATION,
        _S.DROPPING,
        _S.VOID_DROPPING,
        _S.RETURNING,
        _S.AT_REFUGE,
        _S.PUTTING_BACK,
    }
)
"""States with the load on board."""

VOID = frozenset(
    {
        _S.VOID_PICKING,
        _S.VOID_AT_SOURCE,
        _S.VOID_DROPPING,
        _S.RETURNING,
        _S.AT_REFUGE,
        _S.PUTTING_BACK,
        _S.ENDED,
    }
)
"""States without a binding contract."""


class JobStates(States[JobState]):
    """The state of one job.

    Args:
        phase: the phase last told by an earlier life; `Phase.APPROACHING` for a new job.

    Attributes:
        phase: the phase that other agents see.
    """

    __slots__ = ("phase",)

    def __init__(self, phase: Phase) -> None:
        super().__init__("a transport job", TRANSITIONS, JobState.BOUND)
        self.phase = phase

    def enter(self, state: JobState) -> None:
        """Change the state; see `States.enter`."""
        super().enter(state)
        self.phase = PHASES.get(state, self.phase)
