"""The station of a storage as panels see it."""

from __future__ import annotations

from dray.gateway.live.views.agent import ClockView, ShutOutView, SilenceView
from dray.gateway.live.views.base import View
from dray.gateway.live.views.load import DoubtView, LoadView, ToComeView


class StockView(View, kw_only=True):
    """Pieces of one material in a storage."""

    item: str
    level: int
    capacity: int
    promised: int = 0
    """Pieces of `level` set aside for transports."""
    wanted: int = 0
    """Pieces that machines request and that cannot be promised yet."""
    on_order: int = 0
    """Pieces on order or on their way here."""
    uncounted: bool = False
    """Whether the quantity is unknown until somebody counts: at least `level`."""


class StationView(View, kw_only=True):
    """The station of a storage, by its last heartbeat."""

    id: str
    """Id of the storage."""
    name: str
    stocks: tuple[StockView, ...] = ()
    software: str = ""
    draining: bool = False
    """Whether it shuts down gracefully: it promises nothing new, and leaves when nothing holds it."""
    shut_out: ShutOutView | None = None
    """Set while it is shut out and ignored: all other fields are older."""
    clock: ClockView | None = None
    """None while unknown."""
    problem: str = ""
    """For the gate: why it counts nothing or does not let a container in; empty otherwise."""
    unconfirmed: tuple[LoadView, ...] | None = None
    """Where its body is people: loads that vehicles report as brought or taken and nobody has confirmed yet.
    Else None."""
    doubts: tuple[DoubtView, ...] = ()
    """Loads that may lie there although they are not in its stock, oldest first: a person counts."""
    to_come: tuple[ToComeView, ...] = ()
    """For a gate whose body is people: the arrivals that they should confirm, least recently active goal
    first."""
    seen_at_s: float
    silence: SilenceView
