"""Waits: which vehicles cannot drive on, since when, and for whom in the end."""

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
    """What a vehicle has told last of itself."""

    standing: Standing
    node: str
    """Where it stands; empty for one that drives."""
    needs: str
    """The place that it waits for; empty where it does not know."""
    has_task: bool
    since_s: float | None
    """Since when it has stood so (plant clock); None for one that drives."""
    is_repeated: bool = False
    """It has said so before. Who sets off waits for its first answer, which is there before it speaks again."""


class Waits:
    """All vehicles that wait, as far as they tell of right of way.

    Args:
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, to_wall_s: ToWall) -> None:
        self._to_wall_s = to_wall_s
        self._told: dict[str, OwnWord] = {}
        """By vehicle. Bounded by whoever lets vehicles in."""
        self._waiting: dict[str, None] = {}
        self._views: dict[str, WaitView] = {}
        self._chains: Mapping[str, Chain] = {}
        self._unheard_s: dict[str, float] = {}
        """Whom others wait for and nobody has heard -> since when that is told (plant clock)."""
        self._is_stale = False
        self._docks: tuple[Plant, dict[str, str]] | None = None
        """Of this plant: node -> whose dock it is."""
        self.changes = Changes("wait")

    def follow(self, heartbeat: AtvHeartbeat) -> None:
        """A vehicle tells whether it stands, and what for."""
        atv, before = heartbeat.atv, self._told.get(heartbeat.atv)
        if heartbeat.floor is UNSET and not self._told:
            return  # Nobody here drives with right of way.
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
        """Find out who waits for whom at this moment.

        Args:
            is_heard: whether a vehicle is neither lost nor shut out; nobody knows what others do.
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
        """Whether a vehicle has said something since the last look that may change a wait."""
        return self._is_stale and bool(self._waiting or self._views)

    def chain(self, atv: str) -> Chain:
        """For whom one of `views` waits."""
        return self._chains[atv]

    def unheard_at_end(self, atv: str) -> tuple[str, float] | None:
        """Who holds one of `views` up in the end and was never heard, and since when that is told (plant clock); None for nobody."""
        last = self._chains[atv].last
        since_s = self._unheard_s.get(last)
        return None if since_s is None else (last, since_s)

    def names(self, agent: str) -> bool:
        """Whether a vehicle waits for one that was never heard and has this name: the leader of a reservation table has told it."""
        return agent in self._unheard_s

    def has_task(self, atv: str) -> bool:
        """Whether one of `views` is held up at work."""
        return self._told[atv].has_task

    def views(self) -> tuple[WaitView, ...]:
        """All of them, by vehicle."""
        return tuple(self._views[atv] for atv in sorted(self._views))

    def take_changed(self) -> tuple[WaitView, ...]:
        """Those that have come or changed since the last call."""
        return tuple(self._views[atv] for atv in self.changes.take_changed())

    def _concerned(self, is_heard: Callable[[str], bool]) -> dict[str, Standing]:
        """All that wait, and all that are waited for."""
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
        """Whose dock a node is."""
        if self._docks is None or self._docks[0] is not plant:
            self._docks = plant, {plant.node_of(place): place for place in reversed(tuple(plant.places))}
        return self._docks[1].get(node, "")


def _told(heartbeat: AtvHeartbeat, before: OwnWord | None) -> OwnWord:
    """What a heartbeat tells; one that stands as before has stood since then."""
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
    """One vehicle that is heard, as others may wait for it. One that tells nothing of right of way waits for nobody."""
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
    # Who says that it waits for itself says nothing.
    behind = floor.waits_for if floor.waits and floor.waits_for != heartbeat.atv else ""
    return Standing(kind, waits=floor.waits, waits_for=behind)


def _has_no_way(heartbeat: AtvHeartbeat) -> bool:
    """Whether a vehicle stands with a load and nothing leads to where it is to go: lanes are closed."""
    floor, task = heartbeat.floor, heartbeat.task
    if floor is UNSET or floor.waits or heartbeat.way or heartbeat.speed_mps:
        return False
    return task is not None and task.phase in (Phase.CARRYING, Phase.RETURNING)
