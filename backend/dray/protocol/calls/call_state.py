"""The states of a call for help, and their transitions."""

from __future__ import annotations

from dray.messages import CallState
from dray.states import Transitions

TRANSITIONS: Transitions[CallState] = {
    CallState.ASKING: {
        CallState.TAKEN: "somebody takes it",
        CallState.RESTING: "nobody is left to be asked",
        CallState.ENDED: "nobody is needed any more",
    },
    CallState.TAKEN: {
        CallState.ASKING: "given back, or nobody came in time",
        CallState.RESTING: "the same, and nobody else is there",
        CallState.ENDED: "nobody is needed any more",
    },
    CallState.RESTING: {
        CallState.ASKING: "asked again, or somebody has come on duty",
        CallState.TAKEN: "somebody takes it unasked, or late",
        CallState.ENDED: "nobody is needed any more",
    },
    CallState.ENDED: {},
}
