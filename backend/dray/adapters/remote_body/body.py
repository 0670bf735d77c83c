"""A body on a floor elsewhere, from its agent's side."""

from __future__ import annotations

import asyncio

import msgspec
import zenoh
from zenoh.handlers import Callback

from dray.adapters.crossing import Crossing
from dray.adapters.remote_body.exchange import Part
from dray.adapters.remote_body.exchanged import ExchangedBody
from dray.adapters.remote_body.questions import ask, ask_until_answered
from dray.adapters.remote_body.wire import (
    NO_LIFE,
    BodyReport,
    Do,
    Taken,
    body_key,
    encode,
    from_part,
    to_part,
)
from dray.adapters.spares import Spares
from dray.body import Instruction
from dray.errors import UnavailableError


class RemoteBody(ExchangedBody):
    """Implements `dray.ports.Body` for a body that is on a floor elsewhere.

    Args:
        session: the Zenoh session of the agent's process.
        plant: the plant's id.
        agent: the body's agent.
        life: a higher number than any life before; only the highest is obeyed.

    Attributes:
        is_new: whether no earlier life had this body; then an earlier life's commitments were about another body.
    """

    def __init__(self, session: zenoh.Session, plant: str, agent: str, life: int) -> None:
        super().__init__()
        self._session, self._key, self._life = session, body_key(plant, agent), life
        self._crossing = Crossing(asyncio.get_running_loop())
        self.is_new = False
        told = f"{self._key}/told"
        session.declare_subscriber(told, Callback(self._on_sample, indirect=False))
        self._spares = Spares(session)
        self._spares.of_subscription(told)

    async def connect(self) -> None:
        """Take over the body, and learn its state.

        Raises:
            UnavailableError: there is no floor, or no such body on it.
        """
        answer = await ask_until_answered(
            self._session, self._key, str(self._life).encode(), f"the body of {self._key.rpartition('@')[2]}"
        )
        taken = msgspec.msgpack.decode(answer, type=Taken)
        self._state, self.is_new = from_part(taken.state), not taken.known

    async def lost(self) -> None:
        """Wait until it is lost: its floor has ended or restarted, or one side has given up.

        A busy floor, or one whose link is cut for a while, answers when asked.
        """
        while True:
            await self._silence()
            if self._given_up or not await self._is_there():
                return

    async def _is_there(self) -> bool:
        """Whether the floor still has the body, for this life."""
        try:
            answer = await ask(self._session, self._key, str(NO_LIFE).encode())
        except UnavailableError:
            return True  # The answer that it is busy shows that it is there.
        return answer is not None and msgspec.msgpack.decode(answer, type=Taken).life == self._life

    def _part(self, instruction: Instruction) -> Part:
        return to_part(instruction)

    def _write(self) -> None:
        self._session.put(f"{self._key}/do", encode(Do(self._life, self._exchange.write())))

    def _on_sample(self, sample: zenoh.Sample) -> None:
        self._crossing.offer(self._take, sample.payload.to_bytes())

    def _take(self, data: bytes) -> None:
        told = msgspec.msgpack.decode(data, type=BodyReport)
        if told.life == self._life:
            self._told(from_part(told.state), map(from_part, self._exchange.read(told.letter)))
