"""The factory's figures, now and over time."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Response

from dray.gateway.factory.figure_sampler import KEPT_S, SAMPLE_S
from dray.gateway.factory.figures import KpiHistory, KpiPoint, points
from dray.gateway.http.csv_tables import Format, header_of, row_of, table, with_csv
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import FactoryView
from dray.gateway.orders.drafts import Moment
from dray.store import Store

router = APIRouter(tags=["factory"])

SHOWN_S = 8 * 3600.0
"""Default period: a shift."""

MOST_POINTS = 2_000
"""Maximum steps per answer: more than a screen has columns."""

Step = Annotated[
    Literal["60", "300", "900", "3600", "14400", "86400"],
    Query(description="Wall seconds that one step is long"),
]


@router.get("/kpis", responses={200: described(FactoryView, "The figures")}, response_class=Json)
async def get_kpis(projection: Provided[Projection], now_s: Now) -> Json:
    """The factory's figures now."""
    return Json(projection.factory(now_s))


@router.get(
    "/kpis/history",
    responses={200: with_csv(described(KpiHistory, "The figures, oldest first"))},
    response_class=Json,
)
async def get_kpi_history(
    store: Provided[Store],
    now_s: Now,
    since: Moment | None = None,
    until: Moment | None = None,
    step: Step = "300",
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """The factory's figures over time, by default of the last eight hours.

    By minutes, at most 35 days per answer; docs/operating.md has the retention. Steps begin at whole
    multiples of `step` since 1970.
    """
    step_s = float(step)
    until_s = now_s if until is None else until.timestamp()
    since_s = until_s - SHOWN_S if since is None else since.timestamp()
    begin_s, end_s = since_s // step_s * step_s, -(-until_s // step_s) * step_s
    _refuse_nonsense(begin_s, end_s, step_s)
    async with store.read() as work:
        # A sample counts for the middle of its minute.
        samples = await work.kpis.between(begin_s + SAMPLE_S / 2, end_s + SAMPLE_S / 2)
    found = points(samples, step_s)
    if format == "csv":
        fields = KpiPoint.__struct_fields__
        return table("kpis", header_of(fields), (row_of(fields, point) for point in found))
    return Json(KpiHistory(since_at_s=begin_s, until_at_s=end_s, step_s=step_s, items=tuple(found)))


def _refuse_nonsense(since_s: float, until_s: float, step_s: float) -> None:
    if until_s <= since_s:
        raise unusable(FieldError("until", "it is not after since; give a later moment"))
    if until_s - since_s > KEPT_S + step_s:
        days = KEPT_S / 86_400
        raise unusable(FieldError("since", f"{days:g} days are told at once; ask for no more"))
    if (until_s - since_s) / step_s > MOST_POINTS:
        reason = f"that makes more than {MOST_POINTS} steps; take a longer step, or a shorter time"
        raise unusable(FieldError("step", reason))
