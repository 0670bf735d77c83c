"""Porters: people of a simulated factory who carry vehicles as a person on a panel says.

The person on the panel has no hands on this floor. So the porters lift the vehicle once the agents believe the
report. When a place is kept for it they put it down there and switch it on. A vehicle that was switched off as a
fault stays off until that fault ends.
"""

from __future__ import annotations

from dray.messages import Event, Message, Removal, Removals
from dray.messages.fact import PlaceKept, PlacesFreed
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults
from dray_sim.people.floor_office import NAME as FLOOR_OFFICE

NAME = "porters"
"""Their name on the bus."""


class Porters:
    """The porters of one factory; they join its network at once.

    Args:
        factory: whose vehicles they carry.
        faults: show which vehicles were switched off by others.
    """

    def __init__(self, factory: SimFactory, faults: Faults) -> None:
        self._factory, self._faults = factory, faults
        self._said: dict[str, Removal] = {}
        """Vehicle -> the newest word about it."""
        self._session = factory.bus.join(NAME, self._on_message)
        self._session.subscribe(factory.keys.removals)
        self._session.subscribe(factory.keys.all_events)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, Removals):
            for removal in message.removals:
                self._hear(removal)
        elif isinstance(message, Event):
            if isinstance(message.fact, PlacesFreed):
                self._lift(message.fact)
            elif isinstance(message.fact, PlaceKept):
                self._put_down(message.fact)

    def _hear(self, removal: Removal) -> None:
        # People who speak through the floor office carry vehicles themselves.
        if removal.grant.person == FLOOR_OFFICE or removal.atv not in self._factory.vehicles:
            return
        last = self._said.get(removal.atv)
        if last is None or removal.number > last.number:
            self._said[removal.atv] = removal

    def _lift(self, freed: PlacesFreed) -> None:
        """Lift a vehicle whose places are free after a long silence."""
        removal = self._said.get(freed.atv)
        if removal is None or removal.number != freed.number or removal.node:
            return
        self._factory.power_off(freed.atv)
        self._factory.floor.lift(freed.atv)

    def _put_down(self, kept: PlaceKept) -> None:
        removal, floor = self._said.get(kept.atv), self._factory.floor
        if removal is None or removal.number != kept.number or kept.atv not in floor.lifted:
            return
        floor.put_down(kept.atv, removal.node)
        self._faults.switch_on(kept.atv)
