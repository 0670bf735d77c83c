"""One liar in the fleet, for two hours: work goes on, and nobody honest pays for it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

import pytest
from variants import in_campaigns

from dray.messages.fact import ContractorRated
from dray.plant import default_plant
from dray_sim.faults import LinkTrouble
from dray_sim.insiders import BEHAVIOURS
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Stage, play
from dray_sim.scenarios.insider import SHIFT, work

SHORT = replace(SHIFT, duration_s=3600.0)
"""A fraction of a shift: what stops a factory has stopped it by then."""

WORST = (
    "bids-nothing",
    "bids-absurdly",
    "bids-the-least",
    "pretends",
    "hands-over-nothing",
    "falls-silent-loaded",
)
"""Each of these kept every order from being delivered, or nearly."""


@cache
def orders_without() -> int:
    """How many orders are delivered with nobody that lies."""
    played = play(SHORT, default_plant(), 1, partial(work, behaviour=None))
    assert played.result is not None
    return played.result.orders


@pytest.mark.parametrize("name", in_campaigns(WORST, "bids-the-least"))
def test_a_liar_stops_nothing(name: str) -> None:
    played = play(SHORT, default_plant(), 1, partial(work, behaviour=BEHAVIOURS[name]))
    assert played.invariants == HELD
    assert played.result is not None
    assert played.result.orders >= orders_without()


async def lossy(stage: Stage) -> set[str]:
    """Who was on probation at any time, while a fifth of all deliveries was lost."""
    stage.faults.begin(LinkTrouble(loss_frac=0.2))
    await stage.until_s(stage.shift.duration_s)
    return {seen.said.contractor for seen in stage.witness.all(ContractorRated) if seen.said.restricted}


@pytest.mark.campaign
def test_honest_vehicles_on_bad_links_are_never_restricted() -> None:
    played = play(replace(SHORT, keep=(ContractorRated,)), default_plant(), 1, lossy)
    assert played.result == set()
