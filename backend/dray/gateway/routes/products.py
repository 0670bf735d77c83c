"""What this plant can make."""

from __future__ import annotations

import msgspec
from fastapi import APIRouter

from dray.gateway.http.provided import Provided
from dray.gateway.http.responses import PAGE, Cursor, Json, Limit, list_of, page
from dray.gateway.live.projection import Projection
from dray.plant.model import Product

router = APIRouter(tags=["plant"])


class ProductAnswer(msgspec.Struct, frozen=True):
    """A product that can be ordered."""

    id: str
    name: str
    lot: int
    """Pieces in one container."""
    bill: dict[str, int]
    """Pieces of each material that one piece takes."""


@router.get("/products", responses={200: list_of(ProductAnswer, "Products, by id")}, response_class=Json)
async def list_products(projection: Provided[Projection], cursor: Cursor = None, limit: Limit = PAGE) -> Json:
    """Products that can be ordered."""
    products = sorted(
        (_answer(product) for product in projection.site.plant.file.products), key=lambda p: p.id
    )
    return page(products, lambda product: product.id, cursor, limit)


def _answer(product: Product) -> ProductAnswer:
    bill = {line.material: line.quantity for line in product.bill}
    return ProductAnswer(product.id, product.name, product.lot, bill)
