"""Invariant 24: a storage that is open for two carriers of one task at a time is noticed, and no other is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from dray.messages import Docked, DockOpened
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.one_carrier import OneCarrierAtATime
from dray_sim.factory.sim_factory import SimFactory

TASK = "M3-2"


class Storage:
    """S1, whose dock is open for some vehicles."""

    def __init__(self) -> None:
        self.opened: tuple[str, ...] = ()
        body = SimpleNamespace(sense=lambda: SimpleNamespace(opened=self.opened))
        floor = SimpleNamespace(storages={"S1": body})
        self._check = OneCarrierAtATime(cast(SimFactory, SimpleNamespace(floor=floor)))

    def asks(self, vehicle: str, task: str, *, returns: bool = False) -> None:
        asked = Docked(task=task, epoch=1, station="S1", item="bearing", quantity=12, returns=returns)
        self._check.on_message(0.0, vehicle, ">S1", asked)

    def opens(self, vehicle: str, task: str, *but: str) -> None:
        """It opens for a vehicle, and is open for others still."""
        self.opened = (*but, vehicle)
        self._check.on_message(0.0, "S1", f">{vehicle}", DockOpened(task=task, epoch=1, station="S1"))


def test_two_carriers_that_may_fetch_one_load_are_noticed() -> None:
    storage = Storage()
    for vehicle in ("ATV2", "ATV3"):
        storage.asks(vehicle, TASK)
    storage.opens("ATV2", TASK)
    with pytest.raises(InvariantBroken, match="S1 is open for ATV3 and for ATV2 to fetch the load of M3-2"):
        storage.opens("ATV3", TASK, "ATV2")


def test_one_that_brings_its_load_back_does_not_fetch_it() -> None:
    storage = Storage()
    storage.asks("ATV2", TASK)
    storage.opens("ATV2", TASK)
    storage.asks("ATV2", "ATV2-found-501", returns=True)
    storage.opens("ATV2", "ATV2-found-501")
    storage.asks("ATV3", TASK)
    storage.opens("ATV3", TASK, "ATV2")
