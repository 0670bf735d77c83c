"""Outsiders: the agents that people have shut out, as panels are told of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dray.gateway.live.views import ShutOutView
from dray.store.factory.exclusions import Exclusion


class Outsiders:
    """Everybody who is shut out; at most as many as the bus can be told of."""

    def __init__(self) -> None:
        self._exclusions: dict[str, Exclusion] = {}

    def __contains__(self, agent: object) -> bool:
        return agent in self._exclusions

    def __iter__(self) -> Iterator[Exclusion]:
        return iter(self._exclusions.values())

    def put(self, exclusions: Iterable[Exclusion]) -> set[str]:
        """Replace all of them; returns the agents of which something else is said now."""
        before, self._exclusions = self._exclusions, {each.agent: each for each in exclusions}
        return {agent for agent, _ in before.items() ^ self._exclusions.items()}

    def view(self, agent: str) -> ShutOutView | None:
        """What panels are told of one agent; None when it is not shut out."""
        known = self._exclusions.get(agent)
        return None if known is None else ShutOutView(by=known.by, reason=known.reason, at_s=known.at_s)
