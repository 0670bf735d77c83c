"""What lists of everything there ever was are asked for: words, a part of time, an order. Parameters of several routers."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Query

from dray.gateway.factory.duty import DutyRota
from dray.gateway.http.provided import Provided
from dray.gateway.live.projection import Projection
from dray.store.database.searching import Sought

MOST_WORDS = 8
"""Each is looked for in every row: more would be no search any more."""


async def _sought(
    projection: Provided[Projection],
    q: Annotated[
        str,
        Query(
            max_length=200,
            pattern=r"^[^\x00]*$",
            description="Words, of which each must stand somewhere in it; names of products and materials count, too",
        ),
    ] = "",
) -> tuple[Sought, ...]:
    file = projection.site.plant.file
    names = {each.id: each.name.casefold() for each in file.materials}
    names |= {each.id: each.name.casefold() for each in file.products}
    return tuple(
        Sought(word, tuple(item for item, name in names.items() if word.casefold() in name))
        for word in q.split()[:MOST_WORDS]
    )


async def _now_s(rota: Provided[DutyRota]) -> float:
    return rota.wall_s()


NowS = Annotated[float, Depends(_now_s)]
"""A router's parameter: the wall clock."""

Words = Annotated[tuple[Sought, ...], Depends(_sought)]
"""A router's parameter: the words of `q`."""
