"""The controller of a dock, for tests: what docs/stations.md asks of one, around any body."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from dray.adapters.controller.letters import DO, TOLD, Done, Said, Told, encode, from_part, said, to_part
from dray.adapters.remote_body.exchange import Exchange
from dray.body import Report
from dray.ports import Body


class Controller:
    """Serves one body over a link.

    Args:
        body: what it controls.
        publish: called with a topic's last chunk and bytes.
    """

    def __init__(self, body: Body, publish: Callable[[str, bytes], None]) -> None:
        self._body, self._publish = body, publish
        self._exchange, self.life = Exchange(), 0
        body.attach(self._report)

    def on_link(self) -> None:
        self.tell()

    def on_link_lost(self, reason: str) -> None:
        """It goes on counting."""

    def on_message(self, topic: str, data: bytes) -> None:
        """Obey the highest life, and say at once how things are then."""
        if topic != DO:
            return
        done = msgspec.json.decode(data, type=Done)
        if done.life > self.life:
            self.life, self._exchange = done.life, Exchange()
        if done.life == self.life:
            for part in self._exchange.read(done.letter):
                self._body.instruct(from_part(part))
        self.tell()

    def tell(self) -> None:
        """Called once a second, too."""
        letter = self._exchange.write()
        state = Said(*to_part(self._body.sense()))
        told = Told(self.life, letter.heard, letter.first, said(letter), state=state)
        self._publish(TOLD, encode(told))

    def _report(self, report: Report) -> None:
        if self.life:
            self._exchange.say(to_part(report))
            self.tell()
