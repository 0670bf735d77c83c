"""Invariant 10: what the station of a storage promises lies there."""

from __future__ import annotations

from dray.messages import Message, StationHeartbeat
from dray_sim.checks.broken import InvariantBroken


class PromisedLiesThere:
    """Asks it of every word that a station says about its stock."""

    def hear(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """Look at what is promised.

        Raises:
            InvariantBroken: more than lies there.
        """
        if type(message) is not StationHeartbeat:
            return
        for stock in message.stocks:
            if stock.promised > stock.level:
                seen = f"{sender} has promised {stock.promised} of the {stock.level} {stock.item} that it has"
                raise InvariantBroken(10, at_s, seen)
