"""How long later goals pass goals that they should not pass any more: the bound of priorities (docs/protocol.md).

From its wanted time on, no goal that its machine has taken later may pass a goal. A piece of another goal that is
made nevertheless, because the goal's own material is still on the way, counts as passing.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import Event, MachineHeartbeat, Message
from dray.messages.fact import ContractTaken, PieceMade


class Passing:
    """Listens to all machines.

    Attributes:
        longest_s: longest time for which a machine has made pieces that should have come after another goal.
        longest: that goal.
    """

    def __init__(self) -> None:
        self._taken_s: dict[str, float] = {}
        """When each goal was taken."""
        self._since_s: dict[str, float] = {}
        """Since when a goal's machine makes pieces of later goals after its wanted time, and none of it, by goal."""
        self._made: dict[str, int] = {}
        self._open: dict[str, dict[str, float]] = {}
        """Unfinished goals, each with its wanted time, by machine."""
        self.longest_s, self.longest = 0.0, ""

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is MachineHeartbeat:
            self._open[sender] = {
                brief.goal: brief.deadline_s
                for brief in message.goals
                if brief.made < brief.quantity and brief.offered is not True and brief.deadline_s is not UNSET
            }
        elif type(message) is Event:
            if type(message.fact) is ContractTaken:
                self._taken_s[message.fact.task] = at_s
            elif type(message.fact) is PieceMade:
                self._on_piece(sender, message.fact.goal, at_s)

    def _on_piece(self, machine: str, made: str, at_s: float) -> None:
        self._since_s.pop(made, None)
        came_s = self._taken_s.get(made, at_s)
        for goal, wanted_s in self._open.get(machine, {}).items():
            if goal == made:
                continue
            if wanted_s >= came_s:
                self._since_s.pop(goal, None)
                continue
            passed_s = at_s - self._since_s.setdefault(goal, at_s)
            if passed_s > self.longest_s:
                self.longest_s, self.longest = passed_s, goal
