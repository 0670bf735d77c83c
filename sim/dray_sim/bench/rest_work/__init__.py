"""Benchmark `work`: requests over REST are carried out exactly once, though agents are killed meanwhile.

There are two factories, one after the other. Each has its gateway, its database and a simulated floor in this
process, as `dray up` has them:

    levels    200 orders in a file of CSV, for products whose parts other machines make; machines and the strategist are killed. What has
              become of every piece is told item by item.
    calls     500 plain transports, called by a program, by tablets and by a call button, and 20 recurring ones, beside orders for half of
              the machines' time; vehicles, machines, stations and the strategist are killed. Every 201 is one load that was put down once.

All invariants are watched. Times of the floor are the plant's, and so the same on any computer that keeps up.
"""

from __future__ import annotations

import asyncio

from dray_sim.bench.rest_work.calls import CALLS, RECURRING, call_all
from dray_sim.bench.rest_work.levels import ORDERS, order_all
from dray_sim.bench.row import Row

QUICK = 10
"""A quick run asks for a tenth."""


def measure(quick: bool, traffic: bool | None = None) -> list[Row]:
    """Ask, kill, and count.

    Args:
        quick: a tenth of the work.
        traffic: whether vehicles drive with right of way; None: as `dray up` does.

    Raises:
        UnavailableError: a gateway does not start, or an invariant was broken.
    """
    share = QUICK if quick else 1
    rows = asyncio.run(order_all(ORDERS // share, traffic))
    return rows + asyncio.run(call_all(CALLS // share, RECURRING // share, traffic))
