"""Figure 6, centre: ATV3's WLAN is cut in the middle of a transport; its heartbeat goes over a neighbour."""

from __future__ import annotations

import asyncio

from dray.messages import Bid, CallState, HelpCall, Link, Phase
from dray.messages.fact import AwardAnswered, CarrierChanged, LinkChanged, PrimarySuspected, TookOver
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray.scenario_steps import ScenarioStep
from dray_sim.faults import WlanCut
from dray_sim.people.habits import Habits
from dray_sim.run.evidence import Check
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Stage
from dray_sim.scenarios.paper.figure_6 import (
    PRIMARY,
    as_in_figure_6,
    carriers,
    closed,
    handed_over_once,
    in_laboratory,
    longest_gap_s,
    mesh_heartbeats,
    reached,
    replenishment,
)
from dray_sim.scenarios.paper.laboratory import MACHINE

ON_THE_WAY_S = 3.0
"""After ATV3 has left: both contracts stand, and it drives."""

REPAIRED_S = 600.0
"""The operators have plugged the cable in again by then, after the delivery."""

AGAIN_S = 3600.0
"""Machine 8 needs its next material within half an hour."""


async def cut(stage: Stage) -> tuple[Check, ...]:
    """Cut the WLAN of the primary, let it deliver, repair it."""
    witness = stage.witness
    contract = await replenishment(stage)
    if contract is None:
        return (Check(f"{MACHINE} contracts a vehicle", False, "no contract"),)
    await reached(stage, contract, Phase.APPROACHING)
    await asyncio.sleep(ON_THE_WAY_S)
    fault, cut_s = stage.faults.begin(WlanCut(contract.primary)), stage.now_s()
    stage.steps.tell(ScenarioStep.WLAN_CUT, contract.primary)
    stage.steps.expect(
        ScenarioStep.LINK_REPAIRED, LinkChanged, lambda fact: fact.link is Link.WLAN, by=(contract.primary,)
    )
    done = await closed(stage, contract)
    done_s = stage.now_s()
    relayed_s, relays = mesh_heartbeats(stage, contract.primary, cut_s, done_s)
    gap_s = longest_gap_s(relayed_s, cut_s, done_s)
    repaired = await witness.first(
        LinkChanged, lambda fact: fact.link is Link.WLAN, by=contract.primary, within_s=REPAIRED_S
    )
    # Until here only a person could have repaired it, and then only the fault's name is left.
    stage.faults.end(fault)
    repaired_s = stage.now_s()
    bids_meanwhile = [seen for seen in witness.all(Bid, since_s=cut_s) if seen.agent == contract.primary]
    changed = [*witness.all(CarrierChanged), *witness.all(TookOver), *witness.all(PrimarySuspected)]
    stage.steps.expect(ScenarioStep.BIDS_AGAIN, Bid, by=(contract.primary,))
    again = await witness.first(Bid, by=contract.primary, within_s=AGAIN_S)
    won = await witness.first(
        AwardAnswered,
        lambda fact: fact.bidder == contract.primary and fact.answer == "accepted",
        within_s=AGAIN_S,
    )
    allowed_s = bound_s(WORKING_INTERVAL_S)
    return (
        as_in_figure_6(contract),
        Check(
            f"Without WLAN, {PRIMARY}'s heartbeat reaches the others over a neighbour",
            bool(relayed_s) and gap_s < allowed_s,
            f"{len(relayed_s)} heartbeats over {', '.join(relays) or 'nobody'}; longest silence {gap_s:.2f} s of "
            f"the {allowed_s:.1f} s that are allowed",
        ),
        Check(
            "No second transport starts, and nobody is suspected",
            not changed and carriers(stage, contract) == (contract.primary,),
            f"carried by {', '.join(carriers(stage, contract))}; {len(changed)} suspicions and takeovers",
        ),
        Check(
            f"{PRIMARY} delivers",
            done is not None and done.outcome == "delivered" and done.carrier == contract.primary,
            f"{done_s - cut_s:.0f} s after the cut, {done_s - done.promised_s:+.1f} s against its promise"
            if done is not None
            else "not delivered",
        ),
        handed_over_once(stage, contract),
        _called(stage, contract.primary, done_s),
        Check(
            "An operator notices the failure, and repairs it once the delivery is finished",
            repaired is not None,
            f"on WLAN again {repaired_s - done_s:.0f} s after the delivery"
            if repaired is not None
            else "nobody",
        ),
        Check(
            "While it is left with its radio it does not bid",
            not bids_meanwhile,
            f"{len(bids_meanwhile)} bids in {repaired_s - cut_s:.0f} s",
        ),
        Check(
            f"Repaired, {PRIMARY} bids again, and wins",
            again is not None and won is not None and stage.witness.atvs[PRIMARY].link is Link.WLAN,
            f"first bid {again.at_s - repaired_s:.0f} s after the repair" if again is not None else "no bid",
        ),
    )


def _called(stage: Stage, atv: str, done_s: float) -> Check:
    """The check of its call for help, as the bus heard it over a neighbour."""
    calls = [seen for seen in stage.witness.all(HelpCall) if seen.said.caller == atv and seen.agent != atv]
    asked = [seen for seen in calls if seen.said.state is not CallState.ENDED]
    heard = (
        f"heard {asked[0].at_s - done_s:.0f} s after the delivery" if asked else "not heard: nobody was near"
    )
    return Check(
        f"{PRIMARY} calls nobody before it has delivered; then its call goes over whoever hears its radio",
        all(seen.at_s > done_s for seen in asked),
        f"{heard}, {'taken' if any(seen.said.taken_by for seen in calls) else 'not taken'}",
    )


PART = in_laboratory(
    "experiment-wlan",
    cut,
    lambda result: result,
    (
        ScenarioStep.WLAN_CUT,
        ScenarioStep.RELAYED,
        ScenarioStep.DELIVERED,
        ScenarioStep.LINK_REPAIRED,
        ScenarioStep.BIDS_AGAIN,
    ),
    Habits(),
)


def experiment(seed: int) -> Findings:
    """Play it."""
    played = PART.play(seed)
    return Findings(runs=(played,), checks=PART.checks(played))


EXPERIMENT_WLAN = Scenario(
    name="experiment-wlan",
    shows="Figure 6, centre: the primary's WLAN is cut; its heartbeat comes over a neighbour.",
    source="paper, 4.3, Figure 6 centre",
    claim=(
        "A vehicle that loses its WLAN in the middle of a transport is still heard through the radio of a neighbour. "
        "The machine knows that its task goes on, and starts no second transport; repaired, the vehicle takes part "
        "in the bidding again."
    ),
    story=(
        "Machine 8 and three equal vehicles. Machine 8 asks for material; ATV3 becomes primary, ATV1 secondary. When "
        "ATV3 is on its way its WLAN is cut. An operator who sees that on the tablet waits for the delivery, and plugs it in again."
    ),
    play=experiment,
    parts=(PART,),
)
