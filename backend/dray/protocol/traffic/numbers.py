"""How far one agent's word alone moves numbers that only grow: epochs of a reservation table, and versions of it.

There is an end of numbers (`COUNT_MAX`). Whoever could bring a reservation table there, or beyond what others believe, would stop its district for good.
"""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages.base import COUNT_MAX

LEAP_MAX = 2**20
"""Nobody believes one replica alone that the epoch is higher than the present one by more."""

OUTBID_MAX = LEAP_MAX // 4
"""By so much a replica alone lets a vehicle go on, or a vehicle a replica, to a later epoch. Less than `LEAP_MAX`: copies follow the epoch that is begun
then, also one that has missed the one before."""

FAR = COUNT_MAX // 2
"""Nobody believes that an epoch or a version has come farther: a thousand a second do not in 100,000 years."""

ALONE_MAX = FAR // 2
"""One word alone brings no number farther. So what honest agents count from there on is far from `FAR` for ever."""

VERSION_LEAP = 2**27
"""Above `ALONE_MAX` nobody believes one word alone that the version is higher than what others have told by more."""


def most_believed(known: int, leap: int) -> int:
    """How far one word alone brings a number of which the highest is known that others have told."""
    return max(ALONE_MAX, known) + leap


def is_version_believed(version: int, known: int) -> bool:
    """Whether a reservation table can have come to a version.

    Args:
        version: that somebody tells.
        known: the highest that is known.
    """
    return version <= most_believed(known, VERSION_LEAP)


def highest_believed(said: Iterable[int], known: int = 0, leap: int = VERSION_LEAP) -> int:
    """How far a number has come.

    Whoever tells more than is believed is not contradicted: it moves the number by half as much. So what honest agents count from there on is
    believed the next time, when it may be the only word.

    Args:
        said: what each of several agents has told, once.
        known: the highest that is known otherwise.
        leap: by how much more one of them is believed alone, above `ALONE_MAX`.
    """
    for number in sorted(said):
        is_believed = number <= most_believed(known, leap)
        known = max(known, number if is_believed else most_believed(known, leap // 2))
    return known
