"""Random durations around an average, by the seed."""

from __future__ import annotations

from math import log, sqrt
from random import Random


class Durations:
    """Times of one body. Nothing is drawn where the variation is zero.

    Args:
        name: of the body and the seed; everything follows from it.
    """

    __slots__ = ("_name", "_random")

    def __init__(self, name: str) -> None:
        self._name = name
        self._random: Random | None = None

    def draw_s(self, mean_s: float, cv: float) -> float:
        """A log-normal time: never below 0, and seldom much above the average.

        Args:
            mean_s: the average.
            cv: standard deviation over average.
        """
        if not cv:
            return mean_s
        if self._random is None:
            self._random = Random(self._name)
        variance = log(1.0 + cv * cv)
        return mean_s * self._random.lognormvariate(-variance / 2.0, sqrt(variance))
