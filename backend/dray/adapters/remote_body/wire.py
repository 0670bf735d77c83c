"""The messages between a floor and agents elsewhere, with their keys."""

from __future__ import annotations

from typing import Any, get_args

import msgspec

from dray.adapters.remote_body.exchange import Letter, Part
from dray.body import BodyState, Instruction, Report
from dray.plant.model import MachineSpec, VehicleSpec

BodySpec = VehicleSpec | MachineSpec
"""The bodies that may be added to a running floor."""

NO_LIFE = 0
"""Lives count from 1. This number asks for a body's state without taking it over; a body without a life has it, too."""

_KINDS: dict[str, Any] = {
    kind.__name__: kind for union in (Instruction, Report, BodyState, BodySpec) for kind in get_args(union)
}


class Do(msgspec.Struct, array_like=True, frozen=True):
    """Instructions of one life of an agent."""

    life: int
    letter: Letter


class Taken(msgspec.Struct, array_like=True, frozen=True):
    """A body's state, its present life, and whether an earlier life had it."""

    state: Part
    life: int
    known: bool


class BodyReport(msgspec.Struct, array_like=True, frozen=True):
    """A body's message to its present life: reports, and the state after them."""

    life: int
    letter: Letter
    state: Part


class Moved(msgspec.Struct, array_like=True, frozen=True):
    """A pick or drop of a vehicle that is not simulated, at a place that is."""

    vehicle: str
    life: int
    """The life of its agent."""
    action: Part | None
    """The transfer, numbered in its life by `order`; None only asks whether the floor counts for this vehicle."""


encode = msgspec.msgpack.Encoder().encode


def to_part(what: object) -> Part:
    """Encode an object for a letter."""
    return type(what).__name__, msgspec.Raw(encode(what))


def from_part(part: Part) -> Any:
    """Decode an object from a letter."""
    kind, raw = part
    return msgspec.msgpack.decode(raw, type=_KINDS[kind])


def added_key(plant: str) -> str:
    """The key for adding a body to a floor."""
    return f"{plant}/floor/@joining"


def moved_key(plant: str) -> str:
    """The key for telling a floor a transfer of a vehicle that is not simulated there; the reply says why it is not counted."""
    return f"{plant}/floor/@moved"


def body_key(plant: str, agent: str) -> str:
    """The key for asking a body's state; the keys of its messages are below it."""
    # No wildcard matches a chunk with an @, so listening to everything does not include it.
    return f"{plant}/body/@{agent}"
