"""One seeded run: a factory, its listeners, and its orders.

A *script* is a coroutine that acts on the running factory and returns its observations; the run ends with it.
Everything else goes on by itself. All invariants are watched, and the first that breaks ends the run.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from random import Random
from typing import Any, Generic, TypeVar

from dray.messages import OrderItem
from dray.plant import Plant
from dray.scenario_steps import ScenarioStep
from dray_sim.bodies.floor import FIRST_STOCK_FRAC
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.obstacles import MindsObstacles
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.checks.invariants import Invariants
from dray_sim.checks.people.called import NoCallIsLost, OneTakerEach
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.installation import Embody, directly
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults
from dray_sim.network.latency import WLAN, Latency
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.crew import hire
from dray_sim.people.floor_office import FloorOffice
from dray_sim.people.habits import Habits
from dray_sim.people.load_looker import LoadLooker
from dray_sim.people.operators import Operator
from dray_sim.people.order_client import OrderClient
from dray_sim.run.evidence import HELD
from dray_sim.run.observer import Observer
from dray_sim.run.report import Report, make_report
from dray_sim.run.shortfall import Shortfall
from dray_sim.run.steps import Happened, Steps
from dray_sim.run.trace import Trace
from dray_sim.run.witness import Witness

T = TypeVar("T")

DUE_IN_S = 7200.0
"""When an order of a script is due: late enough that nothing is refused for its deadline."""


RIGHT_OF_WAY: ContextVar[bool] = ContextVar("right of way", default=False)
"""Whether vehicles take up room and drive with right of way. Scenarios are about other things, and are played on
either floor, so a context sets it for all of them (`with_right_of_way`)."""


@contextmanager
def with_right_of_way(on: bool) -> Iterator[None]:
    """Let all stages in here be set with right of way, or without."""
    before = RIGHT_OF_WAY.set(on)
    try:
        yield
    finally:
        RIGHT_OF_WAY.reset(before)


STRATEGIST_COUNT: ContextVar[int] = ContextVar("strategists", default=1)
"""Number of strategists of all shifts without a number of their own; a context sets it, too (`with_strategists`)."""


@contextmanager
def with_strategists(count: int | None) -> Iterator[None]:
    """Set the number of strategists of all stages in this context, except for shifts with their own number.

    None keeps the present number.
    """
    before = STRATEGIST_COUNT.set(STRATEGIST_COUNT.get() if count is None else count)
    try:
        yield
    finally:
        STRATEGIST_COUNT.reset(before)


@dataclass(frozen=True, slots=True)
class Shift:
    """The parameters of a run.

    Attributes:
        name: of the scenario.
        duration_s: virtual time in which demand comes in.
        load: part of the machines' time that the demand takes; 0 for no demand.
        codec: pass every message through the wire format.
        stock_frac: range of the buffers' levels at the start.
        latency: of the network.
        people: how the operators of all areas work; None for an empty floor.
        keep: classes of facts and messages that the witness keeps.
        overlaps: whether overlapping vehicles are counted (False), break the run (True), or are not looked for
            (None). With right of way they always break it.
        embody: makes adapters between vehicles and their agents; none by default.
        strategists: their number; None for that of the context (`with_strategists`), which is one by default.
    """

    name: str
    duration_s: float
    load: float = 0.0
    codec: bool = False
    stock_frac: tuple[float, float] = FIRST_STOCK_FRAC
    latency: Latency = WLAN
    people: Habits | None = None
    keep: tuple[type[Any], ...] = ()
    overlaps: bool | None = None
    embody: Embody = directly
    strategists: int | None = None


@dataclass(frozen=True, slots=True)
class Played(Generic[T]):
    """The results of a run.

    Attributes:
        told: the script's result; None when a broken invariant has cut it short.
        report: the figures of the run.
        counts: of all messages, by name.
        steps: those that have happened, in their order.
    """

    result: T | None
    report: Report
    counts: dict[str, int]
    steps: Mapping[ScenarioStep, Happened]

    @property
    def invariants(self) -> str:
        return self.report.invariants


class Stage:
    """A run in progress, as its script sees it.

    Args:
        shift: how long, and how busy.
        plant: the factory.
        seed: everything else follows from it.
        steps: that the script will tell of.
        make: makes the factory: `SimFactory`, or one that is open to the outside.

    Attributes:
        factory: bodies, network, agents.
        faults: its faults.
        people: the operators.
        looker: looks for loads that were disputed twice; None where real people look for them.
        office: reports vehicles that people have carried away; None where no report is needed.
        overlaps: vehicles in one spot so far; None where they are not looked for.
        witness: of all messages.
        steps: the script's progress.
        observer: figures so far.
        shortfall: waits so far.
        orders: all of them, placed or still to come.
        listeners: hear all that is said; a script may add its own.
    """

    def __init__(
        self,
        shift: Shift,
        plant: Plant,
        seed: int,
        steps: tuple[ScenarioStep, ...] = (),
        make: Callable[..., SimFactory] = SimFactory,
    ) -> None:
        self.shift = shift
        self.plant = plant
        self.seed = seed
        self.orders: list[demand.Order] = []
        if shift.load:
            random = Random(f"{seed} demand")
            self.orders += demand.orders(plant, random, load=shift.load, until_s=shift.duration_s)
        self.observer, self.trace, self.witness = Observer(), Trace(), Witness(*shift.keep)
        self.listeners = listeners = Listeners()
        self.factory = make(
            plant,
            clock(),
            seed=seed,
            stock_frac=shift.stock_frac,
            latency=shift.latency,
            codec=shift.codec,
            listener=listeners,
            traffic=RIGHT_OF_WAY.get(),
            embody=shift.embody,
            strategists=shift.strategists or STRATEGIST_COUNT.get(),
        )
        self.faults = Faults(self.factory)
        self.office: FloorOffice | None = None
        if self.factory.traffic is not None:
            factory = self.factory
            self.office = FloorOffice(factory.bus, factory.clock, factory.keys, factory.authority)
        self.people: tuple[Operator, ...] = ()
        if shift.people is not None:
            self.people = hire(self.factory, seed=seed, habits=shift.people, office=self.office)
        self.looker: LoadLooker | None = None
        if make is SimFactory:
            factory = self.factory
            self.looker = LoadLooker(factory.bus, factory.clock, factory.authority, factory.uncounted)
            listeners.add(self.looker)
        self.checks = Invariants(self.factory)
        self.checks.add(OneTakerEach(person.duty for person in self.people))
        self.checks.add(NoCallIsLost())
        if plant.doors:
            self.checks.add(MindsObstacles(self.factory))
        self.overlaps: Overlaps | None = None
        if self.factory.traffic is not None:
            self.checks.add(HeldPlaces(self.factory))
        if self.factory.traffic is not None or shift.overlaps is not None:
            strict = self.factory.traffic is not None or shift.overlaps is True
            self.overlaps = Overlaps(self.factory.vehicles, strict=strict)
            self.checks.add(self.overlaps)
        self.shortfall = Shortfall(plant, self.factory.storages)
        self.steps = Steps(steps, self.now_s)
        listeners.add(self.trace, self.observer, self.checks, self.witness, self.shortfall, self.steps)
        self._customers = OrderClient(self.factory.bus, self.factory.clock, self.factory.strategists)
        self._demand = tuple(self.orders)
        self._placing: list[asyncio.Task[None]] = []

    def now_s(self) -> float:
        return self.factory.clock.now_s()

    def random(self, concern: str) -> Random:
        """A generator of chances for one concern of the script."""
        return Random(f"{self.seed} {self.shift.name} {concern}")

    async def until_s(self, at_s: float) -> None:
        """Let the factory run until this time (plant clock)."""
        await asyncio.sleep(max(0.0, at_s - self.now_s()))

    async def settle(self, within_s: float) -> float:
        """Let it run until every order that was placed is delivered, looking once a second.

        Returns:
            The duration (s), at most `within_s`.
        """
        begun_s = self.now_s()
        for _ in range(int(within_s)):
            if not self.undelivered():
                break
            await asyncio.sleep(1.0)
        return self.now_s() - begun_s

    def undelivered(self) -> list[demand.Order]:
        """Orders that were placed and are not delivered in full."""
        now_s = self.now_s()
        done = self.observer.fulfilled_s
        return [order for order in self.orders if order.at_s <= now_s and order.id not in done]

    def order(self, product: str, quantity: int, due_in_s: float = DUE_IN_S) -> demand.Order:
        """Place an order of one item now."""
        now_s = self.now_s()
        items = (OrderItem(product=product, quantity=quantity),)
        placed = demand.Order(f"S{len(self._placing) + 1}", now_s, now_s + due_in_s, items)
        self.place(placed)
        return placed

    def place(self, order: demand.Order) -> None:
        """Place an order now, at any time of its own."""
        self.orders.append(order)
        self._placing.append(asyncio.create_task(self._customers.order(order)))

    def carry_away(self, atv: str) -> None:
        """Let people carry a vehicle away, and say so where others need its place."""
        if self.office is not None:
            self.factory.power_off(atv)
            self.factory.floor.lift(atv)
            self.office.carry_away(atv)

    async def live(self) -> None:
        """Run the factory and its demand until cancelled.

        Raises:
            ExceptionGroup: an agent ended by an exception (invariant 8).
        """
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self.factory.run())
                group.create_task(self._customers.place(self._demand))
                if self.office is not None:
                    group.create_task(self.office.run())
                if self.looker is not None:
                    group.create_task(self.looker.run())
                for operator in self.people:
                    group.create_task(operator.run(), name=operator.name)
        finally:
            for task in self._placing:
                task.cancel()


def play(
    shift: Shift,
    plant: Plant,
    seed: int,
    script: Callable[[Stage], Awaitable[T]] | None = None,
    steps: tuple[ScenarioStep, ...] = (),
) -> Played[T]:
    """Run a script in virtual time, all invariants watched.

    Args:
        shift: how long, and how busy.
        plant: the factory.
        seed: everything else follows from it.
        script: acts on the factory; None only lets the shift's time pass.
        steps: that the script tells of.

    Returns:
        The script's result, and the figures. A broken invariant ends the run and is named in the report.
    """
    return run(_play(shift, plant, seed, script, steps), JUMP)


async def _play(
    shift: Shift,
    plant: Plant,
    seed: int,
    script: Callable[[Stage], Awaitable[T]] | None,
    steps: tuple[ScenarioStep, ...],
) -> Played[T]:
    stage = Stage(shift, plant, seed, steps)
    life = asyncio.create_task(stage.live())
    broken = asyncio.create_task(stage.checks.wait_broken())
    acting = asyncio.ensure_future(_act(stage, script))
    await asyncio.wait({life, broken, acting}, return_when=asyncio.FIRST_COMPLETED)
    stage.checks.check_end(stage.now_s())
    report = make_report(
        shift.name,
        seed=seed,
        demand=stage.orders,
        factory=stage.factory,
        observer=stage.observer,
        shortfall=stage.shortfall,
        invariants=_verdict(stage.checks, life),
        trace=stage.trace.hexdigest(),
    )
    result = acting.result() if acting.done() else None
    for task in (life, broken, acting):
        task.cancel()
    await asyncio.gather(life, broken, acting, return_exceptions=True)
    return Played(result, report, stage.trace.counts_by_name(), stage.steps.happened)


async def _act(stage: Stage, script: Callable[[Stage], Awaitable[T]] | None) -> T | None:
    if script is None:
        await stage.until_s(stage.shift.duration_s)
        return None
    return await script(stage)


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
