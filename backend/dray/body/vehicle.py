"""A vehicle's body, simulated or a real vehicle behind VDA 5050: what it is told and what it tells.

A way is given as nodes of which a first part is released (VDA 5050's base and horizon), picking and dropping are actions at a
node, holding and going on work at once, and every step comes back as a report.

Every way and action has an `order` number that its agent chose; reports carry it back, so that a report about something that
was replaced meanwhile is recognised and ignored.
"""

from __future__ import annotations

from dray.messages.base import Part
from dray.messages.floor.obstacle import WayBlocked, WayFree
from dray.messages.heartbeat import BodyWait, Pose
from dray.messages.link import Link
from dray.messages.problem import NOTHING_KNOWN, Problem


class Drive(Part, frozen=True):
    """Follow a way. Replaces the way before it; ends charging.

    A moving vehicle finishes the lane that it is on and turns off there: `nodes[0]` must be the
    `VehicleState.next_node` of this moment. A standing vehicle stands at `nodes[0]`.
    """

    order: int
    nodes: tuple[str, ...]
    """At least one; each joined to the next by a lane."""
    released: int
    """How many of `nodes` may be driven to by now, from 1 to all: the vehicle brakes at the last one."""
    limits_mps: tuple[float | None, ...] = ()
    """The highest speed on each lane of the way, where people have made it slow; None where the plant's holds, and empty where
    it does everywhere."""


class ReleaseWay(Part, frozen=True):
    """More of the way may be driven."""

    order: int
    released: int


class Pick(Part, frozen=True):
    """Take a load up at the station where the vehicle stands; at a node that is no station, from a person's hands."""

    order: int
    station: str
    item: str
    quantity: int


class Drop(Part, frozen=True):
    """Put the load down at the station where the vehicle stands."""

    order: int
    station: str
    goal: str = ""
    """At a delivery warehouse, the goal whose pieces these are; without one they are set aside there."""


class Charge(Part, frozen=True):
    """Charge at the charger where the vehicle stands, until the next instruction or full."""

    order: int
    charger: str


class Hold(Part, frozen=True):
    """Stop at once and stay; actions pause too. Holding twice is harmless."""


class Unhold(Part, frozen=True):
    """Go on with what was held."""


SLOWEST_FRAC = 0.01
"""No limit is lower: a vehicle that is to stand is stopped."""


class LimitSpeed(Part, frozen=True):
    """Keep below this part of the vehicle's own top speed."""

    speed_frac: float
    """Above 0, at most 1; below SLOWEST_FRAC the vehicle keeps that."""


VehicleInstruction = Drive | ReleaseWay | Pick | Drop | Charge | Hold | Unhold | LimitSpeed


class NodePassed(Part, frozen=True):
    """A node of the way was reached, the first and last ones included."""

    order: int
    node: str
    index: int
    """Its place in `Drive.nodes`."""
    battery_frac: float


class WayDone(Part, frozen=True):
    """The vehicle stands at the last node of its way."""

    order: int
    node: str


class ActionDone(Part, frozen=True):
    """A pick or drop has ended well, or a charge has filled the battery."""

    order: int


class ActionFailed(Part, frozen=True):
    """A pick, drop or charge ended without effect: the load is where it was."""

    order: int
    reason: str


class ProblemRaised(Part, frozen=True):
    """Something keeps the vehicle from going on. Another one on top of it replaces it; the worst should be said last.

    How long its task waits follows from `problem` (`dray.protocol.people.patience`): say what is known, and no more.
    """

    reason: str
    """In words, for people; not empty."""
    problem: Problem = NOTHING_KNOWN
    """Its kind, and what is known of it."""


class ProblemCleared(Part, frozen=True):
    """It is gone."""


class LinkNoticed(Part, frozen=True):
    """The vehicle's modem has lost the WLAN, or is back on it."""

    link: Link
    access_point: str = ""
    """Of a loss: over which it was on the WLAN last; empty where the modem does not know."""


_OnTheWay = NodePassed | WayDone | WayBlocked | WayFree
VehicleReport = _OnTheWay | ActionDone | ActionFailed | ProblemRaised | ProblemCleared | LinkNoticed


class VehicleState(Part, frozen=True):
    """Everything a vehicle can sense of itself at one moment."""

    pose: Pose
    node: str
    """The last node that was passed."""
    next_node: str
    """Where a new way may begin: the end of the lane it is on, or `node` when it stands there."""
    next_node_s: float
    """Seconds until `next_node` at the present speed; 0 when it stands there."""
    speed_mps: float
    battery_frac: float
    load: str
    """Empty for nothing."""
    load_quantity: int
    held: bool
    charging: bool
    link: Link = Link.WLAN
    problem: str = ""
    """What keeps it from going on; empty for nothing."""
    about_problem: Problem = NOTHING_KNOWN
    """Its kind, and what is known of it; says nothing where there is none."""
    battery_reckoned: bool = False
    """It is not known how full it is: `battery_frac` is reckoned by time and metres."""
    wait: BodyWait | None = None
    """What it waits for at this moment; None for nothing, and where it does not tell."""
    base_end: str = ""
    """The node up to which the way that it was given last is released; empty when it has come there, or has none."""
