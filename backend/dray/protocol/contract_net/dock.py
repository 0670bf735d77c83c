"""Docks: where vehicles stand at the places of a transport, and the door that opens for one vehicle and one load.

Who may load or unload is for the dock's owner to know: whoever receives a load asks its contracts
(`transports.dock`), whoever gives one its reservations (`transports.issuing`).
"""

from __future__ import annotations

from dray.body import CloseDock, OpenDock
from dray.messages import Docked, DockHeld, DockOpened, Transport
from dray.plant import Plant
from dray.protocol.runtime.events import Effect, Instruct, Send


def dock_of(plant: Plant, work: Transport, place: str) -> str:
    """The node where vehicles dock at a source or at the destination of a transport.

    Args:
        plant: as the plant file has it.
        work: the transport; one of a joining machine tells where that stands.
        place: a place of it.

    Returns:
        A node; empty when nobody knows the place.
    """
    if plant.has_place(place):
        return plant.node_of(place)
    return place if place == work.handed_at else work.node


class Door:
    """The door of one dock.

    Args:
        out: where effects go.
    """

    def __init__(self, out: list[Effect]) -> None:
        self._out = out

    def open(self, vehicle: str, asked: Docked, item: str, quantity: int) -> None:
        """Let a vehicle that stands here load or unload, once."""
        self._out.append(Instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity)))
        self.agree(vehicle, asked)

    def agree(self, vehicle: str, asked: Docked) -> None:
        """Tell a vehicle that it may load or unload, without opening a dock: it is not this agent's."""
        self._out.append(Send(vehicle, DockOpened(task=asked.task, epoch=asked.epoch, station=asked.station)))

    def hold(self, vehicle: str, asked: Docked, reason: str) -> None:
        """Let it wait."""
        held = DockHeld(task=asked.task, epoch=asked.epoch, station=asked.station, reason=reason)
        self._out.append(Send(vehicle, held))

    def shut(self, vehicle: str) -> None:
        """End a transfer that this vehicle has begun, without effect."""
        # Also when this life has not opened it: an earlier one may have.
        self._out.append(Instruct(CloseDock(vehicle=vehicle)))
