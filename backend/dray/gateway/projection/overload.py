"""Overload: the vehicles cannot carry what is asked for, and one alert says so instead of one for every machine.

Announcements reach everybody in the end, and a vehicle that is free takes what waits. So a transport that has waited
long, and whose coordinator knows of no other reason, has found no vehicle; and many of them at once are no chance.
"""

from __future__ import annotations

from collections.abc import Iterator

from dray.gateway.projection.tasks import Tasks
from dray.gateway.projection.troubles import Moment, Trouble

WAITED_S = 300.0
"""Factory seconds without a vehicle: three transports of a plant that keeps up take less."""

LEAST = 3
"""Transports that wait so long at once..."""

PER_VEHICLE = 0.25
"""...or so many for each vehicle, if that is more."""

OVER_FRAC = 0.5
"""It is over when only this part of them is left: an alert must not come and go with every transport."""


class Overload:
    """Whether a plant is overloaded."""

    def __init__(self) -> None:
        self._lasts = False

    def look(self, tasks: Tasks, vehicles: int, now: Moment) -> Iterator[Trouble]:
        """What is wrong with the plant's demand.

        Args:
            tasks: all of them.
            vehicles: that are heard and not shut out.
            now: when it is looked at.
        """
        before_s = now.to_wall_s(min(now.plant_s, now.heard_s) - WAITED_S)
        waiting = sum(
            task.kind == "transport"
            and task.state == "bidding"
            and not task.trouble
            and task.opened_at_s < before_s
            for task in tasks.under_way()
        )
        most = max(LEAST, PER_VEHICLE * vehicles)
        self._lasts = waiting >= (OVER_FRAC * most if self._lasts else most)
        if self._lasts:
            carried_frac = tasks.transports.carried_frac(now.heard_s)
            yield Trouble(
                kind="overloaded",
                waiting=waiting,
                carried_frac=None if carried_frac is None else round(carried_frac, 2),
            )
