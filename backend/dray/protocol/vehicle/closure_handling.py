"""A vehicle's closures: it follows the newest signed list, and leaves the area that was closed around it.

A closure applies from the step in which its list arrives. From then on no way leads into it. The present way ends
at the next node, or leads round it. The list is stored for the next life.
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
    """One vehicle's reaction to closures.

    Args:
        floor: the floor as the vehicle knows it.
        trusts: the trusted signers.
        contracts: the vehicle's contracts.
        idle: the vehicle's idle positioning.
    """

    def __init__(
        self, floor: KnownFloor, trusts: Trusts, contracts: Contracts, idle: IdlePositioning, life: Life
    ) -> None:
        super().__init__(floor, trusts, life)
        self._contracts, self._idle = contracts, idle

    def start(self, memory: Memory, now_s: float) -> None:
        """Restore the last life's list, and subscribe."""
        self.listen()
        note = memory.get(CLOSURES)
        if isinstance(note, ClosuresMemory):
            self._floor.take(note.list, now_s)
            self._set_alarm()

    def _note(self, said: Closures) -> None:
        # Stored first: the next life must know the list that this one acknowledges.
        self._life.do(Commit(ClosuresMemory(said), CLOSURES))
        self._life.record(ClosuresKnown(number=said.number))

    def _follow(self, now_s: float) -> None:
        if self._contracts.job is None:
            self._idle.floor_changed(now_s)
        else:
            self._contracts.go_on(lambda job: job.floor_changed(now_s), now_s)
