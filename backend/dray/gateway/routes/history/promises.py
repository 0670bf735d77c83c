"""Promises: how vehicles keep them."""

from __future__ import annotations

from fastapi import APIRouter, Response

from dray.gateway.factory.promises import FIELDS, Ledger, PromiseLedger, rows
from dray.gateway.http.csv_tables import Format, header_of, table, with_csv
from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import Json, described

router = APIRouter(tags=["history"])


@router.get(
    "/promises", responses={200: with_csv(described(PromiseLedger, "The ledger"))}, response_class=Json
)
async def get_promises(
    ledger: Provided[Ledger],
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """The promise ledger: per vehicle, promised against actual delivery times.

    A vehicle promises a time on contract. A vehicle that takes over promises a new time, and the replaced one
    has lost the transport. Computed from the facts in `/api/events`, as long as these are kept.
    """
    promises = await ledger.read()
    return table("promises", header_of(FIELDS), rows(promises)) if format == "csv" else Json(promises)
