"""Imports: files of products, all defined or none."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Body, Depends
from pydantic import ConfigDict

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.csv_rows import RowFault, refusal
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.request_bodies import RowsFile, json_only
from dray.gateway.http.responses import Json, described, problems
from dray.gateway.http.side_work import SideWork
from dray.gateway.http.unread import Unread, UnreadRoute
from dray.gateway.http.versions import changed_since
from dray.gateway.live.projection import Projection
from dray.gateway.products.judging import read_file

router = APIRouter(tags=["plant"], route_class=UnreadRoute)


class ProductsFile(RowsFile):
    """A file of products."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {
                    "csv": "product,name,lot,material,pieces,machine,cycle_s\r\nP9,Bracket,4,steel,2,M1,12.5\r\n",
                    "dry_run": True,
                }
            ]
        },
    )


class ImportedProduct(msgspec.Struct, frozen=True, kw_only=True):
    """A product of the file."""

    id: str
    name: str
    becomes: Literal["new", "changed", "unchanged"]
    revision: int
    """Revision once the file is taken."""


class ProductsAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """The content of the file."""

    products: tuple[ImportedProduct, ...]
    faults: tuple[RowFault, ...]
    """Faults by row, at most 50; empty if it was taken."""
    hints: tuple[RowFault, ...]
    """Oddities that do not prevent taking it, such as letters of an unknown encoding."""


@router.post(
    "/products/import",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ProductsAnswer, "What is in the file; unless it was a dry run, all of it is on disk"),
        **problems(
            p409="As many products as may be are defined, or would be",
            p412="Somebody has changed one of the products meanwhile; send the file again",
            p429="Too many files of this caller are being read, or it would define more products than one caller may",
            p503="Too many files are being read",
        ),
    },
    response_class=Json,
)
async def import_products(
    projection: Provided[Projection],
    catalogue: Provided[Catalogue],
    side_work: Provided[SideWork],
    caller: Caller,
    note: Noted,
    now_s: Now,
    body: Annotated[bytes, Body(), Unread(ProductsFile)],
) -> Json:
    """Define the products of a spreadsheet, all of them or none.

    The first row names the columns: `product`, `name`, `lot`, `ability`, `material`, `pieces`, `machine`,
    `cycle_s`, `document`, `address`, `media_type`, `sha256`. Successive rows with the same product are one
    product; each may name one line of its bill, one machine and one document. An existing product gets a new
    revision, unless nothing has changed. A dry run defines nothing and lists the faults by row; otherwise a
    single fault refuses the whole file.
    """
    judged = projection.site.plant
    read = await side_work.do(caller.key, read_file, body, catalogue.known())
    wishes = read.wishes
    news = [wish for wish in wishes if wish.before is None or catalogue.is_news(wish)]
    note.detail |= {"products": len(wishes), "changed": len(news), "dry_run": read.dry_run}
    new = {wish.product.id for wish in news}
    lasts = await catalogue.lasts([wish.product.id for wish in news if wish.before is None])
    products = tuple(
        ImportedProduct(
            id=wish.product.id,
            name=wish.product.name,
            becomes="unchanged"
            if wish.product.id not in new
            else "new"
            if wish.before is None
            else "changed",
            revision=(wish.before or lasts.get(wish.product.id, 0)) + (wish.product.id in new),
        )
        for wish in wishes
    )
    hints = tuple(read.hints)
    if read.dry_run:
        return Json(ProductsAnswer(products=products, faults=tuple(read.faults), hints=hints))
    if read.faults:
        raise refusal(read.faults)
    if changed := await catalogue.define(news, caller.name, now_s, judged):
        raise changed_since("product", changed)
    return Json(ProductsAnswer(products=products, faults=(), hints=hints))
