"""News: what has happened, as panels show it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView
from dray.gateway.live.views.floor.closure import ClosureView


class NewsView(View, kw_only=True):
    """A failure, its outcome, or people's response to it, for people who are not watching."""

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
    """Wall clock, like all times of views."""
    agent: str
    """The vehicle or machine to look at, or the strategist; empty for a closure."""
    agents: tuple[str, ...] = ()
    """For silence and Stop: all agents concerned, where there are several."""
    other: str = ""
    """The agent that `agent` has replaced; the person who promised help; or the person who stopped it,
    carried it away, or closed something."""
    task: str = ""
    epoch: int = 0
    goal: str = ""
    successor: str = ""
    """The goal that continues the missing part of `goal`; empty if none does."""
    arrived: int = 0
    """Delivered pieces of `goal`, which count."""
    order: str = ""
    reason: str = ""
    """For a takeover: a `Reason` of the wire."""
    cause: CauseView | None = None
    """For a call for help, a waiting goal, or a lost memory."""
    silent_s: float = 0.0
    """Silence of `other`, or of the agent heard again, in factory seconds."""
    until_at_s: float | None = None
    """End of the wait for help."""
    closure: ClosureView | None = None
    """The closure that began or ended, without lanes and effects on vehicles."""
    confirmed: bool = True
    """False for a takeover that the task's coordinator has not confirmed."""
