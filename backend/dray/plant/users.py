"""The users of items: by item, the products in whose bills it stands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dray.plant.model import Product

_NOTHING: frozenset[str] = frozenset()


class Users:
    """The users of all items of a plant.

    There may be thousands of products. So these are found from the users of a plant before it: only products that differ are
    looked at.

    Args:
        products: all products, by id.
        before: the users of another plant.

    Attributes:
        products: all products, by id.
        by_item: item -> its users, of all items that stand or stood in a bill.
    """

    def __init__(self, products: Mapping[str, Product], before: Users | None = None) -> None:
        known: Mapping[str, Product] = {} if before is None else before.products
        old: Mapping[str, frozenset[str]] = {} if before is None else before.by_item
        self.products: Mapping[str, Product] = products
        gone = [product for id_, product in known.items() if products.get(id_) is not product]
        new = [product for id_, product in products.items() if known.get(id_) is not product]
        changed = {item: set(old.get(item, _NOTHING)) for item in {*_items(gone), *_items(new)}}
        for product in gone:
            for item in _items([product]):
                changed[item].discard(product.id)
        for product in new:
            for item in _items([product]):
                changed[item].add(product.id)
        self.by_item: Mapping[str, frozenset[str]] = {
            **old,
            **{item: frozenset(users) for item, users in changed.items()},
        }

    def of(self, item: str) -> frozenset[str]:
        """The products in whose bills an item stands; none for an unknown item."""
        return self.by_item.get(item, _NOTHING)


def _items(products: Iterable[Product]) -> Iterable[str]:
    return (line.material for product in products for line in product.bill)
