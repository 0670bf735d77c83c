"""The sender: signs stops, sends them, and awaits answers. Runs on the stop path's own loop.

It reads neither projection nor database: the vehicle knows its position, and the grant names the areas in
which its holder may stop vehicles. The grant's expiry is on the vehicle's own clock, so that a wrong clock
does not prevent a stop.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

from dray.adapters.security.signing import SigningKey
from dray.gateway.access.principal import Principal
from dray.gateway.factory.awaited import Awaited
from dray.gateway.factory.commands import STOP_VALID_S, granted, name_used, not_confirmed
from dray.gateway.live.timescale import TimeScale
from dray.messages import CommandAnswered, CommandKind, Message, VehicleCommand
from dray.ports import Bus, Session


@dataclass(frozen=True, slots=True)
class Stop:
    """A requested stop.

    Attributes:
        atv: the vehicle.
        said: the command without its grant.
        by: the caller.
        address: the caller's address.
        at_s: time of the request (wall clock).
    """

    atv: str
    said: VehicleCommand
    by: Principal
    address: str
    at_s: float

    @property
    def name(self) -> str:
        """The command's name."""
        return self.said.command


Ended = Callable[[Stop, CommandAnswered | None], None]
"""Called with a stop and the vehicle's answer."""


@dataclass(slots=True)
class _Sent:
    """A stop that was sent.

    Attributes:
        stop: the stop.
        answer: the vehicle's answer; None before it.
        is_over: whether nobody waits any more: it was answered, or given up.
        waiters: set when it is over, one for each caller: each has its own, so that an answer passes one turn
            of the loop and no more, and a caller that goes takes only its own.
    """

    stop: Stop
    answer: CommandAnswered | None = None
    is_over: bool = False
    waiters: list[asyncio.Future[None]] = field(default_factory=list)

    def end(self) -> None:
        """Wake all who wait."""
        self.is_over = True
        for waiter in self.waiters:
            if not waiter.done():
                waiter.set_result(None)


class StopSender:
    """Sends stops to vehicles.

    Args:
        bus: the agents' bus; it must call us on the running loop.
        name: the sender's name on the bus.
        incarnation: differs in every run of the gateway; the bus keeps the latest sender of this name.
        authority: signs the grants.
        time: plant clock and wall clock.
        wall_s: the wall clock.
        timeout_s: wall seconds to wait for the answer.
        ahead_s: plant seconds that a vehicle's clock is ahead; must not block.
        sent: called for every stop that goes out; must not block.
        ended: called with the outcome; None when the vehicle has not answered in time. Must not block.
    """

    def __init__(
        self,
        bus: Bus,
        *,
        name: str,
        incarnation: int,
        authority: SigningKey,
        time: TimeScale,
        wall_s: Callable[[], float],
        timeout_s: float,
        ahead_s: Callable[[str], float],
        sent: Callable[[Stop], None],
        ended: Ended,
    ) -> None:
        self._authority, self._time, self._wall_s = authority, time, wall_s
        self._timeout_s = timeout_s
        self._tell_sent, self._tell_ended, self._ahead_s = sent, ended, ahead_s
        self._sent: Awaited[_Sent] = Awaited(f"{name}.{incarnation}")
        self._session: Session = bus.join(name, self._on_message, incarnation)

    async def stop(
        self, atv: str, by: Principal, address: str, command: str | None = None
    ) -> CommandAnswered:
        """Send a stop to a vehicle, and wait for its answer.

        Args:
            atv: the vehicle; an unknown one never answers.
            by: the caller.
            address: the caller's address.
            command: the caller's name for the command, if any; one that was sent already is only waited for.

        Raises:
            Problem: 504, the vehicle does not answer in time; 503, too many commands wait; 409, another stop
                has this name.
        """
        name = command or self._sent.new_name()
        said = VehicleCommand(command=name, kind=CommandKind.STOP, issued_by=by.name)
        sent = self._sent.get(name)
        if sent is None:
            sent = self._say(Stop(atv, said, by, address, self._wall_s()))
        elif (sent.stop.atv, sent.stop.by.kind, sent.stop.by.id) != (atv, by.kind, by.id):
            raise name_used(name)
        return await self._wait(sent)

    def leave(self) -> None:
        """Leave the bus."""
        self._session.leave()

    def _say(self, stop: Stop) -> _Sent:
        self._sent.refuse_too_many(_who(stop.by))
        valid_s = STOP_VALID_S * self._time.speed
        until_s = self._time.to_plant_s(stop.at_s) + valid_s + self._ahead_s(stop.atv)
        sent = self._sent.keep(stop.name, _Sent(stop))
        self._tell_sent(stop)
        self._session.send(stop.atv, granted(self._authority, stop.atv, stop.said, stop.by, until_s))
        asyncio.get_running_loop().call_later(self._timeout_s, self._give_up, sent)
        return sent

    async def _wait(self, sent: _Sent) -> CommandAnswered:
        with self._sent.waiting(_who(sent.stop.by)):
            if not sent.is_over:
                waiter = asyncio.get_running_loop().create_future()
                sent.waiters.append(waiter)
                try:
                    await waiter
                finally:
                    sent.waiters.remove(waiter)
        if sent.answer is None:
            raise not_confirmed(sent.stop.atv, self._timeout_s)
        return sent.answer

    def _on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, CommandAnswered):
            return
        sent = self._sent.get(message.command)
        if sent is None or sent.stop.atv != sender or sent.answer is not None:
            return
        sent.answer = message
        sent.end()
        self._tell_ended(sent.stop, message)

    def _give_up(self, sent: _Sent) -> None:
        if not sent.is_over:
            sent.end()
            self._tell_ended(sent.stop, None)


def _who(by: Principal) -> str:
    return f"{by.kind}:{by.id}"
