"""The controller of a simulated storage: what it shows, and what it does of what it is told."""

from __future__ import annotations

import pytest
from controller_stand import ControllerStand
from yard import PLANT

from dray.adapters.signals.signal import LEVEL, Signal
from dray_sim.bodies.docks import SHUT
from dray_sim.bodies.stores import REFILL_S, Storage
from dray_sim.controllers.store import StoreController

SHAFTS = LEVEL + "shaft"


class Stand(ControllerStand[StoreController]):
    """A storage of 60 shafts."""

    def __init__(self, parts: tuple[str, ...] = ()) -> None:
        super().__init__()
        spec, clock = PLANT.storages["S1"], self.yard.clock
        self.storage = Storage(spec, clock, self.yard.source, stock={"shaft": 60}, parts=parts)
        self.controller = StoreController(self.storage, clock, self.on_told)


@pytest.fixture
def stand() -> Stand:
    return Stand()


def test_it_begins_with_a_shut_dock_and_shows_what_lies_there(stand: Stand) -> None:
    assert stand.controller.shows == {Signal.DOCK_READY: False, SHAFTS: 60, LEVEL + "seal": 15}
    assert stand.wait(10.0) == []


def test_the_dock_opens_for_one_vehicle_and_the_scale_shows_what_it_takes(stand: Stand) -> None:
    stand.tell(dock_permit=True)
    assert stand.wait(20.0) == []
    stand.tell(dock_vehicle="ATV1")
    assert stand.storage.take("ATV1", "shaft", 20) == SHUT
    assert stand.wait(10.0) == [(Signal.DOCK_READY, True)]
    assert stand.storage.take("ATV2", "shaft", 20) == SHUT
    assert stand.storage.take("ATV1", "shaft", 20) == ""
    assert stand.wait(1.0) == [(SHAFTS, 40)]
    stand.tell(dock_vehicle="ATV2")
    assert stand.wait(10.0) == [(Signal.DOCK_READY, False), (Signal.DOCK_READY, True)]
    stand.tell(dock_permit=False, dock_vehicle="")
    assert stand.wait(10.0) == [(Signal.DOCK_READY, False)]


def test_whatever_is_taken_is_filled_up_again(stand: Stand) -> None:
    """Nobody tells a controller that more is asked for than lies there."""
    stand.storage.take("", "shaft", 5)
    assert stand.wait(REFILL_S - 1.0) == [(SHAFTS, 55)]
    assert stand.wait(2.0) == [(SHAFTS, 60)]


def test_parts_are_not_filled_up() -> None:
    stand = Stand(parts=("shaft",))
    stand.storage.take("", "shaft", 60)
    assert stand.wait(2 * REFILL_S) == [(SHAFTS, 0)]
