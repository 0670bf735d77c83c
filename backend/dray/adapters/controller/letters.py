"""The messages between an agent and a controller: letters in JSON, on two topics (docs/stations.md).

    dray/PLANT/AGENT/do      the agent's:      {"life": 7, "heard": 12, "first": 4, "parts": [{"type": "OpenDock", "about": {...}}]}
    dray/PLANT/AGENT/told    the controller's: likewise, with "state": {"type": "StorageState", "about": {...}}

`parts` are the unconfirmed parts, numbered from `first`; `heard` is the number of the last part received from the other side. A lost
letter does no harm (`dray.adapters.remote_body.exchange`).
"""

from __future__ import annotations

from typing import Any

import msgspec

from dray.adapters.remote_body.exchange import Letter, Part
from dray.body import (
    Admit,
    CloseDock,
    DockReady,
    FillTo,
    GateProblem,
    GateState,
    GoodsArrived,
    HoldOrder,
    OpenDock,
    Refill,
    StockChanged,
    StorageState,
)
from dray.messages.gate import OrderHeld

DO, TOLD = "do", "told"
"""The last chunks of the topics."""

_KINDS: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        *(OpenDock, CloseDock, DockReady, Refill, FillTo, StockChanged, StorageState),
        *(Admit, HoldOrder, GoodsArrived, GateProblem, OrderHeld, GateState),
    )
}


class Said(msgspec.Struct, frozen=True):
    """One part: an instruction, a report or a state (`dray.body`)."""

    type: str
    about: msgspec.Raw


class Done(msgspec.Struct, frozen=True):
    """A letter of an agent."""

    life: int
    """The agent's life; the controller obeys only the highest."""
    heard: int
    first: int
    parts: tuple[Said, ...] = ()

    @property
    def letter(self) -> Letter:
        """The letter for an exchange."""
        return Letter(self.heard, self.first, tuple((part.type, part.about) for part in self.parts))


class Told(Done, frozen=True, kw_only=True):
    """A letter of a controller."""

    state: Said


encode = msgspec.json.Encoder().encode


def prefix(plant: str, agent: str) -> str:
    """The prefix of an agent's topics."""
    return f"dray/{plant}/{agent}"


def to_part(what: object) -> Part:
    """Encode an object for a letter."""
    return type(what).__name__, msgspec.Raw(encode(what))


def from_part(part: Part) -> Any:
    """Decode an object from a letter.

    Raises:
        msgspec.ValidationError: it is not a message of a controller or its agent.
    """
    name, about = part
    if name not in _KINDS:
        raise msgspec.ValidationError(f"nobody says {name!r}")
    return msgspec.json.decode(about, type=_KINDS[name])


def said(letter: Letter) -> tuple[Said, ...]:
    """The parts of a letter."""
    return tuple(Said(*part) for part in letter.parts)
