"""The station of a storage as panels see it."""

from __future__ import annotations

from dray.gateway.live.views.agent import ClockView, ShutOutView, SilenceView
from dray.gateway.live.views.base import View
from dray.gateway.live.views.load import LoadView, ToComeView


class StockView(View, kw_only=True):
    """Pieces of one material in a storage."""

    item: str
    level: int
    capacity: int
    promised: int = 0
    """Pieces of `level` that are set aside for transports."""
    wanted: int = 0
    """Pieces that machines ask for and that cannot be promised yet."""
    on_order: int = 0
    """Pieces that are on their way here, or are to be."""
    uncounted: bool = False
    """Nobody knows how many lie there, until somebody has counted: at least `level`."""


class StationView(View, kw_only=True):
    """The station of a storage, as its last heartbeat told."""

    id: str
    """The storage's."""
    name: str
    stocks: tuple[StockView, ...] = ()
    software: str = ""
    draining: bool = False
    """It was asked to leave, promises nothing new, and goes when nothing holds it any more."""
    shut_out: ShutOutView | None = None
    """Nobody hears it any more: all else here is what it said before."""
    clock: ClockView | None = None
    """None while nothing is known of it."""
    unconfirmed: tuple[LoadView, ...] | None = None
    """Where its body is people: what vehicles have brought and taken by their own word, and nobody has confirmed yet. Else None."""
    to_come: tuple[ToComeView, ...] = ()
    """Of the gate whose body is people: what they are expected to say, the quietest first."""
    seen_at_s: float
    silence: SilenceView
