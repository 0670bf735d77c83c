"""Query parameters of several routers that list the past: words, a period, an order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated

from fastapi import Depends, Query

from dray.gateway.factory.duty import DutyRota
from dray.gateway.http.provided import Provided
from dray.gateway.live.projection import Projection
from dray.store.database.searching import Sought

MOST_WORDS = 8
"""Maximum words: each is searched in every row."""

MOST_NAMED = 200
"""Maximum products and materials whose names match the words of one query, in total: each is searched in
every row too, and SQLite limits their number per query.
"""


async def _sought(
    projection: Provided[Projection],
    q: Annotated[
        str,
        Query(
            max_length=200,
            pattern=r"^[^\x00]*$",
            description="Words, of which each must stand somewhere in it; names of products and materials count, too, "
            f"for words that stand in few of them ({MOST_NAMED} for all words)",
        ),
    ] = "",
) -> tuple[Sought, ...]:
    file = projection.site.plant.file
    names = {id_: name.casefold() for id_, name in projection.site.former.items()}
    names |= {each.id: each.name.casefold() for each in file.materials}
    names |= {each.id: each.name.casefold() for each in file.products}
    return tuple(sought(q, names))


def sought(q: str, names: Mapping[str, str]) -> Iterator[Sought]:
    """The words of a query, each once.

    Args:
        q: the query.
        names: names of products and materials by id, in small letters.
    """
    left = MOST_NAMED
    for word in list({word.casefold(): word for word in q.split()}.values())[:MOST_WORDS]:
        named = tuple(item for item, name in names.items() if word.casefold() in name)
        if len(named) > left:
            # The word matches too many names to be useful.
            named = ()
        left -= len(named)
        yield Sought(word, named)


async def _now_s(rota: Provided[DutyRota]) -> float:
    return rota.wall_s()


NowS = Annotated[float, Depends(_now_s)]
"""A router's parameter: the wall clock."""

Words = Annotated[tuple[Sought, ...], Depends(_sought)]
"""A router's parameter: the words of `q`."""
