"""What cannot be: offers that no contractor could keep, whoever makes them. Pure arithmetic over the plant.

A coordinator does not know where a bidder stands, but it knows the plant, and no vehicle is faster than the
fastest. So for a transport

    loaded way  >= crow flies from source to destination / top speed of the fastest
    done        >= now + that + the shortest loading and unloading
    no part of a price is negative, and nothing is not a number
    the source is one of those that were asked for

and what a contractor promises beyond the longest way of the plant is not believed: it would buy time with words.
Ways are taken as the crow flies, for the plant file of the bidder may know lanes that this one does not.
"""

from __future__ import annotations

from math import hypot, isfinite

from dray.messages import Bid, Production, Transport, TransportCost, Work
from dray.plant import Plant
from dray.protocol.docks import dock_of
from dray.protocol.suspicion import LATENESS_MAX_S
from dray.protocol.waits import WAIT_MAX_S

CLOCKS_S = 1.0
"""Clocks of the plant agree within this."""

UNDER_WAY_S = LATENESS_MAX_S + CLOCKS_S
"""A bid that comes now may have been made so long ago."""

ROUNDING_S = 0.01
"""Two agents add the same lengths in another order."""

LOOSE_FRAC = 1.5
"""A promise may be so many times what the bid has told of its ways: the vehicle has driven on since."""

LOOSE_S = 30.0
"""And so much more than that: a turn, a lane that was to be finished first."""

DIAMETERS = 3.0
"""No way of a transport is believed to be longer than so many diagonals of the floor: there, and around the blocks."""

NOT_A_NUMBER = "a bid that is not a number"
NEGATIVE = "a bid with a negative part"
OTHER_WORK = "a bid for another kind of work"
OTHER_SOURCE = "a bid with a source that was not asked for"
TOO_CHEAP = "a bid below the way as the crow flies"
TOO_SOON = "a bid that would be done sooner than any vehicle could"
BEFORE_NOW = "a bid that would be done in the past"


class Plausibility:
    """What contractors of one plant could do at best, and at worst.

    Args:
        plant: its places, and its types of vehicles.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        kinds = tuple(plant.vehicle_types.values())
        self._top_mps = max((kind.max_speed_mps for kind in kinds), default=1.0)
        self._handling_s = min((kind.load_s + kind.unload_s for kind in kinds), default=0.0)
        self.handling_max_s = max((max(kind.load_s, kind.unload_s) for kind in kinds), default=0.0)
        """The longest loading or unloading."""
        slowest_mps = min((kind.max_speed_mps for kind in kinds), default=1.0)
        self.longest_s = DIAMETERS * plant.diameter_m / slowest_mps + 2.0 * self.handling_max_s
        """No transport takes longer, from wherever its vehicle is."""

    def objection(self, work: Work, bid: Bid, now_s: float) -> str:
        """Why a bid cannot be true; empty when it can. The reasons are few and fixed."""
        cost = bid.cost
        if isinstance(cost, TransportCost) is not isinstance(work, Transport):
            return OTHER_WORK
        parts = _parts_s(bid)
        if not all(map(isfinite, (*parts, bid.finish_s))):
            return NOT_A_NUMBER
        if min(parts) < 0.0:
            return NEGATIVE
        if bid.finish_s < now_s - UNDER_WAY_S:
            return BEFORE_NOW
        return self._transport_objection(work, bid, cost, now_s) if isinstance(cost, TransportCost) else ""

    def believed_s(self, bid: Bid | None, promised_s: float, now_s: float) -> float:
        """Until when a contractor is believed to be done, which has promised to be by `promised_s`.

        Args:
            bid: what it has bid just now; None when that is long ago, or nobody has.
            promised_s: its word with the contract (plant clock).
            now_s: the present time.
        """
        span_s = self.longest_s
        if bid is not None and isinstance(bid.cost, TransportCost):
            ways_s = bid.cost.empty_way_s + bid.cost.loaded_way_s
            span_s = min(span_s, LOOSE_FRAC * ways_s + 2.0 * self.handling_max_s + LOOSE_S)
            # It pays for that with its price; and nobody is believed to wait for ever.
            span_s += min(bid.cost.waiting_s, WAIT_MAX_S)
        return min(max(promised_s, now_s), now_s + span_s)

    def _transport_objection(self, work: Work, bid: Bid, cost: TransportCost, now_s: float) -> str:
        if isinstance(work, Production) or (bid.source and bid.source not in work.sources):
            return OTHER_SOURCE
        least_s = min(self._way_s(work, source) for source in ((bid.source,) if bid.source else work.sources))
        if cost.loaded_way_s < least_s - ROUNDING_S:
            return TOO_CHEAP
        takes_s = cost.empty_way_s + least_s + self._handling_s
        if bid.finish_s < now_s + takes_s - UNDER_WAY_S:
            return TOO_SOON
        return ""

    def _way_s(self, work: Transport, source: str) -> float:
        """The loaded way as the crow flies at the fastest vehicle's top speed; 0 where somebody is not known."""
        nodes = self._plant.nodes
        here, there = (nodes.get(dock_of(self._plant, work, place)) for place in (source, work.destination))
        if here is None or there is None:
            return 0.0
        return hypot(there.x_m - here.x_m, there.y_m - here.y_m) / self._top_mps


def _parts_s(bid: Bid) -> tuple[float, ...]:
    cost = bid.cost
    if isinstance(cost, TransportCost):
        return cost.empty_way_s, cost.loaded_way_s, cost.energy_s, cost.suitability_s, cost.waiting_s
    return cost.queue_s, cost.material_s, cost.making_s
