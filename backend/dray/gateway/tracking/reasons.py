"""Why an order waits, in kinds that reveal nothing of the factory. Pure.

The factory's own words name machines and are not passed on. A reason is given only if an agent has reported
it, and only while it lasts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import StrEnum


class Reason(StrEnum):
    """Why an order does not go on."""

    NOT_RELEASED = "not_released"
    """It is stored and not released."""
    NO_MACHINE = "no_machine"
    """No machine now working can make a part of it."""
    REPAIR = "repair"
    """A machine with a part of it is broken."""
    HANDED_ON = "handed_on"
    """A machine has failed with a part of it; another one makes it, or will."""
    MATERIAL = "material"
    """All its machines lack material, or the next one already waits for some."""
    HELD_UP = "held_up"
    """Finished pieces are stuck on their way out."""
    OVERTAKEN = "overtaken"
    """More urgent work came before a part of it, and its machine has moved its promise."""
    STARTED_ANEW = "started_anew"
    """The factory was started without a memory of it, so what had not arrived is made once more."""


class Doing(StrEnum):
    """The activity of a machine with a part of an order."""

    MAKING = "making"
    STARVED = "starved"
    """It works at this order, and lacks material."""
    BUSY = "busy"
    """It makes something else first, or has finished its part."""
    BROKEN = "broken"
    SILENT = "silent"
    """It has not been heard lately, or ever."""


def reasons(
    *,
    released: bool,
    waits: bool,
    lost: bool,
    held_up: bool,
    lacks: bool,
    overtaken: bool,
    started_anew: bool = False,
    doings: Sequence[Doing],
) -> tuple[Reason, ...]:
    """Why an open order waits; empty when it goes on.

    Args:
        released: whether the factory has it.
        waits: whether the strategist has reported that no machine can make a part of it.
        lost: whether a machine has failed with a part of it.
        held_up: whether a transport of its goods has reported a halt.
        lacks: whether a machine with a part of it waits for material for that part.
        overtaken: whether a part of it waits for more urgent work that came after it.
        started_anew: whether a part of it ended because the factory was started without a memory of it.
        doings: activities of the machines with unfinished parts.
    """
    if not released:
        return (Reason.NOT_RELEASED,)
    at_it = [doing for doing in doings if doing in {Doing.MAKING, Doing.STARVED}]
    return tuple(
        _true(
            (Reason.NO_MACHINE, waits),
            (Reason.REPAIR, Doing.BROKEN in doings),
            (Reason.HANDED_ON, lost),
            # It is no wait if one machine lacks material while another makes pieces.
            (Reason.MATERIAL, (bool(at_it) or lacks) and Doing.MAKING not in at_it),
            (Reason.HELD_UP, held_up),
            (Reason.OVERTAKEN, overtaken),
            (Reason.STARTED_ANEW, started_anew),
        )
    )


def _true(*cases: tuple[Reason, bool]) -> Iterable[Reason]:
    return (reason for reason, holds in cases if holds)
