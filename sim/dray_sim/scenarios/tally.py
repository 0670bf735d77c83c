"""Figures by which runs under different conditions are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dray.protocol.runtime.events import NEVER_S
from dray_sim.run.evidence import HELD, Check
from dray_sim.run.stage import Played, Stage

SETTLE_S = 2 * 3600.0
"""Longest time after the demand. The last order takes half an hour on a good network; after four times that it hangs."""

HEAD = (
    "delivered",
    "on time",
    "transport p50",
    "p95",
    "bids",
    "rounds",
    "suspected",
    "carrier changed",
    "starved",
)
"""Column heads of `row`."""


@dataclass(frozen=True, slots=True)
class Tally:
    """Counts of a run.

    Attributes:
        settled_s: how long after the demand the last order was delivered.
        on_time_frac: of all orders; one that was not delivered in the end is late.
    """

    suspicions: int
    carriers_changed: int
    settled_s: float
    on_time_frac: float


async def run_out(stage: Stage) -> Tally:
    """Let the demand come in, and then let the factory finish the open orders."""
    await stage.until_s(stage.shift.duration_s)
    settled_s = await stage.settle(SETTLE_S)
    return tally(stage, settled_s)


def tally(stage: Stage, settled_s: float) -> Tally:
    """The counts of a run at this moment."""
    seen = stage.observer
    on_time = [order for order in stage.orders if seen.fulfilled_s.get(order.id, NEVER_S) <= order.due_s]
    return Tally(
        suspicions=seen.suspicions,
        carriers_changed=seen.carriers_changed,
        settled_s=settled_s,
        on_time_frac=len(on_time) / max(1, len(stage.orders)),
    )


def row(played: Played[Tally]) -> tuple[str, ...]:
    """The figures of a run, one for each of `HEAD`."""
    report, result = played.report, played.result
    return (
        f"{report.orders_delivered} of {report.orders_placed}",
        f"{result.on_time_frac:.1%}" if result else "-",
        f"{report.transport_p50_s:.0f} s",
        f"{report.transport_p95_s:.0f} s",
        f"{report.bids_per_task:.1f}",
        f"{report.rounds_per_task:.2f}",
        f"{result.suspicions}" if result else "-",
        f"{result.carriers_changed}" if result else "-",
        f"{report.starvation_frac:.2%}",
    )


def all_delivered(runs: Sequence[Played[Any]]) -> Check:
    """Whether no run has left an order open."""
    left = [
        played.report.orders_placed - played.report.orders_delivered if played.invariants == HELD else -1
        for played in runs
    ]
    return Check("Every order is delivered in the end", not any(left), f"left open: {listed(left)}")


def listed(values: Sequence[int]) -> str:
    """Counts, one for each run; a run that was cut short has none."""
    return ", ".join("-" if value < 0 else str(value) for value in values)
