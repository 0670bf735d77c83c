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
    """empty_way, loaded_way, energy, suitability and, where vehicles wait, waiting; or queue, material, making; and reliability, where its coordinator
    adds something for contracts that the bidder has dropped."""
    finish_at_s: float
    source: str = ""
    battery_reckoned: bool = False
    """The level of the bidder's battery is reckoned by time and metres, not measured."""
    answer: str = ""
    """What came of it: empty, asked, accepted, silent, or the reason of the decline."""
    taken_for: str = ""
    """For whom the bidder worked already when it declined because it was busy; empty where nobody knows."""


class RefusalView(View, kw_only=True):
    """Who did not bid, and why."""

    agent: str
    role: Literal["primary", "secondary"]
    epoch: int = 1
    round: int
    reason: str
    detail: str = ""


class CarrierView(View, kw_only=True):
    """Who carried a task from when on, or that it was put up for auction again."""

    carrier: str
    """Empty when it was announced anew."""
    epoch: int
    since_at_s: float
    how: Literal["won", "took_over", "recovered", "announced_anew"] = "won"
    """Won the auction, took over from the one that it watched, or was found to carry it by a coordinator
    that had been away."""
    replaced: str = ""
    """Who carried it before; empty for the first one."""
    reason: str = ""
    """Why `replaced` does not carry it any more: a `Reason` of the wire."""
    silent_s: float = 0.0
    """How long nothing had been heard of the one before, in factory seconds."""
    confirmed: bool = True
    """False while only the carrier itself says so, and the coordinator has not."""


class StrandedView(View, kw_only=True):
    """Goods that wait for a person's word, since the vehicle that has them on board has failed."""

    atv: str
    node: str
    """Where it was heard last; empty where nobody knows."""
    until_at_s: float
    """They are given up then, and made again."""
    handed_at: str = ""
    """Where a person hands them over to another vehicle; empty while nobody has said so."""
    order: str = ""
    """For which order they are; empty for who may not read orders, and where that is not known."""
    order_name: str = ""
    """Its reference, else its id. Whoever is asked to handle them is told it, whether orders may be read or not: it is on their papers."""


class TaskView(View, kw_only=True):
    """A task from its announcement to its end."""

    id: str
    kind: Literal["transport", "production"]
    coordinator: str
    item: str
    quantity: int
    sources: tuple[str, ...] = ()
    source: str = ""
    """Which one the primary chose."""
    destination: str = ""
    order: str = ""
    goal: str = ""
    epoch: int = 1
    round: int = 1
    radius_m: float = 0.0
    state: Literal["bidding", "contracted", "delivered", "withdrawn"] = "bidding"
    phase: str = ""
    goods_aboard: bool = False
    """Goods exist once: nobody else could fetch them now."""
    primary: str = ""
    secondary: str = ""
    opened_at_s: float
    contracted_at_s: float | None = None
    promised_at_s: float | None = None
    deadline_at_s: float
    closed_at_s: float | None = None
    trouble: CauseView | None = None
    """Why it does not go on, as its coordinator tells; None when all is well."""
    stranded: StrandedView | None = None
    """Its goods wait for a person's word, or to be fetched where one hands them over; None where that is not so."""
    carriers: tuple[CarrierView, ...] = ()
    """Oldest first."""
    bids: tuple[BidView, ...] = ()
    refusals: tuple[RefusalView, ...] = ()
    why: WhyView = msgspec.field(default_factory=lambda: WhyView(kind="waiting"))
    """Why this contractor, or why nobody yet; true to the bids that were heard."""
