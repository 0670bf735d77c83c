"""What goes between a floor and the agents that are elsewhere: keys, and what is said on them."""

from __future__ import annotations

from typing import Any, get_args

import msgspec

from dray.adapters.remote_body.exchange import Letter, Part
from dray.body import BodyState, Instruction, Report
from dray.plant.model import MachineSpec, VehicleSpec

BodySpec = VehicleSpec | MachineSpec
"""What may be put down on a floor that runs already."""

NO_LIFE = 0
"""Lives count from 1. This one asks how a body is and takes nothing over, and has the body that nobody has."""

_KINDS: dict[str, Any] = {
    kind.__name__: kind for union in (Instruction, Report, BodyState, BodySpec) for kind in get_args(union)
}


class Do(msgspec.Struct, array_like=True, frozen=True):
    """Instructions of one life of an agent."""

    life: int
    letter: Letter


class Taken(msgspec.Struct, array_like=True, frozen=True):
    """How a body is, which life has it now, and whether any life has had it before."""

    state: Part
    life: int
    known: bool


class Told(msgspec.Struct, array_like=True, frozen=True):
    """What a body tells the life that has it: reports, and how it is after them."""

    life: int
    letter: Letter
    state: Part


class Moved(msgspec.Struct, array_like=True, frozen=True):
    """A vehicle that is not simulated has picked or dropped at a place that is."""

    vehicle: str
    life: int
    """Of its agent."""
    action: Part | None
    """Numbered in its life by `order`; None only asks whether the floor counts for this vehicle."""


encode = msgspec.msgpack.Encoder().encode


def to_part(what: object) -> Part:
    """As it goes into a letter."""
    return type(what).__name__, msgspec.Raw(encode(what))


def from_part(part: Part) -> Any:
    """As it was before it went into a letter."""
    kind, raw = part
    return msgspec.msgpack.decode(raw, type=_KINDS[kind])


def added_key(plant: str) -> str:
    """Where a floor is asked to take one more body in."""
    return f"{plant}/floor/@joining"


def moved_key(plant: str) -> str:
    """Where a floor is told what a vehicle has picked or dropped that is not simulated there; it answers why that is not counted."""
    return f"{plant}/floor/@moved"


def body_key(plant: str, agent: str) -> str:
    """Where a body is asked how it is; below it goes what is said to it and by it."""
    # No wildcard matches a chunk with an @, so nobody hears this by listening to everything.
    return f"{plant}/body/@{agent}"
