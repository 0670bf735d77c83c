"""The subscribers of each key, and a cache of the receivers of a key."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from dray.errors import ProtocolViolation

if TYPE_CHECKING:
    from collections.abc import Callable

    from dray_sim.network.session import SimSession

MAX_KEYS = 10_000
"""Keys whose receivers are remembered: ten times those of a plant of three hundred agents."""


class Subscriptions:
    """Subscriptions to keys and to patterns of keys.

    Attributes:
        found: the receivers of keys that were asked for lately, for callers that must not pay for a call: `of`
            answers for any other key.
    """

    def __init__(self) -> None:
        self.found: dict[str, tuple[SimSession, ...]] = {}
        # Dicts for sets: they keep the order of insertion, and order is what makes runs repeatable.
        self._exact: dict[str, dict[SimSession, None]] = {}
        self._patterns: dict[str, tuple[Callable[[str], object], dict[SimSession, None]]] = {}

    def __len__(self) -> int:
        """Keys and patterns that anybody listens to."""
        return len(self._exact) + len(self._patterns)

    def add(self, session: SimSession, key: str) -> None:
        """Let `session` hear `key`, which may hold wildcards."""
        if "*" not in key:
            self._exact.setdefault(key, {})[session] = None
            self.found.pop(key, None)
            return
        if key not in self._patterns:
            self._patterns[key] = (compile_pattern(key), {})
        self._patterns[key][1][session] = None
        self.found.clear()

    def remove(self, session: SimSession, key: str) -> None:
        """Let `session` hear `key` no longer; harmless when it never did."""
        if "*" not in key:
            subscribers = self._exact.get(key, {})
            subscribers.pop(session, None)
            if not subscribers:
                self._exact.pop(key, None)
            self.found.pop(key, None)
            return
        if key in self._patterns:
            subscribers = self._patterns[key][1]
            subscribers.pop(session, None)
            if not subscribers:
                del self._patterns[key]
            self.found.clear()

    def forget(self, session: SimSession) -> None:
        """Let `session` hear nothing any more."""
        for key in [key for key, subscribers in self._exact.items() if session in subscribers]:
            self.remove(session, key)
        for key in [key for key, (_, subscribers) in self._patterns.items() if session in subscribers]:
            self.remove(session, key)

    def of(self, key: str) -> tuple[SimSession, ...]:
        """The receivers of `key`, in the order in which they joined.

        Raises:
            ProtocolViolation: the key holds a wildcard.
        """
        receivers = self.found.get(key)
        return self._find(key) if receivers is None else receivers

    def _find(self, key: str) -> tuple[SimSession, ...]:
        if "*" in key:
            raise ProtocolViolation(f"published on {key!r}: only subscriptions may hold wildcards")
        subscribers = dict(self._exact.get(key, {}))
        for matches, also in self._patterns.values():
            if matches(key):
                subscribers.update(also)
        # Ordered by joining: the kind of subscription must not decide which agent hears first.
        receivers = tuple(sorted(subscribers, key=lambda session: session.number))
        if len(self.found) >= MAX_KEYS:
            self.found.clear()
        self.found[key] = receivers
        return receivers


def compile_pattern(pattern: str) -> Callable[[str], object]:
    """Make a matcher of a key expression: ``*`` is one chunk, ``**`` any number of them, also none.

    Args:
        pattern: chunks joined by ``/``, as in Zenoh.

    Returns:
        A function of a key, whose result is true when the pattern matches.
    """
    chunks = {"**": "(?:/[^/]+)*", "*": "/[^/]+"}
    parts = (chunks.get(chunk) or "/" + re.escape(chunk) for chunk in pattern.split("/"))
    match = re.compile("".join(parts)).fullmatch
    return lambda key: match("/" + key)
