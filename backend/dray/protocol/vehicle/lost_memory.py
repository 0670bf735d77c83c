"""Where a vehicle has lost its memory, and whether it has left that node with nothing on board.

A place that was down meanwhile knows from this (`AtvHeartbeat.left_empty`) what the vehicle has done at its dock.

    it starts without notes                            its body may still load or unload for the earlier life
    it passes another node with nothing on board       what it came for it has not taken; what it brought is down
    it has a load on board there, or when it leaves    a later life, or another place, tells of that load (`Contracts.bring_back`)
    it stands at that node again                       it may be let in anew: it says no more of its earlier visit
"""

from __future__ import annotations

from dray.memory import AtvMemory
from dray.protocol.runtime.life import Life


class LostMemory:
    """The last loss of one vehicle's memory.

    Attributes:
        node: where it found itself without notes; empty if it was nowhere, has left with a load, or came back.
        is_left: whether it has left that node with nothing on board.
    """

    def __init__(self, life: Life) -> None:
        self._life = life
        self.node, self.is_left = "", False

    @property
    def left_empty(self) -> str:
        """The node where it lost its memory and which it has left with nothing on board; empty for none."""
        return self.node if self.is_left else ""

    def start(self, node: str) -> None:
        """Start without notes of the life before."""
        self._set(node, is_left=False)

    def restore(self, memory: AtvMemory) -> None:
        """Start with the notes of the life before."""
        self.node, self.is_left = memory.forgot_at, memory.left_empty

    def sense(self, node: str, load: str) -> None:
        """Take the last passed node and the item on board (empty for none) from the vehicle's body."""
        if not self.node:
            return
        if self.is_left:
            if node == self.node:
                self._set("", is_left=False)
        elif load:
            self._set("", is_left=False)
        elif node != self.node:
            self._set(self.node, is_left=True)

    def _set(self, node: str, *, is_left: bool) -> None:
        self.node, self.is_left = node, is_left
        self._life.commit()
