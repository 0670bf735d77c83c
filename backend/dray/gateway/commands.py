"""Commands: what a person asks of a vehicle, and the vehicle's word on it.

A command is sent once and never queued: a person must know whether it was heard, and decide again.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from http import HTTPStatus

from dray.adapters.signing import SigningKey
from dray.gateway.access.principal import Principal
from dray.gateway.problems import Problem
from dray.messages import CommandAnswered, CommandKind, Message, VehicleCommand

STOP_VALID_S = 30.0
"""A stop that comes late, over a bad link, is still better than none."""

CLOCKS_S = 1.0
"""Everything else is good for as long as its answer is waited for, and so much longer, as clocks differ: who
was told that it is not confirmed must not see it obeyed later."""

PENDING = 1_000
"""Commands that wait for an answer at once: some per vehicle of the largest plant."""


class Commands:
    """Sends commands and pairs them with their answers.

    Args:
        send: says something to one agent.
        authority: grants what is sent.
        plant_s: the plant's clock.
        speed: plant seconds per wall second.
        name: begins the names of commands; differs in every life of the gateway.
        timeout_s: wall seconds to wait for the vehicle's word.
    """

    def __init__(
        self,
        send: Callable[[str, Message], None],
        *,
        authority: SigningKey,
        plant_s: Callable[[], float],
        speed: float,
        name: str,
        timeout_s: float,
    ) -> None:
        self._send, self._authority = send, authority
        self._plant_s, self._speed = plant_s, speed
        self._name, self._timeout_s = name, timeout_s
        self._pending: dict[str, tuple[str, asyncio.Future[CommandAnswered]]] = {}
        self._count = 0

    async def order(
        self,
        atv: str,
        kind: CommandKind,
        *,
        by: Principal,
        speed_frac: float | None = None,
        wait_s: float | None = None,
    ) -> CommandAnswered:
        """Send a command with a grant, and wait for the vehicle's word.

        Raises:
            Problem: 504 when the vehicle does not answer in time, 503 when too many are waiting.
        """
        if len(self._pending) >= PENDING:
            raise Problem(
                HTTPStatus.SERVICE_UNAVAILABLE,
                "too-many-commands",
                "Too many commands wait for an answer",
                f"{PENDING} vehicles were asked and have not answered yet; try again in some seconds",
                headers={"Retry-After": "3"},
            )
        self._count += 1
        command = f"{self._name}-{self._count}"
        said = VehicleCommand(
            command=command, kind=kind, speed_frac=speed_frac, wait_s=wait_s, issued_by=by.name
        )
        answer: asyncio.Future[CommandAnswered] = asyncio.get_running_loop().create_future()
        self._pending[command] = (atv, answer)
        try:
            self._send(atv, self._granted(atv, said, by))
            async with asyncio.timeout(self._timeout_s):
                return await answer
        except TimeoutError:
            raise Problem(
                HTTPStatus.GATEWAY_TIMEOUT,
                "not-confirmed",
                "Not confirmed by the vehicle",
                f"{atv} has not answered within {self._timeout_s:g} s: it may or may not have heard; look at it",
            ) from None
        finally:
            del self._pending[command]

    def _granted(self, atv: str, command: VehicleCommand, by: Principal) -> VehicleCommand:
        valid_s = STOP_VALID_S if command.kind is CommandKind.STOP else self._timeout_s + CLOCKS_S
        return self._authority.grant(
            atv,
            command,
            person=f"{by.kind}:{by.id}",
            areas=None if by.areas is None else sorted(by.areas),
            valid_until_s=self._plant_s() + valid_s * self._speed,
        )

    def answered(self, sender: str, answer: CommandAnswered) -> bool:
        """A vehicle has answered; returns whether somebody was waiting for it."""
        atv, future = self._pending.get(answer.command, ("", None))
        if future is None or future.done() or atv != sender:
            return False
        future.set_result(answer)
        return True
