"""Several gateways of one plant: each has its own name on the bus, and all show the same."""

from __future__ import annotations

import pytest
from fake_bus import FakeBus
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat

from dray.messages import CommandAnswered, Message, VehicleCommand

pytestmark = pytest.mark.anyio


async def atvs(house: House) -> list[str]:
    answer = await house.client.get("/api/atvs")
    return [atv["id"] for atv in answer.json()["items"] if atv["status"] == "idle"]


async def test_two_gateways_hear_the_same_and_each_its_own_answers(url: str) -> None:
    bus = FakeBus()
    askers: list[str] = []

    def obey(sender: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            askers.append(sender)
            bus.tell("ATV1", sender, CommandAnswered(command=message.command, done=True))

    async with (
        gateway(url, bus=bus, gateway_name="gateway-1") as first,
        gateway(url, bus=bus, gateway_name="gateway-2") as second,
    ):
        bus.join("ATV1", obey)
        bus.say(atv_heartbeat("ATV1"))
        assert await atvs(first) == await atvs(second) == ["ATV1"]
        for house in (second, first):
            answer = await house.client.post("/api/atvs/ATV1/commands", json={"kind": "stop"})
            assert answer.status_code == 200
    assert askers == ["gateway-2", "gateway-1"]
