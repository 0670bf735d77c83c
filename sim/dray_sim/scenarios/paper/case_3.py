"""Case 3: connections come and go. Bidding endures it, and the radio mesh keeps living vehicles from being replaced."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from itertools import count

from dray.messages import AtvHeartbeat, Bid, Link, MachineStatus
from dray.messages.fact import AwardAnswered, MachineStatusChanged, TaskOpened
from dray.plant import default_plant
from dray.scenario_steps import ScenarioStep
from dray_sim.faults import RadioCut, Timed, WlanCut
from dray_sim.faults import play as let_happen
from dray_sim.network.radio import RADIO
from dray_sim.run.evidence import Check, Table
from dray_sim.run.part import Part
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, Stage, play
from dray_sim.scenarios.paper.figure_6 import STOCK_FRAC, WAIT_S
from dray_sim.scenarios.paper.laboratory import MACHINE, PRODUCT, laboratory
from dray_sim.scenarios.reach import Reach
from dray_sim.scenarios.tally import SETTLE_S

# --- nobody can bid ------------------------------------------------------------------------------

DEAF_S = 60.0
"""Time in which no vehicle hears anything, just when a task is announced."""

SOON_S = 60.0
"""Time of a round before the vehicles have noticed that they hear again, a rest of 20 s, and another round, whose
window has grown to 12 s by then."""

LABORATORY = Shift(
    name="case-3",
    duration_s=0.0,
    stock_frac=STOCK_FRAC,
    keep=(TaskOpened, AwardAnswered, MachineStatusChanged),
)


@dataclass(frozen=True, slots=True)
class Endured:
    """How a task found its contract though no vehicle could bid at first.

    Attributes:
        rounds: of bidding, until it had a contract.
        contracted_s: time from the end of the cut to the contract.
        starved: the machine has run out of material.
    """

    task: str
    rounds: int
    contracted_s: float | None
    starved: bool


async def deafen(stage: Stage) -> Endured | None:
    """Cut every vehicle's WLAN at the moment of an announcement."""
    stage.order(PRODUCT, stage.plant.products[PRODUCT].lot)
    stage.steps.tell(ScenarioStep.ORDERED, MACHINE)
    opened = await stage.witness.first(TaskOpened, by=MACHINE, within_s=WAIT_S)
    if opened is None:
        return None
    task = opened.said.task
    stage.steps.tell(ScenarioStep.ANNOUNCED, MACHINE)
    faults = [stage.faults.begin(WlanCut(atv)) for atv in stage.factory.vehicles]
    stage.steps.tell(ScenarioStep.ALL_DEAF, *stage.factory.vehicles)
    await asyncio.sleep(DEAF_S)
    for fault in faults:
        stage.faults.end(fault)
    heard_s = stage.now_s()
    stage.steps.tell(ScenarioStep.ALL_HEAR, *stage.factory.vehicles)
    accepted = await stage.witness.first(
        AwardAnswered, lambda fact: fact.task == task and fact.answer == "accepted", within_s=WAIT_S
    )
    if accepted is not None:
        stage.steps.tell(ScenarioStep.FOUND_CARRIER, MACHINE, accepted.said.bidder)
    rounds = max(seen.said.round for seen in stage.witness.all(TaskOpened) if seen.said.task == task)
    await stage.settle(SETTLE_S)
    if not stage.undelivered():
        stage.steps.tell(ScenarioStep.ALL_DELIVERED)
    starved = any(
        seen.said.status is MachineStatus.STARVED
        for seen in stage.witness.all(MachineStatusChanged, since_s=opened.at_s)
    )
    return Endured(task, rounds, accepted.at_s - heard_s if accepted is not None else None, starved)


# --- some are cut off at any time ----------------------------------------------------------------

PLANT = Shift(
    name="case-3",
    duration_s=2 * 3600.0,
    load=0.7,
    keep=(AtvHeartbeat, Bid),
)

FIRST_S, EVERY_S, LONG_S = 300.0, 60.0, (60.0, 180.0)
"""From five minutes on, every minute another vehicle loses its WLAN for one to three minutes."""


@dataclass(frozen=True, slots=True)
class CutOff:
    """The results of two hours of cuts.

    Attributes:
        replaced: living carriers that could be heard, and were replaced.
        lost: living carriers that no agent could hear, and were replaced.
        relayed: heartbeats that came over the radio mesh.
        furthest: the most relays of one of these.
        bids: of vehicles that had only their radio at that moment.
    """

    cuts: int
    replaced: int
    lost: int
    relayed: int
    furthest: int
    bids: int
    left: int


async def cut_in_turn(stage: Stage) -> CutOff:
    """Cut one vehicle's WLAN after another."""
    schedule = _cuts(stage)
    let_happen(schedule, stage.faults)
    return await _counted(stage, schedule)


async def cut_without_radio(stage: Stage) -> CutOff:
    """The same, and no vehicle has a radio."""
    schedule = _cuts(stage)
    radios = [Timed(0.0, RadioCut(atv)) for atv in stage.factory.vehicles]
    let_happen([*radios, *schedule], stage.faults)
    return await _counted(stage, schedule)


def _cuts(stage: Stage) -> list[Timed]:
    random = stage.random("cuts")
    vehicles = list(stage.factory.vehicles)
    schedule: list[Timed] = []
    for number in count():
        at_s = FIRST_S + number * EVERY_S
        if at_s >= stage.shift.duration_s:
            return schedule
        schedule.append(Timed(at_s, WlanCut(random.choice(vehicles)), at_s + random.uniform(*LONG_S)))
    return schedule


async def _counted(stage: Stage, schedule: list[Timed]) -> CutOff:
    reach = Reach(stage)
    watching = asyncio.create_task(reach.watch())
    await stage.until_s(stage.shift.duration_s)
    await stage.settle(SETTLE_S)
    watching.cancel()
    relayed = [
        seen.said for seen in stage.witness.all(AtvHeartbeat) if seen.said.via and seen.said.link is Link.MESH
    ]
    return CutOff(
        cuts=len(schedule),
        replaced=len(reach.in_reach),
        lost=len(reach.out_of_reach),
        relayed=len(relayed),
        furthest=max((len(heartbeat.via) for heartbeat in relayed), default=0),
        bids=_bids_on_the_mesh(stage),
        left=len(stage.undelivered()),
    )


def _bids_on_the_mesh(stage: Stage) -> int:
    """Bids of vehicles that had last said that they are left with their radio."""
    said = [
        *(
            (seen.at_s, 0, seen.agent, seen.said.link)
            for seen in stage.witness.all(AtvHeartbeat)
            if not seen.said.via
        ),
        *((seen.at_s, 1, seen.agent, Link.WLAN) for seen in stage.witness.all(Bid)),
    ]
    links: dict[str, Link] = {}
    bids = 0
    for _, is_bid, agent, link in sorted(said, key=lambda each: each[:2]):
        if is_bid:
            bids += links.get(agent, Link.WLAN) is Link.MESH
        else:
            links[agent] = link
    return bids


def _endured(result: Endured | None) -> tuple[Check, ...]:
    return (
        Check(
            "A task that nobody could bid for finds its contract as soon as somebody can",
            result is not None and result.contracted_s is not None and result.contracted_s <= SOON_S,
            f"{result.task}: nobody heard it for {DEAF_S:.0f} s; contracted {result.contracted_s:.0f} s later, in round "
            f"{result.rounds}"
            if result is not None and result.contracted_s is not None
            else "no contract",
        ),
        Check(
            "The machine had asked early enough: it does not run out of material",
            result is not None and not result.starved,
            "it ran out" if result is None or result.starved else "never without material",
        ),
    )


PART = Part(
    "case-3",
    LABORATORY,
    laboratory,
    deafen,
    (
        ScenarioStep.ORDERED,
        ScenarioStep.ANNOUNCED,
        ScenarioStep.ALL_DEAF,
        ScenarioStep.ALL_HEAR,
        ScenarioStep.FOUND_CARRIER,
        ScenarioStep.ALL_DELIVERED,
    ),
    _endured,
)


def case_3(seed: int) -> Findings:
    """Play all three."""
    deaf = PART.play(seed)
    meshed = play(PLANT, default_plant(), seed, cut_in_turn)
    alone = play(PLANT, default_plant(), seed, cut_without_radio)
    runs: tuple[Played[CutOff], ...] = (meshed, alone)
    return Findings(
        runs=(deaf, *runs),
        checks=(
            *PART.checks(deaf),
            *(
                _compared(meshed.result, alone.result)
                if meshed.result is not None and alone.result is not None
                else ()
            ),
        ),
        tables=(
            Table(
                "Two hours in which a vehicle loses its WLAN every minute",
                (
                    "",
                    "cuts",
                    "heartbeats by radio",
                    "most hops",
                    "replaced alive",
                    "with nobody near",
                    "delivered",
                    "p50",
                    "p95",
                ),
                tuple(
                    _row(name, played)
                    for name, played in zip(("with the radio mesh", "without"), runs, strict=True)
                ),
            ),
        ),
    )


def _compared(meshed: CutOff, alone: CutOff) -> tuple[Check, ...]:
    return (
        Check(
            f"Who has lost its WLAN is heard over the radio of others within {RADIO.range_m:.0f} m, and is not replaced",
            meshed.relayed > 0 and meshed.replaced == 0,
            f"{meshed.relayed} heartbeats by radio over up to {meshed.furthest} vehicles in {meshed.cuts} cuts; "
            f"{meshed.replaced} replaced, {meshed.lost} more that had nobody near",
        ),
        Check(
            "The mesh is what does it: without it vehicles that live are replaced",
            alone.replaced + alone.lost > meshed.replaced + meshed.lost,
            f"{alone.replaced + alone.lost} in {alone.cuts} cuts; with it {meshed.replaced + meshed.lost}",
        ),
        Check(
            "On the mesh nobody bids",
            meshed.bids == alone.bids == 0,
            f"{meshed.bids} and {alone.bids} bids",
        ),
        Check(
            "Either way every order is delivered, once",
            meshed.left == alone.left == 0,
            f"{meshed.left} and {alone.left} left open",
        ),
    )


def _row(name: str, played: Played[CutOff]) -> tuple[str, ...]:
    result, report = played.result, played.report
    if result is None:
        return (name, *("-",) * 8)
    return (
        name,
        str(result.cuts),
        str(result.relayed),
        str(result.furthest),
        str(result.replaced + result.lost),
        str(result.lost) if result.relayed else "-",
        f"{report.orders_delivered} of {report.orders_placed}",
        f"{report.transport_p50_s:.0f} s",
        f"{report.transport_p95_s:.0f} s",
    )


CASE_3 = Scenario(
    name="case-3",
    shows="Connections come and go: bidding endures, and the radio mesh keeps the living in their contracts.",
    source="paper, 4.2 case 3",
    claim=(
        "A vehicle that cannot be reached cannot bid; so bidding goes on until somebody can, and machines ask early "
        "enough for that. A vehicle that cannot say how it is might be taken for dead, and its transport started twice; "
        "so its heartbeat goes by radio to others nearby, who pass it on."
    ),
    story=(
        f"Machine 8 and three vehicles: at the moment it asks for material, no vehicle hears anything for {DEAF_S:.0f} s. "
        f"Then two hours in the default plant at {PLANT.load:.0%} load, in which every minute a vehicle loses its WLAN for "
        "one to three minutes; and the same two hours without radios."
    ),
    play=case_3,
    parts=(PART,),
)
