"""The kinds of faults: each is a value that says what is wrong, not when.

On the wire a fault is an object with its `kind`: ``{"kind": "wlan_cut", "agent": "ATV1"}``. Bounds are
checked where bytes are read (`dray_sim.faults.schedule`); a struct made in code is believed.
"""

from __future__ import annotations

import re
from typing import Annotated, get_args

import msgspec
from msgspec import Meta

from dray.messages.base import Count, Fraction, Id, Metres, Text

Delay = Annotated[float, Meta(ge=0.0, le=600.0)]
"""Seconds on top of what the network takes; more than ten minutes is a cut, not a delay."""

Pattern = Annotated[str, Meta(min_length=1, max_length=128)]
"""Names agents; ``*`` stands for any number of characters."""


def _snake(name: str) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


class _Kind(msgspec.Struct, frozen=True, tag_field="kind", tag=_snake, forbid_unknown_fields=True):
    """Base of all faults: immutable, comparable, and a misspelt field is an error."""


# --- the network -----------------------------------------------------------------------------------


class WlanCut(_Kind, frozen=True):
    """One agent's WLAN is gone; a wired agent's cable. What it says and what is said to it is lost."""

    agent: Id


class RadioCut(_Kind, frozen=True):
    """One vehicle's radio is gone: it neither sends, nor hears, nor passes anything on by radio."""

    agent: Id


class LinkTrouble(_Kind, frozen=True):
    """Messages from some agents to some others suffer on the WLAN. Several troubles of one link add up.

    An agent's own words reach itself in any case; the radio has troubles of its own.
    """

    sender: Pattern = "*"
    receiver: Pattern = "*"
    latency_s: Delay = 0.0
    """Added to every delivery."""
    jitter_s: Delay = 0.0
    """At most so much more, evenly spread; the order between two agents is kept."""
    loss_frac: Fraction = 0.0
    duplicate_frac: Fraction = 0.0
    """Delivered a second time, some time after the first."""
    reorder_frac: Fraction = 0.0
    """Held up, so that later ones may overtake them."""


class Partition(_Kind, frozen=True):
    """The network falls apart: only agents of one group hear one another. Radios are not concerned."""

    groups: Annotated[tuple[Annotated[tuple[Pattern, ...], Meta(min_length=1)], ...], Meta(min_length=1)]
    """An agent is in the first group that has a pattern for it; whoever is in none is in one more."""


class CoverageHole(_Kind, frozen=True):
    """No WLAN reaches vehicles within this circle: steel was parked there, say."""

    x_m: Metres
    y_m: Metres
    radius_m: Annotated[float, Meta(gt=0.0, le=1e6)]


class AccessPointDown(_Kind, frozen=True):
    """An access point is off; another one may reach the same places."""

    access_point: Id


NetworkFault = WlanCut | RadioCut | LinkTrouble | Partition | CoverageHole | AccessPointDown
"""What the network itself carries out."""

# --- power and processes ---------------------------------------------------------------------------


class PoweredOff(_Kind, frozen=True):
    """A vehicle or a machine is without power: body and agent together."""

    agent: Id


class Crashed(_Kind, frozen=True):
    """An agent's process has ended; its body goes on as bodies do. It is started again at the end."""

    agent: Id


class JournalLost(_Kind, frozen=True):
    """An agent's process has ended, and what it had written down is lost or torn: it is started again without memory."""

    agent: Id


class ClockSet(_Kind, frozen=True):
    """The clock of an agent's computer was set forward by so much, or back, and is set right at the end."""

    agent: Id
    by_s: Annotated[float, Meta(ge=-3600.0, le=3600.0)]


class SentAway(_Kind, frozen=True):
    """An agent was asked to leave in order, for other software say; it is started again at the end.

    Who has not left by then is ended.
    """

    agent: Id
    trial: Count = 0
    """Transports that its next life has to do well before it takes long tasks."""


# --- bodies ----------------------------------------------------------------------------------------


class MachineBroken(_Kind, frozen=True):
    """A machine stands, and its agent can say so."""

    machine: Id
    reason: Text = "a tool has broken"


class VehicleBroken(_Kind, frozen=True):
    """A vehicle has a problem that a person can solve (paper, case 4)."""

    atv: Id
    reason: Text = "the way is blocked"


class LoadShifted(_Kind, frozen=True):
    """A vehicle's load has slipped (paper, case 5); needs a load."""

    atv: Id


Fault = (
    NetworkFault
    | PoweredOff
    | Crashed
    | JournalLost
    | ClockSet
    | SentAway
    | MachineBroken
    | VehicleBroken
    | LoadShifted
)

KINDS: tuple[type[Fault], ...] = get_args(Fault)
KIND_NAMES: tuple[str, ...] = tuple(_snake(kind.__name__) for kind in KINDS)
"""As they stand in `kind` on the wire."""


def kind_of(fault: Fault) -> str:
    """Its name on the wire."""
    return _snake(type(fault).__name__)


def describe(fault: Fault) -> str:
    """One line for a reader: the kind, and what is not left at its default."""
    defaults = type(fault).__struct_defaults__
    names = fault.__struct_fields__
    required = len(names) - len(defaults)
    said = [
        f"{name}={getattr(fault, name)!r}"
        for place, name in enumerate(names)
        if place < required or getattr(fault, name) != defaults[place - required]
    ]
    return f"{kind_of(fault).replace('_', ' ')} ({', '.join(said)})"
