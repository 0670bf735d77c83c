"""One server of the benchmark.

python -m dray_sim.bench.orders bare|ours URL PORT
"""

from __future__ import annotations

import asyncio
import sys

from dray.store import open_store
from dray_sim.bench.orders.bare import create_bare_app
from dray_sim.bench.orders.ours import answer, our_app


async def _serve(kind: str, url: str, port: int) -> None:
    if kind == "bare":
        await answer(create_bare_app(url), port)
        return
    store = await open_store(url)
    try:
        await answer(our_app(url, store), port)
    finally:
        await store.close()


if __name__ == "__main__":
    asyncio.run(_serve(sys.argv[1], sys.argv[2], int(sys.argv[3])))
