"""The contracts of the paper's Figure 6: ATV3 carries for machine 8, ATV1 watches.

Both experiments and the cases about one vehicle begin with them.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from itertools import pairwise

from dray.messages import Accepted, AtvHeartbeat, Award, Bid, HandoverAccepted, HelpCall, Link, Phase, Role
from dray.messages.fact import (
    AwardAnswered,
    CarrierChanged,
    CommandObeyed,
    ContractTaken,
    HelpAsked,
    HelpPromised,
    PhaseEntered,
    PrimarySuspected,
    TaskClosed,
    TaskOpened,
    TookOver,
)
from dray.scenario_steps import ScenarioStep
from dray_sim.people.habits import Habits
from dray_sim.run.evidence import Check
from dray_sim.run.part import Part
from dray_sim.run.stage import Shift, Stage, T
from dray_sim.scenarios.paper.laboratory import MACHINE, PRODUCT, laboratory

PRIMARY, SECONDARY = "ATV3", "ATV1"
"""Carrier and watcher of Figure 6, left."""

LOT = 24

STOCK_FRAC = (0.25, 0.25)
"""Level of the buffers: so low that machine 8 asks for one material, and a while later for the next one."""

WAIT_S = 1800.0
"""Machine 8 asks for material some ten minutes after it has begun."""

SETTLE_S = 3 * 3600.0

BEGINNING = (ScenarioStep.ORDERED, ScenarioStep.CONTRACTED, ScenarioStep.UNDER_WAY)
"""Steps at the beginning of each of these parts."""

KEPT = (
    AtvHeartbeat,
    Award,
    AwardAnswered,
    Accepted,
    Bid,
    CarrierChanged,
    CommandObeyed,
    ContractTaken,
    HandoverAccepted,
    HelpCall,
    HelpAsked,
    HelpPromised,
    PhaseEntered,
    PrimarySuspected,
    TaskClosed,
    TaskOpened,
    TookOver,
)


@dataclass(frozen=True, slots=True)
class Contract:
    """The transport of the experiment."""

    task: str
    primary: str
    secondary: str
    item: str


async def replenishment(stage: Stage) -> Contract | None:
    """Order a lot of pumps, and wait until machine 8 has both vehicles for its first material."""
    stage.order(PRODUCT, LOT)
    stage.steps.tell(ScenarioStep.ORDERED, MACHINE)
    primary = await stage.witness.first(
        AwardAnswered, lambda fact: _accepted(fact, Role.PRIMARY), by=MACHINE, within_s=WAIT_S
    )
    if primary is None:
        return None
    task = primary.said.task
    secondary = await stage.witness.first(
        AwardAnswered,
        lambda fact: fact.task == task and _accepted(fact, Role.SECONDARY),
        by=MACHINE,
        within_s=WAIT_S,
    )
    brief = stage.witness.atvs[primary.said.bidder].task
    contract = Contract(
        task,
        primary.said.bidder,
        secondary.said.bidder if secondary is not None else "",
        brief.item if brief is not None else "",
    )
    stage.steps.tell(ScenarioStep.CONTRACTED, MACHINE, contract.primary, contract.secondary)
    _expect(stage, contract)
    return contract


def _expect(stage: Stage, contract: Contract) -> None:
    """Expect the possible ends of the transport, by the agents' own messages."""
    steps, task, primary = stage.steps, contract.task, contract.primary
    steps.expect(ScenarioStep.TAKEN_OVER, TookOver, lambda fact: fact.task == task)
    steps.expect(ScenarioStep.AUCTIONED, CarrierChanged, lambda fact: fact.task == task and not fact.carrier)
    steps.expect(
        ScenarioStep.DELIVERED,
        TaskClosed,
        lambda fact: fact.task == task and fact.outcome == "delivered",
        about=lambda fact: fact.carrier,
    )
    steps.expect(ScenarioStep.HELP_ASKED, HelpAsked, by=(primary,))
    steps.expect(ScenarioStep.HELP_PROMISED, HelpPromised, by=(primary,))
    steps.expect(
        ScenarioStep.RELAYED,
        AtvHeartbeat,
        lambda said: said.atv == primary and bool(said.via) and said.link is Link.MESH,
    )


PHASES = {Phase.APPROACHING: ScenarioStep.UNDER_WAY, Phase.LOADING: ScenarioStep.LOADING}


async def reached(stage: Stage, contract: Contract, phase: Phase) -> bool:
    """Wait until the primary is that far."""
    brief = stage.witness.atvs[contract.primary].task
    is_there = brief is not None and brief.phase is phase
    if not is_there:
        is_there = await _entered(stage, contract, phase)
    if is_there and phase in PHASES:
        stage.steps.tell(PHASES[phase], contract.primary)
    return is_there


async def _entered(stage: Stage, contract: Contract, phase: Phase) -> bool:
    seen = await stage.witness.first(
        PhaseEntered,
        lambda fact: fact.task == contract.task and fact.phase is phase,
        by=contract.primary,
        within_s=WAIT_S,
    )
    return seen is not None


async def closed(stage: Stage, contract: Contract, within_s: float = WAIT_S) -> TaskClosed | None:
    """Wait until the transport has ended."""
    for seen in stage.witness.all(TaskClosed):
        if seen.said.task == contract.task:
            return seen.said
    ended = await stage.witness.first(TaskClosed, lambda fact: fact.task == contract.task, within_s=within_s)
    return ended.said if ended is not None else None


def as_in_figure_6(contract: Contract) -> Check:
    """Whether the contracts are those of the paper."""
    return Check(
        f"{MACHINE} contracts {PRIMARY} as primary and {SECONDARY} as secondary, as in Figure 6",
        (contract.primary, contract.secondary) == (PRIMARY, SECONDARY),
        f"{contract.task}, {contract.item}: {contract.primary} and {contract.secondary or 'nobody'}",
    )


def carriers(stage: Stage, contract: Contract) -> tuple[str, ...]:
    """All carriers of the task, in order."""
    first = [
        taken.agent
        for taken in stage.witness.all(ContractTaken)
        if taken.said.task == contract.task and taken.said.role is Role.PRIMARY
    ]
    later = [taken.agent for taken in stage.witness.all(TookOver) if taken.said.task == contract.task]
    return tuple(dict.fromkeys((*first, *later)))


def handed_over_once(stage: Stage, contract: Contract) -> Check:
    """Whether one carrier alone has handed the task over."""
    ends = [seen.said for seen in stage.witness.all(TaskClosed) if seen.said.task == contract.task]
    delivered = [end for end in ends if end.outcome == "delivered"]
    return Check(
        "The material is handed over once",
        len(ends) == len(delivered) == 1,
        ", ".join(f"{end.outcome} by {end.carrier or 'nobody'}" for end in ends) or "it is still open",
    )


def mesh_heartbeats(
    stage: Stage, atv: str, since_s: float, until_s: float
) -> tuple[list[float], tuple[str, ...]]:
    """When a vehicle's heartbeats came by radio, and over whom."""
    heard = [
        seen
        for seen in stage.witness.all(AtvHeartbeat, since_s=since_s)
        if seen.said.atv == atv and seen.said.via and seen.said.link is Link.MESH and seen.at_s <= until_s
    ]
    relays = sorted({relay for seen in heard for relay in seen.said.via})
    return [seen.at_s for seen in heard], tuple(relays)


def longest_gap_s(times_s: list[float], since_s: float, until_s: float) -> float:
    """The longest time without any of these between two moments (s)."""
    return max(later - before for before, later in pairwise([since_s, *times_s, until_s]))


def in_laboratory(
    name: str,
    script: Callable[[Stage], Awaitable[T]],
    judge: Callable[[T], tuple[Check, ...]],
    steps: tuple[ScenarioStep, ...] = (),
    people: Habits | None = None,
) -> Part[T]:
    """A part with the paper's three vehicles and without other demand.

    Args:
        name: of the part, and of the shift.
        script: acts on the factory.
        judge: checks the script's result.
        steps: its steps after `BEGINNING`; none for a part without spectators.
        people: see `Shift.people`.
    """
    shift = Shift(name=name, duration_s=0.0, stock_frac=STOCK_FRAC, people=people, keep=KEPT)
    return Part(name, shift, laboratory, script, (*BEGINNING, *steps) if steps else (), judge)


def _accepted(fact: AwardAnswered, role: Role) -> bool:
    return fact.role is role and fact.answer == "accepted"
