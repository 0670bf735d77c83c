"""Bills of three levels: parts made on one machine are material of others, and every piece is accounted for."""

from __future__ import annotations

import asyncio
from collections import Counter
from dataclasses import dataclass

from dray.messages.keys import STRATEGIST
from dray.plant.file.file import shipped_plant
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play

ORDERS = 30

EVERY_S = 270.0
"""Interval between two orders of one container, of the two products in turn: with kills they took 250 s each when
they came faster."""

DUE_IN_S = 7200.0

KILL_EVERY_S = 600.0
"""Interval between two kills: each machine in turn, then the strategist."""

DEAD_S = 45.0
"""Absence of a killed agent, longer than a goal waits for its machine: others make the rest of it."""

END_WITHIN_S = 28_800.0


@dataclass(frozen=True, slots=True)
class Account:
    """The balance of all pieces of one item."""

    item: str
    came: int
    """Pieces at the beginning, and from the source."""
    made: int
    scrapped: int
    used: int
    delivered: int
    lies: int
    """Pieces in storages, buffers and goods, on board, set aside, and in people's hands."""

    @property
    def difference(self) -> int:
        """Unexplained pieces."""
        return self.came + self.made - self.used - self.delivered - self.lies

    def row(self) -> tuple[str, ...]:
        """A row of the table."""
        counts = (self.came, self.made, self.used, self.delivered, self.lies, self.difference, self.scrapped)
        return (self.item, *map(str, counts))


@dataclass(frozen=True, slots=True)
class Result:
    """Observations of the script."""

    took_s: float
    kills: int
    accounts: tuple[Account, ...]
    due: dict[str, int]
    """Ordered pieces, by product."""


def accounts(stage: Stage, first: Counter[str]) -> tuple[Account, ...]:
    """One account for each material, part and product."""
    floor, lies = stage.factory.floor, stage.factory.floor.lying()
    sums: dict[str, Counter[str]] = {"made": Counter(), "scrapped": Counter(), "consumed": Counter()}
    for workcell in floor.workcells.values():
        for name, counter in sums.items():
            counter.update(getattr(workcell, name))
    delivered: Counter[str] = Counter()
    for warehouse in floor.delivery.values():
        delivered.update(warehouse.arrived)
    return tuple(
        Account(
            item=item,
            came=first[item] + (floor.source.supplied(item) if item in stage.plant.materials else 0),
            made=sums["made"][item],
            scrapped=sums["scrapped"][item],
            used=sums["consumed"][item],
            delivered=delivered[item],
            lies=lies[item],
        )
        for item in {**stage.plant.materials, **stage.plant.products}
    )


async def produce(stage: Stage, orders: int) -> Result:
    """Order, kill, and wait for the end."""
    first, products = stage.factory.floor.lying(), stage.plant.ordered
    killing = asyncio.create_task(_kill(stage, orders * EVERY_S))
    due: Counter[str] = Counter()
    for number in range(orders):
        product = products[number % len(products)]
        lot = stage.plant.products[product].lot
        due[product] += lot
        stage.order(product, lot, DUE_IN_S)
        await asyncio.sleep(EVERY_S)
    kills = await killing
    took_s = await stage.settle(END_WITHIN_S)
    return Result(took_s, kills, accounts(stage, first), dict(due))


async def _kill(stage: Stage, until_s: float) -> int:
    """Kill one agent after another; each is started again later. Returns how many were killed."""
    victims, kills = (*stage.factory.workcells, STRATEGIST), 0
    while stage.now_s() + KILL_EVERY_S < until_s:
        await asyncio.sleep(KILL_EVERY_S - DEAD_S)
        victim = victims[kills % len(victims)]
        stage.factory.crash(victim)
        await asyncio.sleep(DEAD_S)
        stage.factory.restart(victim)
        kills += 1
    return kills


def levels(seed: int, orders: int = ORDERS) -> Findings:
    """Play it."""
    shift = Shift(name="levels", duration_s=orders * EVERY_S)
    played = play(shift, shipped_plant("levels"), seed, lambda stage: produce(stage, orders))
    if played.result is None:
        return Findings(runs=(played,), checks=())
    result, report = played.result, played.report
    explained = all(account.difference == 0 for account in result.accounts)
    exact = all(account.delivered == result.due.get(account.item, 0) for account in result.accounts)
    return Findings(
        runs=(played,),
        checks=(
            Check(
                "Every order is delivered",
                report.orders_delivered == report.orders_placed == orders,
                f"{report.orders_delivered} of {report.orders_placed}, with {result.kills} agents killed",
            ),
            Check("What was ordered arrives, and no piece more", exact, "of each product" if exact else "no"),
            Check(
                "The balance of materials, parts and products closes to the piece",
                explained,
                f"{len(result.accounts)} items",
            ),
        ),
        tables=(
            Table(
                "Where all pieces are: came + made = used + delivered + there",
                ("item", "came", "made", "used", "delivered", "there", "difference", "bad, made again"),
                tuple(account.row() for account in result.accounts),
            ),
        ),
    )


LEVELS = Scenario(
    name="levels",
    shows="Parts of three levels with scrap and kills: the balance closes to the piece.",
    source="ours; the paper has machines with bills of material, 4.1",
    claim=(
        "Orders for products whose parts other machines make are delivered exactly once, and every piece on every level is accounted for, though "
        "machines and the strategist are killed and pieces are bad."
    ),
    story=(
        f"{ORDERS} orders, one every {EVERY_S:.0f} s, in the plant `levels`. Every {KILL_EVERY_S / 60:.0f} minutes a machine, or the strategist, is "
        f"killed for {DEAD_S:.0f} s. `dray bench work` does the same with 200 orders of a file over REST."
    ),
    play=levels,
)
