"""What lists of everything there ever was are asked for: words, a part of time, an order. Parameters of several routers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated

from fastapi import Depends, Query

from dray.gateway.factory.duty import DutyRota
from dray.gateway.http.provided import Provided
from dray.gateway.live.projection import Projection
from dray.store.database.searching import Sought

MOST_WORDS = 8
"""Each is looked for in every row: more would be no search any more."""

MOST_NAMED = 200
"""Products and materials in whose names the words of one question stand, all together: each is looked for in every row, too, and SQLite takes no
thousand of them in one question.
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
    names = {each.id: each.name.casefold() for each in file.materials}
    names |= {each.id: each.name.casefold() for each in file.products}
    return tuple(sought(q, names))


def sought(q: str, names: Mapping[str, str]) -> Iterator[Sought]:
    """The words of a question, each once.

    Args:
        q: the question.
        names: of products and materials by their ids, in small letters.
    """
    left = MOST_NAMED
    for word in list({word.casefold(): word for word in q.split()}.values())[:MOST_WORDS]:
        named = tuple(item for item, name in names.items() if word.casefold() in name)
        if len(named) > left:
            # It tells too little of which are meant.
            named = ()
        left -= len(named)
        yield Sought(word, named)


async def _now_s(rota: Provided[DutyRota]) -> float:
    return rota.wall_s()


NowS = Annotated[float, Depends(_now_s)]
"""A router's parameter: the wall clock."""

Words = Annotated[tuple[Sought, ...], Depends(_sought)]
"""A router's parameter: the words of `q`."""
