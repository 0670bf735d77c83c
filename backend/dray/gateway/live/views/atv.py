"""A vehicle as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.agent import ClockView, ProbationView, ShutOutView, SilenceView
from dray.gateway.live.views.base import View
from dray.messages.people.command import PROMISE_MAX_S


class BriefView(View, kw_only=True):
    """A vehicle's part in one task."""

    task: str
    epoch: int
    role: Literal["primary", "secondary"]
    coordinator: str
    phase: str | None = None
    """approaching, loading, carrying, unloading, handing_over, returning; None for a watch."""
    item: str = ""
    quantity: int = 0
    due_at_s: float | None = None


class ProblemView(View, kw_only=True):
    """What a vehicle knows of its problem; None for what it does not know."""

    kind: Literal[
        "load",
        "drive",
        "sensor",
        "battery",
        "way_blocked",
        "lost_position",
        "link",
        "emergency_stop",
        "dock",
        "tool",
        "jam",
        "software",
        "unknown",
    ]
    passes: bool | None = None
    """It goes away by itself."""
    needs_person: bool | None = None
    load_movable: bool | None = None


class BodyWaitView(View, kw_only=True):
    """What a vehicle's body waits for, in its driver's words."""

    what: str
    until: str = ""
    """What ends it; empty where the driver does not know."""
    since_at_s: float


class HelpView(View, kw_only=True):
    """A problem that a person can solve, while its task, or a machine's goals, wait for that."""

    until_at_s: float
    """Solved by then, it goes on; else somebody else takes its task, or its goals."""
    promised_by: str = ""
    """Who has said to be on the way; empty while nobody has."""
    promise_max_s: float = PROMISE_MAX_S
    """How long from now help may be promised for, in factory seconds."""


class OutOfServiceView(View, kw_only=True):
    """A person has taken a vehicle or a machine out of service: it takes no work, and nothing of it is an alarm."""

    by: str
    since_at_s: float
    reason: str = ""
    back_at_s: float | None = None
    """When it is expected back; None where nobody knows."""
    after_work: bool = False
    """What it carries it brings to its end first."""


class RemovalView(View, kw_only=True):
    """A person has carried the vehicle away, and it was not heard since."""

    number: int
    by: str
    at_s: float
    believed_at_s: float
    """From then on it was silent for so long that its places are freed."""
    freed: tuple[str, ...] = ()
    """What it held, and is free now."""
    node: str = ""
    """Where it is being put back; empty while it is off the floor."""
    kept: bool = False
    """That place is kept for it: it may be put down there."""


class AtvView(View, kw_only=True):
    """An ATV, as its last heartbeat told."""

    id: str
    type: str
    status: Literal["idle", "working", "charging", "stopped", "error"]
    x_m: float
    y_m: float
    heading_rad: float
    speed_mps: float
    node: str
    way: tuple[str, ...] = ()
    """Nodes still ahead; the vehicle is between `node` and `way[0]`."""
    holds: tuple[str, ...] = ()
    """Nodes and crossings into which nobody else may drive; empty where vehicles drive without right of way."""
    battery_frac: float
    battery_reckoned: bool = False
    """Its level is reckoned by time and metres, not measured."""
    battery_low: bool = False
    """It takes no work before it has charged, by its type's `must_below_frac`."""
    load: str = ""
    load_quantity: int = 0
    link: Literal["wlan", "mesh"] = "wlan"
    via: tuple[str, ...] = ()
    """The vehicles that pass its heartbeat on, in order, when the link is mesh."""
    task: BriefView | None = None
    watches: tuple[BriefView, ...] = ()
    dwell_point: str = ""
    speed_limit_frac: float = 1.0
    acknowledged: bool = False
    """While it is stopped: somebody has said that the reason is gone, and it may be resumed."""
    problem: str = ""
    about_problem: ProblemView | None = None
    """None without a problem, and where there are only words."""
    body_wait: BodyWaitView | None = None
    """None where it waits for nothing, or for less than ten seconds, or does not tell."""
    help: HelpView | None = None
    software: str = ""
    draining: bool = False
    """It was asked to leave, takes nothing new, and goes when nothing holds it any more."""
    out_of_service: OutOfServiceView | None = None
    sent_to_charge: bool = False
    """By a person's word: it takes no work before it is full."""
    probation: ProbationView | None = None
    """While it is on probation and takes short tasks only."""
    asks_where_it_stands: bool = False
    """Where it stands nothing is its own yet: it drives nowhere before."""
    removal: RemovalView | None = None
    """While it is off the floor, as a person has said: all else here is what it said before."""
    shut_out: ShutOutView | None = None
    """Nobody hears it any more: all else here is what it said before."""
    clock: ClockView | None = None
    """None while nothing is known of it."""
    seen_at_s: float
    silence: SilenceView
