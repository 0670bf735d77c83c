"""Overload: the vehicles cannot carry what is asked for. One rule, for the gateway's alert and for the verdict on a run.

Announcements reach everybody in the end, and a vehicle that is free takes what waits. So a transport that has waited
long, and whose coordinator knows of no other reason, has found no vehicle; and many of them at once are no chance.
"""

from __future__ import annotations

from collections.abc import Iterable

WAITED_S = 300.0
"""Factory seconds without a vehicle: three transports of a plant that keeps up take less."""

LEAST = 3
"""Transports that wait so long at once..."""

PER_VEHICLE = 0.25
"""...or so many for each vehicle, if that is more."""

OVER_FRAC = 0.5
"""It is over when only this part of them is left: an alert must not come and go with every transport."""


class Overload:
    """Whether a plant is overloaded.

    Attributes:
        lasts: whether it was at the last look.
        waiting: transports that had waited too long at the last look.
    """

    def __init__(self) -> None:
        self.lasts = False
        self.waiting = 0

    def look(self, waited_s: Iterable[float], vehicles: int) -> bool:
        """Look at the plant's demand.

        Args:
            waited_s: of every transport that has no vehicle and no other trouble, since when it has been announced
                (factory seconds).
            vehicles: that are there to carry them.

        Returns:
            Whether it is more than these vehicles can carry.
        """
        self.waiting = sum(each_s > WAITED_S for each_s in waited_s)
        most = max(LEAST, PER_VEHICLE * vehicles)
        self.lasts = self.waiting >= (OVER_FRAC * most if self.lasts else most)
        return self.lasts
