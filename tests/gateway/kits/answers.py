"""What is answered: by the gateway when something is wrong, and by a vehicle that is commanded."""

from __future__ import annotations

from typing import Any, cast

import httpx
from gateway_kit import House

from dray.messages import CommandAnswered, CommandRefusal, Message, VehicleCommand

PROBLEM = "application/problem+json"


def problem(response: httpx.Response, status: int, kind: str) -> dict[str, Any]:
    """The body of a problem, which says what is wrong, where, and what to do."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == PROBLEM
    body = cast(dict[str, Any], response.json())
    assert set(body) <= {"type", "title", "status", "detail", "instance", "errors"}
    assert body["type"] == f"urn:dray:problem:{kind}"
    assert body["status"] == status
    assert body["title"]
    assert body["detail"]
    # No database can be asked for a NUL (`Readable`).
    assert body["instance"] == response.request.url.path.replace("\0", "\ufffd")
    for error in body.get("errors", ()):
        assert {"field", "reason"} <= set(error) <= {"field", "reason", "code", "values"}
        assert error["field"]
        assert error["reason"]
    return body


def vehicle(
    house: House, atv: str = "ATV1", *, refusal: CommandRefusal | None = None
) -> list[VehicleCommand]:
    """Let a vehicle join that obeys every command, or refuses it; the commands that it will have heard."""
    heard: list[VehicleCommand] = []

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            heard.append(message)
            house.bus.tell(
                atv, sender, CommandAnswered(command=message.command, done=refusal is None, reason=refusal)
            )

    house.bus.join(atv, receive)
    return heard
