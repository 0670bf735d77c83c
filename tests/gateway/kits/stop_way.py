"""The stop path of a gateway: its endpoint, its sender and its recorder, on the bus of the test and without threads."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import httpx
from gateway_kit import AUTHORITY, BEARER, House
from wall_clock import NOW_S

from dray.gateway.http.hosts import Hosts
from dray.gateway.live.timescale import TimeScale
from dray.gateway.stop.endpoint import StopEndpoint
from dray.gateway.stop.recorder import StopRecorder
from dray.gateway.stop.sender import StopSender
from dray.messages import CommandAnswered, CommandRefusal, Message, VehicleCommand

STOP = {"kind": "stop"}


@dataclass
class Way:
    """The stop path of a house."""

    house: House
    sender: StopSender
    client: httpx.AsyncClient

    async def ask(self, atv: str = "ATV1", body: Any = STOP, **headers: str) -> httpx.Response:
        return await self.client.post(f"/api/atvs/{atv}/commands", json=body, headers=headers)

    def vehicle(self, atv: str = "ATV1", reason: str = "") -> list[VehicleCommand]:
        """Let a vehicle join that answers every command; the commands that it will have heard."""
        heard: list[VehicleCommand] = []

        def receive(sender: str, message: Message) -> None:
            if isinstance(message, VehicleCommand):
                heard.append(message)
                answer = CommandAnswered(
                    command=message.command,
                    done=not reason,
                    reason=CommandRefusal(reason) if reason else None,
                )
                self.house.bus.tell(atv, sender, answer)

        self.house.bus.join(atv, receive)
        return heard

    def states(self) -> list[str]:
        """What panels show of the commands."""
        return [each.state for each in self.house.projection.commands.views()]


@asynccontextmanager
async def way(house: House, timeout_s: float = 3.0) -> AsyncIterator[Way]:
    recorder = StopRecorder(house.commands, house.access.audit_log)
    sender = StopSender(
        house.bus,
        name="gateway-stop",
        incarnation=1,
        authority=AUTHORITY,
        time=TimeScale(0.0, NOW_S),
        wall_s=house.wall,
        timeout_s=timeout_s,
        ahead_s=house.commands.ahead_s,
        sent=recorder.sent,
        ended=recorder.ended,
    )
    endpoint = StopEndpoint(
        sender,
        remembered=house.access.remembered,
        hosts=Hosts("dray.test"),
        origin_port=8000,
        public_url="https://dray.example.com",
        wall_s=house.wall,
    )
    transport = httpx.ASGITransport(app=endpoint)
    async with httpx.AsyncClient(
        transport=transport, base_url="http://dray.test:8001", headers=BEARER
    ) as client:
        try:
            yield Way(house, sender, client)
        finally:
            sender.leave()
