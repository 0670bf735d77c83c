"""How far one agent's word alone moves numbers that only grow: epochs of a book, and versions of it.

There is an end of numbers (`COUNT_MAX`). Whoever could bring a book there, or beyond what others believe, would stop its district for good.
"""

from __future__ import annotations

from dray.messages.base import COUNT_MAX

LEAP_MAX = 2**20
"""Nobody believes one keeper alone that the epoch is higher than the present one by more."""

OUTBID_MAX = LEAP_MAX // 4
"""By so much a keeper alone lets a vehicle go on, or a vehicle a keeper, to a later epoch. Less than `LEAP_MAX`: copies follow the epoch that is begun
then, also one that has missed the one before."""

FAR = COUNT_MAX // 2
"""Nobody believes that an epoch or a version has come so far: a thousand a second do not in 100,000 years."""

VERSION_LEAP = 2**32
"""Above `FAR` a copy believes that the version is higher than its own by no more."""


def is_version_believed(version: int, known: int) -> bool:
    """Whether a book can have come to a version.

    Args:
        version: that somebody tells.
        known: the highest that is known.
    """
    return version <= max(FAR, known + VERSION_LEAP)
