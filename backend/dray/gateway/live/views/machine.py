"""A machine as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.agent import ClockView, ProbationView, ShutOutView, SilenceView
from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView


class BufferView(View, kw_only=True):
    """Pieces of one item at a machine."""

    item: str
    level: int
    capacity: int
    reorder_point: int = 0
    on_order: int = 0
    spare: int = 0
    """Finished pieces that no order wants any more: the next goal of the product takes them."""


class GoalView(View, kw_only=True):
    """A production goal in a machine's queue."""

    goal: str
    product: str
    quantity: int
    made: int
    delivered: int


class OpenTaskView(View, kw_only=True):
    """One of a machine's open transports."""

    task: str
    epoch: int
    item: str
    quantity: int
    source: str
    destination: str
    deadline_at_s: float
    primary: str = ""
    secondary: str = ""
    round: int = 1
    trouble: CauseView | None = None
    """Why it does not go on, as the machine tells; None when all is well."""


class MachineView(View, kw_only=True):
    """A machine, as its last heartbeat told."""

    id: str
    name: str
    status: Literal["idle", "producing", "starved", "blocked", "error"]
    product: str = ""
    goals: tuple[GoalView, ...] = ()
    tasks: tuple[OpenTaskView, ...] = ()
    buffers: tuple[BufferView, ...] = ()
    goods: tuple[BufferView, ...] = ()
    problem: str = ""
    waits: CauseView | None = None
    """The materials that it needs and that nobody can fetch now; None where there are none."""
    software: str = ""
    draining: bool = False
    """It was asked to leave, takes nothing new, and goes when nothing holds it any more."""
    probation: ProbationView | None = None
    """While it is on probation and takes short goals only."""
    shut_out: ShutOutView | None = None
    """Nobody hears it any more: all else here is what it said before."""
    clock: ClockView | None = None
    """None while nothing is known of it."""
    seen_at_s: float
    silence: SilenceView
