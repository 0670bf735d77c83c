"""A vehicle and what people have closed: it goes by the newest signed list, and leaves what was closed around it.

A closure is known from the step in which its list is heard. From then on no way is given into it; the way that the vehicle is
on ends at the next node, or goes on round it. The list outlives the vehicle's process.
"""

from __future__ import annotations

from dray.memory import CLOSURES, ClosuresMemory, Memory
from dray.messages import Closures
from dray.messages.fact import ClosuresKnown
from dray.protocol.closures.closure_listener import ClosureListener
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.runtime.events import Commit
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.trust import Trusts
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.idle_positioning import IdlePositioning


class ClosureHandling(ClosureListener):
    """What one vehicle does about closures.

    Args:
        floor: as the vehicle knows it.
        trusts: whose signatures count.
        contracts: of the vehicle.
        idle: where it goes without work.
    """

    def __init__(
        self, floor: KnownFloor, trusts: Trusts, contracts: Contracts, idle: IdlePositioning, life: Life
    ) -> None:
        super().__init__(floor, trusts, life)
        self._contracts, self._idle = contracts, idle

    def start(self, memory: Memory, now_s: float) -> None:
        """Go by what the last life knew, and listen."""
        self.listen()
        note = memory.get(CLOSURES)
        if isinstance(note, ClosuresMemory):
            self._floor.take(note.list, now_s)
            self._set_alarm()

    def _note(self, said: Closures) -> None:
        # Written down first: what it has told to know, its next life knows.
        self._life.do(Commit(ClosuresMemory(said), CLOSURES))
        self._life.record(ClosuresKnown(number=said.number))

    def _follow(self, now_s: float) -> None:
        if self._contracts.job is None:
            self._idle.floor_changed(now_s)
        else:
            self._contracts.go_on(lambda job: job.floor_changed(now_s), now_s)
