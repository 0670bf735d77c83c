"""A machine as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.agent import ClockView, ProbationView, ShutOutView, SilenceView
from dray.gateway.live.views.atv import HelpView, OutOfServiceView, ProblemView
from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView
from dray.gateway.live.views.load import DoubtView, LoadView


class BufferView(View, kw_only=True):
    """Pieces of one item at a machine."""

    item: str
    level: int
    capacity: int
    reorder_point: int = 0
    on_order: int = 0
    spare: int = 0
    """Finished pieces that no order needs any more; the product's next goal uses them."""


class GoalView(View, kw_only=True):
    """A production goal in a machine's queue."""

    goal: str
    product: str
    quantity: int
    made: int
    to_begin: int
    """Pieces whose production has not begun."""
    delivered: int
    deadline_at_s: float | None = None
    """When it should be done; its order is due some minutes later. None if the machine does not say."""
    order_due_at_s: float | None = None
    """Due time of its order; None if unknown here."""
    order_name: str = ""
    """Name of its order, as in `StrandedView.order_name`."""
    offered: bool = False
    """Whether its machine does not work at it, so that others may make the rest."""


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
    """Why it does not go on, by the machine's word; None when it does."""


class DocumentView(View, kw_only=True):
    """A document of a product that a machine has to make."""

    product: str
    name: str
    address: str
    media_type: str
    sha256: str
    state: Literal["unread", "reading", "verified", "differs", "unreachable"]
    """Nothing is made by a document that is not `verified`."""
    detail: str = ""
    """Finding for a document that cannot be used."""


class MachineView(View, kw_only=True):
    """A machine, by its last heartbeat."""

    id: str
    name: str
    status: Literal["idle", "producing", "starved", "blocked", "error"]
    product: str = ""
    goals: tuple[GoalView, ...] = ()
    tasks: tuple[OpenTaskView, ...] = ()
    buffers: tuple[BufferView, ...] = ()
    goods: tuple[BufferView, ...] = ()
    documents: tuple[DocumentView, ...] = ()
    """Documents of its products, with the state of their verification."""
    problem: str = ""
    about_problem: ProblemView | None = None
    """Details of its problem; None without one, or if unknown."""
    resettable: bool = False
    """Whether its sensors find nothing wrong any more, so that a person may reset it."""
    help: HelpView | None = None
    """Set while its goals wait for a person, or are offered to others."""
    out_of_service: OutOfServiceView | None = None
    """While a person has taken it out of service."""
    speed_frac: float = 1.0
    """Fraction of its own speed that people allow."""
    since_at_s: float | None = None
    """Time since which it has had its status."""
    waits: CauseView | None = None
    """Materials that it needs and no storage can supply now; None without any."""
    software: str = ""
    draining: bool = False
    """Whether it shuts down gracefully: it takes nothing new, and leaves when nothing holds it."""
    probation: ProbationView | None = None
    """Set while it is on probation and takes short goals only."""
    unconfirmed: tuple[LoadView, ...] | None = None
    """Loads that wait for a person's confirmation, oldest first; None where its body is not people."""
    doubts: tuple[DoubtView, ...] = ()
    """Loads that may lie there although they are not in its stock, oldest first: a person counts."""
    shut_out: ShutOutView | None = None
    """Set while it is shut out and ignored: all other fields are older."""
    clock: ClockView | None = None
    """None while unknown."""
    seen_at_s: float
    silence: SilenceView
