"""Invariant 14: no place is held by two vehicles, whatever was lost, restarted or torn apart.

What a vehicle holds is asked of the vehicle itself, also of one whose process has ended: it holds what it held,
until people carry it away. One that lies is not asked.
"""

from __future__ import annotations

from dray.messages import Message
from dray.protocol.vehicle.atv import Atv
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

NUMBER = 14


class HeldPlaces:
    """Looks at a vehicle whenever it says something or something is said to it.

    Args:
        factory: whose vehicles are asked.
    """

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._holders: dict[str, str] = {}
        """Place -> who was seen last to hold it."""

    def on_message(self, at_s: float, sender: str, address: str, _message: Message) -> None:
        """See `Listener`.

        Raises:
            InvariantBroken: two vehicles hold one place.
        """
        for atv in (sender, address.removeprefix(">")):
            if atv in self._factory.vehicles:
                self.check(at_s, atv)

    def check(self, at_s: float, atv: str) -> None:
        """Look at one vehicle now.

        Raises:
            InvariantBroken: it holds a place that another one holds, too.
        """
        for place in self._holds(atv):
            other = self._holders.get(place, atv)
            if other != atv and place in self._holds(other):
                raise InvariantBroken(NUMBER, at_s, f"{other} and {atv} both hold {place}")
            self._holders[place] = atv

    def _holds(self, atv: str) -> tuple[str, ...]:
        if atv in self._factory.floor.carried:
            return ()
        agent = self._factory.workers[atv].agent
        right_of_way = agent.right_of_way if type(agent) is Atv else None
        return right_of_way.holds if right_of_way is not None else ()
