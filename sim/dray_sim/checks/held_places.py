"""Invariant 14: no place is held by two vehicles, whatever was lost, restarted or torn apart.

What a vehicle holds is asked of the vehicle itself, also of one whose process has ended: it holds what it held,
until people carry it away. One that lies is not asked.
"""

from __future__ import annotations

from dray.messages import Message, PlaceGranted, PlaceWished
from dray.protocol.vehicle.atv import Atv
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

NUMBER = 14


class HeldPlaces:
    """Looks whenever a place may have changed hands.

    Args:
        factory: whose vehicles are asked.
    """

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        """See `Listener`.

        Raises:
            InvariantBroken: two vehicles hold one place.
        """
        if type(message) is PlaceWished or type(message) is PlaceGranted:
            self.check(at_s)

    def check(self, at_s: float) -> None:
        """Look now.

        Raises:
            InvariantBroken: two vehicles hold one place.
        """
        holders: dict[str, str] = {}
        for atv in self._factory.vehicles:
            if atv in self._factory.floor.carried:
                continue
            agent = self._factory.workers[atv].agent
            right_of_way = agent.right_of_way if type(agent) is Atv else None
            for place in right_of_way.holds if right_of_way is not None else ():
                other = holders.setdefault(place, atv)
                if other != atv:
                    raise InvariantBroken(NUMBER, at_s, f"{other} and {atv} both hold {place}")
