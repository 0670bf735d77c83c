"""A vehicle's modem on Zenoh: its links say whether it is on the WLAN."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from ipaddress import ip_address, ip_network
from typing import Any

import msgspec
import pytest
import zenoh
from vehicle_states import standing
from zenoh.handlers import Callback
from zenoh_kit import PATIENCE_S, free_address

from dray.adapters.zenoh.links import Links
from dray.adapters.zenoh.modem import Modem, address_of
from dray.body import BodyState, Hold, Instruction, LinkNoticed, Report, VehicleState, WorkcellState
from dray.messages import Link
from dray.plant import load_plant

RADIO = "127.8.0.1"
"""Another address of this computer, for links of a second network."""

RADIO_NETWORK = ip_network(f"{RADIO}/32")

STANDING = standing(load_plant("single-track"), "p3")


class BodyWithoutModem:
    """All of a body but its modem."""

    def __init__(self, state: BodyState) -> None:
        self.state = state
        self.told: list[Instruction] = []
        self.report: Callable[[Report], None]

    def instruct(self, instruction: Instruction) -> None:
        self.told.append(instruction)

    def sense(self) -> BodyState:
        return self.state

    def attach(self, report: Callable[[Report], None]) -> None:
        self.report = report


class Vehicle:
    """A vehicle's computer on two networks, and others that come and go there."""

    def __init__(self) -> None:
        self.wlan, self.radio = free_address(), free_address(RADIO)
        self.session = Links(listen=(self.wlan, self.radio), plain=True).open()
        self._others: dict[str, zenoh.Session] = {}
        self._reports: asyncio.Queue[Report] = asyncio.Queue()
        self.rest = BodyWithoutModem(STANDING)
        self.modem = Modem(self.rest, self.session, (RADIO_NETWORK,))
        self.modem.attach(self._reports.put_nowait)

    def link(self, address: str) -> None:
        """Somebody calls."""
        self._others[address] = Links(peers=(address,), plain=True).open()

    def cut(self, address: str) -> None:
        self._others.pop(address).close()

    async def linked(self) -> None:
        """Wait for a link."""
        loop, linked = asyncio.get_running_loop(), asyncio.Event()
        seen = Callback(lambda _: loop.call_soon_threadsafe(linked.set), indirect=False)
        listener = self.session.info.declare_link_events_listener(seen, history=True)
        async with asyncio.timeout(PATIENCE_S):
            await linked.wait()
        listener.undeclare()

    async def report(self) -> Report:
        async with asyncio.timeout(PATIENCE_S):
            return await self._reports.get()

    def close(self) -> None:
        for other in self._others.values():
            other.close()
        self.session.close()


def with_a_vehicle(test: Callable[[Vehicle], Coroutine[Any, Any, None]]) -> None:
    async def main() -> None:
        vehicle = Vehicle()
        try:
            await test(vehicle)
        finally:
            vehicle.close()

    asyncio.run(main())


def sensed(vehicle: Vehicle) -> Link:
    state = vehicle.modem.sense()
    assert isinstance(state, VehicleState)
    return state.link


def test_a_vehicle_is_on_the_wlan_while_any_link_there_is_open() -> None:
    async def test(vehicle: Vehicle) -> None:
        assert sensed(vehicle) is Link.MESH
        vehicle.link(vehicle.radio)
        vehicle.link(vehicle.wlan)
        assert await vehicle.report() == LinkNoticed(link=Link.WLAN)
        assert sensed(vehicle) is Link.WLAN
        vehicle.cut(vehicle.wlan)
        assert await vehicle.report() == LinkNoticed(link=Link.MESH)
        assert sensed(vehicle) is Link.MESH

    with_a_vehicle(test)


def test_a_vehicle_that_begins_with_its_radio_alone_knows_it() -> None:
    async def test(vehicle: Vehicle) -> None:
        vehicle.link(vehicle.radio)
        await vehicle.linked()
        for radio, link in (((RADIO_NETWORK,), Link.MESH), ((), Link.WLAN)):
            state = Modem(vehicle.rest, vehicle.session, radio).sense()
            assert isinstance(state, VehicleState)
            assert state.link is link

    with_a_vehicle(test)


def test_everything_else_is_the_bodys_own() -> None:
    async def test(vehicle: Vehicle) -> None:
        vehicle.modem.instruct(Hold())
        assert vehicle.rest.told == [Hold()]
        assert vehicle.modem.sense() == msgspec.structs.replace(STANDING, link=Link.MESH)
        vehicle.rest.state = WorkcellState(stock={}, seq=0, cycling="", broken="")
        assert vehicle.modem.sense() is vehicle.rest.state

    with_a_vehicle(test)


@pytest.mark.parametrize(
    ("locator", "address"),
    [
        ("tls/10.8.0.3:40112", "10.8.0.3"),
        ("tcp/[fd00::3]:7447", "fd00::3"),
        ("tls/[fe80::3%mesh0]:7447", "fe80::3%mesh0"),
    ],
)
def test_this_end_of_a_link_is_an_address(locator: str, address: str) -> None:
    assert address_of(locator) == ip_address(address)
