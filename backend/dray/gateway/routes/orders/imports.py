"""Imports: files of orders, placed all or none."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
from fastapi import APIRouter, Depends
from pydantic import ConfigDict

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.http.csv_rows import RowFault, refusal, text_of_file
from dray.gateway.http.problems import MAX_FIELD_ERRORS
from dray.gateway.http.provided import Provided
from dray.gateway.http.request_bodies import RowsFile, json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.http.side_work import SideWork
from dray.gateway.orders.csv_import import ReadOrder, place, placed_already, read_orders, twice_in_file
from dray.gateway.orders.drafts import OrderDraft, nonsense
from dray.gateway.orders.idempotency import Key, own_key
from dray.gateway.orders.order_ids import new_token
from dray.gateway.orders.placement import OrderPlacement
from dray.plant.model import PlantFile
from dray.store.orders.orders import Order

router = APIRouter(tags=["orders"])


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
    """Over all of its items."""


class ImportAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """What was in the file."""

    orders: tuple[ImportedOrder, ...]
    faults: tuple[RowFault, ...]
    """What is wrong with it, by row; 50 at most. Empty when it was placed."""
    hints: tuple[RowFault, ...]
    """What is odd in it and placed all the same, by row; 50 at most. Orders that were placed already, say, or letters of an unknown encoding."""


@router.post(
    "/orders/import",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ImportAnswer, "What is in the file; unless it was a dry run, all of it is on disk"),
        **problems(
            p409="A request with this key is still being answered",
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
    file: ImportRequest,
    key: Key = None,
) -> Json:
    """Place the orders of a spreadsheet, all of them or none.

    The first row names the columns: `customer`, `reference`, `product`, `quantity`, `due_at`, `release`. Rows
    that follow one another with the same customer and reference are one order. A dry run places nothing and
    tells what is wrong in which row; without one, a single fault refuses the whole file.
    """
    read, faults, hints = await side_work.do(_read, file.csv, file.base64)
    drafts = [each.draft for each in read]
    note.detail |= {"orders": len(drafts), "dry_run": file.dry_run}
    # Without a key of its own every request is another one. An order and a file of that order alone are
    # answered differently, so a key stands for another thing here.
    own = own_key(caller, f"import {key or new_token()}")
    if key and not file.dry_run and not faults:
        kept = await placement.answered(drafts, own, note)
        if kept is not None:
            return Json(kept.answer.encode())
    faults += await side_work.do(_senseless, read, placement.plant, placement.now_s)
    faults.sort(key=lambda fault: fault.row)
    hints += twice_in_file(read)
    lately = await placement.placed_lately({draft.reference for draft in drafts if draft.reference})
    hints += placed_already(read, lately, placement.now_s)
    if file.dry_run:
        return Json(_imported([(draft, "") for draft in drafts], faults[:MAX_FIELD_ERRORS], hints))
    if faults:
        raise refusal(faults)

    def render(orders: Sequence[Order]) -> bytes:
        pairs = zip(drafts, (order.id for order in orders), strict=True)
        return msgspec.json.encode(_imported(list(pairs), [], hints))

    kept, _replayed = await placement.place_all_once(drafts, own, render, note)
    return Json(kept.answer.encode())


def _read(csv: str | None, base64: str | None) -> tuple[list[ReadOrder], list[RowFault], list[RowFault]]:
    """The orders of a file, what is wrong with its form, and hints. Takes its time."""
    file = text_of_file(csv, base64)
    return ([], file.faults, []) if file.faults else (*read_orders(file.text), file.hints)


def _senseless(read: Sequence[ReadOrder], plant: PlantFile, now_s: float) -> list[RowFault]:
    """What has the right form and cannot be done here, or any more. Takes its time."""
    return [place(error, each.row) for each in read for error in nonsense(each.draft, plant, now_s)]


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
        hints=tuple(hints[:MAX_FIELD_ERRORS]),
    )
