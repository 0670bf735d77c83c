"""A machine and a station that hear what people tell them, and who may tell them."""

from __future__ import annotations

import pytest
from gateway_kit import House

from dray.messages import CommandAnswered, CommandRefusal, MachineCommand, Message
from dray.plant import load_plant

FLOOR = load_plant("single-track")
MACHINE, STATION = "M1", next(iter(FLOOR.storages))

places = pytest.mark.parametrize("place", [MACHINE, STATION])


def area_of(place: str) -> str:
    """The first area in which a place lies."""
    return min(FLOOR.areas_near(*FLOOR.position_of(place), 0.0))


ELSEWHERE = next(area for area in FLOOR.areas if area not in {area_of(MACHINE), area_of(STATION)})
"""An area in which neither lies."""


def obedient(
    house: House, place: str, *, refusal: CommandRefusal | None = None, detail: str = ""
) -> list[MachineCommand]:
    """Let a place join and obey every command, or refuse it; the commands that it will have heard."""
    heard: list[MachineCommand] = []

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, MachineCommand):
            heard.append(message)
            answer = CommandAnswered(message.command, done=refusal is None, reason=refusal, detail=detail)
            house.bus.tell(place, sender, answer)

    house.bus.join(place, receive)
    return heard
