"""docs/reading.md: what agents pass, in a factory that is played."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import pytest
from reading import Walk, calls, sections

from dray.messages import CommandKind, Role, VehicleCommand
from dray.messages.fact import ContractTaken
from dray.plant import default_plant
from dray.ports import Session
from dray.protocol.runtime import events
from dray.worker.worker import Worker
from dray_sim.faults import PoweredOff
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play, with_right_of_way

OUTSIDE = ("gateway/", "operator/")
"""Where the first file of a part lies that no agent passes: `tests/gateway/live/test_reading.py` walks these."""

STOPPED = "ATV8"


async def morning(stage: Stage) -> None:
    """An order of two, whose vehicle dies on its way, while another vehicle is stopped by hand."""
    stage.order(next(iter(stage.plant.products)), 2)

    async def taken(role: Role) -> str:
        seen = await stage.witness.first(
            ContractTaken, lambda fact: fact.role is role and fact.task.startswith("M"), within_s=300.0
        )
        assert seen is not None
        return seen.agent

    primary = await taken(Role.PRIMARY)
    assert STOPPED not in (primary, await taken(Role.SECONDARY))
    stop = VehicleCommand(command="stop", kind=CommandKind.STOP)
    factory = stage.factory
    granted = factory.authority.grant(STOPPED, stop, person="somebody", areas=None, valid_until_s=1e6)
    factory.bus.join("somebody", lambda _sender, _message: None).send(STOPPED, granted)
    await stage.until_s(stage.now_s() + 3.0)
    stage.faults.begin(PoweredOff(primary))
    await stage.settle(900.0)


@cache
def walked() -> Mapping[str, Walk]:
    """The parts of agents, section by section, after a morning."""
    walks = {
        heading: Walk({part: items for part, items in parts.items() if not items[0][1].startswith(OUTSIDE)})
        for heading, parts in sections().items()
    }
    handle = Worker._handle

    def followed(self: Worker, event: events.Event, session: Session) -> None:
        with calls() as passed:
            handle(self, event, session)
        for walk in walks.values():
            walk.step(passed)

    shift = Shift("reading", 0.0, keep=(ContractTaken,))
    with pytest.MonkeyPatch.context() as patch, with_right_of_way(True):
        patch.setattr(Worker, "_handle", followed)
        played = play(shift, default_plant(), 1, morning)
    assert played.invariants == HELD
    return walks


@pytest.mark.parametrize("heading", sections())
def test_the_code_is_passed_in_the_order_in_which_it_is_to_be_read(heading: str) -> None:
    walk = walked()[heading]
    assert not walk.left, str(walk)
