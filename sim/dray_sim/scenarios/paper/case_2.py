"""Case 2: vehicles join for a busy season and leave after it; no other agent has to be told."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from dray.messages import Bid, Phase, Reason, Role
from dray.messages.fact import ContractEnded, ContractTaken, TookOver
from dray.plant import VehicleSpec, default_plant
from dray.scenario_steps import ScenarioStep
from dray_sim.run.evidence import Check
from dray_sim.run.part import Part
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Shift, Stage
from dray_sim.scenarios.tally import SETTLE_S

JOINING = (
    VehicleSpec(id="GUEST1", type="light", node="p2", battery_frac=0.9),
    VehicleSpec(id="GUEST2", type="heavy", node="p4", battery_frac=0.9),
    VehicleSpec(id="GUEST3", type="heavy", node="p6", battery_frac=0.9),
    VehicleSpec(id="GUEST4", type="light", node="p8", battery_frac=0.9),
)
"""Vehicles that are not in the plant file: no agent has heard of them before."""

JOIN_S, LEAVE_S = 1800.0, 4500.0

CARRIED_AFTER_S = 120.0
"""Time until people have carried them off the floor."""

SHIFT = Shift(name="case-2", duration_s=6300.0, load=1.0, keep=(Bid, ContractTaken, ContractEnded, TookOver))

SOON_S = LEAVE_S - JOIN_S
"""While they are there. The time to the first bid does not measure joining: a guest hears only announcements from
nearby, and depends on machines there that need something. With seed 1 no machine near the parking place P2 needs
anything for 992 s."""


@dataclass(frozen=True, slots=True)
class Guests:
    """The results of the visit.

    Attributes:
        first_s: how long each took until its first bid.
        carried: transports that they handed over.
        watched: watches that they took.
        disturbed: transports of the others that did not end by their handover, and that no guest had carried before.
        in_the_middle: one left in the middle of a transport.
        taken_over: its task was taken over.
        placed: orders.
        left: those that were not delivered in the end.
    """

    first_s: dict[str, float]
    carried: int
    watched: int
    disturbed: tuple[str, ...]
    in_the_middle: str
    taken_over: bool
    lives: int
    placed: int
    left: int


async def visit(stage: Stage, join_s: float = JOIN_S, leave_s: float = LEAVE_S) -> Guests:
    """Let the vehicles join, and take them away later, one of them in the middle of a transport."""
    witness, factory = stage.witness, stage.factory
    guests = {spec.id for spec in JOINING}
    await stage.until_s(join_s)
    for spec in JOINING:
        factory.add_vehicle(spec)
    stage.steps.tell(ScenarioStep.JOINED, *sorted(guests))
    stage.steps.expect(ScenarioStep.FIRST_BID, Bid, by=tuple(guests))
    await stage.until_s(leave_s)
    task = await _carrying(stage, guests, stage.shift.duration_s - leave_s)
    gone_s = stage.now_s()
    # Switched off where they are, and not back again in this run.
    for guest in sorted(guests):
        factory.power_off(guest)
    stage.steps.tell(ScenarioStep.LEFT, *sorted(guests))
    stage.steps.expect(ScenarioStep.TAKEN_OVER, TookOver, lambda fact: fact.task == task)
    await stage.until_s(gone_s + CARRIED_AFTER_S)
    for guest in sorted(guests):
        stage.carry_away(guest)
    stage.steps.tell(ScenarioStep.CARRIED_AWAY, *sorted(guests))
    await stage.until_s(stage.shift.duration_s)
    await stage.settle(SETTLE_S)
    if not stage.undelivered():
        stage.steps.tell(ScenarioStep.ALL_DELIVERED)
    taken = [seen for seen in witness.all(ContractTaken) if seen.agent in guests]
    theirs = {seen.said.task for seen in taken if seen.said.role is Role.PRIMARY}
    ended = witness.all(ContractEnded)
    first_s: dict[str, float] = {}
    for seen in witness.all(Bid, since_s=join_s):
        if seen.agent in guests:
            first_s.setdefault(seen.agent, seen.at_s - join_s)
    return Guests(
        first_s=first_s,
        carried=sum(seen.agent in guests and seen.said.reason == Reason.HANDED_OVER for seen in ended),
        watched=sum(seen.said.role is Role.SECONDARY for seen in taken),
        disturbed=tuple(
            f"{seen.agent} {seen.said.task} {seen.said.reason}"
            for seen in ended
            if seen.agent in stage.plant.fleet
            and seen.said.role is Role.PRIMARY
            and seen.said.reason != Reason.HANDED_OVER
            and seen.said.task not in theirs
        ),
        in_the_middle=task,
        taken_over=any(seen.said.task == task for seen in witness.all(TookOver, since_s=gone_s)),
        lives=sum(heard.incarnation for heard in witness.machines.values()) - len(witness.machines),
        placed=sum(order.at_s <= stage.now_s() for order in stage.orders),
        left=len(stage.undelivered()),
    )


async def _carrying(stage: Stage, guests: set[str], within_s: float) -> str:
    """Wait until a guest has material on board that somebody watches, and name the task; "" if none has in time."""
    for _ in range(int(within_s)):
        atvs = stage.witness.atvs
        loaded = {
            heard.task.task for heard in atvs.values() if heard.task and heard.task.phase is Phase.CARRYING
        }
        for machine, heard in stage.witness.machines.items():
            for brief in heard.tasks:
                mine = brief.primary in guests and brief.secondary not in {*guests, ""}
                if mine and brief.task in loaded and brief.destination == machine:
                    return brief.task
        await asyncio.sleep(1.0)
    return ""


def _judge(result: Guests) -> tuple[Check, ...]:
    slowest_s = max(result.first_s.values(), default=0.0)
    return (
        Check(
            f"Whoever joins bids by itself within {SOON_S / 60:.0f} minutes",
            len(result.first_s) == len(JOINING) and slowest_s <= SOON_S,
            f"{len(result.first_s)} of {len(JOINING)}, the slowest after {slowest_s:.0f} s",
        ),
        Check(
            "Those that join take a part of the work",
            result.carried > 0,
            f"{result.carried} transports, {result.watched} watches",
        ),
        Check(
            "Nobody who was there before is disturbed or restarted",
            not result.disturbed and result.lives == 0,
            ", ".join(result.disturbed) or "every transport that was never a guest's ended by its handover",
        ),
        Check(
            "They may leave at any moment: what one of them was about to bring is brought by its secondary",
            result.taken_over,
            f"{result.in_the_middle or 'nothing'} was under way",
        ),
        Check(
            "Every order is delivered",
            result.left == 0,
            f"{result.placed - result.left} of {result.placed}",
        ),
    )


PART = Part(
    "case-2",
    SHIFT,
    default_plant,
    visit,
    (
        ScenarioStep.JOINED,
        ScenarioStep.FIRST_BID,
        ScenarioStep.LEFT,
        ScenarioStep.TAKEN_OVER,
        ScenarioStep.CARRIED_AWAY,
        ScenarioStep.ALL_DELIVERED,
    ),
    _judge,
)


def case_2(seed: int, part: Part[Guests] = PART) -> Findings:
    """Play it."""
    played = part.play(seed)
    return Findings(runs=(played,), checks=part.checks(played))


CASE_2 = Scenario(
    name="case-2",
    shows="Four vehicles join for a busy season, and leave again; nobody has to be told.",
    source="paper, 4.2 case 2 and 3.1",
    claim=(
        "For a season of much work it is enough to add agents. Those who are there are not affected, since everybody "
        "decides for itself; and whoever leaves touches only those who work with it at that moment."
    ),
    story=(
        f"The default plant with orders for all of its machines' time. After {JOIN_S / 60:.0f} minutes four vehicles join "
        f"that are in no file; after {LEAVE_S / 60:.0f} minutes they are switched off, one in the middle of a transport, and "
        f"carried away {CARRIED_AFTER_S / 60:.0f} minutes later."
    ),
    play=case_2,
    parts=(PART,),
)
