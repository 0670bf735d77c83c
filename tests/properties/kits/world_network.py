"""The network of the small world, which does what it likes."""

from __future__ import annotations

from random import Random

LATENCY_S = 0.02


class Network:
    """How messages fare: changed at will while the world runs.

    Args:
        random: what is left to chance.
    """

    def __init__(self, random: Random) -> None:
        self._random = random
        self.loss_frac = 0.0
        self.double_frac = 0.0
        self.latency_s = LATENCY_S
        self.jitter_s = 0.0
        """Messages overtake one another."""
        self.cut_off: set[str] = set()
        """Agents that neither hear nor are heard."""

    def heal(self) -> None:
        self.loss_frac = self.double_frac = self.jitter_s = 0.0
        self.latency_s = LATENCY_S
        self.cut_off.clear()

    def delays_s(self, sender: str, to: str) -> list[float]:
        """How long each copy of one message is under way; none when it is lost."""
        if sender in self.cut_off or to in self.cut_off:
            return []
        copies = 2 if self._random.random() < self.double_frac else 1
        return [
            self.latency_s + self.jitter_s * self._random.random()
            for _ in range(copies)
            if self._random.random() >= self.loss_frac
        ]
