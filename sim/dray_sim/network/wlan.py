"""The WLAN: a delivery's delay, its order, and the troubles of its link.

The network decides whether two agents have WLAN at all, and handles messages without it. While nothing is wrong it
uses `carry`, which asks for no fault and draws none of their chances.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from dray_sim.network.latency import QUANTILE_BITS, Latency

if TYPE_CHECKING:
    from collections import Counter
    from random import Random

    from dray.messages import Message
    from dray_sim.clock.loop import VirtualClock
    from dray_sim.network.links import Links
    from dray_sim.network.session import SimSession

AGAIN_S = 1.0
"""A second copy comes at most so much later: longer than any protocol waits before it repeats."""

HELD_UP_S = 2.0
"""A held-up message is late by at most so much: a heartbeat is overtaken by the next one or two."""

APART = "partition"
LOST = "link loss"


class Wlan:
    """All deliveries by WLAN.

    Args:
        clock: deliveries are its callbacks.
        random: the only source of chance for delays.
        latency: how long messages are under way.
        links: their faults.
        chance: the only source of chance for the effects of troubles.
        lost: where losses are counted, by reason.

    Attributes:
        doubled: second copies made by a link's trouble.
        held_up: messages that later ones might overtake.
    """

    def __init__(
        self,
        clock: VirtualClock,
        random: Random,
        latency: Latency,
        *,
        links: Links,
        chance: Random,
        lost: Counter[str],
    ) -> None:
        self.doubled = 0
        self.held_up = 0
        self._clock = clock
        self._draw = random.getrandbits
        self._delays_s = latency.quantiles()
        self._links = links
        self._chance = chance.random
        self._lost = lost
        # Grows to (agents that ever talked) x (agents they talked to), and no further: names are few.
        self._last_arrival_s: dict[tuple[str, str], float] = {}

    def carry(self, sender: SimSession, receiver: SimSession, message: Message) -> None:
        """Decide the fate of one delivery while nothing is wrong: when it arrives."""
        when_s = self._clock.time_s + self._delays_s[self._draw(QUANTILE_BITS)]
        # First in, first out between any two agents: a later message waits for an earlier slow one.
        pair = (sender.agent, receiver.agent)
        last_s = self._last_arrival_s.get(pair, 0.0)
        if when_s < last_s:  # noqa: PLR1730 (a call of max costs more than all of this)
            when_s = last_s
        self._last_arrival_s[pair] = when_s
        if sender.context:
            self._clock.call_at(when_s, receiver.deliver_with, sender.context, sender.agent, message)
        else:
            self._clock.call_at(when_s, receiver.deliver, sender.agent, message)

    def pass_link(self, start: str, end: str, arrive: Callable[..., None], *args: object) -> None:
        """Let something pass a link with all its troubles: it arrives in time, late, twice or never."""
        when_s = self._clock.time_s + self._delays_s[self._draw(QUANTILE_BITS)]
        troubles = self._links.troubles(start, end)
        if troubles is None:
            self._lost[APART] += 1
            return
        chance = self._chance
        held_up = copied = False
        for trouble in troubles:
            if trouble.loss_frac and chance() < trouble.loss_frac:
                self._lost[LOST] += 1
                return
            when_s += trouble.latency_s
            if trouble.jitter_s:
                when_s += trouble.jitter_s * chance()
            held_up = held_up or bool(trouble.reorder_frac and chance() < trouble.reorder_frac)
            copied = copied or bool(trouble.duplicate_frac and chance() < trouble.duplicate_frac)
        if held_up:
            self.held_up += 1
            when_s += HELD_UP_S * chance()
        else:
            pair = (start, end)
            when_s = max(when_s, self._last_arrival_s.get(pair, 0.0))
            self._last_arrival_s[pair] = when_s
        self._clock.call_at(when_s, arrive, *args)
        if copied:
            self.doubled += 1
            self._clock.call_at(when_s + AGAIN_S * chance(), arrive, *args)
