"""Limits: how often somebody may try, as buckets that fill up again with time.

Our own, and not the package `limits`: a try that has succeeded is given back, time comes from the caller, and names are bounded
(docs/decisions/11-libraries.md).
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable
from http import HTTPStatus
from ipaddress import IPv6Address, ip_address

from dray.gateway.http.problems import Problem

BUCKETS = 10_000
"""Kept at once, some 2 MB; the one that was used longest ago makes room."""

NETWORK_BITS = 64
"""Of an IPv6 address: whoever has one has all those that begin with it."""


class Limit:
    """One bucket of tries per name.

    Args:
        wall_s: the wall clock.
        tries: in a full bucket.
        rate_hz: tries that come back per second.
    """

    def __init__(self, wall_s: Callable[[], float], *, tries: float, rate_hz: float) -> None:
        self._wall_s, self._tries, self._rate_hz = wall_s, tries, rate_hz
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()
        """Per name: what was left, and when."""

    def take(self, name: str) -> None:
        """Use a try up.

        Raises:
            Problem: 429, there is none left.
        """
        left = self._left(name)
        if left < 1:
            raise too_many((1 - left) / self._rate_hz)
        self._keep(name, left - 1)

    def give_back(self, name: str) -> None:
        """It was no try: it has succeeded."""
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
    """Somebody tries too often.

    Args:
        wait_s: until it is worth while to try again.
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
    """The address, or the network where one of it is as good as all of it."""
    try:
        parsed = ip_address(address)
    except ValueError:
        return address
    if not isinstance(parsed, IPv6Address):
        return address
    if parsed.ipv4_mapped is not None:
        return str(parsed.ipv4_mapped)
    return f"{int(parsed) >> (128 - NETWORK_BITS):x}"
