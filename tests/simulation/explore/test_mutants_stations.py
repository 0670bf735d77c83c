"""The search finds a storage that counts a refill twice, or orders one twice; see `test_mutants`."""

from __future__ import annotations

import pytest
from mutants import Find, Mutant

from dray.body import StockChanged
from dray.protocol.station.refilling import Refilling
from dray.protocol.station.station import Station
from dray_sim.explore.run import draw


def that_counts_a_refill_twice(patch: pytest.MonkeyPatch) -> None:
    """A station takes what a vehicle has put down into its books as its body tells it, once more for the transport, and looks no more."""
    changed = Station._stock_changed

    def count(self: Station, report: StockChanged, now_s: float) -> None:
        if report.change > 0 and report.vehicle:
            self._book._level[report.item] += report.change
        changed(self, report, now_s)

    patch.setattr(Station, "_stock_changed", count)
    patch.setattr(Station, "_sense", lambda _self, _body, _now_s: None)


def that_forgets_what_is_carried(patch: pytest.MonkeyPatch) -> None:
    """A station knows what it is to be given by a warehouse, and not what a vehicle has a contract for."""
    missing = Refilling._missing

    def look(self: Refilling, item: str) -> int:
        flow = self._flow
        wanted = [need.work for need in flow.sourcing]  # type: ignore[attr-defined]
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(flow, "inbound", lambda of: sum(w.quantity for w in wanted if w.item == of))
            return missing(self, item)

    patch.setattr(Refilling, "_missing", look)


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("mutant", "finding"),
    [
        pytest.param(that_counts_a_refill_twice, "invariant 28", id="counted-twice"),
        pytest.param(that_forgets_what_is_carried, "invariant 28", id="ordered-twice"),
    ],
)
def test_the_search_finds_a_mutant_of_a_station(mutant: Mutant, finding: str, find: Find) -> None:
    find(mutant, lambda seed: draw(seed, "stations-alone"), 0, finding)
