"""A person on duty who answers calls at random: asked or not, with impossible times, and who never comes.

The worst that a person with a tablet can do to calls. When the quiet phase begins, all taken calls are given back.
"""

from __future__ import annotations

import asyncio
from math import inf
from random import Random

from dray.messages import (
    OPERATOR_PREFIX,
    CallAnswer,
    CallAnswered,
    CallState,
    DutyStatus,
    HelpCall,
    Message,
    OperatorHeartbeat,
)
from dray.messages.keys import Keys
from dray.ports import Bus, Clock

NAME = OPERATOR_PREFIX + "at-random"

BEAT_S = 5.0

LONGEST_WAIT_S = 45.0


class RandomAnswers:
    """Answers calls until cancelled.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        keys: the plant's.
        random: all chance.
    """

    def __init__(self, bus: Bus, clock: Clock, keys: Keys, random: Random) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._session.subscribe(keys.all_calls)
        self._clock, self._keys, self._random = clock, keys, random
        self._calls: dict[tuple[str, str], HelpCall] = {}
        self._said = 0

    async def meddle(self) -> None:
        """Be there, and answer."""
        while True:
            self._beat()
            for call in tuple(self._calls.values()):
                if self._random.random() < 0.5:
                    self._answer(call)
            await asyncio.sleep(BEAT_S)

    async def put_right(self) -> None:
        """Go off duty; callers that miss the message notice by themselves."""
        self._random = Random(0)
        self._beat(draining=True)
        self._session.leave()

    def _beat(self, *, draining: bool = False) -> None:
        self._said += 1
        heartbeat = OperatorHeartbeat(
            operator=NAME,
            incarnation=1,
            seq=self._said,
            at_s=self._clock.now_s(),
            status=self._random.choice(tuple(DutyStatus)),
            everywhere=True,
            draining=draining,
        )
        self._session.publish(self._keys.operator_heartbeat(NAME), heartbeat)

    def _answer(self, call: HelpCall) -> None:
        waits = None, 0.0, -5.0, 1e9, inf, self._random.uniform(1.0, LONGEST_WAIT_S)
        said = CallAnswered(
            call=call.call,
            operator=NAME,
            answer=self._random.choice(tuple(CallAnswer)),
            wait_s=self._random.choice(waits),
        )
        self._session.send(call.caller, said)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, HelpCall):
            if message.state is CallState.ENDED:
                self._calls.pop(message.subject, None)
            else:
                self._calls[message.subject] = message
