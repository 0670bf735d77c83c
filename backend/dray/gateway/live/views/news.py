"""What has happened, as panels tell it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView
from dray.gateway.live.views.floor.closure import ClosureView


class NewsView(View, kw_only=True):
    """Something that people should know of without looking for it: a failure, what became of it, and what people have done about it."""

    id: str
    kind: Literal[
        "took_over",
        "takeover_refused",
        "announced_anew",
        "link_lost",
        "link_back",
        "help_asked",
        "help_promised",
        "goal_lost",
        "goal_waits",
        "memory_lost",
        "silent",
        "heard_again",
        "carried_away",
        "put_back",
        "stopped",
        "closed",
        "opened",
    ]
    at_s: float
    """Wall clock, as all times of views."""
    agent: str
    """Whom it is about: the vehicle or machine to look at, or the strategist; empty for a closure."""
    agents: tuple[str, ...] = ()
    """Of silence and Stop: all that it is about, where several were at the same moment."""
    other: str = ""
    """Whom `agent` has replaced; who has promised to help; or the name of who has stopped it, carried it away, or closed something."""
    task: str = ""
    epoch: int = 0
    goal: str = ""
    successor: str = ""
    """The goal under which what is missing of `goal` goes on; empty when nothing is."""
    arrived: int = 0
    """Pieces of `goal` that had been delivered, and count."""
    order: str = ""
    reason: str = ""
    """Of a takeover: a `Reason` of the wire."""
    cause: CauseView | None = None
    """Of a wish for help, a goal that waits, a memory that was lost."""
    silent_s: float = 0.0
    """How long nothing had been heard of `other`, or of who is heard again, in factory seconds."""
    until_at_s: float | None = None
    """How long help is waited for."""
    closure: ClosureView | None = None
    """Of what was closed or opened, without its lanes and what follows for vehicles."""
    confirmed: bool = True
    """False for a takeover that the task's coordinator has not confirmed."""
