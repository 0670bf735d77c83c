"""Search texts: all texts of a row in one column, in small letters."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec


class Sought(msgspec.Struct, frozen=True, gc=False):
    """A searched word."""

    text: str
    named: tuple[str, ...] = ()
    """Ids of products, and materials, whose names contain it."""


def searched(texts: Iterable[str], products: Iterable[str]) -> str:
    """The search text of a new row: all its texts in one column, which a search reads at once."""
    return "\n".join((*texts, f"|{'|'.join(products)}|")).casefold()
