"""Why an order waits, in kinds that give nothing of the factory away. Pure.

The factory's own words name machines; none of them is passed on. A kind is given only when an agent
has said what it stands for, and only for as long.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import StrEnum


class Reason(StrEnum):
    """Why an order does not go on as it should."""

    NOT_RELEASED = "not_released"
    """It is stored, and nobody has released it."""
    NO_MACHINE = "no_machine"
    """No machine that works at this moment can make a part of it."""
    REPAIR = "repair"
    """A machine that has taken a part of it is broken."""
    HANDED_ON = "handed_on"
    """A machine has failed with a part of it, which is or will be made by another one."""
    MATERIAL = "material"
    """All machines that are at it lack material, or who is to make it next waits for some already."""
    HELD_UP = "held_up"
    """What is made of it is stuck on its way out."""


class Doing(StrEnum):
    """What a machine does that has taken a part of an order."""

    MAKING = "making"
    STARVED = "starved"
    """It is at this order, and lacks material."""
    BUSY = "busy"
    """It makes something else first, or has made its part already."""
    BROKEN = "broken"
    SILENT = "silent"
    """Nothing has been heard of it lately, or ever."""


def reasons(
    *, released: bool, waits: bool, lost: bool, held_up: bool, lacks: bool, doings: Sequence[Doing]
) -> tuple[Reason, ...]:
    """Why an order that has not ended waits; empty when it goes on.

    Args:
        released: whether the factory has it.
        waits: whether the strategist has said that nobody can make a part of it.
        lost: whether a machine has failed with a part of it.
        held_up: whether a transport of its goods has said that it does not go on.
        lacks: whether one of the machines that have taken a part of it waits for material for that part.
        doings: what the machines do that have taken a part which is not made yet.
    """
    if not released:
        return (Reason.NOT_RELEASED,)
    at_it = [doing for doing in doings if doing in {Doing.MAKING, Doing.STARVED}]
    return tuple(
        _true(
            (Reason.NO_MACHINE, waits),
            (Reason.REPAIR, Doing.BROKEN in doings),
            (Reason.HANDED_ON, lost),
            # One machine that lacks material while another makes pieces is no wait.
            (Reason.MATERIAL, (bool(at_it) or lacks) and Doing.MAKING not in at_it),
            (Reason.HELD_UP, held_up),
        )
    )


def _true(*cases: tuple[Reason, bool]) -> Iterable[Reason]:
    return (reason for reason, holds in cases if holds)
