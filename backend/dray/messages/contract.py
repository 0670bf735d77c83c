"""The Contract Net: what is said from the announcement of a task to its handover (paper, 4.1).

A *task* is work that a *coordinator* gives out: a machine its transports, the strategist the production goals. Both speak the same language; only
`work` and `cost` differ. `epoch` counts the carriers of a task: it rises whenever the carrier changes, and the highest one is right.
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
    """A material on the way in, or from place to place; a product on the way out."""
    quantity: Count
    sources: Annotated[tuple[Id, ...], Meta(min_length=1)]
    """Stations to choose from; never empty."""
    destination: Id
    """A machine on the way in, a delivery warehouse on the way out, a storage for what is taken there."""
    ability: IdOrNone
    """What a vehicle must be able to carry."""
    goal: IdOrNone = ""
    """The goal whose products these are, on the way out."""
    node: IdOrNone = ""
    """Where vehicles dock at the machine that asks, if it is a joining one; empty for one in the plant file."""
    vehicle: IdOrNone = ""
    """The only one that may carry it; empty for any."""
    vehicle_until_s: Seconds | None = None
    """Until when only that one may; None for always."""
    handed_at: IdOrNone = ""
    """The node where a person hands the load over, which is then its only source; empty where it is fetched at a station."""
    also: IdOrNone = ""
    """What a vehicle must be able to carry beside `ability`, where somebody wants that; empty for nothing."""

    def is_for_any(self, now_s: float) -> bool:
        """Whether no vehicle alone may carry it, or may no longer (plant clock)."""
        return not self.vehicle or (self.vehicle_until_s is not None and self.vehicle_until_s <= now_s)

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
    """The index of the order's item; the definition is of the moment when its order was released."""
    definition: ProductDefinition
    part_of: IdOrNone = ""
    """The product for which it is a part: its pieces stay where they are made. Empty for what goes to the delivery warehouse."""


Work = Transport | Production


DOCK_TIMES_MAX = 8
"""Vehicles that are told of one place: who comes later does not concern a transport that begins now."""


class DockTime(Part, frozen=True):
    """When a vehicle expects to be at a dock (plant clock). A hint for others' promises, and no right to the dock."""

    atv: Id
    comes_s: Seconds
    """It is there, or stands behind whoever is."""
    leaves_s: Seconds
    """From then on the next one can be there."""


class DockExpected(Message, said_by=VEHICLES, frozen=True):
    """A vehicle with right of way tells whoever hires vehicles for a place when it will be at the dock there.

    Said when the contract is taken, whenever the vehicle knows better, when it stands there and when it is done.
    """

    place: Id
    comes_s: Seconds
    """It is there, or stands behind whoever is (plant clock)."""
    stays_s: Seconds
    """How long it takes there; 0 when it is done."""
    docked: bool = False
    """It stands there."""


class Wait(Part, frozen=True, omit_defaults=True):
    """How long vehicles wait at a place, beyond the handling itself, lately."""

    place: Id
    wait_s: Seconds
    expected: Annotated[tuple[DockTime, ...], Meta(max_length=DOCK_TIMES_MAX)] = ()
    """Who is expected at the dock there, as these vehicles have told."""


class TaskAnnounced(Message, said_by=COORDINATORS, signed="coordinator", frozen=True):
    """A coordinator asks for bids. Published to everybody within the radius."""

    task: Id
    epoch: Count
    """The epoch that the winner will carry."""
    role: Role
    """PRIMARY, or SECONDARY when a watch is to be elected anew."""
    coordinator: Id
    work: Work
    deadline_s: Seconds
    """When the work should be done (plant clock)."""
    x_m: Metres = 0.0
    y_m: Metres = 0.0
    """The middle of the circle in which vehicles are asked: the coordinator's place."""
    radius_m: Metres = 0.0
    round: Count = 1
    bids_until_s: Seconds = 0.0
    """When the bidding window closes (plant clock)."""
    primary: IdOrNone = ""
    """Whom to watch, when a SECONDARY is sought; that vehicle does not bid."""
    needed_s: Seconds = 0.0
    """When the work was needed at first (plant clock): the deadline moves when nobody can keep it. 0 for the deadline."""
    waits: tuple[Wait, ...] = ()
    """How long vehicles have waited lately at the sources and at the destination, as the coordinator has seen it."""


class WorkSought(Message, said_by=VEHICLES, signed="atv", frozen=True):
    """A vehicle that had no time when everybody was asked is free: what waits?

    Every coordinator whose transports wait answers with the `TaskAnnounced` of the most urgent one that such a vehicle can
    carry, to it alone.
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
    """When it was said, by the same clock; times in it are understood from here. None where a software does not tell."""
    battery_reckoned: bool | UnsetType = UNSET
    """The level of the bidder's battery, and so the part of the price that is for energy, is reckoned by time and metres; left out where
    it is measured."""


class Award(Message, said_by=COORDINATORS, frozen=True):
    """The coordinator asks one bidder to take the contract."""

    task: Id
    epoch: Count
    role: Role
    work: Work
    deadline_s: Seconds
    source: IdOrNone = ""
    primary: IdOrNone = ""
    """Whom to watch, when the role is SECONDARY."""
    number: Count = 1
    """Counts the awards of one coordinator, over all its lives. An answer and a release carry it back: one that comes late is recognised."""


class Refusal(StrEnum):
    """Why a contractor does not bid, or declines an award."""

    BUSY = "busy"
    """Taken by another coordinator meanwhile."""
    WATCHING_ENOUGH = "watching_enough"
    ABILITY = "ability"
    BATTERY = "battery"
    """Could not keep its promise and reach a charger after it."""
    DEADLINE = "deadline"
    NO_WAY = "no_way"
    CLOSED = "closed"
    """What people have closed leaves no way."""
    NOT_FIT = "not_fit"
    """Stopped, in error, on the radio mesh, draining, in the reserve of a fleet that is too large for its roads, or on probation and this is
    not for it."""
    IS_PRIMARY = "is_primary"
    """Asked to watch itself."""


class Accepted(Message, said_by=BIDDERS, frozen=True):
    """The contract stands."""

    task: Id
    epoch: Count
    role: Role
    finish_s: Seconds = 0.0
    number: Count = 1
    """Of the award that this answers."""
    at_s: Seconds | None = None
    """When it was said, by the same clock; times in it are understood from here. None where a software does not tell."""


class Brought(Part, frozen=True):
    """Pieces of a goal that the gate of the delivery warehouses has counted."""

    vehicle: Id
    """Who has brought them."""
    pieces: Count


class Confirmed(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The coordinator has heard that a contract was taken: `Accepted` of a goal, or `TakenOver`.

    A machine begins a goal only then, and repeats `Accepted` until then. Otherwise a goal whose
    acceptance was lost would be made by it and by whoever was asked next. A machine that comes back
    asks in the same way for the goals that it remembers. It is also said whenever pieces of a goal have arrived.
    """

    task: Id
    epoch: Count
    arrived: Count = 0
    """Pieces of the goal that the delivery warehouse has counted."""
    brought: tuple[Brought, ...] = ()
    """The same by vehicle, as far as the strategist's present life has heard: the rest may be anybody's."""
    by_people: bool = False
    """People count at the gate, later than goods come: carriers go on by their own word."""


class Declined(Message, said_by=BIDDERS, radio=True, frozen=True):
    """Not available any more; the coordinator asks the next one."""

    task: Id
    epoch: Count
    role: Role
    reason: Refusal
    number: Count = 1
    """Of the award that this answers."""


class Release(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The coordinator lets a contractor go; whoever is not bound by this award ignores it."""

    task: Id
    epoch: Count
    role: Role
    reason: Reason
    number: Count = 0
    """Of the award that binds no more; 0 where none was given, as for a takeover."""


class Resigned(Message, said_by=VEHICLES, radio=True, frozen=True):
    """A contractor gives the contract back."""

    task: Id
    epoch: Count
    role: Role
    reason: Reason
    detail: Text = ""
    """In the words of whoever has held it up, for people."""
    short: IdOrNone = ""
    """The storage that did not give it what it was to fetch, though it has waited as long as its promise allowed."""


class TakenOver(Message, said_by=VEHICLES, radio=True, frozen=True):
    """A secondary has become the carrier, with a higher epoch. Repeated until it is answered.

    The answer is `Confirmed`; or `Release` when the coordinator still hears the one it replaces, or
    `Superseded` when the task has moved on.
    """

    task: Id
    epoch: Count
    primary: Id
    """Whom it replaces."""
    reason: Reason = Reason.SILENT
    finish_s: Seconds = 0.0
    """When it promises to be done (plant clock)."""
    source: IdOrNone = ""
    """Where it fetches the load."""
    at_s: Seconds | None = None
    """When it was said, by the same clock; times in it are understood from here. None where a software does not tell."""


class Disbelieved(Message, said_by=COORDINATORS, frozen=True):
    """The coordinator does not believe a bid, a promise or a handover, and says why, so that somebody can put it right.

    It binds nobody and ends nothing.
    """

    task: Id
    epoch: Count
    reason: Implausible
    clock_ahead_s: Seconds = 0.0
    """How far the receiver's clock is ahead of the sender's, behind if negative; 0 where `reason` is another one."""


class Docked(Message, said_by=VEHICLES, radio=True, frozen=True):
    """A carrier stands at the source or the destination and asks to load or to unload.

    Every transfer asks first: this is where the epoch fences. A load that nobody waits for any
    more never reaches a buffer.
    """

    task: Id
    epoch: Count
    station: Id
    item: IdOrNone = ""
    """What is to be loaded or unloaded: told to a storage, which may have forgotten whom it was promised to."""
    quantity: Count = 0
    returns: bool = False
    """It brings a load that nobody waits for any more back to a storage."""


class DockOpened(Message, said_by=DOCKS, radio=True, frozen=True):
    """Load or unload now."""

    task: Id
    epoch: Count
    station: Id


class DockHeld(Message, said_by=DOCKS, radio=True, frozen=True):
    """Wait: the right vehicle at the right place, but there is no room or nothing to fetch yet."""

    task: Id
    epoch: Count
    station: Id
    reason: Text


class Handover(Message, said_by=VEHICLES, radio=True, frozen=True):
    """The load is down. Repeated until it is answered; handing over twice is harmless."""

    task: Id
    epoch: Count
    quantity: Count


class HandoverAccepted(Message, said_by=DOCKS, radio=True, frozen=True):
    """The task is done; the vehicle is free."""

    task: Id
    epoch: Count


class Superseded(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """Somebody else carries this task, or nobody needs to: your epoch is over."""

    task: Id
    epoch: Count
    """The epoch that is right now."""


class Withdrawn(Message, said_by=COORDINATORS, radio=True, frozen=True):
    """The coordinator does not need the task any more."""

    task: Id
    epoch: Count
    reason: Reason = Reason.NOT_NEEDED


class GoalClosed(Message, said_by=STRATEGISTS, frozen=True):
    """The strategist has noted that a goal is delivered; the machine may forget it."""

    goal: Id
