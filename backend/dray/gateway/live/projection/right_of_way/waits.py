"""Waits: which vehicles cannot drive on, since when, and which vehicle blocks them in the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec
from msgspec import UNSET

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.projection.right_of_way.chains import NAMED, Chain, Standing, chains_of
from dray.gateway.live.reasons import wait_text
from dray.gateway.live.views import WaitCauseView, WaitView
from dray.gateway.live.views.floor.wait import WaitKind
from dray.messages import AtvHeartbeat, AtvStatus, Phase
from dray.messages.heartbeat import FloorBrief
from dray.plant import Plant
from dray.store.history.clocks import ToWall

SILENT = Standing("silent")


class OwnWord(msgspec.Struct, frozen=True, gc=False):
    """The last report of a vehicle about itself."""

    standing: Standing
    node: str
    """The node where it stands; empty while it drives."""
    needs: str
    """The place that it waits for; empty if unknown."""
    has_task: bool
    since_s: float | None
    """Time since which it has stood like this (plant clock); None while it drives."""
    is_repeated: bool = False
    """Whether it said so before. A vehicle that sets off gets its first answer before its next heartbeat."""


class Waits:
    """All vehicles that wait by right of way.

    Args:
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, to_wall_s: ToWall) -> None:
        self._to_wall_s = to_wall_s
        self._told: dict[str, OwnWord] = {}
        """By vehicle. Bounded because only admitted vehicles are followed."""
        self._waiting: dict[str, None] = {}
        self._views: dict[str, WaitView] = {}
        self._chains: Mapping[str, Chain] = {}
        self._unheard_s: dict[str, float] = {}
        """Unheard vehicles that others wait for -> since when that is known (plant clock)."""
        self._is_stale = False
        self._docks: tuple[Plant, dict[str, str]] | None = None
        """For this plant: node -> place whose dock it is."""
        self.changes = Changes("wait")

    def follow(self, heartbeat: AtvHeartbeat) -> None:
        """Note whether a vehicle stands, and what it waits for."""
        atv, before = heartbeat.atv, self._told.get(heartbeat.atv)
        if heartbeat.floor is UNSET and not self._told:
            return  # No vehicle here drives by right of way.
        now = _told(heartbeat, before)
        if now == before:
            return
        self._told[atv] = now
        self._unheard_s.pop(atv, None)
        if now.standing.waits_for and now.standing.waits_for not in self._told:
            self._unheard_s.setdefault(now.standing.waits_for, heartbeat.at_s)
        if now.standing.waits:
            self._waiting[atv] = None
        else:
            self._waiting.pop(atv, None)
        self._is_stale = True

    def look(self, is_heard: Callable[[str], bool], plant: Plant) -> None:
        """Compute who waits for whom now.

        Args:
            is_heard: whether a vehicle is neither lost nor shut out; the activity of others is unknown.
            plant: knows docks.
        """
        self._is_stale = False
        if self._unheard_s:
            named = {self._told[atv].standing.waits_for for atv in self._waiting}
            self._unheard_s = {atv: since_s for atv, since_s in self._unheard_s.items() if atv in named}
        if not (self._waiting or self._views):
            return
        self._chains = chains_of(self._concerned(is_heard))
        before, self._views = self._views, {}
        for atv, chain in self._chains.items():
            word = self._told[atv]
            if word.since_s is not None and (word.is_repeated or chain.ahead):
                self._views[atv] = self._view(atv, word, word.since_s, chain, plant)
        for atv in before.keys() - self._views.keys():
            self.changes.drop(atv)
        for atv, view in self._views.items():
            if view != before.get(atv):
                self.changes.mark(atv)

    @property
    def is_stale(self) -> bool:
        """Whether a vehicle's report since the last look may change a wait."""
        return self._is_stale and bool(self._waiting or self._views)

    def chain(self, atv: str) -> Chain:
        """The chain of a vehicle in `views`."""
        return self._chains[atv]

    def unheard_at_end(self, atv: str) -> tuple[str, float] | None:
        """The unheard vehicle that blocks a vehicle in `views`, and since when that is known (plant clock).

        None if the blocking vehicle was heard or there is none.
        """
        last = self._chains[atv].last
        since_s = self._unheard_s.get(last)
        return None if since_s is None else (last, since_s)

    def names(self, agent: str) -> bool:
        """Whether a vehicle waits for an unheard one of this name, by a reservation table's leader."""
        return agent in self._unheard_s

    def has_task(self, atv: str) -> bool:
        """Whether a vehicle in `views` waits while it has a task."""
        return self._told[atv].has_task

    def views(self) -> tuple[WaitView, ...]:
        """All of them, by vehicle."""
        return tuple(self._views[atv] for atv in sorted(self._views))

    def take_changed(self) -> tuple[WaitView, ...]:
        """Those that have come or changed since the last call."""
        return tuple(self._views[atv] for atv in self.changes.take_changed())

    def _concerned(self, is_heard: Callable[[str], bool]) -> dict[str, Standing]:
        """All vehicles that wait or are waited for."""
        vehicles: dict[str, Standing] = {}
        for first in self._waiting:
            for atv in (first, self._told[first].standing.waits_for):
                if atv not in vehicles and atv in self._told:
                    vehicles[atv] = self._told[atv].standing if is_heard(atv) else SILENT
        return vehicles

    def _view(self, atv: str, word: OwnWord, since_s: float, chain: Chain, plant: Plant) -> WaitView:
        cause = self._cause(atv, chain, plant)
        return WaitView(
            id=atv,
            since_at_s=self._to_wall_s(since_s),
            place=word.needs,
            cause=cause,
            text=wait_text(cause),
        )

    def _cause(self, atv: str, chain: Chain, plant: Plant) -> WaitCauseView:
        last = self._told.get(chain.last or atv)
        since_s = None if chain.circle or last is None else last.since_s
        more = max(chain.count - NAMED, 0)
        place = ""
        if last is not None and chain.kind in ("docked", "charging", "standing"):
            place = self._dock(last.node, plant)
        return WaitCauseView(
            kind=chain.kind,
            chain=(*chain.ahead[: NAMED - 1], chain.last) if more else chain.ahead,
            more=more,
            place=place,
            since_at_s=None if since_s is None else self._to_wall_s(since_s),
        )

    def _dock(self, node: str, plant: Plant) -> str:
        """The place whose dock a node is."""
        if self._docks is None or self._docks[0] is not plant:
            self._docks = plant, {plant.node_of(place): place for place in reversed(tuple(plant.places))}
        return self._docks[1].get(node, "")


def _told(heartbeat: AtvHeartbeat, before: OwnWord | None) -> OwnWord:
    """A heartbeat's report; a vehicle that stands as before keeps its start time."""
    standing, node = standing_of(heartbeat), "" if heartbeat.speed_mps else heartbeat.node
    since_s = None if heartbeat.speed_mps else heartbeat.at_s
    is_repeated = False
    if since_s is not None and before is not None and before.since_s is not None:
        then = before.standing
        if (before.node, then.kind, then.waits) == (node, standing.kind, standing.waits):
            since_s, is_repeated = before.since_s, True
    needs = "" if heartbeat.floor is UNSET else heartbeat.floor.waits_at
    return OwnWord(standing, node, needs, heartbeat.task is not None, since_s, is_repeated)


def standing_of(heartbeat: AtvHeartbeat) -> Standing:
    """The state of a heard vehicle. Without right of way it waits for nobody."""
    floor = FloorBrief() if heartbeat.floor is UNSET else heartbeat.floor
    ends: tuple[tuple[bool, WaitKind], ...] = (
        (heartbeat.status is AtvStatus.STOPPED, "stopped"),
        (heartbeat.status is AtvStatus.ERROR, "error"),
        (floor.docked, "docked"),
        (heartbeat.status is AtvStatus.CHARGING and not floor.waits, "charging"),
        (_has_no_way(heartbeat), "closed"),
    )
    for holds, kind in ends:
        if holds:
            return Standing(kind, waits=kind == "closed")
    kind = "moving" if heartbeat.speed_mps else "unanswered" if floor.waits else "standing"
    # Ignore self-waits.
    behind = floor.waits_for if floor.waits and floor.waits_for != heartbeat.atv else ""
    return Standing(kind, waits=floor.waits, waits_for=behind)


def _has_no_way(heartbeat: AtvHeartbeat) -> bool:
    """Whether a loaded vehicle stands with no way to its destination, because lanes are closed."""
    floor, task = heartbeat.floor, heartbeat.task
    if floor is UNSET or floor.waits or heartbeat.way or heartbeat.speed_mps:
        return False
    return task is not None and task.phase in (Phase.CARRYING, Phase.RETURNING)
