"""The machine LATHE1 of the plant `levels`, where a cart fetches shafts for PRESS1."""

from __future__ import annotations

from effects import instructed, sent
from rigs import BlindRig, MachineRig

from dray.body import DockReady, OpenDock
from dray.messages import Docked, DockOpened, StockAsked, StockReserved
from dray.plant.file.file import shipped_plant

LEVELS = shipped_plant("levels")
CART, TASK = "CART1", "PRESS1-1"
SIX_SHAFTS = Docked(TASK, 1, "LATHE1", "shaft", 6)
"""The cart's request at the dock."""


def lathe(kind: type[MachineRig] = BlindRig, *, incarnation: int = 1) -> MachineRig:
    """LATHE1 with 12 shafts that no goal of its own wants. Its agent has not started."""
    return kind("LATHE1", {"bar": 60, "shaft": 12}, plant=LEVELS, incarnation=incarnation)


def at_the_dock(rig: MachineRig | None = None, *, cart: str = CART) -> MachineRig:
    """A cart asks at the dock for six shafts for PRESS1; it may load, unless the dock takes time to open."""
    rig = rig or lathe()
    rig.start()
    assert sent(rig.on_message("PRESS1", StockAsked(TASK, 1, "shaft", 6)), StockReserved)
    assert instructed(rig.on_message(cart, SIX_SHAFTS), OpenDock)
    return rig


def before_a_shut_dock(*, cart: str = CART) -> MachineRig:
    """A cart stands before the dock, which the body has not opened yet."""
    rig = lathe()
    rig.answers = True
    return at_the_dock(rig, cart=cart)


def opens(rig: MachineRig, cart: str = CART) -> None:
    """The body has opened the dock."""
    assert sent(rig.report(DockReady(vehicle=cart)), DockOpened, to=cart)
