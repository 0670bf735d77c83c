"""Case 1: a machine fails. Other machines take over its goals; where no other one is able, only its orders wait."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from dray.messages import Production
from dray.messages.fact import GoalContracted, GoalLost, GoalWaits, TaskOpened
from dray.plant import default_plant
from dray.scenario_steps import ScenarioStep
from dray_sim.faults import MachineBroken, PoweredOff
from dray_sim.people.demand import Order
from dray_sim.run.evidence import Check, Table
from dray_sim.run.part import Part
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage, play
from dray_sim.scenarios.paper.laboratory import only_on

# --- others can make it --------------------------------------------------------------------------

SHIFT = Shift(
    name="case-1", duration_s=5400.0, load=0.6, keep=(GoalContracted, GoalLost, GoalWaits, TaskOpened)
)

FAILS_S = 1800.0
"""Beginning of the search for a machine in the middle of a goal that others could make."""

AWAY_S = 2400.0

BACK_S = 30.0
"""After its return more is ordered, for it and all others."""

BREAK_S = 120.0
"""A breakdown that a technician repairs; shorter than the wait of a machine's goals."""

SETTLE_S = 3 * 3600.0


@dataclass(frozen=True, slots=True)
class Passed:
    """A goal that went from a machine to others.

    Attributes:
        arrived: pieces of it that had reached the delivery warehouse.
        announced: pieces that were announced anew.
    """

    goal: str
    quantity: int
    arrived: int
    announced: int
    to: str

    def words(self) -> str:
        return f"{self.goal}: {self.arrived} of {self.quantity} had arrived, {self.announced} to {self.to or 'nobody'}"


@dataclass(frozen=True, slots=True)
class Failed:
    """The results of a machine's goals."""

    machine: str
    held: tuple[str, ...]
    passed: tuple[Passed, ...]
    came_back: bool
    """Whether it was contracted again afterwards."""
    late: tuple[str, ...]
    """Orders of others that were delivered after their time."""
    others: int
    left: int


async def fail(stage: Stage) -> Failed | None:
    """Switch a machine off in the middle of a goal, and on again after a while."""
    await stage.until_s(FAILS_S)
    machine = await _busy_machine(stage)
    if machine is None:
        return None
    held = tuple(brief.goal for brief in stage.witness.machines[machine].goals)
    of_it = _orders_of(stage, machine)
    fault, failed_s = stage.faults.begin(PoweredOff(machine)), stage.now_s()
    stage.steps.tell(ScenarioStep.MACHINE_OFF, machine)
    stage.steps.expect(
        ScenarioStep.GOALS_PASSED, GoalLost, lambda fact: fact.machine == machine, about=lambda _: machine
    )
    await asyncio.sleep(AWAY_S)
    stage.faults.end(fault)
    back_s = stage.now_s()
    stage.steps.tell(ScenarioStep.MACHINE_BACK, machine)
    stage.steps.expect(
        ScenarioStep.NEW_GOALS, GoalContracted, lambda fact: fact.machine == machine, about=lambda _: machine
    )
    await asyncio.sleep(BACK_S)
    _order_for_all(stage, machine)
    await stage.until_s(stage.shift.duration_s)
    await _deliver(stage)
    others = [order for order in stage.orders if order.id not in of_it]
    return Failed(
        machine=machine,
        held=held,
        passed=_passed(stage, machine, failed_s),
        came_back=any(
            seen.said.machine == machine for seen in stage.witness.all(GoalContracted, since_s=back_s)
        ),
        late=tuple(
            order.id for order in others if stage.observer.fulfilled_s.get(order.id, 1e9) > order.due_s
        ),
        others=len(others),
        left=len(stage.undelivered()),
    )


async def _deliver(stage: Stage) -> None:
    """Let it run until everything is delivered."""
    await stage.settle(SETTLE_S)
    if not stage.undelivered():
        stage.steps.tell(ScenarioStep.ALL_DELIVERED)


def _order_for_all(stage: Stage, machine: str) -> None:
    """Order so many pieces of a machine's product that every machine which makes it has to help."""
    making = stage.plant.machines[machine].makes[0]
    machines = len(stage.plant.machines_for(making.product))
    stage.order(making.product, 2 * machines * stage.plant.products[making.product].lot)


async def _busy_machine(stage: Stage) -> str | None:
    """A machine in the middle of a goal, with another goal waiting."""
    for _ in range(int(FAILS_S)):
        for machine, heard in stage.witness.machines.items():
            if len(heard.goals) > 1 and any(
                goal.quantity < 2 * goal.made < 2 * goal.quantity for goal in heard.goals
            ):
                return machine
        await asyncio.sleep(1.0)
    return None


def _orders_of(stage: Stage, machine: str) -> set[str]:
    """Orders that have anything to do with a machine at this moment."""
    goals = {brief.goal for brief in stage.witness.machines[machine].goals}
    return {seen.said.order for seen in stage.witness.all(GoalContracted) if seen.said.goal in goals}


def _passed(stage: Stage, machine: str, since_s: float) -> tuple[Passed, ...]:
    contracted = {seen.said.goal: seen.said for seen in stage.witness.all(GoalContracted)}
    announced = {
        seen.said.task: seen.said.work.quantity
        for seen in stage.witness.all(TaskOpened)
        if isinstance(seen.said.work, Production)
    }
    return tuple(
        Passed(
            goal=seen.said.goal,
            quantity=contracted[seen.said.goal].quantity,
            arrived=seen.said.arrived,
            announced=announced.get(seen.said.successor, 0),
            to=contracted[seen.said.successor].machine if seen.said.successor in contracted else "",
        )
        for seen in stage.witness.all(GoalLost, since_s=since_s)
        if seen.said.machine == machine
    )


# --- a technician mends it -----------------------------------------------------------------------


async def mend(stage: Stage) -> Failed | None:
    """Break a machine down for a short while: it keeps its goals."""
    await stage.until_s(FAILS_S)
    machine = await _busy_machine(stage)
    if machine is None:
        return None
    held = tuple(brief.goal for brief in stage.witness.machines[machine].goals)
    fault, failed_s = stage.faults.begin(MachineBroken(machine)), stage.now_s()
    stage.steps.tell(ScenarioStep.MACHINE_BROKEN, machine)
    await asyncio.sleep(BREAK_S)
    stage.faults.end(fault)
    stage.steps.tell(ScenarioStep.MACHINE_MENDED, machine)
    await stage.until_s(stage.shift.duration_s)
    await _deliver(stage)
    return Failed(machine, held, _passed(stage, machine, failed_s), True, (), 0, len(stage.undelivered()))


# --- nobody else can make it ---------------------------------------------------------------------

ONLY_PRODUCT, ONLY_MACHINE = "motor-e4", "M10"

ALONE = Shift(name="case-1", duration_s=0.0, keep=(GoalContracted, GoalLost, GoalWaits, TaskOpened))

ORDERS = (
    ("motor-e4", 20),
    ("pump-p3", 24),
    ("gear-unit-g1", 40),
    ("gear-unit-g2", 24),
    ("pump-p3", 48),
)

STARTED_S = 300.0
ALONE_AWAY_S = 7200.0
"""Far longer than all other orders take."""

LATER_FRAC = 0.1
"""Other orders may be so much later than without the failure, and no more: vehicles take other ways."""


@dataclass(frozen=True, slots=True)
class Alone:
    """Delivery time of each order (s); which ones waited, and whether the factory said so."""

    delivered_s: dict[str, float]
    before_repair: tuple[str, ...]
    waits: dict[str, str]
    orders: tuple[Order, ...]


async def fail_alone(stage: Stage) -> Alone:
    """Switch the only machine of a product off."""
    return await _alone(stage, failing=True)


async def work_alone(stage: Stage) -> Alone:
    """The same orders, and nothing fails."""
    return await _alone(stage, failing=False)


async def _alone(stage: Stage, *, failing: bool) -> Alone:
    orders = tuple(stage.order(product, quantity) for product, quantity in ORDERS)
    await stage.until_s(STARTED_S)
    if failing:
        fault = stage.faults.begin(PoweredOff(ONLY_MACHINE))
        await asyncio.sleep(ALONE_AWAY_S)
        before = tuple(stage.observer.fulfilled_s)
        stage.faults.end(fault)
    else:
        before = ()
    await stage.settle(SETTLE_S)
    waits = {
        seen.said.order: ", ".join(f"{each.machine} is {each.reason}" for each in seen.said.machines)
        for seen in stage.witness.all(GoalWaits)
    }
    return Alone(dict(stage.observer.fulfilled_s), before, waits, orders)


# --- all of it -----------------------------------------------------------------------------------


def _mended(result: Failed | None) -> tuple[Check, ...]:
    return (
        Check(
            f"Mended within {BREAK_S / 60:.0f} minutes, a machine goes on with its own goals",
            result is not None and bool(result.held) and not result.passed and not result.left,
            f"{result.machine} kept {', '.join(result.held)}"
            if result is not None
            else "no machine was busy",
        ),
    )


def _given_away(result: Failed | None) -> tuple[Check, ...]:
    if result is None:
        return (Check("A machine fails in the middle of a goal", False, "none was busy"),)
    passed = result.passed
    return (
        Check(
            "A dead machine's goals go to others that can make them",
            bool(passed) and all(each.to not in {"", result.machine} for each in passed if each.announced),
            "; ".join(each.words() for each in passed) or f"{result.machine} kept {', '.join(result.held)}",
        ),
        Check(
            "What had arrived is counted once: arrived and announced anew are what was ordered",
            bool(passed) and all(each.arrived + each.announced == each.quantity for each in passed),
            ", ".join(f"{each.arrived} + {each.announced} = {each.quantity}" for each in passed)
            or "nothing was lost",
        ),
        Check(
            "No other order is late, and all are delivered",
            not result.late and not result.left,
            f"{result.others - len(result.late)} of {result.others} others in time; {result.left} left open",
        ),
        Check(
            "The machine comes back and is given new goals",
            result.came_back,
            f"{result.machine} after {AWAY_S / 60:.0f} minutes",
        ),
    )


def _waiting(alone: Alone, twin: Alone) -> tuple[Check, ...]:
    only = {order.id for order in alone.orders if order.items[0].product == ONLY_PRODUCT}
    others = {order.id for order in alone.orders} - only
    later = [
        alone.delivered_s[order] / twin.delivered_s[order] - 1.0
        for order in sorted(others & set(alone.delivered_s) & set(twin.delivered_s))
    ]
    return (
        Check(
            "Where nobody else can make it, only the machine's orders wait, and they say so",
            set(alone.waits) == only and not only & set(alone.before_repair),
            "; ".join(f"{order}: {reason}" for order, reason in alone.waits.items()) or "nobody says so",
        ),
        Check(
            "All others are delivered as if nothing had happened",
            others <= set(alone.before_repair)
            and len(later) == len(others)
            and max(later, default=1.0) <= LATER_FRAC,
            f"{len(others & set(alone.before_repair))} of {len(others)} before the repair; the latest one "
            f"{max(later, default=0.0):+.1%} against the run without a failure",
        ),
        Check(
            "Repaired, the machine finishes what waited",
            only <= set(alone.delivered_s),
            f"{len(only & set(alone.delivered_s))} of {len(only)} delivered",
        ),
    )


def _times(alone: Alone, twin: Alone) -> Table:
    return Table(
        f"{ONLY_MACHINE} alone makes {ONLY_PRODUCT}, and is off for two hours: when each order is delivered",
        ("order", "pieces", "with the failure", "without"),
        tuple(
            (
                order.items[0].product,
                str(order.items[0].quantity),
                _minutes(alone.delivered_s.get(order.id)),
                _minutes(twin.delivered_s.get(order.id)),
            )
            for order in alone.orders
        ),
    )


def _minutes(at_s: float | None) -> str:
    return f"{at_s / 60:.1f} min" if at_s is not None else "-"


PART = Part(
    "case-1",
    SHIFT,
    default_plant,
    fail,
    (
        ScenarioStep.MACHINE_OFF,
        ScenarioStep.GOALS_PASSED,
        ScenarioStep.MACHINE_BACK,
        ScenarioStep.NEW_GOALS,
        ScenarioStep.ALL_DELIVERED,
    ),
    _given_away,
)

MENDED = Part(
    "case-1-mended",
    SHIFT,
    default_plant,
    mend,
    (ScenarioStep.MACHINE_BROKEN, ScenarioStep.MACHINE_MENDED, ScenarioStep.ALL_DELIVERED),
    _mended,
)


def case_1(seed: int, fails: Part[Failed | None] = PART, breaks: Part[Failed | None] = MENDED) -> Findings:
    """Play all three, and the third once more without the failure."""
    others, mended = fails.play(seed), breaks.play(seed)
    plant = only_on(ONLY_PRODUCT, ONLY_MACHINE)
    alone = play(ALONE, plant, seed, fail_alone)
    twin = play(ALONE, plant, seed, work_alone)
    return Findings(
        runs=(others, mended, alone, twin),
        checks=(
            *breaks.checks(mended),
            *fails.checks(others),
            *(
                _waiting(alone.result, twin.result)
                if alone.result is not None and twin.result is not None
                else ()
            ),
        ),
        tables=(_times(alone.result, twin.result),)
        if alone.result is not None and twin.result is not None
        else (),
    )


CASE_1 = Scenario(
    name="case-1",
    shows="A machine fails: mended, replaced by others, or only its own orders wait.",
    source="paper, 4.2 case 1",
    claim=(
        "When a machine fails, a person mends it. Where that takes too long, its orders are distributed among other "
        "machines that can make the same. Where there are none, only its orders are affected, and everything else goes "
        "on as usual."
    ),
    story=(
        f"The default plant at {SHIFT.load:.0%} load: a machine is broken for {BREAK_S / 60:.0f} minutes; in another run "
        f"one is switched off in the middle of a goal for {AWAY_S / 60:.0f} minutes. Then a plant in which "
        f"{ONLY_MACHINE} alone makes {ONLY_PRODUCT}: it is switched off for two hours, and beside it the same orders "
        "without a failure."
    ),
    play=case_1,
    parts=(PART, MENDED),
)
