"""Causes: why something does not go on, in parts that panels put into their reader's language."""

from __future__ import annotations

from dray.gateway.live.views.base import View
from dray.gateway.live.views.floor.wait import WaitCauseView


class FailureView(View):
    """A machine that makes nothing now."""

    agent: str
    reason: str
    """`silent` or `broken`."""


class LackView(View):
    """Material that no storage can supply."""

    material: str
    """Name of the material."""
    short: tuple[str, ...] = ()
    """Storages that have too little."""
    silent: tuple[str, ...] = ()
    """Storages whose stations do not answer."""


class HandoverView(View):
    """A load that a vehicle reports as put down, and the counted quantity."""

    said: int
    item: str
    where: str
    counted: int


class CauseView(View, kw_only=True):
    """Why something does not go on. Only the parts that apply are set; `text` has all in English."""

    reason: str = ""
    """A `Reason` of the wire, or an `Implausible` for a statement that is not believed; `anothers_key` for a
    forged name; `robs_places` for a bad replica of reservation tables; `dock_fails` for a place where vehicle after
    vehicle fails."""
    detail: str = ""
    """An agent's or person's own words."""
    machines: tuple[FailureView, ...] = ()
    """All machines that could make it."""
    lacks: tuple[LackView, ...] = ()
    not_made: tuple[str, ...] = ()
    """Products that this plant does not make."""
    handover: HandoverView | None = None
    wait: WaitCauseView | None = None
    """The vehicles that vehicles wait for."""
    clock_ahead_s: float = 0.0
    """Seconds that the disbelieved agent's clock is ahead, negative if behind (factory seconds)."""
    times: int = 1
    """Number of recent occurrences."""
    text: str = ""
