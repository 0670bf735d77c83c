"""A vehicle as panels see it."""

from __future__ import annotations

from typing import Literal

from dray.gateway.live.views.agent import ClockView, ProbationView, ShutOutView, SilenceView
from dray.gateway.live.views.base import View
from dray.messages import RemovalRefusal
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
    """A vehicle's details of its problem; None for unknown ones."""

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
    """Whether it goes away by itself."""
    needs_person: bool | None = None
    load_movable: bool | None = None


class BodyWaitView(View, kw_only=True):
    """What a vehicle's body waits for, in its driver's words."""

    what: str
    until: str = ""
    """The end of the wait; empty if the driver does not know."""
    since_at_s: float


class HelpView(View, kw_only=True):
    """A problem that a person can solve while its task or goals wait."""

    until_at_s: float
    """Deadline: if solved by then, work goes on; else another agent takes the task or goals."""
    promised_by: str = ""
    """Person on the way; empty while nobody is."""
    promise_max_s: float = PROMISE_MAX_S
    """Maximum time from now for which help may be promised, in factory seconds."""


class OutOfServiceView(View, kw_only=True):
    """A person has taken a vehicle or machine out of service: it takes no work and raises no alarm."""

    by: str
    since_at_s: float
    reason: str = ""
    back_at_s: float | None = None
    """Expected return; None if unknown."""
    after_work: bool = False
    """Whether it first finishes what it carries."""


class RemovalRefusalView(View, kw_only=True):
    """A machine or storage that keeps places for the vehicle, and does not believe the report."""

    agent: str
    """Empty for one outside of the caller's areas."""
    reason: RemovalRefusal
    text: str
    """The reason in English, and what to do."""


class RemovalView(View, kw_only=True):
    """A person has carried the vehicle away, and it was not heard since."""

    number: int
    by: str
    at_s: float
    believed_at_s: float
    """Moment from which it has been silent long enough to free its places."""
    freed: tuple[str, ...] = ()
    """Places that it held and that are free now."""
    refused: tuple[RemovalRefusalView, ...] = ()
    """Who refuses this report, and why. In the first minute every report is refused, which is not told."""
    node: str = ""
    """Node where it is being put back; empty while it is off the floor."""
    kept: bool = False
    """Whether that place is reserved for it, so that it may be put down there."""


class AtvView(View, kw_only=True):
    """An ATV, by its last heartbeat."""

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
    """Nodes and crossings reserved for it; empty where vehicles drive without right of way."""
    battery_frac: float
    battery_reckoned: bool = False
    """Whether the battery level is estimated from time and metres, not measured."""
    battery_low: bool = False
    """Whether it must charge before it takes work, by its type's `must_below_frac`."""
    load: str = ""
    load_quantity: int = 0
    link: Literal["wlan", "mesh"] = "wlan"
    via: tuple[str, ...] = ()
    """Vehicles that relay its heartbeat, in order, when the link is mesh."""
    task: BriefView | None = None
    watches: tuple[BriefView, ...] = ()
    dwell_point: str = ""
    speed_limit_frac: float = 1.0
    acknowledged: bool = False
    """While stopped: whether a person has confirmed that the reason is gone, so that it may be resumed."""
    problem: str = ""
    about_problem: ProblemView | None = None
    """None without a problem, or where only words are known."""
    body_wait: BodyWaitView | None = None
    """None if it waits for nothing, for less than ten seconds, or does not report it."""
    help: HelpView | None = None
    software: str = ""
    draining: bool = False
    """Whether it shuts down gracefully: it takes nothing new, and leaves when nothing holds it."""
    out_of_service: OutOfServiceView | None = None
    sent_to_charge: bool = False
    """Whether a person has sent it to charge: it takes no work before it is full."""
    in_reserve: bool = False
    """Whether it belongs to the reserve of a fleet that is too large for its floor: it takes only work that others cannot do."""
    probation: ProbationView | None = None
    """Set while it is on probation and takes short tasks only."""
    asks_where_it_stands: bool = False
    """Whether its own position is not reserved for it yet: it does not drive before."""
    removal: RemovalView | None = None
    """Set while a person has it off the floor: all other fields are older."""
    shut_out: ShutOutView | None = None
    """Set while it is shut out and ignored: all other fields are older."""
    clock: ClockView | None = None
    """None while unknown."""
    seen_at_s: float
    silence: SilenceView
