"""What this plant can make: master data, which people define while it runs."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Header, Path
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.problems import FieldError, Problem, not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.request_bodies import Line, json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, page, problems
from dray.gateway.live.projection import Projection
from dray.plant import BillLine, Product

router = APIRouter(tags=["plant"])

ID = r"^[A-Za-z][A-Za-z0-9_.-]{0,31}$"

LINES_MAX = 100
"""Of a bill; a machine has a buffer for each."""

MACHINES_MAX = 200

Name = Annotated[str, Field(pattern=ID)]

Pieces = Annotated[int, Field(strict=True, ge=1, le=100_000)]

Seconds = Annotated[float, Field(ge=0.1, le=1e6, allow_inf_nan=False)]

ProductId = Annotated[
    str, Path(pattern=ID, description="Letters, digits, `_ . -`, a letter first, at most 32")
]

IfMatch = Annotated[
    str | None, Header(alias="If-Match", description="The `ETag` of the revision that is changed")
]

IfNoneMatch = Annotated[
    str | None, Header(alias="If-None-Match", description="`*` for a product that does not exist yet")
]

LISTED = "GET /api/products"


class ProductAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A product that can be ordered."""

    id: str
    name: str
    lot: int
    """Pieces in one container."""
    bill: dict[str, int]
    """Pieces of each material that one piece takes."""
    ability: str
    """What a vehicle must be able to carry."""
    machines: dict[str, float]
    """Seconds for one piece, by machine that can make it."""
    revision: int
    """Grows with every change; orders that are released from now on are made by it."""


class ProductDraft(BaseModel):
    """A product as it is to be."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [{"name": "Gear unit", "lot": 4, "bill": {"shaft": 2}, "machines": {"M1": 36.0}}]
        },
    )

    name: Annotated[Line, Field(max_length=80)]
    lot: Pieces
    """In one container."""
    bill: Annotated[dict[Name, Pieces], Field(min_length=1, max_length=LINES_MAX)]
    """Pieces of each material that one piece takes."""
    ability: Name = "tote"
    """What a vehicle must be able to carry."""
    machines: Annotated[dict[Name, Seconds], Field(max_length=MACHINES_MAX)] = Field(default_factory=dict)
    """Seconds for one piece, by machine that can make it. Those that were set up for it by the plant file may be left out."""


EXAMPLE = ProductAnswer(
    id="P1",
    name="Gear unit",
    lot=4,
    bill={"shaft": 2, "steel": 1},
    ability="tote",
    machines={"M1": 36.0},
    revision=1,
)


@router.get("/products", responses={200: list_of(ProductAnswer, "Products, by id")}, response_class=Json)
async def list_products(
    projection: Provided[Projection],
    catalogue: Provided[Catalogue],
    cursor: Cursor = None,
    limit: Limit = PAGE,
) -> Json:
    """Products that can be ordered."""
    products = sorted(
        (_answer(product, catalogue) for product in projection.site.plant.file.products), key=lambda p: p.id
    )
    return page(products, lambda product: product.id, cursor, limit)


@router.get(
    "/products/{product}",
    responses={
        200: described(ProductAnswer, "The product", EXAMPLE),
        **problems(p404="There is no such product"),
    },
    response_class=Json,
)
async def get_product(
    projection: Provided[Projection], catalogue: Provided[Catalogue], product: ProductId
) -> Json:
    """A product; its `ETag` is its revision."""
    known = projection.site.plant.products.get(product)
    if known is None:
        raise not_found("product", product, LISTED)
    return Json(_answer(known, catalogue), headers={"ETag": _tag(catalogue.revision(product))})


@router.put(
    "/products/{product}",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ProductAnswer, "The product as it is now", EXAMPLE),
        201: described(ProductAnswer, "The new product", EXAMPLE),
        **problems(
            p412="Somebody has changed it since, or it exists already",
            p428="It is not said whether it is new, or which revision is changed",
        ),
    },
    response_class=Json,
)
async def define(
    projection: Provided[Projection],
    catalogue: Provided[Catalogue],
    caller: Caller,
    note: Noted,
    now_s: Now,
    product: ProductId,
    request: ProductDraft,
    if_match: IfMatch = None,
    if_none_match: IfNoneMatch = None,
) -> Json:
    """Define a product: a new one with `If-None-Match: *`, another revision with `If-Match`.

    It can be ordered at once, with no restart of anything. What cannot be made or carried in this plant is refused, with the reason. Goals in
    work keep the revision with which they were given out.
    """
    note.target, note.detail["name"] = product, request.name
    before = catalogue.revision(product) if product in projection.site.products else None
    _check_version(product, before, if_match, if_none_match)
    wanted = Product(
        id=product,
        name=request.name,
        lot=request.lot,
        bill=tuple(BillLine(material, quantity) for material, quantity in request.bill.items()),
        ability=request.ability,
    )
    if faults := catalogue.faults(wanted, request.machines):
        raise unusable(*(FieldError(field, reason) for field, reason in faults))
    if not await catalogue.define(wanted, request.machines, before, caller.name, now_s):
        raise _changed(product)
    note.detail["revision"] = revision = catalogue.revision(product)
    answer = _answer(projection.site.plant.products[product], catalogue)
    status = HTTPStatus.CREATED if before is None else HTTPStatus.OK
    return Json(
        answer, status, headers={"ETag": _tag(revision), "Content-Location": f"/api/products/{product}"}
    )


def _check_version(product: str, before: int | None, if_match: str | None, if_none_match: str | None) -> None:
    """Refuse a change of a revision that the caller has not read.

    Raises:
        Problem: 412 or 428.
    """
    if if_match is None and if_none_match is None:
        raise Problem(
            HTTPStatus.PRECONDITION_REQUIRED,
            "no-version",
            "It is not said what is changed",
            "send If-None-Match: * for a new product, or If-Match with the ETag of the product as you have read it",
        )
    if if_none_match is not None:
        if if_none_match.strip() != "*":
            raise _odd()
        if before is not None:
            raise _exists()
    if if_match is not None:
        known = () if before is None else (_tag(before), "*")
        if if_match.strip().removeprefix("W/") not in known:
            raise _changed(product)


def _exists() -> Problem:
    return Problem(
        HTTPStatus.PRECONDITION_FAILED,
        "exists",
        "The product exists already",
        "read it, and send If-Match with its ETag to change it",
    )


def _odd() -> Problem:
    return Problem(
        HTTPStatus.PRECONDITION_FAILED,
        "odd-precondition",
        "If-None-Match is * or left out here",
        "send If-None-Match: * for a new product, or If-Match with the ETag of the product as you have read it",
    )


def _changed(product: str) -> Problem:
    return Problem(
        HTTPStatus.PRECONDITION_FAILED,
        "changed-since",
        "The product is not as you have read it",
        f"read {product} again, and send If-Match with its ETag",
    )


def _tag(revision: int) -> str:
    return f'"{revision}"'


def _answer(product: Product, catalogue: Catalogue) -> ProductAnswer:
    return ProductAnswer(
        id=product.id,
        name=product.name,
        lot=product.lot,
        bill={line.material: line.quantity for line in product.bill},
        ability=product.ability,
        machines=dict(catalogue.cycles_s(product.id)),
        revision=catalogue.revision(product.id),
    )
