"""Case 4: a busy vehicle cannot go on. A person helps in time, or promises to; otherwise another vehicle carries."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from dray.messages import Phase
from dray.messages.fact import CarrierChanged, HelpAsked, HelpPromised, TookOver
from dray.scenario_steps import ScenarioStep
from dray_sim.faults import PoweredOff, VehicleBroken
from dray_sim.people.habits import Habits
from dray_sim.run.evidence import Check, Table
from dray_sim.run.part import Part
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Stage
from dray_sim.scenarios.paper.figure_6 import Contract, closed, in_laboratory, reached, replenishment

REASON = "the way is blocked"

ON_THE_WAY_S = 5.0

QUICK = Habits(react_s=(3.0, 5.0), promises_frac=0.0, walk_s=(5.0, 10.0), mend_s=(5.0, 10.0))
"""Time of a repair that is done before the vehicle's patience is over, without a promise."""

SLOW = Habits(
    react_s=(3.0, 5.0), promises_frac=1.0, estimate=(1.3, 1.5), walk_s=(60.0, 90.0), mend_s=(240.0, 300.0)
)
"""Time of a repair that takes longer than the vehicle would wait, with a promise."""

IN_TIME_S = 2.0
"""A takeover follows the end of the help's time by a heartbeat and a message round."""

BACK_S = 60.0
"""After this long one of the vehicles that were away is switched on again."""


@dataclass(frozen=True, slots=True)
class Result:
    """The course of a transport whose primary had a problem.

    Attributes:
        asked_s: latest time for help, by the vehicle, from the breakdown (s).
        promised_s: promised time of help, from the breakdown (s); None for no promise.
        changed_s: when the task got another carrier or was put up for auction again, from the breakdown (s).
        took_over: the new carrier; empty for none.
        auctioned: it was announced anew.
        done_s: when it was delivered, from the breakdown (s).
    """

    primary: str
    secondary: str
    asked_s: float | None
    promised_s: float | None
    changed_s: float | None
    took_over: str
    auctioned: bool
    carrier: str
    outcome: str
    done_s: float


async def helped_or_not(stage: Stage) -> Result | None:
    """Break the primary down on its way, and observe the delivery."""
    return await _break(stage, _nothing)


async def nobody_left(stage: Stage) -> Result | None:
    """The same with all other vehicles switched off: none is left to take over."""
    return await _break(stage, _switch_others_off)


async def _break(stage: Stage, also: Callable[[Stage, Contract], Awaitable[None]]) -> Result | None:
    contract = await replenishment(stage)
    if contract is None:
        return None
    await reached(stage, contract, Phase.APPROACHING)
    await asyncio.sleep(ON_THE_WAY_S)
    stage.faults.begin(VehicleBroken(contract.primary, REASON))
    broken_s = stage.now_s()
    stage.steps.tell(ScenarioStep.WAY_BLOCKED, contract.primary)
    await also(stage, contract)
    done = await closed(stage, contract)
    done_s = stage.now_s()
    witness = stage.witness
    asked = [seen.said.until_s for seen in witness.all(HelpAsked) if seen.said.task == contract.task]
    promised = [seen.said.until_s for seen in witness.all(HelpPromised) if seen.agent == contract.primary]
    took = [seen for seen in witness.all(TookOver) if seen.said.task == contract.task]
    changed = [seen for seen in witness.all(CarrierChanged) if seen.said.task == contract.task]
    first_s = min([*(seen.at_s for seen in took), *(seen.at_s for seen in changed)], default=None)
    return Result(
        primary=contract.primary,
        secondary=contract.secondary,
        asked_s=asked[0] - broken_s if asked else None,
        promised_s=promised[-1] - broken_s if promised else None,
        changed_s=first_s - broken_s if first_s is not None else None,
        took_over=took[0].agent if took else "",
        auctioned=any(not seen.said.carrier for seen in changed),
        carrier=done.carrier if done is not None else "",
        outcome=done.outcome if done is not None else "still open",
        done_s=done_s - broken_s,
    )


async def _nothing(_stage: Stage, _contract: Contract) -> None:
    return


async def _switch_others_off(stage: Stage, contract: Contract) -> None:
    others = [atv for atv in stage.factory.vehicles if atv != contract.primary]
    off = {atv: stage.faults.begin(PoweredOff(atv)) for atv in others}
    stage.steps.tell(ScenarioStep.OTHERS_OFF, *others)
    await stage.witness.first(CarrierChanged, lambda fact: fact.task == contract.task, within_s=600.0)
    await asyncio.sleep(BACK_S)
    stage.faults.end(off[others[-1]])
    stage.steps.tell(ScenarioStep.BROUGHT_BACK, others[-1])


def case_4(seed: int) -> Findings:
    """Play all four."""
    runs = tuple(part.play(seed) for part in PARTS)
    return Findings(
        runs=runs,
        checks=(
            _said(tuple(played.result for played in runs)),
            *(check for part, played in zip(PARTS, runs, strict=True) for check in _verdict(part, played)),
        ),
        tables=(
            Table(
                "Seconds after the breakdown",
                ("", "would wait until", "promised until", "other carrier", "delivered by", "at"),
                tuple(
                    _row(name, played)
                    for name, played in zip(
                        ("helped in time", "promised", "nobody comes", "nobody comes, no secondary"),
                        runs,
                        strict=True,
                    )
                ),
            ),
        ),
    )


def _verdict(part: Part[Result | None], played: Played[Result | None]) -> tuple[Check, ...]:
    """The checks of one part, without those of all parts together."""
    return part.judge(played.result)[1:]


def _said(runs: tuple[Result | None, ...]) -> Check:
    asked_s = [result.asked_s if result is not None else None for result in runs]
    return Check(
        "The vehicle says what is wrong and how long its task can wait",
        all(each_s is not None for each_s in asked_s),
        ", ".join(_seconds(each_s) for each_s in asked_s),
    )


def _helped(result: Result | None) -> Check:
    return _kept("Helped in time, the vehicle goes on and delivers itself", result)


def _kept(name: str, result: Result | None) -> Check:
    held = result is not None and result.changed_s is None and result.carrier == result.primary
    return Check(name, held and _delivered(result), _words(result))


def _held_back(result: Result | None) -> Check:
    patience_s = result.asked_s if result is not None and result.asked_s is not None else 0.0
    waited = (
        result is not None
        and result.promised_s is not None
        and result.done_s > patience_s < result.promised_s
    )
    kept = _kept("", result)
    return Check(
        "A promise of help holds the takeover back for longer than the vehicle would have waited",
        kept.held and waited,
        kept.figure,
    )


def _taken_over(result: Result | None) -> Check:
    held = (
        result is not None
        and result.took_over == result.secondary == result.carrier
        and _at_the_end_of_patience(result)
    )
    return Check(
        "Nobody comes: when its time is over, the secondary takes over and delivers",
        held and _delivered(result),
        _words(result),
    )


def _auctioned(result: Result | None) -> Check:
    held = (
        result is not None
        and result.auctioned
        and not result.took_over
        and result.carrier not in {"", result.primary}
    )
    return Check(
        "Nobody comes and no secondary lives: the machine puts the task up for auction again",
        held and _delivered(result),
        _words(result),
    )


def _at_the_end_of_patience(result: Result) -> bool:
    return (
        result.changed_s is not None
        and result.asked_s is not None
        and result.asked_s <= result.changed_s <= result.asked_s + IN_TIME_S
    )


def _delivered(result: Result | None) -> bool:
    return result is not None and result.outcome == "delivered"


def _words(result: Result | None) -> str:
    if result is None:
        return "no contract"
    changed = (
        f"another carrier after {result.changed_s:.0f} s"
        if result.changed_s is not None
        else "no other carrier"
    )
    return f"{changed}; {result.outcome} by {result.carrier or 'nobody'} after {result.done_s:.0f} s"


def _row(name: str, played: Played[Result | None]) -> tuple[str, ...]:
    result = played.result
    if result is None:
        return (name, "-", "-", "-", "-", "-")
    return (
        name,
        _seconds(result.asked_s),
        _seconds(result.promised_s),
        _seconds(result.changed_s),
        result.carrier or "-",
        f"{result.done_s:.0f} s",
    )


def _seconds(seconds: float | None) -> str:
    return f"{seconds:.0f} s" if seconds is not None else "-"


def _part(
    name: str,
    script: Callable[[Stage], Awaitable[Result | None]],
    verdict: Callable[[Result | None], Check],
    steps: tuple[ScenarioStep, ...],
    people: Habits | None = None,
) -> Part[Result | None]:
    return in_laboratory(
        name,
        script,
        lambda result: (_said((result,)), verdict(result)),
        (ScenarioStep.WAY_BLOCKED, *steps, ScenarioStep.DELIVERED),
        people,
    )


ASKED, PROMISED = ScenarioStep.HELP_ASKED, ScenarioStep.HELP_PROMISED

PARTS = (
    _part("case-4", helped_or_not, _helped, (ASKED,), QUICK),
    _part("case-4-promised", helped_or_not, _held_back, (ASKED, PROMISED), SLOW),
    _part("case-4-nobody-comes", helped_or_not, _taken_over, (ASKED, ScenarioStep.TAKEN_OVER)),
    _part(
        "case-4-nobody-left",
        nobody_left,
        _auctioned,
        (ScenarioStep.OTHERS_OFF, ASKED, ScenarioStep.AUCTIONED, ScenarioStep.BROUGHT_BACK),
    ),
)


CASE_4 = Scenario(
    name="case-4",
    shows="A busy vehicle has a problem: help in time, a promise, a takeover, a new auction.",
    source="paper, 4.2 case 4",
    claim=(
        "When a busy vehicle cannot go on, its problem is weighed first: what a person can solve within a time that the "
        "task allows, is solved by a person. Otherwise the secondary takes the task over, or the machine puts it up for "
        "auction again."
    ),
    story=(
        "Machine 8 and three vehicles; ATV3 is primary, ATV1 secondary, and ATV3's way is blocked. Four times: an "
        "operator helps at once; an operator promises to come and takes minutes; nobody comes; nobody comes, and the "
        "other vehicles are switched off too until the machine has given up."
    ),
    play=case_4,
    parts=PARTS,
)
