"""Reports on shifts, and targets for a shift's figures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Depends, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.factory.shift_report import (
    FIGURES,
    AgentShift,
    AreaShift,
    InterventionLine,
    Period,
    ShiftReport,
    TakeoverLine,
    figures_of,
)
from dray.gateway.factory.shift_reporter import DAY_S, ShiftReporter
from dray.gateway.http.csv_tables import Format, Row, table, with_csv
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import Json, described, iso
from dray.gateway.orders.drafts import Moment
from dray.settings import Settings
from dray.shift_times import shifts_of
from dray.store import Store
from dray.store.factory.report_targets import Target
from dray.store.replay.spells import Spell
from dray.store.shifts import LateOrder

router = APIRouter(tags=["history"])

LONGEST_DAYS = 7.0
"""Maximum days per report: a week, which is 20 shifts and some 10,000 minutes."""

SHIFT_S = 8 * 3600.0

MOST = 1e9
"""Maximum target, in its unit."""

WEEK_S = 7 * DAY_S

Value = Annotated[float, Field(ge=0, le=MOST, allow_inf_nan=False)]


class ShiftBegin(msgspec.Struct, frozen=True):
    """A daily shift; it ends where the next one begins."""

    name: str
    begin_min: int
    """Minutes after midnight, by the reader's clock."""


class TargetsView(msgspec.Struct, frozen=True, kw_only=True):
    """Targets for figures, and begins of shifts."""

    targets: dict[str, float]
    """By figure, in its own unit: fractions, Wh, factory seconds, or counts. Figures not named have no
    target."""
    by: str
    """Person who set them last; empty if nobody did."""
    at_s: float | None
    """Wall clock time of that."""
    shifts: tuple[ShiftBegin, ...]
    """Earliest first."""


_AT_S = 1_893_456_000.0

EXAMPLES = (
    ShiftReport(
        plant="Figure 1",
        made_at_s=_AT_S,
        period=Period(from_at_s=_AT_S - SHIFT_S, until_at_s=_AT_S, seen_frac=1.0),
        before=Period(from_at_s=_AT_S - DAY_S - SHIFT_S, until_at_s=_AT_S - DAY_S, seen_frac=1.0),
        figures=figures_of({"on_time_frac": 0.962}, {"on_time_frac": 0.971}, {"on_time_frac": 0.95}),
        course=(),
        step_s=1800.0,
        agents=(
            AgentShift(
                agent="ATV3", kind="atv", areas=(), doings_s={"carries": 9120.0, "waits": 310.5}, waits=41
            ),
        ),
        areas=(
            AreaShift(
                area="AREA1",
                name="North",
                machines=6,
                starved_frac=0.016,
                passes=912,
                waits=41,
                waited_s=870.0,
            ),
        ),
        takeovers=(
            TakeoverLine(
                at_s=_AT_S - 60, task="M9-12", replaced="ATV3", carrier="ATV1", reason="silent", silent_s=5.5
            ),
        ),
        interventions=(
            InterventionLine(
                at_s=_AT_S - 90, action="vehicle.command", role="operator", target="ATV6", command="stop"
            ),
        ),
        waits=(
            Spell(agent="ATV5", doing="waits", from_at_s=_AT_S - 400, until_at_s=_AT_S - 270, other="ATV3"),
        ),
        late_orders=(LateOrder("O-7KQ2", "PO-48102", _AT_S - 900, _AT_S - 780),),
    ),
    TargetsView(
        targets={"on_time_frac": 0.95, "interventions": 8.0},
        by="Mia",
        at_s=_AT_S,
        shifts=(ShiftBegin("early", 360), ShiftBegin("late", 840), ShiftBegin("night", 1320)),
    ),
)
"""One example per answer."""


class NewTargets(BaseModel):
    """All targets from now on."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"targets": {"on_time_frac": 0.95, "interventions": 8}}]},
    )

    targets: dict[str, Value] = Field(max_length=len(FIGURES))


@router.get(
    "/reports/shift",
    responses={200: with_csv(described(ShiftReport, "The report"))},
    response_class=Json,
)
async def get_shift_report(
    reporter: Provided[ShiftReporter],
    caller: Caller,
    now_s: Now,
    since: Annotated[Moment | None, Query(alias="from", description="8 h before `until` without it")] = None,
    until: Annotated[Moment | None, Query(description="Now without it")] = None,
    against: Annotated[
        Literal["day", "before", "week"],
        Query(
            description="What it is compared with: the same time a day or a week earlier, or the time just before"
        ),
    ] = "day",
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """The outcome of a shift, or of any period up to a week, against an earlier one and against targets.

    The earlier period is as long as the elapsed part. `docs/reports.md` defines every figure.
    """
    until_s = now_s if until is None else until.timestamp()
    since_s = until_s - SHIFT_S if since is None else since.timestamp()
    if not since_s < until_s <= since_s + LONGEST_DAYS * DAY_S:
        raise unusable(
            FieldError("until", f"give a moment after from, {LONGEST_DAYS:g} days after it at most")
        )
    if since_s >= now_s:
        raise unusable(FieldError("from", "that has not begun; give a moment before now"))
    length_s = min(until_s, now_s) - since_s
    before_s = since_s - {"day": max(DAY_S, length_s), "before": until_s - since_s, "week": WEEK_S}[against]
    report = await reporter.report(
        since_s,
        until_s,
        before_s,
        now_s,
        orders=caller.may(Scope.ORDERS_READ),
        people=caller.may(Scope.AUDIT_READ),
    )
    if format == "csv":
        header = ("part", "name", "figure", "unit", "value", "before", "target")
        return table("shift-report", header, _rows(report))
    return Json(report)


@router.get(
    "/reports/targets",
    responses={200: described(TargetsView, "Targets and shifts")},
    response_class=Json,
)
async def get_targets(store: Provided[Store], settings: Provided[Settings]) -> Json:
    """Targets for a shift's figures, and begins of shifts."""
    async with store.read() as work:
        targets = await work.report_targets.all()
    return Json(_view(targets, settings))


@router.put(
    "/reports/targets",
    dependencies=[Depends(json_only)],
    responses={200: described(TargetsView, "What holds now")},
    response_class=Json,
)
async def put_targets(
    store: Provided[Store],
    settings: Provided[Settings],
    caller: Caller,
    note: Noted,
    now_s: Now,
    request: NewTargets,
) -> Json:
    """Set the targets for a shift's figures; they replace all earlier ones."""
    note.detail["targets"] = request.targets
    faults = [wrong for name, value in request.targets.items() if (wrong := _wrong(name, value))]
    if faults:
        raise unusable(*faults)
    targets = [Target(name, value, caller.name[:80], now_s) for name, value in request.targets.items()]
    async with store.write() as work:
        await work.report_targets.replace(targets)
    return Json(_view(targets, settings))


def _wrong(name: str, value: float) -> FieldError | None:
    if name not in FIGURES:
        return FieldError(f"targets.{name}", f"there is no such figure; there are {', '.join(FIGURES)}")
    is_more = FIGURES[name].unit == "frac" and value > 1
    return FieldError.of(f"targets.{name}", "part_of_one") if is_more else None


def _view(targets: list[Target], settings: Settings) -> TargetsView:
    last = max(targets, key=lambda each: each.at_s, default=None)
    return TargetsView(
        targets={each.figure: each.value for each in targets},
        by="" if last is None else last.by,
        at_s=None if last is None else last.at_s,
        shifts=tuple(ShiftBegin(*each) for each in shifts_of(settings.shifts)),
    )


def _rows(report: ShiftReport) -> Iterator[Row]:
    """One line per figure; lines about a moment have it as their `unit`."""
    for each in report.figures:
        yield "figures", "plant", each.name, each.unit, each.value, each.before, each.target
    for agent in report.agents:
        for doing, spent_s in agent.doings_s.items():
            yield agent.kind, agent.agent, doing, "s", spent_s, None, None
    for area in report.areas:
        yield "area", area.area, "starved_frac", "frac", area.starved_frac, None, None
        yield "area", area.area, "passes", "count", area.passes, None, None
        yield "area", area.area, "waits", "count", area.waits, None, None
        yield "area", area.area, "waited", "s", area.waited_s, None, None
    for taken in report.takeovers:
        yield "takeover", taken.task, taken.reason, iso(taken.at_s), taken.carrier, taken.replaced, None
    for act in report.interventions:
        yield "intervention", act.target, act.action, iso(act.at_s), act.command, act.role, None
    for wait in report.waits:
        yield (
            "wait",
            wait.agent,
            wait.other,
            iso(wait.from_at_s),
            round(wait.until_at_s - wait.from_at_s, 1),
            None,
            None,
        )
    for order in report.late_orders:
        done = None if order.delivered_at_s is None else iso(order.delivered_at_s)
        yield "late_order", order.id, order.reference, iso(order.due_at_s), done, None, None
