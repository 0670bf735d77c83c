"""Limits: how often a caller may try, as buckets that refill with time.

Our own instead of the package `limits`: a successful try is given back, time comes from the caller, and names
are bounded (docs/decisions/11-libraries.md).
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable
from http import HTTPStatus
from ipaddress import IPv6Address, ip_address

from dray.gateway.http.problems import Problem

BUCKETS = 10_000
"""Maximum buckets, some 2 MB; the least recently used one is dropped."""

NETWORK_BITS = 64
"""Network part of an IPv6 address in bits: its owner has all addresses behind it."""


class Limit:
    """One bucket of tries per name.

    Args:
        wall_s: the wall clock.
        tries: size of a full bucket.
        rate_hz: tries refilled per second.
    """

    def __init__(self, wall_s: Callable[[], float], *, tries: float, rate_hz: float) -> None:
        self._wall_s, self._tries, self._rate_hz = wall_s, tries, rate_hz
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()
        """Per name, the tries left and when."""

    def take(self, name: str) -> None:
        """Use up a try.

        Raises:
            Problem: 429, there is none left.
        """
        left = self._left(name)
        if left < 1:
            raise too_many((1 - left) / self._rate_hz)
        self._keep(name, left - 1)

    def give_back(self, name: str) -> None:
        """Return a try that has succeeded."""
        self._keep(name, min(self._tries, self._left(name) + 1))

    def _left(self, name: str) -> float:
        left, at_s = self._buckets.get(name, (self._tries, 0.0))
        passed_s = max(0.0, self._wall_s() - at_s)
        return min(self._tries, left + passed_s * self._rate_hz)

    def _keep(self, name: str, left: float) -> None:
        self._buckets[name] = (left, self._wall_s())
        self._buckets.move_to_end(name)
        if len(self._buckets) > BUCKETS:
            self._buckets.popitem(last=False)


def too_many(wait_s: float) -> Problem:
    """The problem of too many tries.

    Args:
        wait_s: seconds until a new try makes sense.
    """
    whole_s = max(1, math.ceil(wait_s))
    return Problem(
        HTTPStatus.TOO_MANY_REQUESTS,
        "too-many-tries",
        "Too many tries",
        f"try again in {whole_s} s",
        headers={"Retry-After": str(whole_s)},
    )


def neighbourhood(address: str) -> str:
    """The address, or its network for IPv6, where one owner has all of it."""
    try:
        parsed = ip_address(address)
    except ValueError:
        return address
    if not isinstance(parsed, IPv6Address):
        return address
    if parsed.ipv4_mapped is not None:
        return str(parsed.ipv4_mapped)
    return f"{int(parsed) >> (128 - NETWORK_BITS):x}"
