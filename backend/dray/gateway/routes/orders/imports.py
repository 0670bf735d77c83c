"""Imports: files of orders, all placed or none."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import Annotated

import msgspec
from fastapi import APIRouter, Body, Depends
from pydantic import ConfigDict

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.http.csv_rows import RowFault, first_by_row, refusal
from dray.gateway.http.problems import MAX_FIELD_ERRORS
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import RowsFile, json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.http.side_work import SideWork
from dray.gateway.http.unread import Unread, UnreadRoute
from dray.gateway.orders.csv_import import placed_already, read_file
from dray.gateway.orders.drafts import OrderDraft
from dray.gateway.orders.idempotency import Key, own_key
from dray.gateway.orders.order_ids import new_token
from dray.gateway.orders.placement import OrderPlacement
from dray.store.orders.orders import Order

router = APIRouter(tags=["orders"], route_class=UnreadRoute)


class ImportRequest(RowsFile):
    """A file of orders."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "csv": "customer,reference,product,quantity,due_at\r\nMuster GmbH,4711,P1,5,\r\n",
                    "dry_run": True,
                }
            ]
        },
    )


class ImportedOrder(msgspec.Struct, frozen=True, kw_only=True):
    """An order of the file."""

    id: str
    """Empty in a dry run."""
    customer: str
    reference: str | None
    items: int
    pieces: int
    """Total of all its items."""


class ImportAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """The content of the file."""

    orders: tuple[ImportedOrder, ...]
    faults: tuple[RowFault, ...]
    """Faults by row, at most 50; empty if it was placed."""
    hints: tuple[RowFault, ...]
    """Oddities by row that do not prevent placing, at most 50: orders placed already, for example, or letters
    of an unknown encoding."""


@router.post(
    "/orders/import",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ImportAnswer, "What is in the file; unless it was a dry run, all of it is on disk"),
        **problems(
            p409="A request with this key is still being answered",
            p429="Too many files of this caller are being read",
            p503="Too many orders are open, or too many files are being read",
        ),
    },
    response_class=Json,
)
async def import_orders(
    placement: Provided[OrderPlacement],
    side_work: Provided[SideWork],
    caller: Caller,
    note: Noted,
    body: Annotated[bytes, Body(), Unread(ImportRequest)],
    key: Key = None,
) -> Json:
    """Place the orders of a spreadsheet, all of them or none.

    The first row names the columns: `customer`, `reference`, `product`, `quantity`, `due_at`, `release`.
    Successive rows with the same customer and reference are one order. A dry run places nothing and lists the
    faults by row; otherwise a single fault refuses the whole file.
    """
    file = await side_work.do(caller.key, read_file, body, placement.products, placement.now_s)
    drafts = [each.draft for each in file.orders]
    note.detail |= {"orders": len(drafts), "dry_run": file.dry_run}
    # Without a key every request is a new one. A file's answer differs from a single order's, so the key is
    # prefixed here.
    own = own_key(caller, f"import {key or new_token()}")
    if key and not file.dry_run and not file.faults:
        kept = await placement.answered(drafts, own, note)
        if kept is not None:
            return Json(kept.answer.encode())
    faults = first_by_row([*file.faults, *file.senseless])
    if faults and not file.dry_run:
        raise refusal(faults)
    lately = await placement.placed_lately({draft.reference for draft in drafts if draft.reference})
    again = islice(placed_already(file.orders, lately, placement.now_s), MAX_FIELD_ERRORS)
    hints = first_by_row([*file.hints, *again])
    if file.dry_run:
        return Json(_imported([(draft, "") for draft in drafts], faults, hints))

    def render(orders: Sequence[Order]) -> bytes:
        pairs = zip(drafts, (order.id for order in orders), strict=True)
        return msgspec.json.encode(_imported(list(pairs), [], hints))

    kept, _replayed = await placement.place_all_once(drafts, caller.key, own, render, note)
    return Json(kept.answer.encode())


def _imported(
    orders: Sequence[tuple[OrderDraft, str]], faults: Sequence[RowFault], hints: Sequence[RowFault]
) -> ImportAnswer:
    return ImportAnswer(
        orders=tuple(
            ImportedOrder(
                id=name,
                customer=draft.customer,
                reference=draft.reference,
                items=len(draft.items),
                pieces=sum(item.quantity for item in draft.items),
            )
            for draft, name in orders
        ),
        faults=tuple(faults),
        hints=tuple(hints),
    )
