"""Invariants 14 and 29: two vehicles never hold one place, and none is granted more than it needs.

Neither losses, restarts nor partitions are an excuse. The vehicle itself is asked what it holds, also when its
process has ended: it holds its places until people carry it away. A liar is not asked; the tables' answers show its
grants.
"""

from __future__ import annotations

from dray.messages import Message, PlaceGranted
from dray.protocol.traffic.reservations.reach import RUN_MAX
from dray.protocol.vehicle.atv import Atv
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

HELD_TWICE, TOO_MUCH = 14, 29


class HeldPlaces:
    """Looks at a vehicle whenever it says something or something is said to it.

    Args:
        factory: whose vehicles are asked.
    """

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._holders: dict[str, str] = {}
        """Place -> the vehicle that was last seen to hold it."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        """See `Listener`.

        Raises:
            InvariantBroken: two vehicles hold one place, or one was granted more than it can need.
        """
        if type(message) is PlaceGranted and len(message.grants) > RUN_MAX:
            count, atv = len(message.grants), address.removeprefix(">")
            raise InvariantBroken(TOO_MUCH, at_s, f"{atv} has {count} places of {message.district}")
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
                raise InvariantBroken(HELD_TWICE, at_s, f"{other} and {atv} both hold {place}")
            self._holders[place] = atv

    def _holds(self, atv: str) -> tuple[str, ...]:
        if atv in self._factory.floor.carried:
            return ()
        agent = self._factory.workers[atv].agent
        right_of_way = agent.right_of_way if type(agent) is Atv else None
        return right_of_way.holds if right_of_way is not None else ()
