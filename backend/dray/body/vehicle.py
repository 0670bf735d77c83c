"""A vehicle's body, simulated or a real vehicle behind VDA 5050: its instructions and reports.

A way is a list of nodes whose first part is released (VDA 5050's base and horizon). Picking and dropping are actions at a
node. Holding and resuming take effect at once, and every step is reported.

Every way and action has an `order` number that its agent chose. Reports carry it, so that a report about a replaced
instruction is recognised and ignored.
"""

from __future__ import annotations

from dray.messages.base import Part
from dray.messages.floor.obstacle import WayBlocked, WayFree
from dray.messages.heartbeat import BodyWait, Pose
from dray.messages.link import Link
from dray.messages.problem import NOTHING_KNOWN, Problem


class Drive(Part, frozen=True):
    """Follow a way. Replaces the previous way; ends charging.

    A moving vehicle finishes its lane and turns off there: `nodes[0]` must be the `VehicleState.next_node` of this moment. A
    standing vehicle stands at `nodes[0]`.
    """

    order: int
    nodes: tuple[str, ...]
    """At least one; each joined to the next by a lane."""
    released: int
    """Number of `nodes` that are released, from 1 to all: the vehicle brakes at the last one."""
    limits_mps: tuple[float | None, ...] = ()
    """Maximum speed on each lane of the way, where people have limited it; None where the plant's limit holds. Empty where it
    holds everywhere."""


class ReleaseWay(Part, frozen=True):
    """Release more of the way."""

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
    """At a delivery warehouse, the goal of the pieces; pieces without one are set aside there."""


class Charge(Part, frozen=True):
    """Charge at the charger where the vehicle stands, until full or the next instruction."""

    order: int
    charger: str


class Hold(Part, frozen=True):
    """Stop at once and stay; actions pause too. Holding twice is harmless."""


class Unhold(Part, frozen=True):
    """Resume what was held."""


SLOWEST_FRAC = 0.01
"""The lowest limit: a vehicle that must stand is stopped instead."""


class LimitSpeed(Part, frozen=True):
    """Keep below this fraction of the vehicle's own top speed."""

    speed_frac: float
    """Above 0, at most 1; lower values than SLOWEST_FRAC count as that."""


VehicleInstruction = Drive | ReleaseWay | Pick | Drop | Charge | Hold | Unhold | LimitSpeed


class NodePassed(Part, frozen=True):
    """A node of the way was reached, the first and last ones included."""

    order: int
    node: str
    index: int
    """The node's index in `Drive.nodes`."""
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
    """Something blocks the vehicle. A later problem replaces the earlier one; report the worst last.

    The timeout of its task follows from `problem` (`dray.protocol.people.patience`): report only what is known.
    """

    reason: str
    """A text for people; not empty."""
    problem: Problem = NOTHING_KNOWN
    """Its kind, and the known details."""


class ProblemCleared(Part, frozen=True):
    """The problem is gone."""


class LinkNoticed(Part, frozen=True):
    """The vehicle's modem has lost the WLAN, or is back on it."""

    link: Link
    access_point: str = ""
    """After a loss, the last access point; empty where the modem does not know."""


_OnTheWay = NodePassed | WayDone | WayBlocked | WayFree
VehicleReport = _OnTheWay | ActionDone | ActionFailed | ProblemRaised | ProblemCleared | LinkNoticed


class UnplacedVehicle(Part, frozen=True):
    """The state of a vehicle that has not told a place since its agent was started."""

    why: str
    """What is missing, as a text for people; not empty."""


class VehicleState(Part, frozen=True):
    """The vehicle's state at one moment."""

    pose: Pose
    node: str
    """The last node passed."""
    next_node: str
    """The possible start of a new way: the end of the current lane, or `node` for a standing vehicle."""
    next_node_s: float
    """Seconds until `next_node` at the present speed; 0 for a standing vehicle."""
    speed_mps: float
    battery_frac: float
    load: str
    """The load on board; empty for nothing."""
    load_quantity: int
    held: bool
    charging: bool
    link: Link = Link.WLAN
    problem: str = ""
    """The problem that blocks it, as text; empty for none."""
    about_problem: Problem = NOTHING_KNOWN
    """Its kind, and the known details; `NOTHING_KNOWN` where there is none."""
    battery_reckoned: bool = False
    """Whether `battery_frac` is only estimated by time and metres."""
    wait: BodyWait | None = None
    """What it waits for at present; None for nothing, and where it does not tell."""
    base_end: str = ""
    """The last node that it may drive to, by its latest way or by one of an earlier life; empty when it is there."""
