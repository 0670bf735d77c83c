"""A vehicle that has not told a place since its agent was started: it does nothing, and calls a person after a while.

Without a place it can hold none and take no work. It sends no heartbeat either: others would believe the position in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dray.body import UnplacedVehicle
from dray.memory import WHOLE, AtvMemory, Memory
from dray.messages import CallPlace, Message, Problem, ProblemKind
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls
from dray.protocol.runtime.life import Life

CALL_AFTER_S = 60.0
"""Time without a place after which a person is called (s): vehicle, broker and agent may be started in any order."""

LOOK_S = 1.0
"""Interval of looks at the body (s)."""

LOOK = "look for its place"

UNPLACED = "the agent waits for its place"
"""Why messages are ignored meanwhile."""

NEVER_TOLD, LAST_AT = (
    "it has not told any place yet: {}",
    "it does not tell its place, and was last at {}: {}",
)
"""The call's reason in words."""


class Unplaced:
    """The wait for a vehicle's place.

    Args:
        atv: the vehicle's id.
        plant: its places.
        calls: the vehicle's calls for help.
        life: the agent's life; alarms are named `LOOK`.

    Attributes:
        memory: of the last life, for the vehicle when it has a place.
        message_handlers: the messages that the vehicle handles meanwhile.
    """

    def __init__(self, atv: str, plant: Plant, calls: HelpCalls, life: Life) -> None:
        self._atv, self._plant, self._calls, self._life = atv, plant, calls, life
        self.memory: Memory = {}
        self._node = self._why = ""
        self._call_s = 0.0
        self._is_draining = False
        self.message_handlers: dict[type[Message], Callable[[str, Any, float], None]] = calls.message_handlers

    def start(self, body: UnplacedVehicle, memory: Memory, now_s: float) -> None:
        """Begin to wait."""
        note = memory.get(WHOLE)
        self.memory, self._why = memory, body.why
        if isinstance(note, AtvMemory) and note.node in self._plant.nodes:
            self._node = note.node
        self._call_s = now_s + CALL_AFTER_S
        self._calls.listen()
        self.look(now_s)

    def sense(self, body: UnplacedVehicle) -> None:
        """Note what is missing now."""
        self._why = body.why

    def leave(self, now_s: float) -> None:
        """The vehicle was asked to leave: it calls nobody any more."""
        self._is_draining = True
        self._calls.close(now_s)

    def stop(self) -> None:
        """The vehicle has told its place."""
        self._life.cancel(LOOK)

    def look(self, now_s: float) -> None:
        """Handle the alarm `LOOK`: call a person, or say what is missing now."""
        self._life.alarm(LOOK, now_s + LOOK_S)
        if now_s < self._call_s or self._is_draining:
            return
        if self._node:
            place, node, reason = CallPlace.LAST, self._node, LAST_AT.format(self._node, self._why)
        else:
            spec = self._plant.fleet.get(self._atv)
            place, node = CallPlace.UNTOLD, spec.node if spec is not None else ""
            reason = NEVER_TOLD.format(self._why)
        spot = self._plant.nodes.get(node)
        place_m = (0.0, 0.0) if spot is None else (spot.x_m, spot.y_m)
        about = Problem(kind=ProblemKind.LOST_POSITION, needs_person=True)
        self._calls.open(about, reason, now_s, place_m=place_m, place=place)
