"""Waits: which vehicles cannot drive on, since when, and for whom in the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import msgspec
from msgspec import UNSET

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.projection.right_of_way.chains import Chain, Standing, chains_of
from dray.gateway.live.reasons import wait_text
from dray.gateway.live.views import WaitCauseView, WaitView
from dray.gateway.live.views.wait import WaitKind
from dray.messages import AtvHeartbeat, AtvStatus, Phase
from dray.messages.heartbeat import FloorBrief
from dray.plant import Plant
from dray.store.history.clocks import ToWall

NAMED = 8
"""Vehicles of a chain that are named at most: nobody reads more."""


class Since(msgspec.Struct, frozen=True, gc=False):
    """How a vehicle stands, and since when."""

    node: str
    docked: bool
    waits: bool
    at_s: float
    """Plant clock."""


class Waits:
    """All vehicles that wait, as far as they tell of right of way.

    Args:
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, to_wall_s: ToWall) -> None:
        self._to_wall_s = to_wall_s
        self._since: dict[str, Since] = {}
        """By vehicle, while it stands. Bounded by whoever lets vehicles in."""
        self._views: dict[str, WaitView] = {}
        self._chains: Mapping[str, Chain] = {}
        self._with_task: frozenset[str] = frozenset()
        self._is_stale = False
        self._docks: tuple[Plant, dict[str, str]] | None = None
        """Of this plant: node -> whose dock it is."""
        self.changes = Changes("wait")

    def follow(self, heartbeat: AtvHeartbeat) -> None:
        """A vehicle tells whether it stands, and what for."""
        floor, atv = heartbeat.floor, heartbeat.atv
        self._is_stale |= floor is not UNSET or atv in self._since
        if floor is UNSET or heartbeat.speed_mps:
            self._since.pop(atv, None)
            return
        before = self._since.get(atv)
        now = Since(heartbeat.node, floor.docked, waits(heartbeat), heartbeat.at_s)
        if before is None or msgspec.structs.replace(before, at_s=now.at_s) != now:
            self._since[atv] = now

    def look(
        self, heartbeats: Iterable[AtvHeartbeat], is_lost: Callable[[str, AtvHeartbeat], bool], plant: Plant
    ) -> None:
        """Find out who waits for whom at this moment.

        Args:
            heartbeats: the last one of each vehicle that is not shut out.
            is_lost: whether nobody hears a vehicle any more.
            plant: knows docks.
        """
        if not (self._is_stale or self._views):
            return
        self._is_stale = False
        last = {each.atv: each for each in heartbeats}
        vehicles = {
            atv: standing_of(heartbeat, floor, lost=is_lost(atv, heartbeat))
            for atv, heartbeat in last.items()
            if (floor := heartbeat.floor) is not UNSET
        }
        self._chains = chains_of(vehicles)
        self._with_task = frozenset(atv for atv in self._chains if last[atv].task is not None)
        before, self._views = self._views, {}
        for atv, chain in self._chains.items():
            since = self._since.get(atv)
            if since is not None:
                self._views[atv] = self._view(last[atv], since, chain, last, plant)
        for atv in before.keys() - self._views.keys():
            self.changes.drop(atv)
        for atv, view in self._views.items():
            if view != before.get(atv):
                self.changes.mark(atv)

    @property
    def is_stale(self) -> bool:
        """Whether a vehicle has said something of it since the last look."""
        return self._is_stale

    def chain(self, atv: str) -> Chain:
        """For whom one of `views` waits."""
        return self._chains[atv]

    def has_task(self, atv: str) -> bool:
        """Whether one of `views` is held up at work."""
        return atv in self._with_task

    def views(self) -> tuple[WaitView, ...]:
        """All of them, by vehicle."""
        return tuple(self._views[atv] for atv in sorted(self._views))

    def take_changed(self) -> tuple[WaitView, ...]:
        """Those that have come or changed since the last call."""
        return tuple(self._views[atv] for atv in self.changes.take_changed())

    def _view(
        self,
        heartbeat: AtvHeartbeat,
        since: Since,
        chain: Chain,
        last: Mapping[str, AtvHeartbeat],
        plant: Plant,
    ) -> WaitView:
        floor = heartbeat.floor
        cause = self._cause(heartbeat.atv, chain, last, plant)
        return WaitView(
            id=heartbeat.atv,
            since_at_s=self._to_wall_s(since.at_s),
            place="" if floor is UNSET else floor.waits_at,
            cause=cause,
            text=wait_text(cause),
        )

    def _cause(self, atv: str, chain: Chain, last: Mapping[str, AtvHeartbeat], plant: Plant) -> WaitCauseView:
        end = chain.ahead[-1] if chain.ahead else atv
        since = None if chain.circle else self._since.get(end)
        more = max(len(chain.ahead) - NAMED, 0)
        place = ""
        if chain.kind in ("docked", "charging", "standing"):
            place = self._dock(last[end].node, plant)
        return WaitCauseView(
            kind=chain.kind,
            chain=(*chain.ahead[: NAMED - 1], chain.ahead[-1]) if more else chain.ahead,
            more=more,
            place=place,
            since_at_s=None if since is None else self._to_wall_s(since.at_s),
        )

    def _dock(self, node: str, plant: Plant) -> str:
        """Whose dock a node is."""
        if self._docks is None or self._docks[0] is not plant:
            self._docks = plant, {plant.node_of(place): place for place in reversed(tuple(plant.places))}
        return self._docks[1].get(node, "")


def standing_of(heartbeat: AtvHeartbeat, floor: FloorBrief, *, lost: bool) -> Standing:
    """One vehicle, as others may wait for it."""
    ends: tuple[tuple[bool, WaitKind], ...] = (
        (lost, "silent"),
        (heartbeat.status is AtvStatus.STOPPED, "stopped"),
        (heartbeat.status is AtvStatus.ERROR, "error"),
        (floor.docked, "docked"),
        (heartbeat.status is AtvStatus.CHARGING and not floor.waits, "charging"),
        (has_no_way(heartbeat), "closed"),
    )
    for holds, kind in ends:
        if holds:
            return Standing(kind, waits=kind == "closed")
    if floor.waits:
        return Standing(
            "moving" if heartbeat.speed_mps else "unanswered", waits=True, waits_for=floor.waits_for
        )
    return Standing("moving" if heartbeat.speed_mps else "standing")


def waits(heartbeat: AtvHeartbeat) -> bool:
    """Whether a vehicle cannot drive on, by its own words."""
    return has_no_way(heartbeat) or (heartbeat.floor is not UNSET and heartbeat.floor.waits)


def has_no_way(heartbeat: AtvHeartbeat) -> bool:
    """Whether a vehicle stands with a load and nothing leads to where it is to go: lanes are closed."""
    floor, task = heartbeat.floor, heartbeat.task
    if floor is UNSET or floor.docked or floor.waits or heartbeat.way or heartbeat.speed_mps:
        return False
    return task is not None and task.phase in (Phase.CARRYING, Phase.RETURNING)
