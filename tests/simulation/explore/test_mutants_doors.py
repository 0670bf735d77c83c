"""The search finds doors that shut on vehicles, and vehicles that drive into doors; see `test_mutants`."""

from __future__ import annotations

import pytest
from mutants import Find, Mutant

from dray_sim.bodies.doors import Doors, DoorState, _Door
from dray_sim.bodies.vehicle.travel import Travel
from dray_sim.explore.run import draw


def with_doors_that_shut_on_vehicles(patch: pytest.MonkeyPatch) -> None:
    """A door shuts its time after it has opened, whoever is in it."""
    opened = Doors._opened

    def open_for_a_while(self: Doors, door: _Door) -> None:
        opened(self, door)
        if door.state is DoorState.OPEN:
            self._call(door, 3.0, lambda each: setattr(each, "state", DoorState.SHUT))

    patch.setattr(Doors, "_opened", open_for_a_while)


def with_bodies_that_see_no_door(patch: pytest.MonkeyPatch) -> None:
    """A body drives on, whether the door before it is open or not."""
    patch.setattr(Travel, "_is_shut", lambda *_: False)


@pytest.mark.campaign
@pytest.mark.parametrize("mutant", [with_doors_that_shut_on_vehicles, with_bodies_that_see_no_door])
def test_the_search_finds_a_mutant_of_doors(mutant: Mutant, find: Find) -> None:
    find(mutant, lambda seed: draw(seed, "doors-alone"), 0, "invariant 20")
