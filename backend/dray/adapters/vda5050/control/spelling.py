"""Words of VDA 5050 in a vehicle's own spelling: "fatal" for FATAL, "Teach-In" for TEACHIN.

An error at the level "fatal" keeps a vehicle from going on like one at FATAL. So a known word in another spelling is read as that word.
A word that the standard does not have stays as it is. People are told of both, once for each field.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import msgspec

from dray.adapters.vda5050.control.doubts import QUOTED, Doubts
from dray.adapters.vda5050.wire.messages import ActionState, State, VehicleError


@dataclass(frozen=True, slots=True)
class Field:
    """A field with words of the standard."""

    name: str
    words: frozenset[str]
    by_letters: Mapping[str, str]
    """By its letters alone, in capitals: the word."""
    otherwise: str
    """What follows from another word."""

    def read(self, said: str | None, doubts: Doubts) -> str | None:
        """The word that was meant; what was said where nobody knows it."""
        if not said or said in self.words:
            return said
        word = self.by_letters.get("".join(filter(str.isalpha, said)).upper())
        quoted = f"{said[:QUOTED]!r}"
        if word is None:
            doubts.note(f"an unknown {self.name}", f"VDA 5050 has no {quoted}: {self.otherwise}")
            return said
        doubts.note(f"an odd {self.name}", f"{quoted} is read as {word}")
        return word


def _field(name: str, words: Iterable[str], otherwise: str) -> Field:
    known = frozenset(words)
    return Field(name, known, {word.replace("_", ""): word for word in sorted(known)}, otherwise)


LEVEL = _field(
    "errorLevel",
    ("WARNING", "URGENT", "CRITICAL", "FATAL"),
    "such an error is no problem as long as it goes on",
)
STATUS = _field(
    "actionStatus",
    ("WAITING", "INITIALIZING", "RUNNING", "PAUSED", "RETRIABLE", "FINISHED", "FAILED"),
    "such an action has not ended",
)
MODE = _field(
    "operatingMode",
    ("AUTOMATIC", "SEMIAUTOMATIC", "STARTUP", "INTERVENED", "MANUAL", "SERVICE", "TEACH_IN", "TEACHIN"),
    "it counts as AUTOMATIC",
)
STOP = _field("eStop", ("NONE", "AUTOACK", "MANUAL", "REMOTE"), "it counts as an emergency stop")


def spelled(state: State, doubts: Doubts) -> State:
    """A state with the words of the standard.

    Args:
        state: as the vehicle has sent it.
        doubts: receives other spellings and unknown words.
    """
    changes: dict[str, object] = {}
    if (mode := MODE.read(state.operating_mode, doubts)) != state.operating_mode:
        changes["operating_mode"] = mode
    if (safety := state.safety_state) is not None:
        stops = {
            "e_stop": STOP.read(safety.e_stop, doubts),
            "active_emergency_stop": STOP.read(safety.active_emergency_stop, doubts),
        }
        if stops != {"e_stop": safety.e_stop, "active_emergency_stop": safety.active_emergency_stop}:
            changes["safety_state"] = msgspec.structs.replace(safety, **stops)
    if state.errors:
        errors = tuple(_error(error, doubts) for error in state.errors)
        if errors != state.errors:
            changes["errors"] = errors
    for name, actions in (
        ("action_states", state.action_states),
        ("instant_action_states", state.instant_action_states),
    ):
        if actions and (read := tuple(_action(action, doubts) for action in actions)) != actions:
            changes[name] = read
    return msgspec.structs.replace(state, **changes) if changes else state


def _error(error: VehicleError, doubts: Doubts) -> VehicleError:
    level = LEVEL.read(error.error_level, doubts)
    return error if level == error.error_level else msgspec.structs.replace(error, error_level=level)


def _action(action: ActionState, doubts: Doubts) -> ActionState:
    status = STATUS.read(action.action_status, doubts)
    return action if status == action.action_status else msgspec.structs.replace(action, action_status=status)
