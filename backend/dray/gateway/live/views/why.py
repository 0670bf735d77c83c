"""Why a task has this carrier: in one sentence, and by the bids that it is true to."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View


class PassedView(View, kw_only=True):
    """A bidder that would have come before the one that was chosen, and why it was passed over."""

    agent: str
    less_s: float
    """How much less it had bid; 0 where no figure with one decimal shows a difference."""
    answer: str
    """silent, late (its bid came after the window), asked (no answer is on record), or why it declined."""
    taken_for: str = ""
    """For whom it worked already when it declined because it was busy; empty where nobody knows."""


class RefusedView(View, kw_only=True):
    """Those who did not bid, by their reason."""

    reason: str
    agents: tuple[str, ...]


class WhyView(View, kw_only=True):
    """Why this contractor: the parts of the sentence, for other languages, and the sentence itself."""

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
    """Whom it is about: the carrier, else the cheapest bidder, else the coordinator."""
    total_s: float = 0.0
    """Its price."""
    bidders: int = 0
    """How many bid."""
    left: int = 0
    """How many of them were left to choose from: neither passed over nor asked in vain."""
    other: str = ""
    """The next cheapest one of those."""
    by_s: float = 0.0
    """How much more that one wanted."""
    part: str = ""
    """The part of the price that makes most of the difference; empty where none does."""
    part_s: float = 0.0
    """The difference in that part."""
    tie_by: Literal["", "price", "finish", "name"] = ""
    """What decided between equal prices: less than is shown, who is done earlier, or the order of names."""
    passed: tuple[PassedView, ...] = ()
    """Cheapest first."""
    refused: tuple[RefusedView, ...] = ()
    """The most frequent reason first."""
    round: int = 0
    """How many rounds it took, or has taken so far."""
    radius_m: float = 0.0
    """How far the last of them reached; 0 where distance does not matter."""
    replaced: str = ""
    """Who carried it before."""
    reason: str = ""
    """Why that one does not any more: a `Reason` of the wire."""
    silent_s: float = 0.0
    """How long nothing had been heard of that one, in factory seconds."""
    confirmed: bool = True
    """False for a takeover that the coordinator has not confirmed."""
    coordinator: str = ""
    text: str = ""
    """All of it in one English sentence or two."""
