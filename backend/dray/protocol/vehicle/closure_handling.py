"""A vehicle and what people have closed: it goes by the newest signed list, and leaves what was closed around it.

A closure is known from the step in which its list is heard. From then on no way is given into it; the way that the vehicle is
on ends at the next node, or goes on round it. The list outlives the vehicle's process, and what ends by its own time ends by the
vehicle's clock.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dray.memory import CLOSURES, ClosuresMemory, Memory
from dray.messages import Closures, Message
from dray.messages.fact import ClosuresKnown
from dray.messages.keys import Keys
from dray.protocol.closures.known_floor import REOPEN, KnownFloor
from dray.protocol.runtime.events import Commit, Effect, Ignore, Record, Subscribe
from dray.protocol.runtime.timers import Timers
from dray.protocol.vehicle.command_authorisation import Trusts
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.idle_positioning import IdlePositioning


class ClosureHandling:
    """What one vehicle does about closures.

    Args:
        floor: as the vehicle knows it.
        trusts: whose signatures count.
        contracts: of the vehicle.
        idle: where it goes without work.
        timers: the vehicle's alarms; this class uses `REOPEN`.
        out: where effects go.
    """

    def __init__(
        self,
        floor: KnownFloor,
        trusts: Trusts,
        contracts: Contracts,
        idle: IdlePositioning,
        timers: Timers,
        out: list[Effect],
    ) -> None:
        self._floor, self._trusts = floor, trusts
        self._contracts, self._idle = contracts, idle
        self._key = Keys(floor.id).closures
        self._timers, self._out = timers, out
        self.message_handlers: Mapping[type[Message], Callable[..., None]] = {Closures: self._on_closures}
        self.alarms: Mapping[str, Callable[[Any, float], None]] = {REOPEN: self._look_again}

    def start(self, memory: Memory, now_s: float) -> None:
        """Go by what the last life knew, and listen."""
        self._out.append(Subscribe(self._key))
        note = memory.get(CLOSURES)
        if isinstance(note, ClosuresMemory):
            self._floor.take(note.list, now_s)
            self._set_alarm()

    def _on_closures(self, _sender: str, said: Closures, now_s: float) -> None:
        if objection := self._floor.objection(said, self._trusts):
            self._out.append(Ignore(objection))
            return
        changed = self._floor.take(said, now_s)
        # Written down first: what it has told to know, its next life knows.
        self._out += (Commit(ClosuresMemory(said), CLOSURES), Record(ClosuresKnown(number=said.number)))
        self._set_alarm()
        if changed:
            self._follow(now_s)

    def _look_again(self, _about: None, now_s: float) -> None:
        if self._floor.look(now_s):
            self._follow(now_s)
        self._set_alarm()

    def _set_alarm(self) -> None:
        self._timers.set(REOPEN, self._floor.ends_s)

    def _follow(self, now_s: float) -> None:
        """Drive by what holds now."""
        if self._contracts.job is None:
            self._idle.floor_changed(now_s)
        else:
            self._contracts.go_on(lambda job: job.floor_changed(now_s), now_s)
