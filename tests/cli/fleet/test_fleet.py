"""A factory as processes: an order is delivered, whoever is killed comes back, agents join, all end together."""

from __future__ import annotations

import asyncio
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fleets import AGENTS, NEW_MACHINE, PLANT, START_S, WHOLE, Fleet, Witness

from dray import __version__
from dray.messages import AtvHeartbeat, Event, MachineHeartbeat, OrderItem, ProbationBrief
from dray.messages.fact import OrderFulfilled
from dray.messages.keys import STRATEGIST
from dray.plant import plant_yaml
from dray_sim.clock.loop import VirtualClock
from dray_sim.people.demand import Order
from dray_sim.people.order_client import OrderClient

JOINING = "ATV99"

FREE_NODE = PLANT.file.chargers[-1].node
"""Where nobody is: the vehicles of the plant are parked, and have much left in their batteries."""

PIECES = 8
"""Enough that the order is still in work when both have been killed, one after the other."""

DELIVERED_S = 240.0
"""Real seconds for the order; some twenty are enough on a computer with nothing else to do."""


@contextmanager
def joining(fleet: Fleet, *agent: str) -> Iterator[subprocess.Popen[bytes]]:
    """An agent that the plant file does not know, on probation; when the context ends it has left."""
    options = ("--probation", "1", "--settings", str(fleet.folder / "fleet.env"))
    process = subprocess.Popen([sys.executable, "-m", "dray", "agent", *agent, *options], cwd=fleet.folder)
    try:
        yield process
        assert process.wait(START_S) == 0
    finally:
        process.kill()


def assert_each_tells_its_own(told: dict[str, str]) -> None:
    assert set(told) == {*AGENTS, "floor"}
    for name, text in told.items():
        assert "process_resident_memory_bytes" in text, name
        assert ("dray_bus_messages_lost_total" in text) == (name != "floor"), name
        acts = name in AGENTS - {"historian", "gateway"}
        assert ("dray_journal_write_seconds_count" in text) == acts, name
    assert 'dray_floor_bodies{state="free"} 0.0' in told["floor"]
    assert "dray_historian_up 1.0" in told["historian"]
    assert "dray_database_up 1.0" in told["gateway"]


@pytest.mark.slow
def test_an_order_is_delivered_whoever_is_killed_and_a_joining_agent_joins_and_leaves(fleet: Fleet) -> None:
    product = next(each for each in PLANT.products if PLANT.machines_for(each))
    order = Order("O-1", 0.0, 1e10, (OrderItem(product, PIECES),))
    atv = next(iter(PLANT.fleet))

    async def story() -> None:
        witness = Witness(fleet.registry)
        try:
            async with asyncio.timeout(START_S):
                await witness.all_there(AGENTS)
            assert_each_tells_its_own(await asyncio.to_thread(fleet.metrics))
            async with asyncio.timeout(DELIVERED_S):
                await OrderClient(witness.bus, VirtualClock()).order(order)
                for name in (atv, STRATEGIST):
                    await asyncio.to_thread(fleet.run, "kill", name)
                await witness.until(
                    lambda heard: (
                        isinstance(heard, AtvHeartbeat) and heard.atv == atv and heard.incarnation >= 2
                    )
                )
                await witness.until(
                    lambda heard: (
                        isinstance(heard, Event)
                        and isinstance(heard.fact, OrderFulfilled)
                        and heard.incarnation >= 2
                    )
                )
            async with asyncio.timeout(START_S):
                spec = next(iter(PLANT.fleet.values()))
                with joining(fleet, "atv", JOINING, "--type", spec.type, "--node", FREE_NODE) as process:
                    await witness.until(
                        lambda heard: (
                            isinstance(heard, AtvHeartbeat)
                            and heard.atv == JOINING
                            and heard.probation == ProbationBrief(of=1)
                        )
                    )
                    process.terminate()
                    await witness.until(
                        lambda heard: (
                            isinstance(heard, AtvHeartbeat) and heard.atv == JOINING and heard.draining
                        )
                    )
            async with asyncio.timeout(START_S):
                file = fleet.folder / "new.yaml"
                file.write_text(plant_yaml(WHOLE), encoding="utf-8")
                with joining(fleet, "machine", NEW_MACHINE.id, "--joining", str(file)) as process:
                    await witness.until(
                        lambda heard: (
                            isinstance(heard, MachineHeartbeat)
                            and heard.machine == NEW_MACHINE.id
                            and heard.joining is not None
                        )
                    )
                    process.terminate()
        finally:
            witness.bus.close()

    asyncio.run(story())
    starts = {member.name: member.starts for member in fleet.registry.members}
    assert {name for name, count in starts.items() if count > 1} == {atv, STRATEGIST}
    table = fleet.run("status")
    assert all(
        re.search(rf"^ {name} +\d+ +yes +(yes)? +{count} +{re.escape(__version__)} *$", table, re.MULTILINE)
        for name, count in starts.items()
    )
    pids = [member.pid for member in fleet.registry.members]
    assert fleet.stop() == 0
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    assert not (fleet.folder / "fleet.json").exists()


@pytest.mark.slow
def test_with_the_floor_the_fleet_ends_and_says_so(fleet: Fleet) -> None:
    fleet.run("kill", "floor")
    told, _ = fleet.process.communicate(timeout=START_S)
    assert fleet.process.returncode == 1
    assert "the floor: has ended, and all vehicles and machines with it; see " in told
    assert not (fleet.folder / "fleet.json").exists()


def test_without_a_fleet_there_is_nothing_to_show_or_kill(tmp_path: Path) -> None:
    for command in (["status"], ["kill", "ATV1"]):
        done = subprocess.run(
            [sys.executable, "-m", "dray", "fleet", *command, "--folder", str(tmp_path)],
            capture_output=True,
            text=True,
            check=False,
            timeout=START_S,
        )
        assert done.returncode == 1
        assert "start a fleet with `dray fleet up`" in done.stderr
