"""The reporter: reads the data of a shift report from SQL, in bounded pieces."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from dray.gateway.factory.figure_sampler import SAMPLE_S
from dray.gateway.factory.figures import KpiPoint, part, point, points
from dray.gateway.factory.shift_report import (
    AgentShift,
    AreaShift,
    InterventionLine,
    Period,
    ShiftReport,
    TakeoverLine,
    agents_of,
    figures_of,
    starved_frac,
    waited,
)
from dray.gateway.live.projection import Projection
from dray.gateway.live.replay.recorder import Recorder
from dray.gateway.live.replay.spells import LONGEST_S
from dray.store import Store
from dray.store.access.audit import AuditRow
from dray.store.factory.lane_traffic import HOUR_S, LaneTraffic
from dray.store.factory.takeovers import Takeover
from dray.store.replay.spells import Spell
from dray.store.work import Work

INTERVENTIONS = (
    "vehicle.command",
    "machine.command",
    "vehicle.carry_away",
    "vehicle.put_back",
    "agent.shut_out",
    "agent.readmit",
    "floor.close",
    "floor.open",
    "floor.cleared",
    "area.pause",
    "area.go_on",
    "call.answer",
    "order.change",
    "order.revoke",
    "order.cancel",
)
"""Audit log actions that intervene in running work; planned actions, such as a new order, do not count."""

LINES_MOST, LATE_MOST, WAITS_MOST = 50, 20, 10
"""Maximum lines that a person reads at a change of shifts; the panel's pages have all."""

HALF_HOUR_S, FOUR_HOURS_S, DAY_S = 1800.0, 4 * 3600.0, 86_400.0


@dataclass(frozen=True, slots=True)
class _Sums:
    """The sums of one span."""

    period: Period
    figures: dict[str, float | None]
    agents: tuple[AgentShift, ...]


class ShiftReporter:
    """Makes reports.

    Args:
        store: the database.
        projection: knows the plant.
        recorder: this gateway's recorder, which knows present spells.
        speed: factory seconds per wall second.
    """

    def __init__(self, store: Store, projection: Projection, recorder: Recorder | None, speed: float) -> None:
        self._store, self._recorder, self._speed = store, recorder, speed
        self._projection, self._plant = projection, projection.site.plant

    async def report(
        self, since_s: float, until_s: float, before_s: float, now_s: float, *, orders: bool, people: bool
    ) -> ShiftReport:
        """The report on a span of time.

        Args:
            since_s: begin (all times: wall clock).
            until_s: end.
            before_s: begin of the span to compare with, of the same length as the elapsed part.
            now_s: the present.
            orders: whether the caller may see single orders.
            people: whether the caller may see single acts of people.
        """
        until_s = max(since_s, min(until_s, now_s))
        step_s = HALF_HOUR_S if until_s - since_s <= DAY_S else FOUR_HOURS_S
        async with self._store.read() as work:
            now = await self._sums(work, since_s, until_s)
            before = await self._sums(work, before_s, before_s + until_s - since_s)
            targets = {each.figure: each.value for each in await work.report_targets.all()}
            course = await _course(work, since_s, until_s, step_s)
            lanes = await work.lane_hours.between(since_s // HOUR_S * HOUR_S, until_s)
            _, taken = await work.takeovers.between(since_s, until_s, LINES_MOST)
            _, acts = await work.shifts.interventions(since_s, until_s, INTERVENTIONS, LINES_MOST)
            waits = await work.shifts.worst("waits", since_s, until_s, LONGEST_S, WAITS_MOST)
            late = await work.shifts.late_orders(since_s, until_s, LATE_MOST) if orders else []
        return ShiftReport(
            plant=self._plant.name,
            made_at_s=now_s,
            period=now.period,
            before=before.period,
            figures=figures_of(now.figures, _comparable(before), targets),
            course=course,
            step_s=step_s,
            agents=now.agents,
            areas=self._areas(now.agents, lanes),
            takeovers=tuple(map(_takeover, taken)),
            interventions=tuple(_intervention(*act) for act in acts) if people else (),
            waits=tuple(waits),
            late_orders=tuple(late),
        )

    async def _sums(self, work: Work, since_s: float, until_s: float) -> _Sums:
        samples = await work.kpis.between(since_s + SAMPLE_S / 2, until_s + SAMPLE_S / 2)
        total = point(since_s, samples) if samples else None
        uses = await work.shifts.uses(since_s, until_s, LONGEST_S)
        told = [(each.agent, each.doing, each.spent_s, each.spells) for each in uses]
        machines = {name: self._areas_of(node) for name, node in self._machines()}
        agents = agents_of([*told, *self._under_way(since_s, until_s)], machines, tuple(self._plant.fleet))
        orders = await work.shifts.orders(since_s, until_s)
        takeovers, _ = await work.takeovers.between(since_s, until_s, 0)
        acts, _ = await work.shifts.interventions(since_s, until_s, INTERVENTIONS, 0)
        kept_from_s = await work.takeovers.since_s()
        times_s = await work.shifts.transport_times_s(since_s, until_s, DAY_S, (0.5, 0.95))
        waits, waited_frac = waited(agents)
        seen_s = sum(each.span_s for each in samples) / self._speed
        figures: dict[str, float | None] = {
            "orders_delivered": orders.delivered,
            "on_time_frac": part(orders.delivered - orders.late, orders.delivered),
            "orders_late": orders.late,
            "orders_open": orders.open,
            "orders_overdue": orders.overdue,
            "waits": waits,
            "waited_frac": waited_frac,
            "interventions": acts,
            "takeovers": takeovers if kept_from_s is not None and kept_from_s < until_s else None,
        }
        for name, wall_s in zip(("transport_p50_s", "transport_p95_s"), times_s, strict=False):
            figures[name] = wall_s * self._speed
        if total is not None:
            figures |= _of_minutes(total)
            made_s, with_goal_s = (
                sum(each.machine_making_s for each in samples),
                sum(
                    each.machine_making_s + each.machine_starved_s + each.machine_broken_s for each in samples
                ),
            )
            figures["machine_producing_frac"] = part(made_s, with_goal_s)
        period = Period(
            from_at_s=since_s, until_at_s=until_s, seen_frac=min(1.0, part(seen_s, until_s - since_s) or 0.0)
        )
        return _Sums(period, figures, agents)

    def _machines(self) -> list[tuple[str, str]]:
        return [(machine.id, machine.node) for machine in self._plant.machines.values()]

    def _areas_of(self, node: str) -> tuple[str, ...]:
        at = self._plant.nodes.get(node)
        return () if at is None else self._plant.areas_at(at.x_m, at.y_m)

    def _under_way(self, since_s: float, until_s: float) -> list[tuple[str, str, float, int]]:
        """Unwritten spells of this span."""
        spells: list[Spell] = [] if self._recorder is None else self._recorder.spells()
        cut = ((each, min(each.until_at_s, until_s) - max(each.from_at_s, since_s)) for each in spells)
        return [(each.agent, each.doing, spent_s, 1) for each, spent_s in cut if spent_s > 0]

    def _areas(self, agents: tuple[AgentShift, ...], lanes: list[LaneTraffic]) -> tuple[AreaShift, ...]:
        found = []
        for area in self._plant.areas.values():
            nodes = self._plant.extent_of(area.id).nodes
            inside = [lane for lane in lanes if lane.start in nodes]
            machines = [each for each in agents if area.id in each.areas]
            found.append(
                AreaShift(
                    area=area.id,
                    name=area.name,
                    machines=len(machines),
                    starved_frac=starved_frac(machines),
                    passes=sum(lane.passes for lane in inside),
                    waits=sum(lane.waits for lane in inside),
                    waited_s=sum(lane.waited_s for lane in inside),
                )
            )
        return tuple(found)


def _comparable(sums: _Sums) -> dict[str, float | None]:
    """The figures to compare with: where no gateway has counted, a 0 means nothing."""
    if sums.period.seen_frac > 0.0:
        return sums.figures
    return {name: value or None for name, value in sums.figures.items()}


async def _course(work: Work, since_s: float, until_s: float, step_s: float) -> tuple[KpiPoint, ...]:
    samples = await work.kpis.between(since_s + SAMPLE_S / 2, until_s + SAMPLE_S / 2)
    return tuple(points(samples, step_s))


def _of_minutes(total: KpiPoint) -> dict[str, float | None]:
    return {
        "transports": total.transports,
        "empty_frac": total.empty_frac,
        "starved_frac": total.starved_frac,
        "machine_available_frac": total.machine_available_frac,
        "atv_available_frac": total.atv_available_frac,
        "energy_wh": total.energy_wh,
        "transport_energy_wh": part(total.energy_wh, total.transports),
        "helps": total.helps,
    }


def _takeover(told: Takeover) -> TakeoverLine:
    fact = told.fact
    return TakeoverLine(
        at_s=told.at_s,
        task=fact.task,
        replaced=fact.replaced,
        carrier=fact.carrier,
        reason=fact.reason.value,
        silent_s=fact.silent_s,
    )


def _intervention(row: AuditRow, role: str) -> InterventionLine:
    assert isinstance(row.detail, msgspec.Raw)  # noqa: S101 - as it was read
    detail = msgspec.json.decode(row.detail)
    command = detail.get("command", "") if isinstance(detail, dict) else ""
    return InterventionLine(
        at_s=row.at_s,
        action=row.action,
        role=role,
        target=row.target,
        command=command if isinstance(command, str) else "",
    )
