"""ATVs as panels see them: the last heartbeat of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

import msgspec
from msgspec import UNSET

from dray.gateway.live.projection.agents.asked import help_view, out_view, problem_view, wait_view
from dray.gateway.live.projection.agents.outsiders import Outsiders
from dray.gateway.live.projection.agents.removals import Removals
from dray.gateway.live.projection.agents.silence import Silence
from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.projection.figures.fleet import Fleet
from dray.gateway.live.views import (
    AtvView,
    BriefView,
    ClockView,
    ProbationView,
)
from dray.messages import AtvHeartbeat, Brief, Heartbeat
from dray.messages.overtaken import LatestNumbers
from dray.plant.model import Charging, VehicleSpec, VehicleType
from dray.store.history.clocks import Clocks, ToWall

ANY_MUST_CHARGE_FRAC = Charging().must_below_frac
"""Charging threshold of a vehicle whose type is unknown here."""

JOINING_LEAST = 256
"""Minimum number of agents of a kind that may join any plant without a new plant file."""


def joining_max(known: int) -> int:
    """Maximum agents of a kind that may join at run time: as many as there are. It bounds invented names."""
    return max(JOINING_LEAST, known)


def clock_of(clocks: Clocks, agent: str) -> ClockView | None:
    """The clock offset of an agent, as panels are told."""
    offset = clocks.offset(agent)
    if offset is None:
        return None
    wrong = clocks.is_wrong(offset)
    return ClockView(ahead_s=round(offset.ahead_s, 2), bound_s=round(offset.bound_s, 2), wrong=wrong)


class Atvs:
    """The fleet.

    Args:
        fleet: the plant's vehicles; others may join.
        types: the vehicle types.
        to_wall_s: plant clock to wall clock.
        outsiders: the agents that are shut out.
        removals: the vehicles that were carried away.
        clocks: of all agents.
        silence: of all agents.
        top_mps: top speed of the fastest vehicle.

    Attributes:
        strangers: heartbeats ignored because their vehicles are not in the plant file and too many have
            joined.
    """

    def __init__(
        self,
        fleet: Iterable[VehicleSpec],
        types: Iterable[VehicleType],
        to_wall_s: ToWall,
        outsiders: Outsiders,
        removals: Removals,
        clocks: Clocks,
        silence: Silence,
        top_mps: float,
    ) -> None:
        self._outsiders, self._removals = outsiders, removals
        self._clocks, self._silence = clocks, silence
        self._types = {vehicle.id: vehicle.type for vehicle in fleet}
        types = tuple(types)
        charging = {kind.id: kind.charging for kind in types}
        holds_wh = {kind.id: kind.battery_wh for kind in types}
        self._battery_wh = {atv: holds_wh.get(kind, 0.0) for atv, kind in self._types.items()}
        self._must_charge_frac = {
            atv: charging[kind].must_below_frac for atv, kind in self._types.items() if kind in charging
        }
        self._to_wall_s = to_wall_s
        self._last: dict[str, AtvHeartbeat] = {}
        self._newest: LatestNumbers[str] = LatestNumbers()
        self._shown: dict[str, tuple[AtvHeartbeat, AtvView]] = {}
        """The view made of the heartbeat beside it; dropped when anything else about the vehicle changes."""
        self.changes = Changes("atv")
        self.by_status: Counter[str] = Counter()
        self.fleet = Fleet(top_mps)
        self.strangers = 0
        self._joined = 0
        """Vehicles that were heard and are not in the plant file."""

    def __contains__(self, atv: object) -> bool:
        """Whether the vehicle is in the plant file or was heard."""
        return atv in self._types or atv in self._last

    def fold(self, heartbeat: AtvHeartbeat, now_s: float) -> bool:
        """Take a heartbeat in, which came at this time of the plant's clock.

        Returns:
            False when it is older than the last one, or exceeds the number of vehicles that may join.
        """
        atv = heartbeat.atv
        last = self._last.get(atv)
        if last is None:
            if atv not in self._types:
                if self._joined >= joining_max(len(self._types)):
                    self.strangers += 1
                    return False
                self._joined += 1
        if not self._newest.takes(atv, (heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        if last is None or last.status is not heartbeat.status:
            self.by_status[heartbeat.status.value] += 1
            if last is not None:
                self.by_status[last.status.value] -= 1
        self.fleet.fold(last, heartbeat, self._battery_wh.get(atv, 0.0))
        if last is not None and last.floor is not heartbeat.floor is UNSET and _stands_as(last, heartbeat):
            # Radio heartbeats omit reservations; a vehicle that has not moved keeps its last known ones.
            heartbeat = msgspec.structs.replace(heartbeat, floor=last.floor)
        self._last[atv] = heartbeat
        self.changes.mark(atv)
        return True

    def heard_s(self, atv: str) -> float | None:
        """When the last heartbeat of one vehicle came (plant clock); None when it was never heard."""
        return self._newest.heard_s(atv)

    def last(self, atv: str) -> AtvHeartbeat | None:
        """The last heartbeat of one vehicle."""
        return self._last.get(atv)

    def heartbeats(self) -> Iterable[AtvHeartbeat]:
        """The last one of each vehicle."""
        return self._last.values()

    def place_m(self, atv: str) -> tuple[float, float] | None:
        """Where a vehicle was by its last heartbeat (x, y); None when it was never heard."""
        heartbeat = self._last.get(atv)
        return None if heartbeat is None else (heartbeat.pose.x_m, heartbeat.pose.y_m)

    def mark(self, agents: Iterable[str]) -> None:
        """Mark these vehicles as changed, if they were heard."""
        for agent in agents:
            if agent in self._last:
                self._shown.pop(agent, None)
                self.changes.mark(agent)

    def view(self, atv: str) -> AtvView | None:
        """One vehicle, or None when it was never heard."""
        return self._show(atv) if atv in self._last else None

    def views(self) -> tuple[AtvView, ...]:
        """All of them, by id."""
        return tuple(self._show(atv) for atv in sorted(self._last))

    def take_changed(self) -> tuple[AtvView, ...]:
        """Those that have changed since the last call."""
        return tuple(self._show(atv) for atv in self.changes.take_changed())

    def _show(self, atv: str) -> AtvView:
        heartbeat = self._last[atv]
        shown = self._shown.get(atv)
        if shown is None or shown[0] is not heartbeat:
            shown = self._shown[atv] = heartbeat, self._view(heartbeat)
        return shown[1]

    def _view(self, heartbeat: AtvHeartbeat) -> AtvView:
        atv, pose = heartbeat.atv, heartbeat.pose
        return AtvView(
            id=atv,
            type=self._types.get(atv, ""),
            status=plain(heartbeat.status),
            x_m=pose.x_m,
            y_m=pose.y_m,
            heading_rad=pose.heading_rad,
            speed_mps=heartbeat.speed_mps,
            node=heartbeat.node,
            way=heartbeat.way,
            holds=() if heartbeat.floor is UNSET else heartbeat.floor.holds,
            battery_frac=heartbeat.battery_frac,
            battery_reckoned=heartbeat.battery_reckoned,
            battery_low=heartbeat.battery_frac < self._must_charge_frac.get(atv, ANY_MUST_CHARGE_FRAC),
            load=heartbeat.load,
            load_quantity=heartbeat.load_quantity,
            link=plain(heartbeat.link),
            via=heartbeat.via,
            task=None if heartbeat.task is None else self._brief(heartbeat.task),
            watches=tuple(self._brief(brief) for brief in heartbeat.watches),
            dwell_point=heartbeat.dwell_point,
            speed_limit_frac=heartbeat.speed_limit_frac,
            acknowledged=heartbeat.acknowledged,
            problem=heartbeat.problem,
            about_problem=None if heartbeat.about_problem is UNSET else problem_view(heartbeat.about_problem),
            body_wait=None
            if heartbeat.body_wait is UNSET
            else wait_view(heartbeat.body_wait, self._to_wall_s),
            help=None if heartbeat.help is None else help_view(heartbeat.help, self._to_wall_s),
            software=heartbeat.software,
            draining=heartbeat.draining,
            out_of_service=None
            if heartbeat.out_of_service is UNSET
            else out_view(heartbeat.out_of_service, self._to_wall_s),
            sent_to_charge=heartbeat.sent_to_charge,
            in_reserve=heartbeat.in_reserve,
            probation=probation_of(heartbeat),
            asks_where_it_stands=heartbeat.floor is not UNSET and heartbeat.floor.asks_where_it_stands,
            removal=self._removals.view(atv),
            shut_out=self._outsiders.view(atv),
            clock=clock_of(self._clocks, atv),
            seen_at_s=self._to_wall_s(heartbeat.at_s),
            silence=self._silence.view(atv, heartbeat),
        )

    def _brief(self, brief: Brief) -> BriefView:
        return BriefView(
            task=brief.task,
            epoch=brief.epoch,
            role=plain(brief.role),
            coordinator=brief.coordinator,
            phase=None if brief.phase is None else brief.phase.value,
            item=brief.item,
            quantity=brief.quantity,
            due_at_s=None if brief.due_s is None else self._to_wall_s(brief.due_s),
        )


def _stands_as(last: AtvHeartbeat, heartbeat: AtvHeartbeat) -> bool:
    """Whether a vehicle has not moved, in the same incarnation."""
    there = (last.incarnation, last.node, last.pose) == (
        heartbeat.incarnation,
        heartbeat.node,
        heartbeat.pose,
    )
    return there and not last.speed_mps and not heartbeat.speed_mps


def probation_of(heartbeat: Heartbeat) -> ProbationView | None:
    """The progress of an agent on probation; None for one that is not."""
    probation = heartbeat.probation
    return None if probation is None else ProbationView(of=probation.of, done=probation.done)


def plain(word: Any) -> Any:
    """The enumeration member as the plain text that views use; both have the same words."""
    return str(word)
