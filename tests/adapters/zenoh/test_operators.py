"""Operators on a bus with certificates: whoever may speak for a gateway may speak for those on duty at its tablets, and nobody else may."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from zenoh_kit import PATIENCE_S, Row

from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.system_clock import SystemClock
from dray.adapters.zenoh.bus import ZenohBus
from dray.body import CallReplied, DutyState, ShowCalls
from dray.cli.runtime.gateway.operators import OperatorWorkers
from dray.errors import SettingsError
from dray.gateway.factory.duty import Tablet
from dray.gateway.live.timescale import TimeScale
from dray.messages import (
    OPERATOR_PREFIX,
    CallAnswer,
    CallAnswered,
    CallState,
    HelpCall,
    Message,
    OperatorHeartbeat,
)
from dray.messages.keys import Keys
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of

KEYS = Keys("p")

NAME = OPERATOR_PREFIX + "k3x7m2qa"


@pytest.fixture
def identities(tmp_path: Path) -> list[Identity]:
    """The certificates of a vehicle and of a gateway; neither names an operator."""
    authority = Authority.make("p")
    authority.write(tmp_path)
    authority.issue(tmp_path, "p", names_of("ATV1", Kind.ATV))
    authority.issue(tmp_path, "p", names_of("gateway", Kind.GATEWAY))
    return [Identity.in_folder(tmp_path, name) for name in ("ATV1", "gateway")]


class Willing(Tablet):
    """A person who takes every call."""

    def instruct(self, instruction: object) -> None:
        if isinstance(instruction, ShowCalls) and instruction.calls and self._report is not None:
            call = instruction.calls[0].call.call
            if instruction.calls[0].part == "asked":
                self._report(CallReplied(call=call, answer=CallAnswer.TAKE, wait_s=60.0))


class Vehicle:
    """One that calls whoever is on duty."""

    def __init__(self, bus: ZenohBus) -> None:
        self.answered: asyncio.Future[CallAnswered] = asyncio.get_running_loop().create_future()
        self._session = bus.join("ATV1", self._on_message, 1)
        self._session.subscribe(KEYS.all_operator_heartbeats)
        self._said = 0

    def _on_message(self, sender: str, message: Message) -> None:
        if isinstance(message, OperatorHeartbeat):
            self._said += 1
            call = HelpCall(
                call="ATV1-1-1",
                caller="ATV1",
                incarnation=1,
                number=self._said,
                at_s=0.0,
                state=CallState.ASKING,
                since_s=0.0,
                asked=(sender,),
            )
            self._session.publish(KEYS.call("ATV1"), call)
        elif isinstance(message, CallAnswered) and not self.answered.done():
            self.answered.set_result(message)


def test_an_operator_at_a_gateway_is_heard_asked_and_answers(identities: list[Identity]) -> None:
    async def main() -> CallAnswered:
        row = Row(2, identities=identities)
        clock = SystemClock(asyncio.get_running_loop())
        operators = OperatorWorkers(row.buses[1], KEYS, TimeScale(0.0, 0.0), clock.now_s)
        try:
            vehicle = Vehicle(row.buses[0])
            async with operators.running():
                tablet = Willing(DutyState(everywhere=True), 0.0)
                tablet.employed = operators.employ(NAME, tablet)
                return await asyncio.wait_for(vehicle.answered, PATIENCE_S)
        finally:
            row.close()

    answered = asyncio.run(main())
    assert (answered.operator, answered.answer, answered.call) == (NAME, CallAnswer.TAKE, "ATV1-1-1")


def test_a_vehicle_speaks_for_no_operator(identities: list[Identity]) -> None:
    async def main() -> None:
        row = Row(2, identities=identities)
        try:
            with pytest.raises(SettingsError):
                row.buses[0].join(NAME, lambda *_: None, 1)
        finally:
            row.close()

    asyncio.run(main())
