"""Case 6: new software, agent by agent, while production runs."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from dray.messages.fact import CarrierChanged, ContractEnded
from dray.plant import default_plant
from dray.protocol.strategist import STRATEGIST
from dray_sim.evidence import Check, Table
from dray_sim.scenario import Findings, Scenario
from dray_sim.scenarios.tally import SETTLE_S
from dray_sim.stage import Played, Shift, Stage, play

NEW = "next"
"""The other version. It says the same things, as every version of one wire version does."""

WARM_UP_S = 3600.0
SPAN_S = 3600.0
"""Measured before, and again while agents are updated."""

TRIAL_S = 600.0
"""The first vehicle drives alone with the new software for this long."""

DOWN_S = 15.0
"""A process ends, the new one starts."""

EVERY_S = 60.0

SHARE = 0.9
"""So much of the work before must go on meanwhile; chance alone takes a few transports."""

ON_TIME = 0.95
"""As on a day without an update."""

SHIFT = Shift(
    name="case-6", duration_s=WARM_UP_S + 2 * SPAN_S, load=0.7, keep=(CarrierChanged, ContractEnded)
)


@dataclass(frozen=True, slots=True)
class Update:
    """What was seen.

    Attributes:
        before, meanwhile: transports in the hour before, and in the hour of the update.
        old: agents that still say the old version at the end.
        trial: transports that the first one made alone with the new software, beside the old ones.
        mixed_s: how long both versions were at work.
        lost: transports whose carrier changed.
    """

    before: int
    meanwhile: int
    agents: int
    old: tuple[str, ...]
    trial: int
    mixed_s: float
    lost: int
    settled_s: float


async def update(stage: Stage, warm_up_s: float = WARM_UP_S, span_s: float = SPAN_S) -> Update:
    """Update one vehicle, try it, then update everybody else, one after another."""
    factory, seen = stage.factory, stage.observer
    await stage.until_s(warm_up_s)
    first = len(seen.transports)
    await asyncio.sleep(span_s)
    begun_s, begun = stage.now_s(), len(seen.transports)
    trial, *others = (*factory.vehicles, *factory.workcells, STRATEGIST)
    await _restart(stage, trial)
    await asyncio.sleep(TRIAL_S)
    tried = sum(
        ended.agent == trial and ended.said.reason == "handed_over"
        for ended in stage.witness.all(ContractEnded, since_s=begun_s)
    )
    for agent in others:
        await _restart(stage, agent)
        await asyncio.sleep(EVERY_S - DOWN_S)
    updated_s = stage.now_s()
    await stage.until_s(begun_s + span_s)
    meanwhile = len(seen.transports) - begun
    settled_s = await stage.settle(SETTLE_S)
    versions = {atv: heard.software for atv, heard in stage.witness.atvs.items()}
    versions.update((machine, heard.software) for machine, heard in stage.witness.machines.items())
    return Update(
        before=begun - first,
        meanwhile=meanwhile,
        agents=len(versions),
        old=tuple(agent for agent, software in versions.items() if software != NEW),
        trial=tried,
        mixed_s=updated_s - begun_s,
        lost=len(stage.witness.all(CarrierChanged, since_s=begun_s)),
        settled_s=settled_s,
    )


async def _restart(stage: Stage, agent: str) -> None:
    stage.factory.crash(agent)
    await asyncio.sleep(DOWN_S)
    stage.factory.restart(agent, software=NEW)


def case_6(seed: int) -> Findings:
    """Play it."""
    played: Played[Update] = play(SHIFT, default_plant(), seed, update)
    told, report = played.told, played.report
    if told is None:
        return Findings(runs=(played,), checks=())
    return Findings(
        runs=(played,),
        checks=(
            Check(
                "One agent is tried out alone, among others of the old version, and does its work",
                told.trial > 0,
                f"{told.trial} transports in {TRIAL_S / 60:.0f} minutes",
            ),
            Check(
                "In the end every agent runs the new version",
                not told.old,
                f"{told.agents - len(told.old)} of {told.agents} in {told.mixed_s / 60:.0f} minutes; one at a time, each "
                f"away for {DOWN_S:.0f} s",
            ),
            Check(
                f"Production goes on: at least {SHARE:.0%} of the transports of the hour before",
                told.meanwhile >= SHARE * told.before,
                f"{told.before} before, {told.meanwhile} meanwhile",
            ),
            Check(
                f"Every order is delivered, and {ON_TIME:.0%} of them on time",
                report.orders_delivered == report.orders_placed and report.on_time_frac >= ON_TIME,
                f"{report.orders_delivered} of {report.orders_placed}; {report.on_time_frac:.1%} on time",
            ),
        ),
        tables=(
            Table(
                "The hour before, and the hour of the update",
                ("", "transports", "carriers changed"),
                (("before", str(told.before), "0"), ("meanwhile", str(told.meanwhile), str(told.lost))),
            ),
        ),
    )


CASE_6 = Scenario(
    name="case-6",
    shows="Agents restarted one by one with another software version while production runs.",
    source="paper, 4.2 case 6",
    claim=(
        "Software is updated agent by agent: one is tried out first, then the others follow. Neither the factory nor an "
        "area of it has to stop."
    ),
    story=(
        f"The default plant at {SHIFT.load:.0%} load. A vehicle is ended and started with another software version, and "
        f"drives with it alone for {TRIAL_S / 60:.0f} minutes. Then the other vehicles, the machines and the strategist "
        f"follow, one every {EVERY_S:.0f} s."
    ),
    play=case_6,
)
