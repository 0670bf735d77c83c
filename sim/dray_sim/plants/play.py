"""One plant that was drawn from a seed, at work for some hours under a load that it can serve."""

from __future__ import annotations

import time
from collections.abc import Iterator
from random import Random
from typing import Literal

import msgspec

from dray.messages import OrderItem
from dray.plant import Plant
from dray.plant.planning.advice import NO_LOAD_FRAC, Advice, advice
from dray.plant.planning.flow import Flow
from dray_sim.people import demand
from dray_sim.plants.draw import draw_plant
from dray_sim.plants.raster import draw_raster
from dray_sim.plants.watch import Waiting, Watch
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play, with_right_of_way
from dray_sim.run.verdict import NOTHING, Verdict

HOURS = 4.0

Kind = Literal["raster", "halls"]
"""A raster of roads (`dray_sim.plants.raster`), or halls with lanes of any shape (`dray_sim.plants.draw`), most of which are too narrow for
right of way."""

LOAD_FRAC = (0.3, 0.6)
"""Range of the load, relative to the load at which the scarcest resource is full: queues stay short there."""

SETTLE_S = 4 * 3600.0
"""Additional time for orders that are open after the demand. Empty buffers are filled first, which a small fleet
needs hours for."""


LEAST_ORDERS = 12
"""Orders of a plant that can make little are small, so that there are several."""


class Run(msgspec.Struct, frozen=True):
    """One plant and its demand.

    Attributes:
        load: part of the machines' time that the demand is drawn for.
        limit: the scarcest resource, in words.
        limit_load: the load at which it is full.
    """

    seed: int
    small: bool
    plant: Plant
    hours: float
    load: float
    limit: str
    limit_load: float
    orders: tuple[demand.Order, ...]


class Judgement(msgspec.Struct, frozen=True):
    """The results of a run."""

    seed: int
    plant: str
    limit: str
    load: float
    limit_load: float
    orders: int
    delivered: int
    transports: int
    p50_s: float
    p95_s: float
    late_p95_s: float
    flat: tuple[str, ...]
    waited: int
    """Carriers that waited longer than their promise and two minutes."""
    longest_s: float
    longest: str
    settled_s: float
    utilisation_frac: dict[str, float]
    refusals: dict[str, int]
    messages_per_task: float
    invariants: str
    took_s: float
    """Processor time; not the same in two runs."""
    replay: str
    foreseen: str
    """Why `dray plant check` says that it cannot be served; empty when it can be."""
    verdict: Verdict
    warnings: tuple[str, ...]
    """All that `dray plant check` says."""

    @property
    def failures(self) -> tuple[str, ...]:
        """Broken promises of a plant that can be served."""
        found = []
        if self.invariants != HELD:
            found.append(self.invariants)
        if self.delivered < self.orders:
            found.append(f"{self.orders - self.delivered} of {self.orders} orders not delivered")
        if self.flat:
            found.append(f"flat: {', '.join(self.flat)}")
        if self.waited:
            found.append(
                f"{self.waited} transports waited at a dock beyond their promise and two minutes, the longest {self.longest_s:.0f} s: {self.longest}"
            )
        return tuple(found)

    @property
    def named(self) -> str:
        """Why a plant was not served: by the earlier check of `dray plant check`, or by the verdict on unfinished orders.

        There is no excuse for a flat battery, a wait and a broken invariant.
        """
        if self.foreseen:
            return self.foreseen
        only_left = self.delivered < self.orders and len(self.failures) == 1
        return self.verdict.text if only_left and self.verdict.bottleneck != NOTHING else ""

    def tell(self, *, whole: bool = False) -> list[str]:
        """One line, and the command that repeats a failed run; with all figures if `whole`."""
        verdict = "served" if not self.failures else "explained" if self.named else "FAILED"
        bearable = f"load {self.load:.1%} of {self.limit_load:.1%} ({self.limit})"
        work = f"{self.delivered} of {self.orders} orders, {self.transports} transports"
        times = f"p50 / p95 {self.p50_s:.0f} / {self.p95_s:.0f} s"
        lines = [f"seed {self.seed}: {verdict}: {self.plant}, {bearable}: {work}, {times}"]
        lines += [f"  {failure}" for failure in self.failures]
        if self.failures:
            lines.append(f"  {self.foreseen or self.verdict.text}")
        if self.failures:
            lines.append(f"  replay: {self.replay}")
        if whole:
            shares = ", ".join(f"{name} {part:.1%}" for name, part in self.utilisation_frac.items())
            refused = ", ".join(f"{reason} {count}" for reason, count in self.refusals.items())
            lines += [
                f"  later than promised p95 {self.late_p95_s:.0f} s",
                f"  longest wait beyond a promise {self.longest_s:.0f} s: {self.longest}",
                f"  settled {self.settled_s:.0f} s after the demand; {self.messages_per_task:.0f} messages per transport",
                f"  vehicles: {shares}",
                f"  refusals: {refused or 'none'}",
            ]
            lines += self.verdict.lines()
            lines += [f"  warned: {warning}" for warning in self.warnings]
        return lines


def plant_of(seed: int, kind: Kind, *, small: bool = False) -> Plant:
    """The plant of a seed.

    Raises:
        PlantError: the generator has drawn an invalid plant.
    """
    return draw_raster(seed, small=small) if kind == "raster" else draw_plant(seed, small=small)


def draw(seed: int, kind: Kind = "raster", *, small: bool = False, hours: float = HOURS) -> Run:
    """The plant of a seed, and a demand that it can serve.

    Raises:
        PlantError: the generator has drawn an invalid plant.
    """
    plant = plant_of(seed, kind, small=small)
    limit = Flow(plant).limits()[0]
    random = Random(f"{seed} load")
    load = random.uniform(*LOAD_FRAC) * min(1.0, limit.load_frac)
    orders = tuple(_orders(plant, Random(f"{seed} demand"), load, hours * 3600.0))
    return Run(seed, small, plant, hours, load, f"{limit.kind} {limit.name}", limit.load_frac, orders)


def _orders(plant: Plant, random: Random, load: float, until_s: float) -> Iterator[demand.Order]:
    """Orders at random moments that together take no more than the load of the machines' time."""
    budget_s = load * len(plant.machines) * until_s
    now_s, number = demand.FIRST_ORDER_S, 0
    while now_s < until_s and budget_s > 0.0:
        number += 1
        items = []
        work_s = 0.0
        for product in random.sample(
            tuple(plant.products), k=min(len(plant.products), random.choice((1, 1, 2)))
        ):
            lot, cycle_s = plant.products[product].lot, demand.mean_cycle_s(plant, product)
            most = int(load * len(plant.machines) * until_s / LEAST_ORDERS / cycle_s)
            quantity = max(1, min(random.randint(max(1, lot // 2), 3 * lot), most))
            items.append(OrderItem(product=product, quantity=quantity))
            work_s += quantity * cycle_s
        yield demand.Order(f"D{number}", now_s, now_s + random.uniform(*demand.DUE_AFTER_S), tuple(items))
        budget_s -= work_s
        now_s += random.expovariate(1.0) * work_s / (len(plant.machines) * load)


def replay_of(seed: int, kind: Kind, *, small: bool, hours: float, traffic: bool) -> str:
    """The command that repeats a run."""
    return (
        f"dray sim plants --seed {seed} --kind {kind}{' --small' if small else ''}{f' --hours {hours:g}' if hours != HOURS else ''}"
        f" {'--traffic' if traffic else '--no-traffic'}"
    )


def play_seed(
    seed: int, kind: Kind = "raster", *, small: bool = False, hours: float = HOURS, traffic: bool = False
) -> Judgement:
    """Draw a plant, and let it work.

    Args:
        seed: decides everything.
        kind: of plant.
        small: a few machines and vehicles.
        hours: of demand.
        traffic: whether vehicles drive with right of way.
    """
    run = draw(seed, kind, small=small, hours=hours)
    began_s = time.process_time()
    watch = Watch(run.plant)

    async def work(stage: Stage) -> float:
        stage.listeners.add(watch)
        for order in run.orders:
            await stage.until_s(order.at_s)
            stage.place(order)
        await stage.until_s(run.hours * 3600.0)
        return await stage.settle(SETTLE_S)

    shift = Shift(name="plants", duration_s=run.hours * 3600.0)
    with with_right_of_way(traffic):
        played = play(shift, run.plant, seed, work)
    report, longest = played.report, watch.longest
    warned = advice(run.plant)
    return Judgement(
        seed=seed,
        plant=repr(run.plant)[1:-1],
        limit=run.limit,
        load=run.load,
        limit_load=run.limit_load,
        orders=len(run.orders),
        delivered=report.orders_delivered,
        transports=report.transports,
        p50_s=report.transport_p50_s,
        p95_s=report.transport_p95_s,
        late_p95_s=report.late_p95_s,
        flat=tuple(watch.flat),
        waited=len(watch.waits),
        longest_s=longest.beyond_s,
        longest=_told(run.plant, longest),
        settled_s=played.result or 0.0,
        utilisation_frac={str(name): part for name, part in report.utilisation_frac.items()},
        refusals=report.refusals,
        messages_per_task=report.messages_per_task,
        invariants=report.invariants,
        took_s=time.process_time() - began_s,
        replay=replay_of(seed, kind, small=small, hours=hours, traffic=traffic),
        foreseen=next((each.text for each in warned if _forbids(each)), ""),
        verdict=report.verdict,
        warnings=tuple(f"{each.kind}: {each.text}" for each in warned),
    )


def _forbids(warning: Advice) -> bool:
    """Whether the advice says that the plant cannot be served: a resource is too scarce, or the floor too small."""
    return warning.load_frac < NO_LOAD_FRAC or (warning.kind == "dwell_points" and warning.level == "error")


def _told(plant: Plant, wait: Waiting) -> str:
    """The longest wait in words."""
    if not wait.atv:
        return "nobody waited beyond a promise"
    places = (*plant.machines, *plant.storages, *plant.delivery_warehouses)
    there = " or ".join(place for place in places if plant.node_of(place) == wait.node) or f"node {wait.node}"
    return f"{wait.atv} with {wait.item} of {wait.task}, {wait.phase} at {there}"
