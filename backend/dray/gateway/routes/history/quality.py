"""Quality: good and bad pieces made by machines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import msgspec
from fastapi import APIRouter, Response

from dray.gateway.access.caller import Caller
from dray.gateway.factory.figure_sampler import KEPT_S
from dray.gateway.factory.figures import part
from dray.gateway.http.csv_tables import Format, header_of, row_of, table, with_csv
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, described
from dray.gateway.orders.drafts import Moment
from dray.gateway.routes.history.events import Words
from dray.gateway.routes.history.kpis import SHOWN_S
from dray.gateway.routes.parameters import Visible
from dray.store import Store
from dray.store.factory.piece_hours import HOUR_S, PieceCount

router = APIRouter(tags=["factory"])


class QualityLine(msgspec.Struct, frozen=True):
    """One machine's pieces of one product, in the terms of ISO 22400-2."""

    machine: str
    product: str
    good_quantity: int
    """Good pieces."""
    scrap_quantity: int
    """Bad pieces; each was made again."""
    produced_quantity: int
    """Sum of both."""
    quality_ratio: float
    """Good quantity / produced quantity: 1 if every piece was good."""


class QualityAnswer(msgspec.Struct, frozen=True):
    """Good and bad pieces by machine and product, in whole wall hours."""

    since_at_s: float
    """Wall clock at a whole hour, like `until_at_s`."""
    until_at_s: float
    good_quantity: int
    """Sum of all lines below, like the next three."""
    scrap_quantity: int
    produced_quantity: int
    quality_ratio: float | None
    """Null if nothing was made."""
    items: tuple[QualityLine, ...]
    """By machine, then by product; only those with pieces."""


EXAMPLE = QualityAnswer(
    1_767_250_800.0,
    1_767_279_600.0,
    *(388, 12, 400, 0.97),
    (QualityLine("MILL1", "gear", 388, 12, 400, 0.97),),
)


@router.get(
    "/kpis/quality",
    responses={200: with_csv(described(QualityAnswer, "The pieces", EXAMPLE))},
    response_class=Json,
)
async def get_quality(
    store: Provided[Store],
    caller: Caller,
    visible: Visible,
    now_s: Now,
    since: Moment | None = None,
    until: Moment | None = None,
    machine: Words = None,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """Good and bad pieces, and the quality ratio of ISO 22400-2, by machine and product.

    By default of the last eight hours. Counted by whole wall hours; at most 35 days per answer. `machine` may
    be repeated; without it, all machines that the caller sees.
    """
    until_s = now_s if until is None else until.timestamp()
    since_s = until_s - SHOWN_S if since is None else since.timestamp()
    begin_s, end_s = since_s // HOUR_S * HOUR_S, -(-until_s // HOUR_S) * HOUR_S
    if end_s <= begin_s:
        raise unusable(FieldError("until", "it is not after since; give a later moment"))
    if end_s - begin_s > KEPT_S + HOUR_S:
        reason = f"{KEPT_S / 86_400:g} days are told at once; ask for no more"
        raise unusable(FieldError("since", reason))
    async with store.read() as work:
        counts = await work.piece_hours.between(begin_s, end_s)
    asked = frozenset(machine or ())
    told = (count for count in counts if not asked or count.machine in asked)
    if caller.areas is not None:
        here = {each.id for each in visible.plant().machines}
        told = (count for count in told if count.machine in here)
    lines = tuple(_lines(told))
    if format == "csv":
        fields = QualityLine.__struct_fields__
        return table("quality", header_of(fields), (row_of(fields, line) for line in lines))
    good, bad = sum(line.good_quantity for line in lines), sum(line.scrap_quantity for line in lines)
    return Json(QualityAnswer(begin_s, end_s, good, bad, good + bad, part(good, good + bad), lines))


def _lines(counts: Iterable[PieceCount]) -> Iterator[QualityLine]:
    for each in counts:
        made = each.good + each.bad
        yield QualityLine(each.machine, each.product, each.good, each.bad, made, each.good / made)
