"""What work costs who bids for it: parts in seconds, so that they add up and can be compared (paper, 4.1)."""

from __future__ import annotations

from dray.messages.base import Part, Seconds


class TransportCost(Part, tag_field="kind", tag="transport", frozen=True):
    """The parts of a vehicle's price, all in seconds so that they add up (paper, 4.1)."""

    empty_way_s: Seconds
    """Driving to the source."""
    loaded_way_s: Seconds
    """Driving from the source to the destination."""
    energy_s: Seconds
    """Energy used, and how little is left after it, weighed as seconds."""
    suitability_s: Seconds
    """What it costs the plant that this vehicle could do rarer work meanwhile."""
    waiting_s: Seconds = 0.0
    """Waiting where it loads and unloads, as was seen there lately."""

    @property
    def total_s(self) -> float:
        return self.empty_way_s + self.loaded_way_s + self.energy_s + self.suitability_s + self.waiting_s


class ProductionCost(Part, tag_field="kind", tag="production", frozen=True):
    """The parts of a machine's price for a goal, in seconds."""

    queue_s: Seconds
    """Goals taken before that are wanted before it."""
    material_s: Seconds
    """Waiting for material that is not in the buffers yet."""
    making_s: Seconds
    """Cycles."""
    passed_s: Seconds = 0.0
    """Work that is wanted later and would have to wait, weighed: a price, and no time until it is done."""
    rest_s: Seconds = 0.0
    """Rests of the machine until it is done, by its working time."""

    @property
    def takes_s(self) -> float:
        """From now until it is done."""
        return self.queue_s + self.material_s + self.making_s + self.rest_s

    @property
    def total_s(self) -> float:
        return self.takes_s + self.passed_s


Cost = TransportCost | ProductionCost
