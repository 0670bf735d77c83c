"""What needs a product, so that it cannot be removed. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from collections.abc import Set as AbstractSet
from typing import Literal

import msgspec

from dray.plant import PlantFile
from dray.store.orders.products import Needing

NAMED_MAX = 5
"""Maximum names, of each kind, of what needs a product."""

NeedKind = Literal["order", "schedule", "transport", "machine", "product"]


class Need(msgspec.Struct, frozen=True):
    """What needs a product, of one kind."""

    kind: NeedKind
    first: tuple[str, ...]
    """The first ones, at most `NAMED_MAX`."""
    count: int


class Kept(msgspec.Struct, frozen=True):
    """Why a product is not removed."""

    why: Literal["unknown", "in_plant_file", "changed", "needed"]
    needs: tuple[Need, ...] = ()


def needing(names: Iterable[str]) -> Needing:
    """The first of these names, and their number."""
    found = sorted(set(names))
    return Needing(tuple(found[:NAMED_MAX]), len(found))


def schedules_needing(contents: Iterable[tuple[str, str, str]], ids: AbstractSet[str]) -> dict[str, Needing]:
    """Recurring work that orders or fetches these; paused work goes on some day."""
    found: dict[str, list[str]] = {}
    for name, transport, order in contents:
        for item in ids & _items_of(transport, order):
            found.setdefault(item, []).append(name)
    return {item: needing(names) for item, names in found.items()}


def _items_of(transport: str, order: str) -> set[str]:
    if order:
        return {item["product"] for item in msgspec.json.decode(order)["items"]}
    return {msgspec.json.decode(transport).get("item", "")}


def users_of(file: PlantFile, ids: AbstractSet[str], needed: Collection[str]) -> dict[str, Needing]:
    """Products of which these are parts and that stay, by part.

    Args:
        file: of the plant.
        ids: the products to remove.
        needed: those of them that stay for other reasons.
    """
    bills = {each.id: ids & {line.material for line in each.bill} for each in file.products}
    users: dict[str, list[str]] = {}
    ahead = [product for product in bills if product not in ids or product in needed]
    stay = set(ahead)
    while ahead:
        product = ahead.pop()
        for part in bills[product]:
            users.setdefault(part, []).append(product)
            if part not in stay:
                stay.add(part)
                ahead.append(part)
    return {part: needing(names) for part, names in users.items()}
