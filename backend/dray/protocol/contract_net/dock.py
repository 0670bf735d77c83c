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


NOT_READY = "the dock is not ready yet"
"""To a vehicle, while whoever makes the dock safe has not said that it is."""


class Door:
    """The door of one dock.

    Args:
        out: where effects go.

    Attributes:
        answers: whether the body says when it has opened (`dray.body.WorkcellState`); else it is open as soon as it is told to.
    """

    def __init__(self, out: list[Effect]) -> None:
        self._out = out
        self._asked: dict[str, Docked] = {}
        """By vehicle, what it has asked for and waits to be opened."""
        self.answers = False

    def open(self, vehicle: str, asked: Docked, item: str, quantity: int) -> None:
        """Let a vehicle that stands here load or unload, once; it waits where the body has to make the dock ready for it."""
        self._out.append(Instruct(OpenDock(vehicle=vehicle, item=item, quantity=quantity)))
        if self.answers:
            self._asked[vehicle] = asked
            self.hold(vehicle, asked, NOT_READY)
        else:
            self.agree(vehicle, asked)

    def is_opening(self, vehicle: str) -> bool:
        """Whether a vehicle waits for the body to open."""
        return vehicle in self._asked

    def on_ready(self, vehicle: str) -> bool:
        """The body has opened the dock for a vehicle; whether that has waited for it here."""
        asked = self._asked.pop(vehicle, None)
        if asked is not None:
            self.agree(vehicle, asked)
        return asked is not None

    def agree(self, vehicle: str, asked: Docked) -> None:
        """Tell a vehicle that it may load or unload, without opening a dock: it is not this agent's."""
        self._out.append(Send(vehicle, DockOpened(task=asked.task, epoch=asked.epoch, station=asked.station)))

    def hold(self, vehicle: str, asked: Docked, reason: str) -> None:
        """Let it wait."""
        held = DockHeld(task=asked.task, epoch=asked.epoch, station=asked.station, reason=reason)
        self._out.append(Send(vehicle, held))

    def shut(self, vehicle: str) -> None:
        """End a transfer that this vehicle has begun, without effect."""
        self._asked.pop(vehicle, None)
        # Also when this life has not opened it: an earlier one may have.
        self._out.append(Instruct(CloseDock(vehicle=vehicle)))
