"""Offers that no contractor could keep, whichever it is. Pure arithmetic over the plant.

A coordinator does not know where a bidder stands, but it knows the plant, and no vehicle is faster than the
fastest. The rules for a transport:

    loaded way  >= crow flies from source to destination / top speed of the fastest
    done        >= now + that + the shortest loading and unloading
    no part of a price is negative, and every number is finite
    done        <= now + the durations in its price, and LATE_S; a goal: within LATEST_GOAL_S
    the source is one of the announced ones

A promise beyond the longest way of the plant is not believed: it would buy time with words. That way leads from the
farthest node to the source and on to the destination, by the slowest suitable vehicle.

Every time comes from some clock. A bid, an acceptance and a takeover carry the time they were sent, by the same
clock. The receiver sees a slightly wrong clock and corrects the promise:

    ahead_s = at_s - now           0 within a link's delay, and CLOCKS_AGREE_S
    finish  = finish_s - ahead_s

From CLOCK_WRONG_S on nothing by that clock is believed: it is reported, and people correct it. Ways are straight
lines, because the bidder's plant file may have lanes that this one lacks.
"""

from __future__ import annotations

from math import hypot, isfinite
from typing import TypeVar

import msgspec

from dray.errors import NoWay
from dray.messages import Accepted, Bid, Implausible, Production, TakenOver, Transport, TransportCost, Work
from dray.messages.base import CLOCK_WRONG_S, CLOCKS_AGREE_S
from dray.plant import Plant
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.contract_net.waits import WAIT_MAX_S
from dray.protocol.liveness.suspicion import LATENESS_MAX_S

UNDER_WAY_S = LATENESS_MAX_S + CLOCKS_AGREE_S
"""Maximum age of an arriving bid (s)."""

LATE_S = 1800.0
"""Slack beyond a bid's ways and queues (s): docks, people, and other causes that it may know."""

LATEST_GOAL_S = 30 * 86_400.0
"""Maximum time of a goal (s): a machine with work for a month takes no more."""

ROUNDING_S = 0.01
"""Tolerance for rounding (s): two agents may add the same lengths in different orders."""

LOOSE_FRAC = 1.5
"""Maximum promise as a multiple of the bid's ways: the vehicle has driven on since."""

LOOSE_S = 30.0
"""Slack added to that (s): a turn, or a lane to finish first."""

DIAMETERS = 3.0
"""Minimum believed length of a transport's ways in floor diagonals, whichever lanes this plant file has."""

S = TypeVar("S", Bid, Accepted, TakenOver)


def clock_ahead_s(at_s: float | None, now_s: float) -> float:
    """How far a sender's clock is ahead (s), negative if behind; 0 within the possible link delay.

    Args:
        at_s: send time by that clock; None if unknown.
        now_s: the present time.
    """
    if at_s is None or now_s - UNDER_WAY_S <= at_s <= now_s + CLOCKS_AGREE_S:
        return 0.0
    return at_s - now_s


def by_our_clock(said: S, now_s: float) -> S:
    """The message with its times by our clock; unchanged if its clock is too wrong."""
    ahead_s = clock_ahead_s(said.at_s, now_s)
    if not ahead_s or abs(ahead_s) > CLOCK_WRONG_S:
        return said
    return msgspec.structs.replace(said, finish_s=said.finish_s - ahead_s, at_s=now_s)


def is_clock_wrong(said: Bid | Accepted | TakenOver, now_s: float) -> bool:
    """Whether the sender's clock is too wrong to correct."""
    return abs(clock_ahead_s(said.at_s, now_s)) > CLOCK_WRONG_S


class Plausibility:
    """The plausible limits of contractors in one plant.

    Args:
        plant: its places and vehicle types.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        kinds = tuple(plant.vehicle_types.values())
        self._top_mps = max((kind.max_speed_mps for kind in kinds), default=1.0)
        self._handling_s = min((kind.load_s + kind.unload_s for kind in kinds), default=0.0)
        self.handling_max_s = max((max(kind.load_s, kind.unload_s) for kind in kinds), default=0.0)
        """The longest loading or unloading (s)."""
        slowest_mps = min((kind.max_speed_mps for kind in kinds), default=1.0)
        self._floor_s = DIAMETERS * plant.diameter_m / slowest_mps + 2.0 * self.handling_max_s

    def objection(self, work: Work, bid: Bid, now_s: float) -> Implausible | None:
        """Why a bid is implausible; None if it is plausible.

        Args:
            work: the announced work.
            bid: by our clock if possible (`by_our_clock`).
            now_s: the present time.
        """
        if is_clock_wrong(bid, now_s):
            return Implausible.CLOCK
        cost = bid.cost
        if isinstance(cost, TransportCost) is not isinstance(work, Transport):
            return Implausible.OTHER_WORK
        parts = _parts_s(bid)
        if not all(map(isfinite, (*parts, bid.finish_s))):
            return Implausible.NOT_A_NUMBER
        if min(parts) < 0.0:
            return Implausible.NEGATIVE
        if bid.finish_s < now_s - UNDER_WAY_S:
            return Implausible.BEFORE_NOW
        if isinstance(cost, TransportCost) and (said := self._transport_objection(work, bid, cost, now_s)):
            return said
        told_s = LOOSE_FRAC * sum(parts) + 2.0 * self.handling_max_s + LATE_S
        latest_s = told_s if isinstance(cost, TransportCost) else LATEST_GOAL_S
        return Implausible.TOO_LATE if bid.finish_s > now_s + latest_s else None

    def longest_s(self, work: Work) -> float:
        """Maximum duration of a transport from any vehicle position and any of its sources (s)."""
        longest_s = self._floor_s
        if not isinstance(work, Transport):
            return longest_s
        there = dock_of(self._plant, work, work.destination)
        for kind, vehicle in self._plant.vehicle_types.items():
            if not all(ability in vehicle.abilities for ability in work.needed):
                continue
            routes = self._plant.routes(kind)
            for source in work.sources:
                here = dock_of(self._plant, work, source)
                try:
                    ways_s = routes.farthest_s(here) + routes.duration_s(here, there)
                except NoWay:
                    continue  # The bidder's plant file may know a way, or only one side knows of a closure.
                longest_s = max(longest_s, LOOSE_FRAC * ways_s + 2.0 * self.handling_max_s)
        return longest_s

    def believed_s(self, work: Work, bid: Bid | None, promised_s: float, now_s: float) -> float:
        """Credible finish time of a contractor that has promised `promised_s`.

        Args:
            work: the promised work.
            bid: its fresh bid; None if it is old or missing.
            promised_s: finish time promised with the contract (plant clock).
            now_s: the present time.
        """
        span_s = self.longest_s(work)
        if bid is not None and isinstance(bid.cost, TransportCost):
            ways_s = bid.cost.empty_way_s + bid.cost.loaded_way_s
            span_s = min(span_s, LOOSE_FRAC * ways_s + 2.0 * self.handling_max_s + LOOSE_S)
            # The bidder pays for waiting with its price; an endless wait is not believed.
            span_s += min(bid.cost.waiting_s, WAIT_MAX_S)
        elif bid is not None:
            span_s = LOOSE_FRAC * bid.cost.total_s + LOOSE_S
        return min(max(promised_s, now_s), now_s + span_s)

    def _transport_objection(
        self, work: Work, bid: Bid, cost: TransportCost, now_s: float
    ) -> Implausible | None:
        if isinstance(work, Production) or (bid.source and bid.source not in work.sources):
            return Implausible.OTHER_SOURCE
        least_s = min(self._way_s(work, source) for source in ((bid.source,) if bid.source else work.sources))
        if cost.loaded_way_s < least_s - ROUNDING_S:
            return Implausible.TOO_CHEAP
        takes_s = cost.empty_way_s + least_s + self._handling_s
        if bid.finish_s < now_s + takes_s - UNDER_WAY_S:
            return Implausible.TOO_SOON
        return None

    def _way_s(self, work: Transport, source: str) -> float:
        """Duration of the loaded way in a straight line at the fastest vehicle's top speed (s); 0 if a node is unknown."""
        nodes = self._plant.nodes
        here, there = (nodes.get(dock_of(self._plant, work, place)) for place in (source, work.destination))
        if here is None or there is None:
            return 0.0
        return hypot(there.x_m - here.x_m, there.y_m - here.y_m) / self._top_mps


def _parts_s(bid: Bid) -> tuple[float, ...]:
    cost = bid.cost
    if isinstance(cost, TransportCost):
        return cost.empty_way_s, cost.loaded_way_s, cost.energy_s, cost.suitability_s, cost.waiting_s
    return cost.queue_s, cost.material_s, cost.making_s, cost.passed_s, cost.rest_s
