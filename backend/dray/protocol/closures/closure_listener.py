"""How an agent follows the newest list of closures, and ends closures by its own clock."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dray.messages import Closures, Message
from dray.messages.keys import Keys
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.trust import Trusts

REOPEN = "reopen"
"""Alarm of a closure that ends by its own time."""


class ClosureListener:
    """The closure listener of one agent.

    Args:
        floor: the floor as the agent knows it.
        trusts: the people whose signatures count.
        life: the agent's life; alarms are named `REOPEN`.

    Attributes:
        message_handlers, alarms: entries for the agent's tables.
    """

    def __init__(self, floor: KnownFloor, trusts: Trusts, life: Life) -> None:
        self._floor, self._trusts = floor, trusts
        self._life = life
        self.message_handlers: Mapping[type[Message], Callable[..., None]] = {Closures: self._on_closures}
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {REOPEN: self._look_again}

    def listen(self) -> None:
        """Subscribe to closures."""
        self._life.subscribe(Keys(self._floor.id).closures)

    def _on_closures(self, _sender: str, said: Closures, now_s: float) -> None:
        if objection := self._floor.objection(said, self._trusts):
            self._life.ignore(objection)
            return
        changed = self._floor.take(said, now_s)
        self._note(said)
        self._set_alarm()
        if changed:
            self._follow(now_s)

    def _look_again(self, _about: None, now_s: float) -> None:
        if self._floor.look(now_s):
            self._follow(now_s)
        self._set_alarm()

    def _set_alarm(self) -> None:
        self._life.alarm(REOPEN, self._floor.ends_s)

    def _note(self, said: Closures) -> None:
        """Another list applies from now on."""

    def _follow(self, now_s: float) -> None:
        """The floor has changed: act on it."""
