"""A vehicle's handling of obstacles on lanes (paper, 3.1): it reports them, drives round, and looks again.

Its body stops before an obstacle and reports it. From then on this vehicle, and all that have heard of it, plan
ways round it. That ends when a vehicle has driven there, or when no vehicle has seen it for a while. It is a
problem for people only if no way leads round.
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
from dray.protocol.traffic.driving.wait import ShutOut
from dray.protocol.vehicle.contracts import Contracts
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.idle_positioning import IdlePositioning
from dray.protocol.vehicle.people.problem_handling import ProblemHandling
from dray.protocol.vehicle.silent_vehicles import STANDS, SilentVehicles

LOOK_AGAIN = "look again"

KNOWN = "a report of a known obstacle, or of a lane that is free already"

IN_THE_WAY = "something is in the way from {} to {}, and no way leads round it"

SHUT = "the door {} does not open, and no way leads round it"

NO_TURNING = "the door {} does not open, and no lane leads back from {}"

BLOCKED = Problem(kind=ProblemKind.WAY_BLOCKED, needs_person=True)
"""Whether it goes away by itself is unknown."""


class Owner(Protocol):
    """The vehicle, as obstacles need it."""

    id: str

    @property
    def link(self) -> Link:
        """The link that it uses."""


class ObstacleHandling:
    """The obstacles that one vehicle meets and hears of.

    Args:
        owner: the vehicle.
        floor: the floor as it knows it.
        driver: its driver.
        contracts, idle: the purposes of its ways.
        problems: its problem handling.
        life: the agent's life; alarms are named `LOOK_AGAIN`.

    Attributes:
        messages, reports, alarms: entries for the vehicle's tables.
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
        """The lane with an obstacle that no way leads round: a problem of the vehicle."""
        self._may_turn = False
        """Whether it stands before that lane, and not on it."""
        self._reason = ""
        """The reason that it reports."""
        self._untold: dict[Ends, float] = {}
        """Obstacles met without WLAN, and when they are forgotten."""
        self._silent = SilentVehicles(floor.obstacles, contracts.subscriptions, life, self._keys)
        self.messages: dict[type[Message], Callable[[str, Any, float], None]] = {
            AtvHeartbeat: self._on_heartbeat,
            Removals: self._on_removals,
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
        """Subscribe to other vehicles' obstacles."""
        self._life.subscribe(self._keys.all_obstacles)

    def drove(self, start: str, end: str, now_s: float) -> None:
        """It has driven a lane: an obstacle there is gone."""
        if start != end and self._floor.obstacles.is_on(start, end):
            self._tell_gone(start, end, now_s)

    def shut_out(self, shut: ShutOut, now_s: float) -> None:
        """A silent vehicle blocks every way: report it as an obstacle, and plan the job anew.

        The vehicle can still make room for others, so this is no problem of its own; its heartbeat names the
        vehicle it waits for.
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
        """A primary may have failed. A successor does not drive up behind a standing one if others have the load.

        No way leads back from the lane before a dock, and a failed vehicle at the dock is assumed to stay.
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
        """Report obstacles that are not reported yet, if there is WLAN."""
        if self._owner.link is not Link.WLAN:
            return
        for (start, end), until_s in self._untold.items():
            if until_s > now_s and self._floor.obstacles.is_on(start, end):
                # Rounding may exceed the maximum by a little.
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
        """Another problem is solved; the obstacle before it remains."""
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
        if heartbeat.status not in STANDS:  # Else it stands until a person has checked it.
            self._end_silent(heartbeat.atv, now_s)

    def _on_removals(self, _sender: str, said: Removals, now_s: float) -> None:
        for removal in said.removals:
            if not removal.node:
                self._end_silent(removal.atv, now_s)

    def _end_silent(self, atv: str, now_s: float) -> None:
        """A silent vehicle is none any more: its lanes are free."""
        for ends in self._silent.note_gone(atv, now_s):
            if self._floor.obstacles.is_on(*ends):
                self._tell_gone(*ends, now_s)

    # --- others' reports -------------------------------------------------------------------------

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
                # It has entered that lane and still sees the obstacle: its body reports when it is gone.
                self._meet(*self._stands_before, now_s)
        self._set_alarm()

    def _heed(self, start: str, end: str, now_s: float, *, news: bool, there: bool) -> None:
        """Handle a report of an obstacle, or of its end."""
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

    # --- reactions -------------------------------------------------------------------------------

    def _try_round(self, now_s: float) -> None:
        """Another obstacle is gone: perhaps a way leads round now."""
        if self._stands_before is not None and self._go_round(self._stands_before[0], now_s):
            self._end_problem(now_s)

    def _go_round(self, node: str, now_s: float) -> bool:
        """Take another way from the present node; False if none leads round."""
        if not self._driver.leads_round(node, now_s) or not self._driver.turn_back(node, now_s):
            return False
        self._follow(now_s)
        return True

    def _turn_aside(self, node: str, now_s: float) -> bool:
        """Leave an obstacle without work, if a way leads away; False with work, or without a way."""
        return self._contracts.job is None and self._idle.turn_aside(node, now_s)

    def note_ended(self, now_s: float) -> None:
        """The contract has ended: leave the obstacle, if it stands before one."""
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
