"""Outsiders: the agents that people have shut out, as panels see them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dray.gateway.live.views import ShutOutView
from dray.store.factory.exclusions import Exclusion


class Outsiders:
    """All agents that are shut out; at most as many as one message on the bus can name."""

    def __init__(self) -> None:
        self._exclusions: dict[str, Exclusion] = {}

    def __contains__(self, agent: object) -> bool:
        return agent in self._exclusions

    def __iter__(self) -> Iterator[Exclusion]:
        return iter(self._exclusions.values())

    def put(self, exclusions: Iterable[Exclusion]) -> set[str]:
        """Replace all exclusions; returns the agents whose exclusion changed."""
        before, self._exclusions = self._exclusions, {each.agent: each for each in exclusions}
        return {agent for agent, _ in before.items() ^ self._exclusions.items()}

    def view(self, agent: str) -> ShutOutView | None:
        """The exclusion of one agent; None when it is not shut out."""
        known = self._exclusions.get(agent)
        return None if known is None else ShutOutView(by=known.by, reason=known.reason, at_s=known.at_s)
