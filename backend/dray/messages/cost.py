"""The cost of work to a bidder: parts in seconds, so that they add up and can be compared (paper, 4.1)."""

from __future__ import annotations

from dray.messages.base import Part, Seconds


class TransportCost(Part, tag_field="kind", tag="transport", frozen=True):
    """The parts of a vehicle's price (paper, 4.1)."""

    empty_way_s: Seconds
    """Driving to the source."""
    loaded_way_s: Seconds
    """Driving from the source to the destination."""
    energy_s: Seconds
    """Energy used, and a low battery level afterwards, weighed as seconds."""
    suitability_s: Seconds
    """Cost to the plant, as this vehicle could do rarer work meanwhile."""
    waiting_s: Seconds = 0.0
    """Waiting at the source and the destination, by recent waits there."""

    @property
    def total_s(self) -> float:
        return self.empty_way_s + self.loaded_way_s + self.energy_s + self.suitability_s + self.waiting_s


class ProductionCost(Part, tag_field="kind", tag="production", frozen=True):
    """The parts of a machine's price for a goal, in seconds."""

    queue_s: Seconds
    """Goals taken earlier that are due before it."""
    material_s: Seconds
    """Waiting for material that is not in the buffers yet."""
    making_s: Seconds
    """Its cycles."""
    passed_s: Seconds = 0.0
    """Price for later work that would have to wait, weighed; it adds no time until the goal is done."""
    rest_s: Seconds = 0.0
    """Rests of the machine until then, by its working time."""

    @property
    def takes_s(self) -> float:
        """Time from now until it is done."""
        return self.queue_s + self.material_s + self.making_s + self.rest_s

    @property
    def total_s(self) -> float:
        return self.takes_s + self.passed_s


Cost = TransportCost | ProductionCost
