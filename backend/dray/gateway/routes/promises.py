"""Promises: how vehicles keep them."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Response

from dray.gateway.answers import Json, described
from dray.gateway.ledger import PromiseLedger, to_csv
from dray.gateway.parts import Gateway

router = APIRouter(tags=["history"])

ANSWER = described(PromiseLedger, "The ledger")
ANSWER["content"]["text/csv"] = {"schema": {"type": "string"}}


@router.get("/promises", responses={200: ANSWER}, response_class=Json)
async def get_promises(
    gateway: Gateway,
    format: Annotated[  # noqa: A002 - the word that others use
        Literal["json", "csv"], Query(description="`csv` for a spreadsheet")
    ] = "json",
) -> Response:
    """The promise ledger: per vehicle, when transports were promised against when they were delivered.

    A vehicle promises a time when it is hired. Who takes a transport over promises a new one, and the one
    that it replaces has lost it. Kept from the facts in `/api/events`, as long as these are.
    """
    ledger = await gateway.ledger.read()
    if format == "json":
        return Json(ledger)
    headers = {"Content-Disposition": 'attachment; filename="promises.csv"'}
    return Response(to_csv(ledger), media_type="text/csv", headers=headers)
