"""What a vehicle does about things that lie on lanes (paper, 3.1): it tells the others, goes round, and looks again.

Its body stops before what is in its way and says so. From then on ways lead round, its own and those of whoever has heard of it,
until it is gone: until somebody has driven there, or nobody has seen it for a while. Only where no way leads round is it a problem,
for which people are asked.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Protocol

from dray.body import ProblemCleared, ProblemRaised, WayBlocked, WayFree
from dray.messages import Link, Message, ObstacleCleared, ObstacleSeen, Problem, ProblemKind
from dray.messages.keys import Keys
from dray.plant.restrictions import Ends
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.runtime.events import Effect, Ignore, Publish, Subscribe
from dray.protocol.runtime.timers import Timers
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.idle_positioning import IdlePositioning
from dray.protocol.vehicle.people.problem_handling import ProblemHandling

LOOK_AGAIN = "look again"

KNOWN = "of an obstacle that is known, or a lane that is free already"

IN_THE_WAY = "something is in the way from {} to {}, and no way leads round it"

BLOCKED = Problem(kind=ProblemKind.WAY_BLOCKED, needs_person=True)
"""Whether it goes away by itself nobody knows."""


class Owner(Protocol):
    """The vehicle, as far as obstacles need it."""

    id: str

    @property
    def link(self) -> Link:
        """By which it speaks."""


class ObstacleHandling:
    """The obstacles that one vehicle meets and hears of.

    Args:
        owner: the vehicle.
        floor: as it knows it.
        driver: its place on the lanes.
        contracts, idle: what it drives for.
        problems: of its body, and its own.
        timers: the vehicle's alarms; this class uses `LOOK_AGAIN`.
        out: where effects go.

    Attributes:
        messages, reports, alarms: for the vehicle's tables.
    """

    def __init__(
        self,
        owner: Owner,
        floor: KnownFloor,
        driver: Driver,
        contracts: Contracts,
        idle: IdlePositioning,
        problems: ProblemHandling,
        timers: Timers,
        out: list[Effect],
    ) -> None:
        self._owner, self._floor = owner, floor
        self._driver, self._contracts, self._idle, self._problems = driver, contracts, idle, problems
        self._timers, self._out = timers, out
        self._keys = Keys(floor.id)
        self._stands_before: Ends | None = None
        """The lane on which something holds it up, with no way round; a problem of its own."""
        self._untold: dict[Ends, float] = {}
        """What it has met while it had no WLAN, and when that is forgotten."""
        self.messages: dict[type[Message], Callable[[str, Any, float], None]] = {
            ObstacleSeen: self._on_seen,
            ObstacleCleared: self._on_cleared,
        }
        self.reports: dict[type, Callable[[Any, float], None]] = {
            WayBlocked: self._way_blocked,
            WayFree: self._way_free,
            ProblemCleared: self._problem_cleared,
        }
        self.alarms: dict[str, Callable[[Any, float], None]] = {LOOK_AGAIN: self._look_again}

    def start(self) -> None:
        """Listen to what others meet."""
        self._out.append(Subscribe(self._keys.all_obstacles))

    def drove(self, start: str, end: str, now_s: float) -> None:
        """It has driven a lane: whatever lay there is gone."""
        if start != end and self._floor.obstacles.is_on(start, end):
            self._tell_gone(start, end, now_s)

    def tell(self, now_s: float) -> None:
        """Tell what it has met and was not told yet, if it has WLAN."""
        if self._owner.link is not Link.WLAN:
            return
        for (start, end), until_s in self._untold.items():
            if until_s > now_s and self._floor.obstacles.is_on(start, end):
                for_s = until_s - now_s
                said = ObstacleSeen(atv=self._owner.id, start=start, end=end, there=True, forget_in_s=for_s)
                self._out.append(Publish(self._keys.obstacle(self._owner.id), said))
        self._untold.clear()

    # --- its own body ----------------------------------------------------------------------------

    def _way_blocked(self, report: WayBlocked, now_s: float) -> None:
        start, end = report.start, report.end
        for_s = self._floor.obstacles.meet(start, end, self._owner.id, now_s)
        self._changed()
        self._untold[start, end] = now_s + for_s
        self.tell(now_s)
        if report.entered or not self._go_round(start, now_s):
            self._stands_before = (start, end)
            self._raise(start, end, now_s)

    def _raise(self, start: str, end: str, now_s: float) -> None:
        reason = IN_THE_WAY.format(start, end)
        self._problems.raise_problem(ProblemRaised(reason=reason, problem=BLOCKED), now_s)

    def _problem_cleared(self, report: ProblemCleared, now_s: float) -> None:
        """Something else was wrong, and is put right: what lies before it still does."""
        self._problems.reports[ProblemCleared](report, now_s)
        if self._stands_before is not None:
            self._raise(*self._stands_before, now_s)

    def _way_free(self, report: WayFree, now_s: float) -> None:
        self._tell_gone(report.start, report.end, now_s)

    def _tell_gone(self, start: str, end: str, now_s: float) -> None:
        self._floor.obstacles.clear(start, end)
        self._changed()
        if self._owner.link is Link.WLAN:
            said = ObstacleSeen(atv=self._owner.id, start=start, end=end, there=False)
            self._out.append(Publish(self._keys.obstacle(self._owner.id), said))
        if self._stands_before is not None and set(self._stands_before) == {start, end}:
            self._end_problem(now_s)

    # --- what others say -------------------------------------------------------------------------

    def _on_seen(self, sender: str, seen: ObstacleSeen, now_s: float) -> None:
        obstacles = self._floor.obstacles
        if sender == self._owner.id:
            return
        if seen.there:
            news = obstacles.on_told(seen.start, seen.end, sender, seen.forget_in_s, now_s)
        else:
            news = obstacles.clear(seen.start, seen.end)
        self._heed(seen.start, seen.end, now_s, news=news, there=seen.there)

    def _on_cleared(self, _sender: str, cleared: ObstacleCleared, now_s: float) -> None:
        news = self._floor.obstacles.clear(cleared.start, cleared.end)
        self._heed(cleared.start, cleared.end, now_s, news=news, there=False)

    def _look_again(self, _about: None, now_s: float) -> None:
        if self._floor.obstacles.look(now_s):
            self._changed()
            self._try_round(now_s)
        self._set_alarm()

    def _heed(self, start: str, end: str, now_s: float, *, news: bool, there: bool) -> None:
        """Somebody has seen something, or that it is gone: go by that."""
        if not news:
            self._out.append(Ignore(KNOWN))
            return
        self._changed()
        if not there:
            self._try_round(now_s)
            return
        ahead = (self._driver.next_node, *self._driver.ahead)
        on_way = any({start, end} == set(ends) for ends in pairwise(ahead))
        if on_way and self._driver.leads_round(self._driver.next_node, now_s):
            self._follow(now_s)

    # --- what it does ----------------------------------------------------------------------------

    def _try_round(self, now_s: float) -> None:
        """It stands before something, and something else is gone: perhaps a way leads round now."""
        if self._stands_before is not None and self._go_round(self._stands_before[0], now_s):
            self._end_problem(now_s)

    def _go_round(self, node: str, now_s: float) -> bool:
        """Go another way from the node where it stands; False when none leads round."""
        if not self._driver.leads_round(node, now_s) or not self._driver.turn_back(node, now_s):
            return False
        self._follow(now_s)
        return True

    def _follow(self, now_s: float) -> None:
        if self._contracts.job is None:
            self._idle.floor_changed(now_s)
        else:
            self._contracts.go_on(lambda job: job.floor_changed(now_s), now_s)

    def _end_problem(self, now_s: float) -> None:
        if self._stands_before is not None:
            reason, self._stands_before = IN_THE_WAY.format(*self._stands_before), None
            self._problems.end_problem(reason, now_s)

    def _changed(self) -> None:
        self._floor.note_obstacles()
        self._set_alarm()

    def _set_alarm(self) -> None:
        self._timers.set(LOOK_AGAIN, self._floor.obstacles.ends_s)
