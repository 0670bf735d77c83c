"""Removal of products that people have defined."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated, Literal

import msgspec
from fastapi import APIRouter, Depends, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.access.audit_log import Noted
from dray.gateway.access.caller import Caller
from dray.gateway.access.principal import Scope
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.problems import FieldError, Problem, not_found
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.request_bodies import json_only
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, described, list_of, listing, part, problems
from dray.gateway.http.versions import changed_since, check_version
from dray.gateway.live.projection import Projection
from dray.gateway.products.drafts import Name
from dray.gateway.products.needs import Kept
from dray.gateway.routes.products.products import LISTED, IfMatch, ProductId
from dray.store import Store
from dray.store.orders.products import AuthoredProduct

router = APIRouter(tags=["plant"])

REMOVED_AT_ONCE = 500
"""Maximum products of one request: their ids fit into a body, and their names into a line of the audit log."""


class ProductsToRemove(BaseModel):
    """Products to remove."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"products": ["P8", "P9"]}]})

    products: Annotated[list[Name], Field(min_length=1, max_length=REMOVED_AT_ONCE)]
    """Their ids."""


class RemovedProduct(msgspec.Struct, frozen=True, kw_only=True):
    """What became of a product."""

    id: str
    result: Literal["removed", "unknown", "in_plant_file", "changed", "needed"]
    """`unknown`: there is none that people have defined, perhaps since it was removed already."""
    reasons: tuple[FieldError, ...] = ()
    """What needs it, by kind."""


class RemovedProducts(msgspec.Struct, frozen=True):
    """What became of products, in the order of the request."""

    products: tuple[RemovedProduct, ...]


class DefinitionAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """A product that people have defined or removed."""

    id: str
    name: str
    revision: int
    by: str
    """Who has defined it last, or removed it."""
    at_s: float
    """When, in seconds since 1970."""
    state: Literal["made", "unfit", "removed"]
    """`made`: it can be ordered. `unfit`: the plant file does not fit it any more; it counts, and can be removed or
    defined anew. `removed`: it is known by its name only."""


REMOVED = RemovedProducts(
    (
        RemovedProduct(id="P8", result="removed"),
        RemovedProduct(
            id="P9",
            result="needed",
            reasons=(FieldError.of("product", "needed_by_order", count=1, names="O-1M9K3WZ7P-2TQA"),),
        ),
    )
)

DEFINITION = DefinitionAnswer(
    id="P8", name="Bracket", revision=1, by="maria", at_s=1_900_000_000.0, state="made"
)


@router.delete(
    "/products/{product}",
    status_code=HTTPStatus.NO_CONTENT,
    responses={
        **problems(
            p404="There is no such product",
            p409="Something needs it, or it stands in the plant file",
            p412="Somebody has changed it since",
        )
    },
)
async def remove(
    catalogue: Provided[Catalogue],
    caller: Caller,
    note: Noted,
    now_s: Now,
    product: ProductId,
    if_match: IfMatch = None,
) -> Response:
    """Remove a product that people have defined and that nothing needs.

    Orders that have ended, reports and figures keep its name. It can be defined anew later. With `If-Match` only
    the revision with this `ETag` is removed, otherwise any.
    """
    note.target = product
    revision = None
    if if_match is not None:
        revision = catalogue.revision(product)
        check_version(revision, if_match, changed_since("product", product))
    if kept := (await catalogue.remove([product], caller.name, now_s, revision=revision)).get(product):
        raise _not_removed(product, kept, named=caller.may(Scope.ORDERS_READ))
    return Response(status_code=HTTPStatus.NO_CONTENT)


@router.post(
    "/products/remove",
    dependencies=[Depends(json_only)],
    responses={200: described(RemovedProducts, "What became of each product", REMOVED)},
    response_class=Json,
)
async def remove_several(
    catalogue: Provided[Catalogue], caller: Caller, note: Noted, now_s: Now, request: ProductsToRemove
) -> Json:
    """Remove several products: each that people have defined and that nothing else needs.

    Parts that only others of them need are removed with these. Whatever cannot be removed stays, with the reason.
    """
    ids = list(dict.fromkeys(request.products))
    kept = await catalogue.remove(ids, caller.name, now_s)
    note.detail |= {"products": len(ids), "removed": [id_ for id_ in ids if id_ not in kept]}
    named = caller.may(Scope.ORDERS_READ)
    return Json(RemovedProducts(tuple(_removal(id_, kept.get(id_), named=named) for id_ in ids)))


@router.get(
    "/product-definitions",
    responses={200: list_of(DefinitionAnswer, "Products that people have defined, by id")},
    response_class=Json,
)
async def list_definitions(
    store: Provided[Store],
    projection: Provided[Projection],
    removed: Annotated[bool, Query(description="The last removed ones instead")] = False,
    cursor: Cursor = None,
    limit: Limit = PAGE,
) -> Json:
    """Products that people have defined, also those that do not fit this plant any more, or removed ones."""
    async with store.read() as work:
        rows = await (work.products.removed_by_people() if removed else work.products.authored())
    some, following = part(rows, _authored_id, cursor, limit)
    made = projection.site.products
    return listing([_definition(row, made=row.id in made) for row in some], following)


def _authored_id(row: AuthoredProduct) -> str:
    return row.id


def _definition(row: AuthoredProduct, *, made: bool) -> DefinitionAnswer:
    return DefinitionAnswer(
        id=row.id,
        name=row.name,
        revision=row.revision,
        by=row.by,
        at_s=row.at_s,
        state="removed" if not row.defined else "made" if made else "unfit",
    )


def _removal(product: str, kept: Kept | None, *, named: bool) -> RemovedProduct:
    if kept is None:
        return RemovedProduct(id=product, result="removed")
    return RemovedProduct(id=product, result=kept.why, reasons=_reasons(kept, named=named))


def _reasons(kept: Kept, *, named: bool) -> tuple[FieldError, ...]:
    """What needs a product, by kind; its names are only for callers who may see orders."""
    return tuple(
        FieldError.of(
            "product",
            f"needed_by_{need.kind}",
            count=need.count,
            names=", ".join(need.first) + ", …" * (need.count > len(need.first)) if named else "…",
        )
        for need in kept.needs
    )


def _not_removed(product: str, kept: Kept, *, named: bool) -> Problem:
    match kept.why:
        case "unknown":
            return not_found("product", product, LISTED)
        case "changed":
            return changed_since("product", product)
        case "in_plant_file":
            return Problem(
                HTTPStatus.CONFLICT,
                "product-in-plant-file",
                "The product stands in the plant file",
                f"remove {product} from the plant file, and start with that; "
                f"until then PUT /api/products/{product} changes it",
            )
        case "needed":
            reasons = _reasons(kept, named=named)
            return Problem(
                HTTPStatus.CONFLICT,
                "product-needed",
                "Something needs the product",
                "; ".join(each.reason for each in reasons),
                errors=reasons,
            )
