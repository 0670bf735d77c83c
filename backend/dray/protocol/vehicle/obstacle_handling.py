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
from dray.messages import (
    AtvHeartbeat,
    Link,
    Message,
    ObstacleCleared,
    ObstacleSeen,
    Problem,
    ProblemKind,
    Removals,
)
from dray.messages.floor.obstacle import FORGOTTEN_AT_MOST_S
from dray.messages.keys import Keys
from dray.plant.restrictions import Ends
from dray.protocol.closures.known_floor import KnownFloor
from dray.protocol.runtime.life import Life
from dray.protocol.takeover.standby import WATCHED_SILENCE
from dray.protocol.traffic.driving.right_of_way import ShutOut
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.idle_positioning import IdlePositioning
from dray.protocol.vehicle.people.problem_handling import ProblemHandling
from dray.protocol.vehicle.silent_vehicles import STANDS, SilentVehicles

LOOK_AGAIN = "look again"

KNOWN = "of an obstacle that is known, or a lane that is free already"

IN_THE_WAY = "something is in the way from {} to {}, and no way leads round it"

SHUT = "the door {} does not open, and no way leads round it"

NO_TURNING = "the door {} does not open, and no lane leads back from {}"

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
        life: its agent's; its alarms are named `LOOK_AGAIN`.

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
        life: Life,
    ) -> None:
        self._owner, self._floor = owner, floor
        self._driver, self._contracts, self._idle, self._problems = driver, contracts, idle, problems
        self._life = life
        self._keys = Keys(floor.id)
        self._stands_before: Ends | None = None
        """The lane on which something holds it up, with no way round; a problem of its own."""
        self._may_turn = False
        """It stands before that lane, and not on it."""
        self._reason = ""
        """What it says of that."""
        self._untold: dict[Ends, float] = {}
        """What it has met while it had no WLAN, and when that is forgotten."""
        self._silent = SilentVehicles(
            floor.obstacles, contracts.subscriptions, self._tell_gone, life, self._keys
        )
        self.messages: dict[type[Message], Callable[[str, Any, float], None]] = {
            AtvHeartbeat: self._on_heartbeat,
            Removals: self._silent.on_removals,
            ObstacleSeen: self._on_seen,
            ObstacleCleared: self._on_cleared,
        }
        self.reports: dict[type, Callable[[Any, float], None]] = {
            WayBlocked: self._way_blocked,
            WayFree: self._way_free,
            ProblemCleared: self._problem_cleared,
        }
        self.alarms: dict[str, Callable[[Any, float], None]] = {
            LOOK_AGAIN: self._look_again,
            WATCHED_SILENCE: self._look_after,
        }

    def start(self) -> None:
        """Listen to what others meet."""
        self._life.subscribe(self._keys.all_obstacles)

    @property
    def silent_one(self) -> str:
        """A silent vehicle that it has waited for in vain, and has told of; empty for none."""
        return next(iter(self._silent), "")

    def drove(self, start: str, end: str, now_s: float) -> None:
        """It has driven a lane: whatever lay there is gone."""
        if start != end and self._floor.obstacles.is_on(start, end):
            self._tell_gone(start, end, now_s)

    def shut_out(self, shut: ShutOut, now_s: float) -> None:
        """A silent vehicle is in its way, and none leads round: that is an obstacle, and what is carried is planned anew.

        It stays able to make room for others, so this is no problem of its own: who waits for whom is told with its heartbeat.
        """
        if self._silent.was_heard_lately(shut.by, now_s):
            return
        is_first = shut.by not in self._silent
        for start, end in self._silent.meet(shut.by, shut.lanes):
            self._floor.obstacles.on_reported(start, end, self._owner.id, FORGOTTEN_AT_MOST_S, now_s)
            self._untold[start, end] = now_s + FORGOTTEN_AT_MOST_S
        self._changed()
        self.tell(now_s)
        if self._contracts.job is not None:
            self._contracts.go_on(lambda job: job.shut_out(shut.by, shut.waited_s, now_s), now_s)
        elif is_first:
            self._idle.go_elsewhere(now_s)

    def _look_after(self, task: str, now_s: float) -> None:
        """A primary may have failed. Whoever takes over from one that stands does not drive up behind it for its load, if others have it.

        From the lane before a dock no way leads back, and who stands at the dock was judged to stay there.
        """
        failed = self._contracts.standby.last_heard(task)
        self._contracts.alarms[WATCHED_SILENCE](task, now_s)
        job = self._contracts.job
        if failed is None or failed.status not in STANDS or job is None or job.task != task:
            return
        shut = self._driver.shut_out_by(failed)
        if shut is not None:
            self.shut_out(shut, now_s)

    def tell(self, now_s: float) -> None:
        """Tell what it has met and was not told yet, if it has WLAN."""
        if self._owner.link is not Link.WLAN:
            return
        for (start, end), until_s in self._untold.items():
            if until_s > now_s and self._floor.obstacles.is_on(start, end):
                # Sums of moments are rounded: a hair more than the most that may be said is the most.
                for_s = min(until_s - now_s, FORGOTTEN_AT_MOST_S)
                said = ObstacleSeen(atv=self._owner.id, start=start, end=end, there=True, forget_in_s=for_s)
                self._life.publish(self._keys.obstacle(self._owner.id), said)
        self._untold.clear()

    # --- its own body ----------------------------------------------------------------------------

    def _way_blocked(self, report: WayBlocked, now_s: float) -> None:
        start, end = report.start, report.end
        self._meet(start, end, now_s)
        if report.entered or not (self._go_round(start, now_s) or self._turn_aside(start, now_s)):
            self._stands_before, self._may_turn = (start, end), not report.entered
            self._reason = self._told(start, end, entered=report.entered)
            self._raise(now_s)

    def _meet(self, start: str, end: str, now_s: float) -> None:
        for_s = self._floor.obstacles.meet(start, end, self._owner.id, now_s)
        self._changed()
        self._untold[start, end] = now_s + for_s
        self.tell(now_s)

    def _told(self, start: str, end: str, *, entered: bool) -> str:
        """What it waits for, in words."""
        door = None if entered else self._floor.door_on.get((start, end))
        if door is None:
            return IN_THE_WAY.format(start, end)
        turns = any(lane.end != end for lane in self._floor.roads.leaving[start])
        return SHUT.format(door.name) if turns else NO_TURNING.format(door.name, start)

    def _raise(self, now_s: float) -> None:
        self._problems.raise_problem(ProblemRaised(reason=self._reason, problem=BLOCKED), now_s)

    def _problem_cleared(self, report: ProblemCleared, now_s: float) -> None:
        """Something else was wrong, and is put right: what lies before it still does."""
        self._problems.reports[ProblemCleared](report, now_s)
        if self._stands_before is not None:
            self._raise(now_s)

    def _way_free(self, report: WayFree, now_s: float) -> None:
        self._tell_gone(report.start, report.end, now_s)

    def _tell_gone(self, start: str, end: str, now_s: float) -> None:
        self._floor.obstacles.clear(start, end)
        self._changed()
        if self._owner.link is Link.WLAN:
            said = ObstacleSeen(atv=self._owner.id, start=start, end=end, there=False)
            self._life.publish(self._keys.obstacle(self._owner.id), said)
        if self._stands_before is not None and set(self._stands_before) == {start, end}:
            self._end_problem(now_s)

    def _on_heartbeat(self, sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        self._contracts.message_handlers[AtvHeartbeat](sender, heartbeat, now_s)
        self._silent.on_heartbeat(heartbeat, now_s)

    # --- what others say -------------------------------------------------------------------------

    def _on_seen(self, sender: str, seen: ObstacleSeen, now_s: float) -> None:
        obstacles = self._floor.obstacles
        if sender == self._owner.id:
            return
        if seen.there:
            news = obstacles.on_reported(seen.start, seen.end, sender, seen.forget_in_s, now_s)
        else:
            news = obstacles.clear(seen.start, seen.end)
        self._heed(seen.start, seen.end, now_s, news=news, there=seen.there)

    def _on_cleared(self, _sender: str, cleared: ObstacleCleared, now_s: float) -> None:
        news = self._floor.obstacles.clear(cleared.start, cleared.end)
        self._heed(cleared.start, cleared.end, now_s, news=news, there=False)

    def _look_again(self, _about: None, now_s: float) -> None:
        if self._floor.obstacles.look(now_s):
            self._silent.look()
            self._changed()
            if self._stands_before is None or self._may_turn:
                self._try_round(now_s)
            elif not self._floor.obstacles.is_on(*self._stands_before):
                # It has entered that lane and still sees what lies there: its body says when it is gone.
                self._meet(*self._stands_before, now_s)
        self._set_alarm()

    def _heed(self, start: str, end: str, now_s: float, *, news: bool, there: bool) -> None:
        """Somebody has seen something, or that it is gone: go by that."""
        if not news:
            self._life.ignore(KNOWN)
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

    def _turn_aside(self, node: str, now_s: float) -> bool:
        """Without work there is nothing to wait for: leave, if a way leads from there; False when it has work, or none does."""
        return self._contracts.job is None and self._idle.turn_aside(node, now_s)

    def note_ended(self, now_s: float) -> None:
        """Its contract has ended, while it stood before something perhaps: whoever has it now goes on, and so does this vehicle."""
        if (
            self._stands_before is not None
            and self._may_turn
            and self._turn_aside(self._stands_before[0], now_s)
        ):
            self._end_problem(now_s)

    def _follow(self, now_s: float) -> None:
        if self._contracts.job is None:
            self._idle.floor_changed(now_s)
        else:
            self._contracts.go_on(lambda job: job.floor_changed(now_s), now_s)

    def _end_problem(self, now_s: float) -> None:
        if self._stands_before is not None:
            self._stands_before = None
            self._problems.end_problem(self._reason, now_s)

    def _changed(self) -> None:
        self._floor.note_obstacles()
        self._set_alarm()

    def _set_alarm(self) -> None:
        self._life.alarm(LOOK_AGAIN, self._floor.obstacles.ends_s)
