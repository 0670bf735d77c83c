"""A task as panels see it: its auction, its carriers, and why."""

from __future__ import annotations

from typing import Literal

import msgspec

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView
from dray.gateway.live.views.why import WhyView


class BidView(View, kw_only=True):
    """A bid, with the parts of its price in seconds."""

    bidder: str
    role: Literal["primary", "secondary"]
    epoch: int = 1
    round: int
    total_s: float
    parts_s: dict[str, float]
    """empty_way, loaded_way, energy, suitability and, where vehicles wait, waiting; or queue, material,
    making. Also reliability, where the coordinator adds a surcharge for contracts that the bidder dropped."""
    finish_at_s: float
    source: str = ""
    battery_reckoned: bool = False
    """Whether the bidder's battery level is estimated from time and metres, not measured."""
    answer: str = ""
    """Outcome: empty, asked, accepted, silent, or the reason of the decline."""
    taken_for: str = ""
    """Coordinator of a busy bidder's other task; empty if unknown."""


class RefusalView(View, kw_only=True):
    """An agent that did not bid, and why."""

    agent: str
    role: Literal["primary", "secondary"]
    epoch: int = 1
    round: int
    reason: str
    detail: str = ""


class CarrierView(View, kw_only=True):
    """A change of a task's carrier, or a new announcement."""

    carrier: str
    """Empty for a new announcement."""
    epoch: int
    since_at_s: float
    how: Literal["won", "took_over", "recovered", "announced_anew"] = "won"
    """Won the auction, took over as secondary, or was found at work by a coordinator that had been away."""
    replaced: str = ""
    """The carrier before; empty for the first."""
    reason: str = ""
    """Why `replaced` no longer carries it: a `Reason` of the wire."""
    silent_s: float = 0.0
    """Silence of the carrier before, in factory seconds."""
    confirmed: bool = True
    """False while the coordinator has not confirmed the carrier's own word."""


class StrandedView(View, kw_only=True):
    """Goods on board of a failed vehicle that wait for a person."""

    atv: str
    node: str
    """Node where it was heard last; empty if unknown."""
    until_at_s: float
    """When they are given up and made again."""
    handed_at: str = ""
    """Place where a person hands them over to another vehicle; empty while nobody has said so."""
    order: str = ""
    """Id of their order; empty if unknown, or if the reader may not read orders."""
    order_name: str = ""
    """Reference of their order, else its id. Visible to anyone asked to handle the goods, since it is on
    their papers."""


class TaskView(View, kw_only=True):
    """A task from its announcement to its end."""

    id: str
    kind: Literal["transport", "production"]
    coordinator: str
    item: str
    quantity: int
    sources: tuple[str, ...] = ()
    source: str = ""
    """The source that the primary chose."""
    destination: str = ""
    order: str = ""
    goal: str = ""
    epoch: int = 1
    round: int = 1
    radius_m: float = 0.0
    state: Literal["bidding", "contracted", "delivered", "withdrawn"] = "bidding"
    phase: str = ""
    goods_aboard: bool = False
    """Whether goods are on board: they exist once, so no other vehicle could fetch them."""
    primary: str = ""
    secondary: str = ""
    opened_at_s: float
    contracted_at_s: float | None = None
    promised_at_s: float | None = None
    deadline_at_s: float
    closed_at_s: float | None = None
    trouble: CauseView | None = None
    """Why it does not go on, by its coordinator's word; None when it does."""
    fails_at: str = ""
    """The place where vehicles have failed to load or unload it, while a person is asked to look there."""
    stranded: StrandedView | None = None
    """Set while its goods wait for a person, or for a vehicle at the handover place."""
    carriers: tuple[CarrierView, ...] = ()
    """Oldest first."""
    bids: tuple[BidView, ...] = ()
    refusals: tuple[RefusalView, ...] = ()
    why: WhyView = msgspec.field(default_factory=lambda: WhyView(kind="waiting"))
    """Why this contractor, or why none yet; based on the bids that were heard."""
