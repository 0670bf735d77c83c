"""Two strategists or more, one of which is killed every few minutes: no order is lost, made twice, or waits for long."""

from __future__ import annotations

import asyncio
from collections import Counter
from dataclasses import dataclass

from dray.messages import Event, Message
from dray.messages.fact import GoalContracted, GoalLost, OrderTakenOver
from dray.plant.file.file import shipped_plant
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S
from dray.protocol.strategist.goal_auctions import GOAL_RULES
from dray.protocol.strategist.order_holding import TURN_S
from dray.protocol.strategist.peers import PEER_SILENCE_S
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import STRATEGIST_COUNT, Played, Shift, Stage, play

HOURS = 8.0

KILL_EVERY_S = 300.0

DEAD_S = 60.0
"""Absence of a killed strategist, four times as long as the other one waits."""

ORDER_EVERY_S = 110.0
"""Interval that does not divide KILL_EVERY_S: orders come before, during and after a strategist's absence."""

DUE_IN_S = 7200.0

END_WITHIN_S = 14_400.0

BEGUN_WITHIN_S = PEER_SILENCE_S + WORKING_INTERVAL_S + TURN_S + 2 * GOAL_RULES.window_s
"""Longest time from an order until a machine has its first goal: the silence, the look for it, a turn, and an auction
with its answers."""

ALONE_HOURS = 2.0
"""Hours for which one strategist alone is watched, for comparison."""


class Begun:
    """Beginning of each order, and takeovers: a `Listener`."""

    def __init__(self) -> None:
        self.begun_s: dict[str, float] = {}
        self.taken_over: Counter[str] = Counter()
        """Number of takeovers, by order."""
        self.lost = 0
        """Goals that were given to others."""

    def on_message(self, at_s: float, _sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if type(message) is not Event:
            return
        fact = message.fact
        if type(fact) is GoalContracted:
            self.begun_s.setdefault(fact.order, at_s)
        elif type(fact) is OrderTakenOver:
            self.taken_over[fact.order] += 1
        elif type(fact) is GoalLost:
            self.lost += 1


@dataclass(frozen=True, slots=True)
class Result:
    """Observations of the script."""

    kills: int
    away: tuple[float, ...]
    """Wait for the beginning of each order that came while a strategist was away (s)."""
    there: tuple[float, ...]
    """The same of the others."""
    taken_over: int
    """Orders that were taken over, each as often as that was."""
    lost: int
    is_exact: bool
    """Whether the arrived pieces of each product equal the ordered ones."""


async def order_and_kill(stage: Stage, hours: float) -> Result:
    """Order, kill one strategist after the other, and wait for the end."""
    begun, ordered = Begun(), Counter[str]()
    stage.listeners.add(begun)
    away_s: list[tuple[float, float]] = []
    killing = asyncio.create_task(_kill(stage, hours * 3600.0, away_s))
    products = stage.plant.ordered
    for number in range(int(hours * 3600.0 / ORDER_EVERY_S)):
        product = products[number % len(products)]
        lot = stage.plant.products[product].lot
        ordered[product] += lot
        stage.order(product, lot, DUE_IN_S)
        await asyncio.sleep(ORDER_EVERY_S)
    await killing
    await stage.settle(END_WITHIN_S)
    arrived: Counter[str] = Counter()
    for warehouse in stage.factory.delivery.values():
        arrived.update(warehouse.arrived)
    waits: dict[bool, list[float]] = {True: [], False: []}
    for order in stage.orders:
        was_away = any(since_s <= order.at_s < until_s for since_s, until_s in away_s)
        waits[was_away].append(begun.begun_s.get(order.id, float("inf")) - order.at_s)
    return Result(
        kills=len(away_s),
        away=tuple(sorted(waits[True])),
        there=tuple(sorted(waits[False])),
        taken_over=begun.taken_over.total(),
        lost=begun.lost,
        is_exact=arrived == ordered,
    )


async def _kill(stage: Stage, until_s: float, away_s: list[tuple[float, float]]) -> None:
    """Kill one strategist after another; each is started again later."""
    victims = stage.factory.strategists
    while stage.now_s() + KILL_EVERY_S <= until_s:
        await asyncio.sleep(KILL_EVERY_S - DEAD_S)
        victim, since_s = victims[len(away_s) % len(victims)], stage.now_s()
        away_s.append((since_s, since_s + DEAD_S))
        stage.factory.crash(victim)
        await asyncio.sleep(DEAD_S)
        stage.factory.restart(victim)


def _played(seed: int, hours: float, strategists: int) -> Played[Result]:
    shift = Shift(name="strategists", duration_s=hours * 3600.0, strategists=strategists)
    return play(shift, shipped_plant("default"), seed, lambda stage: order_and_kill(stage, hours))


def _row(name: str, result: Result) -> tuple[str, ...]:
    return (
        name,
        str(result.kills),
        str(len(result.away)),
        f"{result.away[len(result.away) // 2]:.1f} s",
        f"{result.away[-1]:.1f} s",
        f"{result.there[-1]:.1f} s",
        str(result.taken_over),
        str(result.lost),
    )


def strategists(seed: int, hours: float = HOURS, alone_hours: float = ALONE_HOURS) -> Findings:
    """Play it, and one strategist alone beside it."""
    count = max(2, STRATEGIST_COUNT.get())
    alone, two = _played(seed, alone_hours, 1), _played(seed, hours, count)
    if alone.result is None or two.result is None:
        return Findings(runs=(alone, two), checks=())
    result, report = two.result, two.report
    longest_s = max(*result.away, *result.there)
    return Findings(
        runs=(alone, two),
        checks=(
            Check(
                "No order is lost",
                report.orders_delivered == report.orders_placed > 0,
                f"{report.orders_delivered} of {report.orders_placed}, with {result.kills} strategists killed",
            ),
            Check(
                "None is made twice: of each product arrives what was ordered, and no piece more",
                result.is_exact,
                "of each product" if result.is_exact else "no",
            ),
            Check(
                f"Every order is begun within {BEGUN_WITHIN_S:.0f} s, whoever is killed",
                longest_s <= BEGUN_WITHIN_S,
                f"{longest_s:.1f} s at most",
            ),
            Check(
                "Orders are taken over, and machines go on with their goals",
                result.taken_over > 0 and result.lost == 0,
                f"{result.taken_over} times, {result.lost} goals given to another machine",
            ),
        ),
        tables=(
            Table(
                "How long orders wait until a machine has taken the first goal",
                (
                    "strategists",
                    "kills",
                    "orders meanwhile",
                    "median wait",
                    "longest",
                    "longest of all others",
                    "orders taken over",
                    "goals given to others",
                ),
                (
                    _row(f"one, {alone_hours:.0f} h", alone.result),
                    _row(f"{'two' if count == 2 else count}, {hours:.0f} h", result),
                ),
            ),
        ),
    )


STRATEGISTS = Scenario(
    name="strategists",
    shows="Two strategists, one killed every five minutes: orders are taken over, none is lost or made twice.",
    source="ours; the paper has one strategical layer, 3.2",
    claim=(
        "No strategist is needed more than another: when one is silent the other goes on with its orders from what the gate and the machines know, and "
        "orders that come meanwhile are begun as soon as the takeover bound allows."
    ),
    story=(
        f"{HOURS:.0f} h with an order of one container every {ORDER_EVERY_S:.0f} s. Every {KILL_EVERY_S / 60:.0f} minutes one of two strategists, in turn, is "
        f"killed for {DEAD_S:.0f} s. Beside it {ALONE_HOURS:.0f} h with one strategist that is killed as often."
    ),
    play=strategists,
)
