"""The gateway and its retention task over the whole history, in a process of its own, as `dray up` runs both.

python -m dray_sim.bench.history URL PORT BEFORE_S

A line on its input lets it forget the events before that moment; it writes a line of JSON when it is done.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time

from dray.store import Store, open_store
from dray.store.retention import Retention
from dray_sim.bench.history.data import NOW_S
from dray_sim.bench.history.forgetting import TimedStore, kept_after
from dray_sim.bench.orders.ours import answer, our_app


async def _serve(url: str, port: int, before_s: float) -> None:
    store = await open_store(url)
    begun_s = time.time()
    forgetting = asyncio.create_task(_forget(store, before_s))
    try:
        await answer(our_app(url, store, lambda: NOW_S + time.time() - begun_s), port)
    finally:
        forgetting.cancel()
        await store.close()


async def _forget(store: Store, before_s: float) -> None:
    # A separate thread waits for the line, and dies with the process.
    await asyncio.to_thread(sys.stdin.readline)
    timed = TimedStore(store)
    begun_s = time.perf_counter()
    await Retention(timed, kept_after(before_s), lambda: NOW_S).forget()
    took_s = time.perf_counter() - begun_s
    sys.stdout.write(json.dumps({"took_s": took_s, "transactions_ms": timed.took_ms}) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    asyncio.run(_serve(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
