"""The gate of the delivery warehouses, the strategist's body: what it is told and what it tells (see `dray.body`)."""

from __future__ import annotations

from dray.messages.base import Part


class Admit(Part, frozen=True):
    """Let in as many pieces of this goal, those that have arrived included, and no more.

    The gate is where a goal is fenced: pieces of a goal that was given to another machine meanwhile
    are not let in, whoever brings them. Answered with `GoodsArrived`, also when nothing changes.
    Less than have arrived already means: no more.
    """

    goal: str
    quantity: int


class GoodsArrived(Part, frozen=True):
    """How many pieces of a goal are in by now: said after every arrival and every `Admit`."""

    goal: str
    arrived: int
    admitted: int
    """How many may get in at all; 0 tells that the gate is shut and `arrived` the last word."""
    vehicle: str = ""
    """Who has brought the last ones; empty after an `Admit`, and where the gate cannot tell."""


class GateState(Part, frozen=True):
    """What the gate has counted since it was built."""

    arrived: dict[str, int]
    """Pieces by goal, for every goal that was ever admitted and is not forgotten."""
