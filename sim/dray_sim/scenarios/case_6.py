"""Case 6: new software, agent by agent, while production runs."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from dray.messages.fact import CarrierChanged, ContractEnded
from dray.plant import default_plant
from dray.protocol.strategist import STRATEGIST
from dray_sim.evidence import Check, Table
from dray_sim.scenario import Findings, Scenario
from dray_sim.scenarios.tally import SETTLE_S, Tally, all_delivered, tally
from dray_sim.stage import Shift, Stage, play

NEW = "next"
"""The other version. It says the same things, as every version of one wire version does."""

WARM_UP_S = 1800.0

SPAN_S = 3600.0
"""From the first restart on; what is done in this time is compared."""

TRIAL_S = 900.0
"""The first vehicle drives alone with the new software for this long."""

DOWN_S = 15.0
"""A process ends, the new one starts."""

EVERY_S = 60.0

SHARE = 0.9
"""So much must be done all the same; what chance does to either run is about as much."""

ON_TIME_COST = 0.05
"""So much of the orders may become late by it."""

SHIFT = Shift(name="case-6", duration_s=WARM_UP_S + SPAN_S, load=0.7, keep=(CarrierChanged, ContractEnded))


@dataclass(frozen=True, slots=True)
class Span:
    """What was seen of the time of the update, in a run with it or without.

    Attributes:
        trial: transports that the first one made alone with the new software, beside the old ones.
        mixed_s: how long both versions were at work.
        old: agents that say the old version at the end.
        changed: transports whose carrier changed.
    """

    transports: int
    pieces: int
    trial: int
    mixed_s: float
    agents: int
    old: tuple[str, ...]
    changed: int
    tally: Tally

    def row(self, name: str) -> tuple[str, ...]:
        """A row of the table."""
        on_time = f"{self.tally.on_time_frac:.1%}"
        return (name, str(self.transports), str(self.pieces), str(self.changed), on_time)


async def update(stage: Stage) -> Span:
    """Update one vehicle, try it, then update everybody else, one after another."""
    return await _span(stage, updating=True)


async def leave(stage: Stage) -> Span:
    """The same time, and nobody is updated."""
    return await _span(stage, updating=False)


async def _span(stage: Stage, *, updating: bool) -> Span:
    seen = stage.observer
    await stage.until_s(WARM_UP_S)
    transports, pieces = len(seen.took_s), sum(seen.delivered.values())
    trial = await _update(stage) if updating else 0
    mixed_s = stage.now_s() - WARM_UP_S
    await stage.until_s(stage.shift.duration_s)
    transports, pieces = len(seen.took_s) - transports, sum(seen.delivered.values()) - pieces
    settled_s = await stage.settle(SETTLE_S)
    versions = {atv: heard.software for atv, heard in stage.witness.atvs.items()}
    versions.update((machine, heard.software) for machine, heard in stage.witness.machines.items())
    return Span(
        transports=transports,
        pieces=pieces,
        trial=trial,
        mixed_s=mixed_s,
        agents=len(versions),
        old=tuple(agent for agent, software in versions.items() if software != NEW),
        changed=len(stage.witness.all(CarrierChanged, since_s=WARM_UP_S)),
        tally=tally(stage, settled_s),
    )


async def _update(stage: Stage) -> int:
    """Returns the transports of the trial."""
    trial, *others = (*stage.factory.vehicles, *stage.factory.workcells, STRATEGIST)
    await _restart(stage, trial)
    await asyncio.sleep(TRIAL_S)
    tried = sum(
        ended.agent == trial and ended.said.reason == "handed_over"
        for ended in stage.witness.all(ContractEnded, since_s=WARM_UP_S)
    )
    for agent in others:
        await _restart(stage, agent)
        await asyncio.sleep(EVERY_S - DOWN_S)
    return tried


async def _restart(stage: Stage, agent: str) -> None:
    stage.factory.crash(agent)
    await asyncio.sleep(DOWN_S)
    stage.factory.restart(agent, software=NEW)


def case_6(seed: int) -> Findings:
    """Play the same demand with the update and without."""
    updated = play(SHIFT, default_plant(), seed, update)
    left = play(SHIFT, default_plant(), seed, leave)
    told, twin = updated.told, left.told
    if told is None or twin is None:
        return Findings(runs=(updated, left), checks=())
    cost = twin.tally.on_time_frac - told.tally.on_time_frac
    return Findings(
        runs=(updated, left),
        checks=(
            Check(
                "One agent is tried out alone, among others of the old version, and does its work",
                told.trial > 0,
                f"{told.trial} transport{'s' if told.trial > 1 else ''} in {TRIAL_S / 60:.0f} minutes",
            ),
            Check(
                "In the end every agent runs the new version",
                not told.old,
                f"{told.agents - len(told.old)} of {told.agents} in {told.mixed_s / 60:.0f} minutes; one at a time, each "
                f"away for {DOWN_S:.0f} s",
            ),
            Check(
                f"Production goes on: at least {SHARE:.0%} of the transports and pieces of the same hour without an update",
                told.transports >= SHARE * twin.transports and told.pieces >= SHARE * twin.pieces,
                f"{told.transports} transports, without {twin.transports}; {told.pieces} pieces, without {twin.pieces}",
            ),
            all_delivered((updated, left)),
            Check(
                f"It makes no more than {ON_TIME_COST:.0%} of the orders late",
                cost <= ON_TIME_COST,
                f"{told.tally.on_time_frac:.1%} on time, without {twin.tally.on_time_frac:.1%}",
            ),
        ),
        tables=(
            Table(
                "The same hour, with the update and without",
                ("", "transports", "pieces", "carriers changed", "on time"),
                (told.row("update"), twin.row("no update")),
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
        f"follow, one every {EVERY_S:.0f} s. Beside it the same demand without an update."
    ),
    play=case_6,
)
