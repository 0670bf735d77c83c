"""One seeded run and its report."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from random import Random

from dray.plant import Plant
from dray_sim import demand
from dray_sim.desk import Desk
from dray_sim.factory import Ears, SimFactory
from dray_sim.invariants import Invariants
from dray_sim.loop import JUMP, clock, run
from dray_sim.observer import Observer
from dray_sim.report import Report, make_report
from dray_sim.trace import Trace

HELD = "held"
"""What a report says of its invariants when nothing broke them."""


@dataclass(frozen=True, slots=True)
class Shift:
    """What is to be run.

    Attributes:
        name: of the scenario.
        duration_s: virtual time.
        load: part of the machines' time that the demand takes.
        codec: pass every message through the wire format.
    """

    name: str
    duration_s: float
    load: float
    codec: bool = False


def run_shift(shift: Shift, plant: Plant, seed: int) -> Report:
    """Run a shift in virtual time, all invariants watched.

    Args:
        shift: how long, and how busy.
        plant: the factory.
        seed: everything else follows from it.

    Returns:
        The report; a broken invariant ends the run and is named in it.
    """
    return run(_play(shift, plant, seed), JUMP)


async def _play(shift: Shift, plant: Plant, seed: int) -> Report:
    orders = list(demand.orders(plant, Random(f"{seed} demand"), load=shift.load, until_s=shift.duration_s))
    observer, trace, ears = Observer(), Trace(), Ears()
    factory = SimFactory(plant, clock(), seed=seed, codec=shift.codec, ear=ears)
    checks = Invariants(factory)
    ears.add(trace, observer, checks)
    life = asyncio.create_task(_live(factory, orders))
    broken = asyncio.create_task(checks.wait_broken())
    await asyncio.wait({life, broken}, timeout=shift.duration_s, return_when=asyncio.FIRST_COMPLETED)
    checks.check_end(factory.clock.now_s())
    report = make_report(
        shift.name,
        seed=seed,
        demand=orders,
        factory=factory,
        observer=observer,
        invariants=_verdict(checks, life),
        trace=trace.hexdigest(),
    )
    for task in (life, broken):
        task.cancel()
    await asyncio.gather(life, broken, return_exceptions=True)
    return report


async def _live(factory: SimFactory, orders: list[demand.Order]) -> None:
    async with asyncio.TaskGroup() as group:
        group.create_task(factory.run())
        group.create_task(Desk(factory.bus, factory.clock).place(orders))


def _verdict(checks: Invariants, life: asyncio.Task[None]) -> str:
    if checks.broken is not None:
        return str(checks.broken)
    if life.done() and (error := life.exception()) is not None:
        return f"invariant 8 is broken: an agent ended by {_innermost(error)!r}"
    return HELD


def _innermost(error: BaseException) -> BaseException:
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    return error
