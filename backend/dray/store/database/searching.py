"""What words are looked for in: all texts of a row in one column, in small letters."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec


class Sought(msgspec.Struct, frozen=True, gc=False):
    """A word that somebody looks for."""

    text: str
    named: tuple[str, ...] = ()
    """Ids of products, and materials, whose names hold it."""


def searched(texts: Iterable[str], products: Iterable[str]) -> str:
    """What words are looked for in, of a row that is new: all of it in one column, which is read at once."""
    return "\n".join((*texts, f"|{'|'.join(products)}|")).casefold()
