"""A dock's controller as the body of its agent."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

import msgspec

from dray.adapters.controller.letters import DO, TOLD, Done, Told, encode, from_part, said, to_part
from dray.adapters.remote_body.exchange import Part
from dray.adapters.remote_body.exchanged import ExchangedBody
from dray.body import Instruction, StorageState
from dray.body.gate import GateState

_log = logging.getLogger(__name__)


class ControllerBody(ExchangedBody):
    """Implements `dray.ports.Body` and the listener of a link.

    A controller's unreadable message changes nothing: it is logged, and the controller repeats it until it is confirmed.

    Args:
        life: the agent's life, higher than all before.
        senses: the type of its state.
        publish: called with a topic's last chunk and bytes.

    Attributes:
        refused: number of unreadable letters.
    """

    def __init__(
        self,
        life: int,
        senses: type[StorageState | GateState],
        publish: Callable[[str, bytes], None],
    ) -> None:
        super().__init__()
        self._life, self._senses, self._publish = life, senses, publish
        self._known = asyncio.Event()
        self.refused = 0

    async def known(self) -> None:
        """Wait until the controller has accepted this life and sent its state."""
        await self._known.wait()

    async def lost(self) -> None:
        """Wait until the controller is silent, has restarted, or serves another life."""
        await self._silence()

    # --- the listener of a link ---

    def on_link(self) -> None:
        """Tell the controller this life's number when the broker is connected."""
        self._write()

    def on_link_lost(self, reason: str) -> None:
        """The connection to the broker is lost."""
        _log.warning("no controller: %s", reason)

    def on_message(self, topic: str, data: bytes) -> None:
        """Read a letter of the controller."""
        if topic != TOLD:
            return
        try:
            told = msgspec.json.decode(data, type=Told)
            state = from_part((told.state.type, told.state.about))
            if type(state) is not self._senses:
                raise msgspec.ValidationError(f"a state is a {self._senses.__name__}")
            # Check all of it before any of it counts as heard.
            for part in told.parts:
                from_part((part.type, part.about))
        except msgspec.DecodeError as error:
            self.refused += 1
            _log.error("a letter of the controller is no letter: %s", error)
            return
        if told.life != self._life:
            # A restarted controller has lost what it heard; or another life of ours has it now.
            self._given_up = self._known.is_set() or told.life > self._life
            if not self._given_up:
                self._write()
            return
        self._told(state, map(from_part, self._exchange.read(told.letter)))
        self._known.set()

    # --- letters ---

    def _part(self, instruction: Instruction) -> Part:
        return to_part(instruction)

    def _write(self) -> None:
        letter = self._exchange.write()
        self._publish(DO, encode(Done(self._life, letter.heard, letter.first, said(letter))))
