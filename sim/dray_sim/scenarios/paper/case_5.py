"""Case 5: the load shifts while it is loaded. Stop, put it right, slow down, acknowledge, resume."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from math import hypot

from dray.messages import AtvHeartbeat, CommandAnswered, CommandKind, Message, Phase, VehicleCommand
from dray.messages.fact import CarrierChanged, CommandObeyed, HelpAsked, TookOver
from dray.scenario_steps import ScenarioStep
from dray_sim.faults import FaultError, LoadShifted
from dray_sim.people.habits import Habits
from dray_sim.run.evidence import Check
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Stage
from dray_sim.run.witness import Seen
from dray_sim.scenarios.paper.figure_6 import (
    Contract,
    closed,
    handed_over_once,
    in_laboratory,
    reached,
    replenishment,
)

LOADING_S = 5.0
"""Time into the loading, which takes 20 s."""

HABITS = Habits(slow_frac=0.5, slow_s=60.0)

GIVEN = {
    ScenarioStep.STOPPED: "stop",
    ScenarioStep.SLOWED: "set_speed",
    ScenarioStep.ACKNOWLEDGED: "acknowledge",
    ScenarioStep.RESUMED: "resume",
}

IN_ORDER = tuple(GIVEN.values())
"""The operator's commands, with the repair between the first and the second."""

STILL_M = 0.01

ANSWER_S = 60.0


@dataclass(frozen=True, slots=True)
class Walk:
    """A vehicle's motion between two moments."""

    metres: float
    top_mps: float


class Unauthorised:
    """A passer-by with the right to command everywhere, who acknowledges and resumes too early."""

    def __init__(self, stage: Stage) -> None:
        self.answers: list[CommandAnswered] = []
        self._factory = stage.factory
        self._session = stage.factory.bus.join("passer", self._on_message)

    def say_go_on(self, atv: str) -> None:
        until_s = self._factory.clock.now_s() + ANSWER_S
        for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME):
            command = VehicleCommand(command=f"passer-{kind.value}", kind=kind, issued_by="passer")
            granted = self._factory.authority.grant(
                atv, command, person="passer", areas=None, valid_until_s=until_s
            )
            self._session.send(atv, granted)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered):
            self.answers.append(message)


async def shift(stage: Stage) -> tuple[Check, ...]:
    """Let the primary's load slip while it is loaded, and follow the operator."""
    contract = await replenishment(stage)
    if contract is None:
        return ()
    witness = stage.witness
    stranger = Unauthorised(stage)
    await reached(stage, contract, Phase.APPROACHING)
    await reached(stage, contract, Phase.LOADING)
    await asyncio.sleep(LOADING_S)
    try:
        stage.faults.begin(LoadShifted(contract.primary))
    except FaultError as nothing:
        return (Check("A load is on its way on board", False, str(nothing)),)
    shifted_s = stage.now_s()
    stage.steps.tell(ScenarioStep.LOAD_SHIFTED, contract.primary)
    for step, what in GIVEN.items():
        stage.steps.expect(
            step,
            CommandObeyed,
            lambda fact, what=what: fact.what == what and fact.done,  # type: ignore[misc]
            by=(contract.primary,),
        )
    stopped = await _obeyed(stage, contract, "stop")
    if stopped is None:
        return (Check("An operator stops the vehicle", False, f"not within {ANSWER_S:.0f} s"),)
    stranger.say_go_on(contract.primary)
    await _obeyed(stage, contract, "set_speed")
    limited_s = stage.now_s()
    resumed = await _obeyed(stage, contract, "resume")
    resumed_s = resumed.at_s if resumed is not None else stage.now_s()
    done = await closed(stage, contract)
    done_s = stage.now_s()
    given = [
        seen.said.what
        for seen in witness.all(CommandObeyed, since_s=shifted_s)
        if seen.agent == contract.primary
        and seen.said.done
        and seen.said.what != "promise"
        and seen.at_s <= resumed_s
    ]
    replaced = [*witness.all(TookOver), *witness.all(CarrierChanged)]
    stood = _walk(stage, contract, shifted_s, resumed_s)
    drove = _walk(stage, contract, limited_s, min(done_s, limited_s + HABITS.slow_s))
    vehicle_type = stage.plant.vehicle_types[stage.plant.fleet[contract.primary].type]
    limit_mps = HABITS.slow_frac * vehicle_type.max_speed_mps
    asked = [seen for seen in witness.all(HelpAsked, since_s=shifted_s) if seen.agent == contract.primary]
    return (
        Check(
            "The vehicle stops loading, and says why",
            bool(asked),
            asked[0].said.reason if asked else "it says nothing",
        ),
        Check(
            "The operator stops it, puts the load right, slows it down, acknowledges and resumes, in this order",
            tuple(given) == IN_ORDER,
            ", ".join(given) + f"; {resumed_s - shifted_s:.0f} s in all",
        ),
        Check(
            "Until the resume it does not move",
            stood.metres <= STILL_M,
            f"{stood.metres:.2f} m in {resumed_s - shifted_s:.0f} s",
        ),
        Check(
            "An acknowledge is refused as long as the fault is there, and a resume before it, whoever gives them",
            len(stranger.answers) == 2 and not any(answer.done for answer in stranger.answers),
            "; ".join(map(_said, stranger.answers)) or "no answer",
        ),
        Check(
            f"Then it drives on with at most half its speed, {limit_mps:.2f} m/s, as it was told",
            0.0 < drove.top_mps <= limit_mps + 1e-9,
            f"at most {drove.top_mps:.2f} m/s",
        ),
        Check(
            "Nobody takes its task over, and it delivers",
            not replaced and done is not None and done.carrier == contract.primary,
            f"{done.outcome} by {done.carrier} after {done_s - shifted_s:.0f} s; {len(replaced)} takeovers"
            if done is not None
            else "not delivered",
        ),
        handed_over_once(stage, contract),
    )


async def _obeyed(stage: Stage, contract: Contract, what: str) -> Seen[CommandObeyed] | None:
    return await stage.witness.first(
        CommandObeyed,
        lambda fact: fact.what == what and fact.done,
        by=contract.primary,
        within_s=10 * ANSWER_S,
    )


def _walk(stage: Stage, contract: Contract, since_s: float, until_s: float) -> Walk:
    heard = [
        seen.said
        for seen in stage.witness.all(AtvHeartbeat, since_s=since_s)
        if seen.agent == contract.primary and seen.at_s <= until_s
    ]
    if not heard:
        return Walk(0.0, 0.0)
    first = heard[0].pose
    metres = max(hypot(each.pose.x_m - first.x_m, each.pose.y_m - first.y_m) for each in heard)
    return Walk(metres, max(each.speed_mps for each in heard))


def _said(answer: CommandAnswered) -> str:
    """Why a command was refused, in words."""
    reason = "obeyed" if answer.reason is None else answer.reason.value.replace("_", " ")
    return f"{reason}: {answer.detail}" if answer.detail else reason


PART = in_laboratory(
    "case-5",
    shift,
    lambda result: result,
    (ScenarioStep.LOADING, ScenarioStep.LOAD_SHIFTED, *GIVEN, ScenarioStep.DELIVERED),
    HABITS,
)


def case_5(seed: int) -> Findings:
    """Play it."""
    played = PART.play(seed)
    return Findings(runs=(played,), checks=PART.checks(played))


CASE_5 = Scenario(
    name="case-5",
    shows="A load shifts while it is loaded: stop, repair, slow down, acknowledge, resume.",
    source="paper, 4.2 case 5",
    claim=(
        "When a load shifts, people can stop a vehicle or slow it down. Only after somebody has confirmed that the fault "
        "is gone may it go on, and then it does its task to the end."
    ),
    story=(
        "Machine 8, three vehicles and operators. While ATV3 takes its load up, the load shifts. Somebody who passes by "
        "says that all is well, and to go on, before it is."
    ),
    play=case_5,
    parts=(PART,),
)
