"""The Contract Net: what is said from the announcement of a task to its handover (paper, 4.1).

A *task* is work that a *coordinator* gives out: a machine its transports, the strategist the
production goals. Both speak the same language; only `work` and `cost` differ. `epoch` counts the
carriers of a task: it rises whenever the carrier changes, and the highest one is right.
"""

from __future__ import annotations

from enum import StrEnum

from dray.messages.base import Message, Part
from dray.messages.heartbeat import Role


class Transport(Part, tag_field="kind", tag="transport", frozen=True):
    """Carry `quantity` pieces of `item` from one of `sources` to `destination`."""

    item: str
    """A material on the way in, a product on the way out."""
    quantity: int
    sources: tuple[str, ...]
    """Stations to choose from; never empty."""
    destination: str
    """A station: a machine on the way in, a delivery warehouse on the way out."""
    ability: str
    """What a vehicle must be able to carry."""
    goal: str = ""
    """The goal whose products these are, on the way out."""


class Production(Part, tag_field="kind", tag="production", frozen=True):
    """Make `quantity` pieces of `product` for one item of an order."""

    product: str
    quantity: int
    order: str
    item: int
    """The index of the order's item."""


Work = Transport | Production


class TransportCost(Part, tag_field="kind", tag="transport", frozen=True):
    """The parts of a vehicle's price, all in seconds so that they add up (paper, 4.1)."""

    empty_way_s: float
    """Driving to the source."""
    loaded_way_s: float
    """Driving from the source to the destination."""
    energy_s: float
    """Energy used, and how little is left after it, weighed as seconds."""
    suitability_s: float
    """What it costs the plant that this vehicle could do rarer work meanwhile."""

    @property
    def total_s(self) -> float:
        return self.empty_way_s + self.loaded_way_s + self.energy_s + self.suitability_s


class ProductionCost(Part, tag_field="kind", tag="production", frozen=True):
    """The parts of a machine's price for a goal, in seconds."""

    queue_s: float
    """Goals taken before."""
    material_s: float
    """Waiting for material that is not in the buffers yet."""
    making_s: float
    """Cycles."""

    @property
    def total_s(self) -> float:
        return self.queue_s + self.material_s + self.making_s


Cost = TransportCost | ProductionCost


class TaskAnnounced(Message, frozen=True):
    """A coordinator asks for bids. Published to everybody within the radius."""

    task: str
    epoch: int
    """The epoch that the winner will carry."""
    role: Role
    """PRIMARY, or SECONDARY when a watch is to be elected anew."""
    coordinator: str
    work: Work
    deadline_s: float
    """When the work should be done (plant clock)."""
    x_m: float = 0.0
    y_m: float = 0.0
    """The middle of the circle in which vehicles are asked: the coordinator's place."""
    radius_m: float = 0.0
    round: int = 1
    bids_until_s: float = 0.0
    """When the bidding window closes (plant clock)."""
    primary: str = ""
    """Whom to watch, when a SECONDARY is sought; that vehicle does not bid."""


class Bid(Message, frozen=True):
    """A contractor's price, sent straight to the coordinator."""

    task: str
    epoch: int
    role: Role
    round: int
    cost: Cost
    finish_s: float
    """When it promises to be done (plant clock)."""
    source: str = ""
    """The source it would fetch from."""


class Award(Message, frozen=True):
    """The coordinator asks one bidder to take the contract."""

    task: str
    epoch: int
    role: Role
    work: Work
    deadline_s: float
    source: str = ""
    primary: str = ""
    """Whom to watch, when the role is SECONDARY."""


class Refusal(StrEnum):
    """Why a contractor does not bid, or declines an award."""

    BUSY = "busy"
    """Taken by another coordinator meanwhile."""
    WATCHING_ENOUGH = "watching_enough"
    ABILITY = "ability"
    BATTERY = "battery"
    """Could not keep its promise and reach a charger after it."""
    DEADLINE = "deadline"
    OUT_OF_RADIUS = "out_of_radius"
    NO_WAY = "no_way"
    NOT_FIT = "not_fit"
    """Stopped, in error or on the radio mesh."""
    IS_PRIMARY = "is_primary"
    """Asked to watch itself."""


class Accepted(Message, frozen=True):
    """The contract stands."""

    task: str
    epoch: int
    role: Role
    finish_s: float = 0.0


class Declined(Message, frozen=True):
    """Not available any more; the coordinator asks the next one."""

    task: str
    epoch: int
    role: Role
    reason: Refusal


class Release(Message, frozen=True):
    """The coordinator lets a contractor go; whoever is not bound ignores it."""

    task: str
    epoch: int
    role: Role
    reason: str


class Resigned(Message, frozen=True):
    """A contractor gives the contract back."""

    task: str
    epoch: int
    role: Role
    reason: str


class TakenOver(Message, frozen=True):
    """A secondary has become the carrier, with a higher epoch."""

    task: str
    epoch: int
    primary: str
    """Whom it replaces."""


class Docked(Message, frozen=True):
    """A carrier stands at the source or the destination and asks to load or to unload.

    Every transfer asks first: this is where the epoch fences. A load that nobody waits for any
    more never reaches a buffer.
    """

    task: str
    epoch: int
    station: str


class DockOpened(Message, frozen=True):
    """Load or unload now."""

    task: str
    epoch: int
    station: str


class DockHeld(Message, frozen=True):
    """Wait: the right vehicle at the right place, but there is no room or nothing to fetch yet."""

    task: str
    epoch: int
    station: str
    reason: str


class Handover(Message, frozen=True):
    """The load is down. Repeated until it is answered; handing over twice is harmless."""

    task: str
    epoch: int
    quantity: int


class HandoverAccepted(Message, frozen=True):
    """The task is done; the vehicle is free."""

    task: str
    epoch: int


class Superseded(Message, frozen=True):
    """Somebody else carries this task, or nobody needs to: your epoch is over."""

    task: str
    epoch: int
    """The epoch that is right now."""


class Withdrawn(Message, frozen=True):
    """The coordinator does not need the task any more."""

    task: str
    epoch: int
    reason: str


class GoalClosed(Message, frozen=True):
    """The strategist has noted that a goal is delivered; the machine may forget it."""

    goal: str
