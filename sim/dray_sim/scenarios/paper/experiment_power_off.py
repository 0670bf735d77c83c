"""Figure 6, right: ATV3 is switched off in the middle of a transport; ATV1 takes over and delivers."""

from __future__ import annotations

import asyncio

from dray.messages import AtvHeartbeat, Phase
from dray.messages.fact import PhaseEntered, PrimarySuspected, TookOver
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray.scenario_steps import ScenarioStep
from dray_sim.faults import PoweredOff
from dray_sim.people.habits import Habits
from dray_sim.run.evidence import Check
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Stage
from dray_sim.scenarios.paper.figure_6 import (
    PRIMARY,
    SECONDARY,
    as_in_figure_6,
    carriers,
    closed,
    handed_over_once,
    in_laboratory,
    reached,
    replenishment,
)
from dray_sim.scenarios.paper.laboratory import MACHINE

ON_THE_WAY_S = 3.0

AIR_S = 0.25
"""Largest difference in transit time between two heartbeats: the slowest delivery."""

TAKEOVER_S = 30.0

REMOVED_S = 1800.0
"""Time by which a person has come for the dead vehicle."""


async def switch_off(stage: Stage) -> tuple[Check, ...]:
    """Switch the primary off on its way, and observe the delivery."""
    contract = await replenishment(stage)
    if contract is None:
        return (Check(f"{MACHINE} contracts a vehicle", False, "no contract"),)
    await reached(stage, contract, Phase.APPROACHING)
    await asyncio.sleep(ON_THE_WAY_S)
    stage.faults.begin(PoweredOff(contract.primary))
    off_s, life = stage.now_s(), stage.witness.atvs[contract.primary].incarnation
    stage.steps.tell(ScenarioStep.SWITCHED_OFF, contract.primary)
    stage.steps.expect(
        ScenarioStep.BROUGHT_BACK,
        AtvHeartbeat,
        lambda said: said.atv == contract.primary and said.incarnation > life,
    )
    allowed_s = bound_s(WORKING_INTERVAL_S) + AIR_S
    took = await stage.witness.first(TookOver, lambda fact: fact.task == contract.task, within_s=TAKEOVER_S)
    left = [
        seen
        for seen in stage.witness.all(PhaseEntered, since_s=off_s)
        if seen.agent == contract.secondary and seen.said.task == contract.task
    ]
    done = await closed(stage, contract)
    done_s = stage.now_s()
    for _ in range(int(REMOVED_S)):
        if stage.factory.running(contract.primary):
            break
        await asyncio.sleep(1.0)
    suspected = stage.witness.all(PrimarySuspected, since_s=off_s)
    settled_s = await stage.settle(3 * 3600.0)
    if not stage.undelivered():
        stage.steps.tell(ScenarioStep.ALL_DELIVERED)
    return (
        as_in_figure_6(contract),
        Check(
            f"{SECONDARY} notices that {PRIMARY} is heard neither by WLAN nor by radio, and takes the task over",
            took is not None and took.agent == contract.secondary and took.at_s - off_s <= allowed_s,
            f"{took.agent} after {took.at_s - off_s:.2f} s; bound {allowed_s:.2f} s"
            if took is not None
            else "nobody",
        ),
        Check(
            "It drives at once",
            took is not None and bool(left) and left[0].at_s == took.at_s,
            f"{left[0].said.phase.value} to {left[0].said.station}, epoch {left[0].said.epoch}"
            if left
            else "no",
        ),
        Check(
            f"{SECONDARY} delivers",
            done is not None and done.outcome == "delivered" and done.carrier == contract.secondary,
            f"{done_s - off_s:.0f} s after the switch-off, carried by {' and then '.join(carriers(stage, contract))}"
            if done is not None
            else "not delivered",
        ),
        handed_over_once(stage, contract),
        Check(
            f"The operators notice the silence, bring {PRIMARY} to a charger, and switch it on again",
            stage.factory.running(contract.primary),
            f"{len(suspected)} suspicion{'' if len(suspected) == 1 else 's'}; {PRIMARY} is in life "
            f"{stage.witness.atvs[PRIMARY].incarnation}",
        ),
        Check(
            "The order is made and delivered in full",
            not stage.undelivered(),
            f"{settled_s:.0f} s later" if not stage.undelivered() else "not within three hours",
        ),
    )


PART = in_laboratory(
    "experiment-power-off",
    switch_off,
    lambda result: result,
    (
        ScenarioStep.SWITCHED_OFF,
        ScenarioStep.TAKEN_OVER,
        ScenarioStep.DELIVERED,
        ScenarioStep.BROUGHT_BACK,
        ScenarioStep.ALL_DELIVERED,
    ),
    Habits(),
)


def experiment(seed: int) -> Findings:
    """Play it."""
    played = PART.play(seed)
    return Findings(runs=(played,), checks=PART.checks(played))


EXPERIMENT_POWER_OFF = Scenario(
    name="experiment-power-off",
    shows="Figure 6, right: the primary is switched off; the secondary takes over and delivers.",
    source="paper, 4.3, Figure 6 right",
    claim=(
        "When the primary is switched off, the secondary notices that it is heard neither by WLAN nor by radio, takes "
        "the task over by itself and carries it out. The operators notice it as well, and take the vehicle away."
    ),
    story=(
        "Machine 8, three equal vehicles and operators. Machine 8 asks for material; ATV3 becomes primary, ATV1 "
        "secondary. When ATV3 is on its way it is switched off."
    ),
    play=experiment,
    parts=(PART,),
)
