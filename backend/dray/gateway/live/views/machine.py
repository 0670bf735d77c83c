"""A machine as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.agent import ClockView, ProbationView, ShutOutView, SilenceView
from dray.gateway.live.views.atv import HelpView, OutOfServiceView, ProblemView
from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView
from dray.gateway.live.views.load import LoadView


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
    to_begin: int
    """Pieces whose material no cycle has taken yet: one in the making is not among them."""
    delivered: int
    deadline_at_s: float | None = None
    """When it should be done; its order is due some minutes later. None where the machine does not tell."""
    order_due_at_s: float | None = None
    """When its order is due. None where that is not known here."""
    order_name: str = ""
    """Of its order, as `StrandedView.order_name`."""
    offered: bool = False
    """Its machine does not work at it: others may make what is missing."""


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


class DocumentView(View, kw_only=True):
    """A document of a product that a machine has to make."""

    product: str
    name: str
    address: str
    media_type: str
    sha256: str
    state: Literal["unread", "reading", "verified", "differs", "unreachable"]
    """Nothing is made by one that is not `verified`."""
    detail: str = ""
    """What was found, of one that cannot be used."""


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
    documents: tuple[DocumentView, ...] = ()
    """Of the products that it has to make, as it verifies them."""
    problem: str = ""
    about_problem: ProblemView | None = None
    """What is known of its problem; None where there is none, or nothing is known."""
    resettable: bool = False
    """Its sensors find nothing wrong any more: it waits for somebody to say so."""
    help: HelpView | None = None
    """While its goals wait for a person, or are offered to others."""
    out_of_service: OutOfServiceView | None = None
    """While a person has taken it out of service."""
    speed_frac: float = 1.0
    """The part of its own speed at which people let it work."""
    since_at_s: float | None = None
    """Since when it has had its status."""
    waits: CauseView | None = None
    """The materials that it needs and that nobody can fetch now; None where there are none."""
    software: str = ""
    draining: bool = False
    """It was asked to leave, takes nothing new, and goes when nothing holds it any more."""
    probation: ProbationView | None = None
    """While it is on probation and takes short goals only."""
    unconfirmed: tuple[LoadView, ...] | None = None
    """Loads that wait for a word of people, the oldest first; None where a machine's body is not people."""
    shut_out: ShutOutView | None = None
    """Nobody hears it any more: all else here is what it said before."""
    clock: ClockView | None = None
    """None while nothing is known of it."""
    seen_at_s: float
    silence: SilenceView
