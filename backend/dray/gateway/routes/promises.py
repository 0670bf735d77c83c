"""Promises: how vehicles keep them."""

from __future__ import annotations

from fastapi import APIRouter, Response

from dray.gateway.answers import Json, described
from dray.gateway.ledger import FIELDS, PromiseLedger, rows
from dray.gateway.parts import Gateway
from dray.gateway.spreadsheet import Format, header_of, table, with_csv

router = APIRouter(tags=["history"])


@router.get(
    "/promises", responses={200: with_csv(described(PromiseLedger, "The ledger"))}, response_class=Json
)
async def get_promises(
    gateway: Gateway,
    format: Format = "json",  # noqa: A002 - the word that others use
) -> Response:
    """The promise ledger: per vehicle, when transports were promised against when they were delivered.

    A vehicle promises a time when it is hired. Who takes a transport over promises a new one, and the one
    that it replaces has lost it. Kept from the facts in `/api/events`, as long as these are.
    """
    ledger = await gateway.ledger.read()
    return table("promises", header_of(FIELDS), rows(ledger)) if format == "csv" else Json(ledger)
