"""Orders in a CSV file, for products of three levels, in the plant `levels`: all pieces are accounted for."""

from __future__ import annotations

import asyncio
from collections import Counter
from dataclasses import dataclass
from functools import partial

from dray.errors import UnavailableError
from dray.messages.keys import STRATEGIST
from dray.plant import Plant
from dray.plant.file.file import shipped_plant
from dray_sim.bench.rest_work.house import WRITTEN_WITHIN_S, open_house, until_all
from dray_sim.bench.rest_work.killing import kill_in_turn
from dray_sim.bench.row import Row
from dray_sim.run.stage import Shift, Stage
from dray_sim.scenarios.levels import DEAD_S, KILL_EVERY_S, Account, accounts

ORDERS = 200

SPEED = 20.0
"""Multiple of real time; on a busy computer the floor falls behind, and stays correct."""

END_WITHIN_S = 72_000.0
"""Longest time for an order, after which it is taken for lost (plant clock)."""

LOOK_S = 10.0
"""Interval between two looks whether all has arrived (plant clock)."""


@dataclass(frozen=True, slots=True)
class Result:
    """Observations of the factory's thread."""

    kills: int
    took_s: float
    accounts: tuple[Account, ...]


def file_of(plant: Plant, orders: int) -> tuple[str, Counter[str]]:
    """A file of orders of one piece each, of the products in turn; and its quantities, by product."""
    lines, wanted = ["customer,reference,product,quantity,priority"], Counter[str]()
    for number in range(orders):
        product = plant.ordered[number % len(plant.ordered)]
        priority = "urgent" if number % 20 == 0 else "normal"
        lines.append(f"Hall {1 + number % 3},PO-{number + 1:03},{product},1,{priority}")
        wanted[product] += 1
    return "\r\n".join(lines) + "\r\n", wanted


async def make(stage: Stage, orders: int) -> Result:
    """Run the factory, with kills, until so many orders have arrived."""
    first, since_s = stage.factory.floor.lying(), stage.now_s()
    done = stage.observer.fulfilled_s

    def is_over() -> bool:
        return len(done) >= orders or stage.now_s() > since_s + END_WITHIN_S

    victims = (*stage.factory.workcells, STRATEGIST)
    kills = await kill_in_turn(stage, victims, KILL_EVERY_S, DEAD_S, is_over)
    return Result(kills, max(done.values(), default=since_s) - since_s, accounts(stage, first))


async def order_all(orders: int, traffic: bool | None) -> list[Row]:
    """Order, kill, wait for the end, and account for every piece."""
    plant = shipped_plant("levels")
    csv, wanted = file_of(plant, orders)
    shift = Shift(name="levels", duration_s=0.0)
    async with open_house(plant, shift, partial(make, orders=orders), speed=SPEED, traffic=traffic) as house:
        status, answer = await asyncio.to_thread(
            house.admin.ask, "POST", "/api/orders/import", {"csv": csv}, **{"Idempotency-Key": "work-levels"}
        )
        placed = len(answer["orders"]) if status == 200 else 0
        if placed != orders:
            raise UnavailableError("the import", f"was answered with {status}: {answer}", "see why")
        # The same file under the same key is the same orders.
        await asyncio.to_thread(
            house.admin.ask, "POST", "/api/orders/import", {"csv": csv}, **{"Idempotency-Key": "work-levels"}
        )
        result = await house.result
        await until_all(
            house.admin,
            "/api/orders",
            lambda found: all(each["status"] == "delivered" for each in found),
            WRITTEN_WITHIN_S,
        )
        found = await house.admin.all("/api/orders")
    delivered = [each for each in found if each["status"] == "delivered"]
    arrived = {account.item: account.delivered for account in result.accounts}
    wrong = sum(abs(arrived[product] - wanted[product]) for product in arrived)
    return [
        Row(
            "work: orders of one file, delivered",
            len(delivered),
            "orders",
            orders,
            "what the file asks for",
            target=orders,
            note=f"{len(found)} orders at the gateway, {result.kills} machines and strategists killed, {result.took_s / 3600:.1f} h of the plant's clock",
        ),
        Row(
            "work: pieces that arrived beyond or below what was ordered",
            wrong,
            "pieces",
            wanted.total(),
            "what was ordered",
            target=0,
            less=True,
        ),
        *(_row(account) for account in result.accounts),
    ]


def _row(account: Account) -> Row:
    """The places of all pieces of an item."""
    there = f"used {account.used} + delivered {account.delivered} + there {account.lies}"
    scrapped = f"; {account.scrapped} bad ones, made again" if account.scrapped else ""
    return Row(
        f"work: {account.item} that nobody can explain",
        abs(account.difference),
        "pieces",
        max(1, account.came + account.made),
        "all there were",
        target=0,
        note=f"came {account.came} + made {account.made} = {there}{scrapped}",
        less=True,
    )
