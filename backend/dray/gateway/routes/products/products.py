"""Products of this plant: master data that people define at run time."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

import msgspec
from fastapi import APIRouter, Depends, Header, Path

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.problems import Problem, not_found, unusable
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, listing, part, problems
from dray.gateway.http.side_work import SideWork
from dray.gateway.http.versions import changed_since, check_version, no_version, version_tag
from dray.gateway.live.projection import Projection
from dray.gateway.products.drafts import ID, ProductDraft, wanted
from dray.gateway.products.judging import judge
from dray.messages import Document
from dray.plant import Product

router = APIRouter(tags=["plant"])

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

ADVICE = (
    "send If-None-Match: * for a new product, or If-Match with the ETag of the product as you have read it"
)


class ProductAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A product that can be ordered."""

    id: str
    name: str
    lot: int
    """Pieces in one container."""
    bill: dict[str, int]
    """Pieces of each material per piece."""
    ability: str
    """Ability that a vehicle needs to carry it."""
    machines: dict[str, float]
    """Seconds per piece, by capable machine."""
    documents: tuple[Document, ...]
    """Documents for its makers: machines verify their checksums before they begin."""
    revision: int
    """Grows with every change; orders released from now on use it."""


EXAMPLE = ProductAnswer(
    id="P1",
    name="Gear unit",
    lot=4,
    bill={"shaft": 2, "steel": 1},
    ability="tote",
    machines={"M1": 36.0},
    documents=(
        Document("Work instruction", "https://plm.example/p1.pdf", "application/pdf", "9f86d081884c7d65" * 4),
    ),
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
    products = sorted(projection.site.plant.file.products, key=_id)
    some, following = part(products, _id, cursor, limit)
    return listing([_answer(product, catalogue) for product in some], following)


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
    return Json(_answer(known, catalogue), headers={"ETag": version_tag(catalogue.revision(product))})


@router.put(
    "/products/{product}",
    dependencies=[Depends(json_only)],
    responses={
        200: described(ProductAnswer, "The product as it is now", EXAMPLE),
        201: described(ProductAnswer, "The new product", EXAMPLE),
        **problems(
            p409="As many products as may be are defined",
            p412="Somebody has changed it since, or it exists already",
            p428="It is not said whether it is new, or which revision is changed",
            p429="Too much of this caller is being judged, or it has defined as many as one caller may",
            p503="Too much is being judged",
        ),
    },
    response_class=Json,
)
async def define(
    projection: Provided[Projection],
    catalogue: Provided[Catalogue],
    side_work: Provided[SideWork],
    caller: Caller,
    note: Noted,
    now_s: Now,
    product: ProductId,
    request: ProductDraft,
    if_match: IfMatch = None,
    if_none_match: IfNoneMatch = None,
) -> Json:
    """Define a product: a new one with `If-None-Match: *`, another revision with `If-Match`.

    It can be ordered at once, without a restart. A product that cannot be made or carried in this plant is
    refused with the reason. Goals in work keep their revision.
    """
    note.target, note.detail["name"] = product, request.name
    before = catalogue.revision(product) if product in projection.site.products else None
    _check_version(product, before, if_match, if_none_match)
    wish = wanted(product, request, before)
    judged = projection.site.plant
    [faults] = await side_work.do(caller.key, judge, [wish], catalogue.known())
    if faults:
        raise unusable(*faults)
    if await catalogue.define([wish], caller.name, now_s, judged):
        raise changed_since("product", product)
    note.detail["revision"] = revision = catalogue.revision(product)
    answer = _answer(projection.site.plant.products[product], catalogue)
    status = HTTPStatus.CREATED if before is None else HTTPStatus.OK
    return Json(
        answer,
        status,
        headers={"ETag": version_tag(revision), "Content-Location": f"/api/products/{product}"},
    )


def _check_version(product: str, before: int | None, if_match: str | None, if_none_match: str | None) -> None:
    """Refuse a change of a revision that the caller has not read.

    Raises:
        Problem: 412 or 428.
    """
    if if_match is None and if_none_match is None:
        raise no_version(ADVICE)
    if if_none_match is not None:
        if if_none_match.strip() != "*":
            raise _odd()
        if before is not None:
            raise _exists()
    if if_match is not None:
        check_version(before, if_match, changed_since("product", product))


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
        ADVICE,
    )


def _id(product: Product) -> str:
    return product.id


def _answer(product: Product, catalogue: Catalogue) -> ProductAnswer:
    return ProductAnswer(
        id=product.id,
        name=product.name,
        lot=product.lot,
        bill={line.material: line.quantity for line in product.bill},
        ability=product.ability,
        machines=dict(catalogue.cycles_s(product.id)),
        documents=catalogue.documents(product.id),
        revision=catalogue.revision(product.id),
    )
