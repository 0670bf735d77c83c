"""A factory as processes, and two attackers on its bus that are processes, too: what they can have is bounded, is told, and can be taken back."""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE, Process, create_subprocess_exec
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import msgspec
import pytest
from attackers import Told
from fleets import AGENTS, DELIVERED_S, PLANT, START_S, Fleet, Witness

from dray.adapters.security.certificates import Authority
from dray.adapters.zenoh.bus import UNREADABLE
from dray.cli.fleet.folder import CERTIFICATES
from dray.messages import AtvHeartbeat, AtvStatus, Event, Message
from dray.messages.fact import NameMisused, OrderFulfilled
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.reach import RUN_MAX
from dray.protocol.vehicle.people.command_handling import DOUBLED

STRANGER = "ATV9"
"""Somebody has issued a certificate for it; it has no body."""

OWNER = next(iter(PLANT.fleet))
"""A vehicle of the plant whose certificate was stolen, and then its disk."""

HEARD = 409
"""Nobody says of a vehicle that is heard that it is off the floor."""

PIECES = 1
"""Its parts and itself are carried."""


class Attack:
    """An attacker as a process.

    Args:
        process: it.
    """

    def __init__(self, process: Process) -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        self._process, self._orders, self._told = process, process.stdin, process.stdout
        self.granted: set[str] = set()
        """All places that it was ever granted."""

    def order(self, what: str) -> None:
        """Tell it what to do from now on."""
        self._orders.write(f"{what}\n".encode())

    async def spoken(self, times: int) -> None:
        """Wait until it has spoken so many times more."""
        told = await self._next()
        last = told.said + times
        while told.said < last:
            told = await self._next()

    async def _next(self) -> Told:
        told = msgspec.json.decode(await self._told.readline(), type=Told)
        self.granted.update(told.granted)
        return told

    async def end(self) -> None:
        """Let it leave, and read what it has told until then."""
        self._orders.close()
        async for line in self._told:
            self.granted.update(msgspec.json.decode(line, type=Told).granted)
        assert await self._process.wait() == 0


@asynccontextmanager
async def attack(kind: str, fleet: Fleet, name: str) -> AsyncIterator[Attack]:
    program = Path(__file__).with_name("attackers.py")
    process = await create_subprocess_exec(
        *(sys.executable, str(program), kind, str(fleet.folder), name), stdin=PIPE, stdout=PIPE
    )
    try:
        yield Attack(process)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


def alarms(people: httpx.Client) -> set[str]:
    """About whom there is an alarm."""
    answer = people.get("/api/alerts")
    assert answer.is_success, answer.text
    return {each["agent"] for each in answer.json()["items"] if each["level"] == "alarm"}


def is_fulfilled(order: str, message: Message) -> bool:
    return (
        isinstance(message, Event)
        and isinstance(message.fact, OrderFulfilled)
        and message.fact.order == order
    )


def is_of_owner(message: Message, status: AtvStatus, problem: str) -> bool:
    return (
        isinstance(message, AtvHeartbeat)
        and message.atv == OWNER
        and (message.status, message.problem) == (status, problem)
    )


def status_of_owner(witness: Witness) -> AtvStatus:
    """As it was heard last."""
    beats = (heard for heard in reversed(witness.heard) if isinstance(heard, AtvHeartbeat))
    return next(beat.status for beat in beats if beat.atv == OWNER)


@pytest.mark.slow
def test_what_two_attackers_can_have_is_bounded_is_told_and_can_be_taken_back(tmp_path: Path) -> None:
    fleet = Fleet(tmp_path, plain=False)
    try:
        authority = Authority.load(tmp_path / CERTIFICATES)
        authority.issue(tmp_path / CERTIFICATES, PLANT.id, names_of(STRANGER, Kind.ATV))
        asyncio.run(attacked(fleet))
    finally:
        code = fleet.stop()
    assert code == 0


async def attacked(fleet: Fleet) -> None:
    product = next(each for each in PLANT.products if PLANT.machines_for(each))
    places = Places(PLANT)

    witness = Witness(fleet.registry, fleet.folder)
    try:
        async with asyncio.timeout(START_S):
            await witness.all_there(AGENTS)

        async def deliver() -> None:
            order = await asyncio.to_thread(fleet.place, product, PIECES)
            async with asyncio.timeout(DELIVERED_S):
                await witness.until(lambda heard: is_fulfilled(order, heard))

        async with attack("claims", fleet, STRANGER) as claims, attack("doubles", fleet, OWNER) as doubles:
            # Certificates alone.
            await claims.spoken(5)
            await deliver()
            await doubles.spoken(5)
            assert not claims.granted
            assert (await witness.told(NameMisused)).fact == NameMisused(OWNER)
            assert not any(is_of_owner(heard, AtvStatus.STOPPED, DOUBLED) for heard in witness.heard)

            # It says where it is, and so it is a vehicle like others, for which people answer.
            claims.order("be there")
            while not claims.granted:
                await claims.spoken(1)
            await claims.spoken(5)
            with fleet.gateway() as people:
                said = people.post(f"/api/agents/{STRANGER}/shut-out", json={"reason": "has no body"})
                assert said.is_success, said.text
                carried = f"/api/atvs/{STRANGER}/carried-away"
                while (said := people.post(carried, json={"off_the_floor": True})).status_code == HEARD:
                    await witness.until_more()
                assert said.is_success, said.text
            for inside in map(places.places_in, places.replicas_of):
                assert len(claims.granted & inside) <= RUN_MAX
            await deliver()

            # The vehicle's key, too.
            doubles.order("use the key")
            async with asyncio.timeout(DELIVERED_S):
                await witness.until(lambda heard: is_of_owner(heard, AtvStatus.STOPPED, DOUBLED))
            with fleet.gateway() as people:
                while OWNER not in alarms(people):
                    await witness.until_more()
            await doubles.end()
            await claims.end()
        async with asyncio.timeout(DELIVERED_S):
            await witness.until(lambda heard: is_of_owner(heard, AtvStatus.STOPPED, ""))
        with fleet.gateway() as people:
            for kind in ("acknowledge", "resume"):
                said = people.post(f"/api/atvs/{OWNER}/commands", json={"kind": kind})
                assert said.is_success, said.text
        async with asyncio.timeout(DELIVERED_S):
            while status_of_owner(witness) is AtvStatus.STOPPED:
                await witness.until_more()
        await deliver()
    finally:
        witness.bus.close()
    assert [member.starts for member in fleet.registry.members] == [1] * len(fleet.registry.members)
    told = await asyncio.to_thread(fleet.metrics)
    assert "dray_floor_overlaps_total 0.0" in told["floor"]
    for name in (*PLANT.machines, *PLANT.storages):
        assert f'dray_bus_messages_lost_total{{reason="{UNREADABLE}"}} 0.0' not in told[name], name
