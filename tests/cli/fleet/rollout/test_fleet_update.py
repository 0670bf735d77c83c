"""Updates of a fleet of processes under load: bad versions go back by themselves, a good one comes to all agents."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from itertools import count
from pathlib import Path

import pytest
from fleets import AGENTS, PLANT, START_S, Fleet, Witness
from versions import make_version, patched

import dray
from dray import __version__
from dray.cli.fleet.rollout.report import Report, Verdict
from dray.messages import Event, Message, OrderItem
from dray.messages.fact import OrderFulfilled
from dray_sim.clock.loop import VirtualClock
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

OPEN = 4
"""Orders at a time, of one piece each: machines and vehicles always have something to do, and soon have done it."""

DIES_WHEN_HIRED = {
    "protocol/contract_net/replies.py": (
        "def accept(coordinator: str, award: Award, finish_s: float, now_s: float) -> Effect:",
        "def accept(coordinator: str, award: Award, finish_s: float, now_s: float) -> Effect:\n    raise ValueError(award)",
    )
}
DOES_NOT_START = {
    "protocol/runtime/agent.py": (
        "from __future__ import annotations",
        "from __future__ import annotations\n\nraise ImportError",
    )
}

TRIES = 3


class Customers:
    """They order again whenever something has arrived."""

    def __init__(self, witness: Witness) -> None:
        self.placed: list[str] = []
        self._witness = witness
        self._customers = OrderClient(witness.bus, VirtualClock())

    async def order(self) -> None:
        products = [each for each in PLANT.products if PLANT.machines_for(each)]
        for number in count():
            product = products[number % len(products)]
            items = (OrderItem(product, 1),)
            self.placed.append(f"O-{number}")
            await self._customers.order(Order(self.placed[-1], 0.0, 1e10, items))
            if number >= OPEN:
                await self.got(self.placed[number - OPEN])

    async def got(self, order: str) -> None:
        def is_it(heard: Message) -> bool:
            return (
                isinstance(heard, Event)
                and isinstance(heard.fact, OrderFulfilled)
                and heard.fact.order == order
            )

        await self._witness.until(is_it)


@contextlib.asynccontextmanager
async def ordering(fleet: Fleet) -> AsyncIterator[Customers]:
    """Orders come in as long as the context lasts; all of them are delivered before it ends."""
    witness = Witness(fleet.registry)
    customers = Customers(witness)
    try:
        at_it = asyncio.create_task(customers.order())
        async with asyncio.timeout(START_S):
            await customers.got("O-0")
        yield customers
        at_it.cancel()
        async with asyncio.timeout(START_S):
            for order in customers.placed[:-1]:
                await customers.got(order)
    finally:
        witness.bus.close()


def versions_of(fleet: Fleet) -> dict[str, str]:
    return {member.name: member.software.version for member in fleet.registry.members}


def assert_nothing_was_lost(report: Report) -> None:
    assert report.cost is not None
    assert (report.cost.lost, report.cost.twice, report.cost.missing) == ((), (), 0)


async def roll_out(fleet: Fleet, python: Path) -> tuple[int, Report]:
    """Update all; again when an agent looked silent, as one does whose computer is busy with other tests."""
    for _ in range(TRIES):
        code, report = await asyncio.to_thread(fleet.update, python, "--canary-tasks", "1")
        assert_nothing_was_lost(report)
        if report.done or "silent" not in report.end:
            break
    return code, report


@pytest.mark.parametrize("patches", [DIES_WHEN_HIRED, DOES_NOT_START])
def test_what_a_bad_version_changes_stands_in_the_code(patches: dict[str, tuple[str, str]]) -> None:
    for module, patch in patches.items():
        assert patched(Path(dray.__file__).parent / module, *patch)


@pytest.mark.campaign
def test_bad_versions_go_back_by_themselves_and_a_good_one_comes_to_all(fleet: Fleet, tmp_path: Path) -> None:
    good = make_version(tmp_path / "good", "9.0")
    dead = make_version(tmp_path / "dead", "9.1", DOES_NOT_START)
    fatal = make_version(tmp_path / "fatal", "9.2", DIES_WHEN_HIRED)
    first = next(iter(PLANT.fleet))
    before = versions_of(fleet)
    assert set(before.values()) == {__version__}

    async def story() -> None:
        async with ordering(fleet) as customers:
            for python in (dead, fatal):
                code, report = await asyncio.to_thread(fleet.update, python, "--canary-tasks", "1")
                assert (code, report.done) == (1, False)
                assert [(step.agent, step.verdict) for step in report.steps] == [
                    (first, Verdict.FAILED),
                    (first, Verdict.BACK),
                ]
                assert "its process has ended" in report.steps[0].why
                assert versions_of(fleet) == before
                assert_nothing_was_lost(report)
            placed = len(customers.placed)
            code, report = await roll_out(fleet, good)
            assert (code, report.end) == (0, f"{len(AGENTS)} processes updated"), report
            assert len(customers.placed) > placed, "production went on"
        assert versions_of(fleet) == dict.fromkeys(AGENTS, "9.0") | {"floor": __version__}
        assert {step.agent for step in report.steps} == AGENTS
        assert not any(step.killed for step in report.steps)
        assert_nothing_was_lost(report)
        assert report.cost is not None
        assert report.cost.during.mean > 0.0
        # Whoever has been replaced is an agent like all others: nothing is left to do.
        code, report = await asyncio.to_thread(fleet.update, good)
        assert (code, report.steps, report.end) == (0, (), "every process runs it already")

    asyncio.run(story())
    assert fleet.stop() == 0
