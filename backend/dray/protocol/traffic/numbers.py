"""Limits on how far a single agent can raise numbers that only grow: epochs and versions of a reservation table, and vehicles' requests.

Numbers end at `COUNT_MAX`. An agent that raised a table's number to that end, or beyond what others believe, would stop its
district for good.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages.base import COUNT_MAX

LEAP_MAX = 2**20
"""Largest raise of the epoch above the present one that is believed from a single replica."""

OUTBID_MAX = LEAP_MAX // 4
"""Largest raise of the epoch that a single replica causes at a vehicle, or a vehicle at a replica. It is below `LEAP_MAX`, so that
copies follow the new epoch even when they have missed the one before."""

FAR = COUNT_MAX // 2
"""Highest believed epoch, version, life or number of a request: at a thousand a second, it is not reached in 100,000 years."""

ALONE_MAX = FAR // 2
"""Number up to which a single agent is believed. Honest agents that count on from there stay far below `FAR` for ever."""

VERSION_LEAP = 2**27
"""Largest raise of the version, above `ALONE_MAX` and others' reports, that is believed from a single agent."""


def most_believed(known: int, leap: int) -> int:
    """The highest number that is believed from a single agent, when others have reported `known`."""
    return max(ALONE_MAX, known) + leap


def is_version_believed(version: int, known: int) -> bool:
    """Whether a table's reported version is believed.

    Args:
        version: the reported one.
        known: the highest known one.
    """
    return version <= most_believed(known, VERSION_LEAP)


def highest_believed(said: Iterable[int], known: int = 0, leap: int = VERSION_LEAP) -> int:
    """The highest believed number among several reports.

    A report above what is believed still raises the number by half a leap. So the numbers that honest agents count from there are
    believed the next time, even when only one agent reports them.

    Args:
        said: one report of each agent.
        known: the highest number known otherwise.
        leap: the raise above `ALONE_MAX` that is believed from a single agent.
    """
    for number in sorted(said):
        is_believed = number <= most_believed(known, leap)
        known = max(known, number if is_believed else most_believed(known, leap // 2))
    return known
