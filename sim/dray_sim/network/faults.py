"""Network faults as data: each kind is a value that says what is wrong, not when.

On the wire a fault is an object with its `kind`: ``{"kind": "wlan_cut", "agent": "ATV1"}``. Bounds are
checked where bytes are read (`dray_sim.faults.schedule`); a struct made in code is believed.
"""

from __future__ import annotations

import re
from typing import Annotated

import msgspec
from msgspec import Meta

from dray.messages.base import Fraction, Id, Metres

Delay = Annotated[float, Meta(ge=0.0, le=600.0)]
"""Seconds of additional delay; more than ten minutes is a cut, not a delay."""

Pattern = Annotated[str, Meta(min_length=1, max_length=128)]
"""Names agents; ``*`` stands for any number of characters."""


def snake(name: str) -> str:
    """A kind's name on the wire."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


class FaultKind(msgspec.Struct, frozen=True, tag_field="kind", tag=snake, forbid_unknown_fields=True):
    """Base of all faults, here and in `dray_sim.faults`: immutable, comparable, a misspelt field is an error."""


class WlanCut(FaultKind, frozen=True):
    """One agent has no WLAN; a wired agent has no cable. All messages from it and to it are lost."""

    agent: Id


class RadioCut(FaultKind, frozen=True):
    """One vehicle has no radio: it neither sends, nor hears, nor relays by radio."""

    agent: Id


class LinkTrouble(FaultKind, frozen=True):
    """Messages from some agents to some others suffer on the WLAN. Several troubles of one link add up.

    An agent's own words reach itself in any case; the radio has troubles of its own.
    """

    sender: Pattern = "*"
    receiver: Pattern = "*"
    latency_s: Delay = 0.0
    """Added to every delivery."""
    jitter_s: Delay = 0.0
    """Most additional random delay, uniform; the order between two agents is kept."""
    loss_frac: Fraction = 0.0
    duplicate_frac: Fraction = 0.0
    """Delivered a second time, some time after the first."""
    reorder_frac: Fraction = 0.0
    """Held up, so that later ones may overtake them."""


class Partition(FaultKind, frozen=True):
    """The network falls apart: only agents of one group hear one another. Radios are not concerned."""

    groups: Annotated[tuple[Annotated[tuple[Pattern, ...], Meta(min_length=1)], ...], Meta(min_length=1)]
    """An agent is in the first group that has a pattern for it; agents in none form one more group."""


class CoverageHole(FaultKind, frozen=True):
    """No WLAN reaches vehicles within this circle, as behind parked steel."""

    x_m: Metres
    y_m: Metres
    radius_m: Annotated[float, Meta(gt=0.0, le=1e6)]


class AccessPointDown(FaultKind, frozen=True):
    """An access point is off; another one may reach the same places."""

    access_point: Id


NetworkFault = WlanCut | RadioCut | LinkTrouble | Partition | CoverageHole | AccessPointDown
"""Faults that the network itself carries out."""
