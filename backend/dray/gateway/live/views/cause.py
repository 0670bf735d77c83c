"""Why something does not go on, by its parts: panels put it into their reader's language."""

from __future__ import annotations

from dray.gateway.live.views.base import View
from dray.gateway.live.views.floor.wait import WaitCauseView


class FailureView(View):
    """A machine that makes nothing now."""

    agent: str
    reason: str
    """`silent` or `broken`."""


class LackView(View):
    """Material that is nowhere to be fetched."""

    material: str
    """Its name."""
    short: tuple[str, ...] = ()
    """Storages that have too little."""
    silent: tuple[str, ...] = ()
    """Storages whose stations do not answer."""


class HandoverView(View):
    """A load that a vehicle says to have put down, and what was counted of it."""

    said: int
    item: str
    where: str
    counted: int


class CauseView(View, kw_only=True):
    """Why something does not go on. Only the parts are set that say something; `text` says all of it in English."""

    reason: str = ""
    """One of the reasons of the wire: `Reason`, or `Implausible` of a word that is not believed; `anothers_key` where it is not its own; `robs_places` of a replica of reservation tables."""
    detail: str = ""
    """What an agent or a person says, in words of their own."""
    machines: tuple[FailureView, ...] = ()
    """All that could make something."""
    lacks: tuple[LackView, ...] = ()
    not_made: tuple[str, ...] = ()
    """Products that this plant does not make."""
    handover: HandoverView | None = None
    wait: WaitCauseView | None = None
    """For whom vehicles wait."""
    clock_ahead_s: float = 0.0
    """How far the clock is ahead of whoever is not believed, behind if below 0 (factory seconds)."""
    times: int = 1
    """How often it was so lately."""
    text: str = ""
