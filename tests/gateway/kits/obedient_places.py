"""Machines and stations that hear what people tell them."""

from __future__ import annotations

from gateway_kit import House

from dray.messages import CommandAnswered, CommandRefusal, MachineCommand, Message


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
