"""The Contract Net: messages from the announcement of a task to its handover (paper, 4.1).

A *task* is work that a *coordinator* gives out: a machine its transports, the strategist the production goals. Both use the same
messages; only `work` and `cost` differ. `epoch` counts the carriers of a task: it rises with each change, and the highest is valid.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import UNSET, Meta, UnsetType

from dray.messages.base import Count, Id, IdOrNone, Message, Metres, Part, Seconds, Text
from dray.messages.cost import Cost
from dray.messages.heartbeat import Role
from dray.messages.kinds import BIDDERS, COORDINATORS, DOCKS, STRATEGISTS, VEHICLES
from dray.messages.product import ProductDefinition
from dray.messages.reason import Implausible, Reason


class Transport(Part, tag_field="kind", tag="transport", frozen=True):
    """Carry `quantity` pieces of `item` from one of `sources` to `destination`."""

    item: Id
    """A material on the way in, or between places; a product on the way out."""
    quantity: Count
    sources: Annotated[tuple[Id, ...], Meta(min_length=1)]
    """Stations to choose from; never empty."""
    destination: Id
    """A machine on the way in, a delivery warehouse on the way out, or a storage."""
    ability: IdOrNone
    """What a vehicle must be able to carry."""
    goal: IdOrNone = ""
    """The goal whose products these are, on the way out."""
    node: IdOrNone = ""
    """The dock node of the machine that asks, if it is a joining one; empty for one in the plant file."""
    vehicle: IdOrNone = ""
    """The only vehicle that may carry it; empty for any."""
    vehicle_until_s: Seconds | None = None
    """Until when only that vehicle may; None for always."""
    handed_at: IdOrNone = ""
    """The node where a person hands the load over, which is then its only source; empty when it is fetched at a station."""
    also: IdOrNone = ""
    """A second ability that the vehicle must have; empty for none."""

    @property
    def needed(self) -> tuple[str, ...]:
        """The abilities that its vehicle must have."""
        return (self.ability, self.also) if self.also else (self.ability,)


class Production(Part, tag_field="kind", tag="production", frozen=True):
    """Make `quantity` pieces of `product` for one item of an order."""

    product: Id
    quantity: Count
    order: Id
    item: Count
    """The index of the order's item; the definition is that of the order's release."""
    definition: ProductDefinition
    part_of: IdOrNone = ""
    """The product of which it is a part: its pieces stay where they are made. Empty for goods for the delivery warehouse."""


Work = Transport | Production


DOCK_TIMES_MAX = 8
"""Maximum vehicles that are listed for one place: later ones do not concern a transport that begins now."""


class DockTime(Part, frozen=True):
    """When a vehicle expects to be at a dock (plant clock). A hint for others' promises, which reserves nothing."""

    atv: Id
    comes_s: Seconds
    """When it is there, or in the queue for the dock."""
    leaves_s: Seconds
    """When the next vehicle can be there."""


class DockExpected(Message, said_by=VEHICLES, frozen=True):
    """A vehicle with right of way reports to a place's coordinators when it will be at the dock there.

    Sent when the contract is taken, when the estimate changes, when it docks and when it is done.
    """

    place: Id
    comes_s: Seconds
    """When it is there, or in the queue for the dock (plant clock)."""
    stays_s: Seconds
    """Length of its stay there; 0 when it is done."""
    docked: bool = False
    """Whether it stands at the dock."""


class Wait(Part, frozen=True, omit_defaults=True):
    """Recent waits of vehicles at a place, beyond the handling itself."""

    place: Id
    wait_s: Seconds
    expected: Annotated[tuple[DockTime, ...], Meta(max_length=DOCK_TIMES_MAX)] = ()
    """The vehicles expected at the dock there, by their own reports."""


class TaskAnnounced(Message, said_by=COORDINATORS, signed="coordinator", frozen=True):
    """A coordinator asks for bids. Published to all within the radius."""

    task: Id
    epoch: Count
    """The epoch of the winner's contract."""
    role: Role
    """PRIMARY, or SECONDARY when a new watch is sought."""
    coordinator: Id
    work: Work
    deadline_s: Seconds
    """When the work should be done (plant clock)."""
    x_m: Metres = 0.0
    y_m: Metres = 0.0
    """Centre of the circle in which vehicles are asked: the coordinator's position."""
    radius_m: Metres = 0.0
    round: Count = 1
    bids_until_s: Seconds = 0.0
    """When the bidding window closes (plant clock)."""
    primary: IdOrNone = ""
    """The vehicle to watch, when a SECONDARY is sought; it does not bid."""
    needed_s: Seconds = 0.0
    """When the work was first needed (plant clock); the deadline moves when no bidder can keep it. 0 for the deadline."""
    waits: tuple[Wait, ...] = ()
    """Recent waits at the sources and at the destination, as the coordinator has seen them."""


class WorkSought(Message, said_by=VEHICLES, signed="atv", frozen=True):
    """A free vehicle asks for waiting work, since it had no time when bids were asked for.

    Each coordinator with waiting transports sends this vehicle the `TaskAnnounced` of the most urgent one that it can carry.
    """

    atv: Id
    abilities: tuple[Id, ...]
    """What it can carry."""


class Bid(Message, said_by=BIDDERS, frozen=True):
    """A contractor's price, sent straight to the coordinator."""

    task: Id
    epoch: Count
    role: Role
    round: Count
    cost: Cost
    finish_s: Seconds
    """When it promises to be done (plant clock)."""
    source: IdOrNone = ""
    """The source it would fetch from."""
    at_s: Seconds | None = None
    """When it was sent, by the clock of its other times, which are relative to it. None when the software does not fill it."""
    battery_reckoned: bool | UnsetType = UNSET
    """Whether the bidder's battery level, and so the energy part of the price, is estimated from time and metres; left out when it is
    measured."""


class Award(Message, said_by=COORDINATORS, frozen=True):
    """The coordinator asks one bidder to take the contract."""

    task: Id
    epoch: Count
    role: Role
    work: Work
    deadline_s: Seconds
    source: IdOrNone = ""
    primary: IdOrNone = ""
    """The vehicle to watch, when the role is SECONDARY."""
    number: Count = 1
    """Counts the awards of one coordinator, over all its lives. Answers and releases repeat it, so that late ones are recognised."""


class Refusal(StrEnum):
    """Why a contractor does not bid, or declines an award."""

    BUSY = "busy"
    """It has taken another contract meanwhile."""
    WATCHING_ENOUGH = "watching_enough"
    ABILITY = "ability"
    BATTERY = "battery"
    """It could not reach a charger after keeping its promise."""
    DEADLINE = "deadline"
    NO_WAY = "no_way"
    CLOSED = "closed"
    """People's closures leave no way."""
    NOT_FIT = "not_fit"
    """It is stopped, in error, on the radio mesh, draining, shut in by a silent vehicle, in the reserve of a fleet too large for its
    roads, or on probation and this task is too large."""
    IS_PRIMARY = "is_primary"
    """It would watch itself."""


class Accepted(Message, said_by=BIDDERS, frozen=True):
    """A bidder accepts an award."""

    task: Id
    epoch: Count
    role: Role
    finish_s: Seconds = 0.0
    number: Count = 1
    """Number of the award that this answers."""
    at_s: Seconds | None = None
    """When it was sent, by the clock of its other times, which are relative to it. None when the software does not fill it."""


class Brought(Part, frozen=True):
    """Pieces of a goal that the gate of the delivery warehouses has counted."""

    vehicle: Id
    """The vehicle that has brought them."""
    pieces: Count


class Confirmed(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The coordinator confirms that a contract was taken: `Accepted` of a goal, or `TakenOver`.

    A machine begins a goal only then, and repeats `Accepted` until then. Otherwise a goal whose acceptance was lost would be made
    twice, by it and by the next machine. A restarted machine asks in the same way about the goals that it remembers. It is also
    sent whenever pieces of a goal have arrived.
    """

    task: Id
    epoch: Count
    arrived: Count = 0
    """Pieces of the goal that the delivery warehouse has counted."""
    brought: tuple[Brought, ...] = ()
    """The same by vehicle, as far as the strategist has heard since its start; the rest may be of any vehicle."""
    by_people: bool = False
    """Whether the gate counts after the goods have come, as people do: then carriers do not wait for the count."""


class Declined(Message, said_by=BIDDERS, radio=True, frozen=True):
    """A bidder declines an award; the coordinator asks the next one."""

    task: Id
    epoch: Count
    role: Role
    reason: Refusal
    number: Count = 1
    """Number of the award that this answers."""


class Release(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The coordinator releases a contractor; one that is not bound by this award ignores it."""

    task: Id
    epoch: Count
    role: Role
    reason: Reason
    number: Count = 0
    """Number of the award that ends; 0 without an award, as after a takeover."""


class Resigned(Message, said_by=VEHICLES, radio=True, frozen=True):
    """A contractor gives the contract back."""

    task: Id
    epoch: Count
    role: Role
    reason: Reason
    detail: Text = ""
    """Text for people, in the words of the agent that has held it up."""
    short: IdOrNone = ""
    """The storage that did not supply the load, though the vehicle has waited as long as its promise allowed."""


class TakenOver(Message, said_by=VEHICLES, radio=True, frozen=True):
    """A secondary has become the carrier, with a higher epoch. Repeated until it is answered.

    The answer is `Confirmed`; or `Release` when the coordinator still hears the primary; or `Superseded` when the task has another
    carrier or has ended.
    """

    task: Id
    epoch: Count
    primary: Id
    """The vehicle that it replaces."""
    reason: Reason = Reason.SILENT
    finish_s: Seconds = 0.0
    """When it promises to be done (plant clock)."""
    source: IdOrNone = ""
    """Where it fetches the load."""
    at_s: Seconds | None = None
    """When it was sent, by the clock of its other times, which are relative to it. None when the software does not fill it."""


class Disbelieved(Message, said_by=COORDINATORS, frozen=True):
    """The coordinator does not believe a bid, a promise or a handover, and says why, so that the cause can be fixed.

    It changes no contract.
    """

    task: Id
    epoch: Count
    reason: Implausible
    clock_ahead_s: Seconds = 0.0
    """How far the receiver's clock is ahead of the sender's, behind if negative; 0 when `reason` is another one."""


class Docked(Message, said_by=VEHICLES, radio=True, frozen=True):
    """A carrier stands at the source or the destination and asks to load or to unload.

    Every transfer asks first, so that an outdated epoch is stopped here. A load that is not needed any more never reaches a buffer.
    """

    task: Id
    epoch: Count
    station: Id
    item: IdOrNone = ""
    """What is to be loaded or unloaded; filled for a storage, which may have forgotten its promise."""
    quantity: Count = 0
    returns: bool = False
    """Whether it brings a load that is not needed any more back to a storage."""


class DockOpened(Message, said_by=DOCKS, radio=True, frozen=True):
    """The vehicle may load or unload now."""

    task: Id
    epoch: Count
    station: Id


class DockHeld(Message, said_by=DOCKS, radio=True, frozen=True):
    """The vehicle must wait: it is right here, but there is no room or nothing to fetch yet."""

    task: Id
    epoch: Count
    station: Id
    reason: Text


class Handover(Message, said_by=VEHICLES, radio=True, frozen=True):
    """The vehicle has put its load down. Repeated until it is answered; handing over twice is harmless."""

    task: Id
    epoch: Count
    quantity: Count


class HandoverAccepted(Message, said_by=DOCKS, radio=True, frozen=True):
    """The task is done; the vehicle is free."""

    task: Id
    epoch: Count


class Superseded(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The receiver's epoch is over: another vehicle carries this task, or none needs to."""

    task: Id
    epoch: Count
    """The valid epoch."""


class Withdrawn(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The coordinator does not need the task any more."""

    task: Id
    epoch: Count
    reason: Reason = Reason.NOT_NEEDED


class GoalClosed(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist has noted that a goal is delivered; the machine may forget it."""

    goal: Id
