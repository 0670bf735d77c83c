"""Why a task has this carrier: a sentence, and the bids that prove it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View


class PassedView(View, kw_only=True):
    """A bidder that ranked before the chosen one, and why it was passed over."""

    agent: str
    less_s: float
    """Seconds by which its bid was lower; 0 where one decimal shows no difference."""
    answer: str
    """silent, late (its bid came after the window), asked (no answer is on record), or the reason of its
    decline."""
    taken_for: str = ""
    """Coordinator of a busy bidder's other task; empty if unknown."""


class RefusedView(View, kw_only=True):
    """Agents that did not bid for one reason."""

    reason: str
    agents: tuple[str, ...]
    detail: str = ""
    """What keeps those that are `not_fit` from all work, in the words of one of them; empty for other reasons."""


class WhyView(View, kw_only=True):
    """Why this contractor: a sentence, and its parts for other languages."""

    kind: Literal[
        "waiting",
        "leading",
        "asked",
        "only",
        "cheapest",
        "tie",
        "took_over",
        "recovered",
        "unknown",
        "withdrawn",
    ]
    """waiting: nobody has bid; leading, asked: the cheapest bid so far; only: nobody else bid; unknown: no
    bid of its carrier is on record."""
    agent: str = ""
    """The carrier, else the cheapest bidder, else the coordinator."""
    total_s: float = 0.0
    """Price of its bid, in seconds."""
    bidders: int = 0
    """Number of bidders."""
    left: int = 0
    """Bidders left to choose from: neither passed over nor asked in vain."""
    other: str = ""
    """The next cheapest bidder left."""
    by_s: float = 0.0
    """Seconds by which its price is higher."""
    part: str = ""
    """The part of the price that makes most of the difference; empty if none does."""
    part_s: float = 0.0
    """Difference in that part, in seconds."""
    tie_by: Literal["", "price", "finish", "name"] = ""
    """What decided between equal prices: an invisible price difference, the earlier finish, or the order of
    names."""
    passed: tuple[PassedView, ...] = ()
    """Cheapest first."""
    refused: tuple[RefusedView, ...] = ()
    """The most frequent reason first."""
    round: int = 0
    """Number of rounds so far."""
    radius_m: float = 0.0
    """Radius of the last round in metres; 0 where distance does not matter."""
    replaced: str = ""
    """The carrier before."""
    reason: str = ""
    """Why that one no longer carries it: a `Reason` of the wire."""
    silent_s: float = 0.0
    """Silence of that one, in factory seconds."""
    confirmed: bool = True
    """False for a takeover that the coordinator has not confirmed."""
    coordinator: str = ""
    text: str = ""
    """The whole reason in one or two English sentences."""
