"""Vehicles and machines that call for help at an open house, and who is on duty there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from fake_bus import KEYS, FakeSession
from gateway_kit import House
from msgspec.structs import replace
from open_house import OpenHouse
from puppets import Puppet

from dray.messages import CallAnswer, CallAnswered, CallState, HelpCall, Message, Problem, ProblemKind

BLOCKED = Problem(kind=ProblemKind.WAY_BLOCKED, passes=False, needs_person=True)

SOON_S = 3600.0
"""Browsers' clocks go on while that of the kit stands: nothing runs out in a test."""


class Calling:
    """Somebody who calls for help: says so, and takes whoever says to come.

    Args:
        house: where the call is heard.
        caller: its id.
        hears: what it does with all else that it is told.
        said: more of the call.
    """

    def __init__(self, house: House, caller: str, hears: Callable[[str, Message], None], **said: Any) -> None:
        self.answers: list[CallAnswer] = []
        self.quicker = ""
        """Who has it already when somebody takes it."""
        self._house, self._caller, self._hears = house, caller, hears
        first = HelpCall(
            call=f"{caller}-1-1",
            caller=caller,
            incarnation=1,
            number=0,
            at_s=0.0,
            state=CallState.RESTING,
            since_s=0.0,
            problem=BLOCKED,
            reason="a pallet on the lane",
        )
        self._call = replace(first, **said)
        house.bus.join(caller, self._on_message)

    def say(self, **said: Any) -> None:
        self._call = replace(self._call, number=self._call.number + 1, **said)
        FakeSession(self._house.bus, self._caller, self._on_message).publish(
            KEYS.call(self._caller), self._call
        )

    def _on_message(self, sender: str, message: Message) -> None:
        if isinstance(message, CallAnswered):
            self.answers.append(message.answer)
            if message.answer is CallAnswer.TAKE:
                by = self.quicker or sender
                self.say(state=CallState.TAKEN, taken_by=by, turn=1, asked=(), until_s=SOON_S)
        else:
            self._hears(sender, message)


def vehicle_calls(house: OpenHouse, vehicle: Puppet, **said: Any) -> Calling:
    """A vehicle whose way is blocked, where it is."""
    place = {"x_m": vehicle.x_m, "y_m": vehicle.y_m}
    return cast(
        "Calling", do(house, lambda inside: Calling(inside, vehicle.atv, vehicle.on_message, **place | said))
    )


def asks(house: OpenHouse, calling: Calling) -> str:
    """It asks the only one who is on duty."""
    [operator] = house.until(on_duty)
    do(house, lambda _inside: calling.say(state=CallState.ASKING, asked=(operator,), until_s=SOON_S))
    return cast("str", operator)


def do(house: OpenHouse, what: Callable[[House], Any]) -> Any:
    async def work(inside: House) -> Any:
        return what(inside)

    return house.do(work)


def on_duty(inside: House) -> list[str]:
    return [each.operator for each in inside.projection.people.on_duty(0.0)]
