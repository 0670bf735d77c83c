"""The network of the simulated factory: a `dray.ports.Bus` in one process, on virtual time.

Every delivery to every receiver is an event of its own on the clock, after a delay of its own. Chance
comes from the generator that is handed in and from nothing else, and receivers are gone through in the
order in which they joined, so one seed gives one run.

What a delivery meets on its way is decided in one place, `SimNetwork._carry`.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dray.codec import decode, encode
from dray.errors import ProtocolViolation

if TYPE_CHECKING:
    from collections.abc import Callable
    from random import Random

    from dray.messages import Message
    from dray.ports import Receive
    from dray_sim.loop import VirtualClock
    from dray_sim.trace import Ear

QUANTILE_BITS = 12
"""Delays are drawn from 2^12 quantiles: one table look-up instead of a logarithm per delivery. Finer
than 0.1 ms nearly everywhere, and no agent's timer is that fine."""

MAX_ROUTES = 10_000
"""Keys whose listeners are remembered: ten times those of a plant of three hundred agents."""


@dataclass(frozen=True, slots=True)
class Latency:
    """How long a message is under way: `base_s` plus an exponential part, at most `cap_s`.

    Attributes:
        base_s: what even an idle WLAN takes: two radio hops of some 2 ms, and the two stacks.
        mean_extra_s: waiting for air time and sending again; exponential, since each try is like the last.
        cap_s: WLAN stops trying again after about this time; longer than this is loss.
    """

    base_s: float = 0.005
    mean_extra_s: float = 0.015
    cap_s: float = 0.250

    def quantiles(self) -> list[float]:
        """2^QUANTILE_BITS delays in seconds, all equally likely."""
        n = 1 << QUANTILE_BITS
        middles = ((i + 0.5) / n for i in range(n))
        return [min(self.base_s - self.mean_extra_s * math.log1p(-p), self.cap_s) for p in middles]


WLAN = Latency()
"""A factory's WLAN on an ordinary day: half of all messages within 15 ms, one in a thousand above 110 ms."""


class SimSession:
    """One agent's place on the network (see `dray.ports.Session`)."""

    __slots__ = ("_arrivals", "_network", "agent", "deliver", "joined", "number", "receive")

    def __init__(self, network: SimNetwork, number: int, agent: str, receive: Receive) -> None:
        self._network = network
        self.number = number
        self.agent = agent
        self.receive = receive
        self.joined = True
        self.deliver = self._deliver
        """Bound once: it goes into the clock's heap with every delivery."""

    def publish(self, key: str, message: Message) -> None:
        """Say it to all that listen on `key`."""
        self._network.publish(self, key, message)

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent alone."""
        self._network.send(self, to, message)

    def subscribe(self, key: str) -> None:
        """Hear what is published on `key` from now on."""
        if self.joined:
            self._network.subscribe(self, key)

    def unsubscribe(self, key: str) -> None:
        """Hear it no longer."""
        self._network.unsubscribe(self, key)

    def leave(self) -> None:
        """Leave the network."""
        if self.joined:
            self._network.leave(self)

    def _deliver(self, sender: str, message: Message) -> None:
        if self.joined:
            self._network.delivered += 1
            self.receive(sender, message)
        else:
            self._network.missed += 1


class SimNetwork:
    """Where the simulated agents meet (see `dray.ports.Bus`).

    Args:
        clock: deliveries are its callbacks.
        random: the only source of chance.
        latency: how long messages are under way.
        codec: pass every message through the wire format. Slower, and the trace is the same.
        trace: a `Trace` or another ear; hears every utterance, whether or not anybody else does.

    Attributes:
        delivered: messages that reached an agent.
        missed: messages that found nobody: sent to or by an agent that is not, or no longer, there.
    """

    def __init__(
        self,
        clock: VirtualClock,
        random: Random,
        latency: Latency = WLAN,
        *,
        codec: bool = False,
        trace: Ear | None = None,
    ) -> None:
        self.delivered = 0
        self.missed = 0
        self._clock = clock
        self._draw = random.getrandbits
        self._delays_s = latency.quantiles()
        self._codec = codec
        self._trace = trace
        self._joins = 0
        self._sessions: dict[str, SimSession] = {}
        # Dicts for sets: they keep the order of insertion, and order is what makes runs repeatable.
        self._exact: dict[str, dict[SimSession, None]] = {}
        self._patterns: dict[str, tuple[Callable[[str], object], dict[SimSession, None]]] = {}
        self._routes: dict[str, tuple[SimSession, ...]] = {}
        # Grows to (agents that ever talked) x (agents they talked to), and no further: names are few.
        self._last_arrival_s: dict[tuple[str, str], float] = {}

    # --- the port --------------------------------------------------------------------------------

    def join(self, agent: str, receive: Receive) -> SimSession:
        """See `dray.ports.Bus.join`."""
        before = self._sessions.get(agent)
        if before is not None:
            self.leave(before)
        self._joins += 1
        session = SimSession(self, self._joins, agent, receive)
        self._sessions[agent] = session
        return session

    # --- what sessions ask -----------------------------------------------------------------------

    def publish(self, sender: SimSession, key: str, message: Message) -> None:
        """Carry `message` to all that listen on `key`."""
        if not sender.joined:
            self.missed += 1
            return
        message = self._utter(sender.agent, key, message)
        receivers = self._routes.get(key)
        if receivers is None:
            receivers = self._find_receivers(key)
        for receiver in receivers:
            self._carry(sender, receiver, message)

    def send(self, sender: SimSession, to: str, message: Message) -> None:
        """Carry `message` to one agent."""
        if not sender.joined:
            self.missed += 1
            return
        message = self._utter(sender.agent, f">{to}", message)
        receiver = self._sessions.get(to)
        if receiver is None:
            self.missed += 1
            return
        self._carry(sender, receiver, message)

    def subscribe(self, session: SimSession, key: str) -> None:
        """Let `session` hear `key`, which may hold wildcards."""
        if "*" not in key:
            self._exact.setdefault(key, {})[session] = None
            self._routes.pop(key, None)
            return
        if key not in self._patterns:
            self._patterns[key] = (compile_pattern(key), {})
        self._patterns[key][1][session] = None
        self._routes.clear()

    def unsubscribe(self, session: SimSession, key: str) -> None:
        """Let `session` hear `key` no longer."""
        if "*" not in key:
            listeners = self._exact.get(key, {})
            listeners.pop(session, None)
            if not listeners:
                self._exact.pop(key, None)
            self._routes.pop(key, None)
            return
        if key in self._patterns:
            listeners = self._patterns[key][1]
            listeners.pop(session, None)
            if not listeners:
                del self._patterns[key]
            self._routes.clear()

    def leave(self, session: SimSession) -> None:
        """Forget `session`; what is under way to it is dropped when it arrives."""
        session.joined = False
        if self._sessions.get(session.agent) is session:
            del self._sessions[session.agent]
        for key in [key for key, listeners in self._exact.items() if session in listeners]:
            self.unsubscribe(session, key)
        for key in [key for key, (_, listeners) in self._patterns.items() if session in listeners]:
            self.unsubscribe(session, key)

    # --- the way of a message --------------------------------------------------------------------

    def _utter(self, sender: str, address: str, message: Message) -> Message:
        if self._trace is not None:
            self._trace.hear(self._clock.time_s, sender, address, message)
        return decode(encode(sender, message))[1] if self._codec else message

    def _carry(self, sender: SimSession, receiver: SimSession, message: Message) -> None:
        """Decide the fate of one delivery: when it arrives. The one place for whatever can go wrong."""
        when_s = self._clock.time_s + self._delays_s[self._draw(QUANTILE_BITS)]
        # First in, first out between any two agents: a later message waits for an earlier slow one.
        pair = (sender.agent, receiver.agent)
        last_s = self._last_arrival_s.get(pair, 0.0)
        if when_s < last_s:  # noqa: PLR1730 (a call of max costs more than all of this)
            when_s = last_s
        self._last_arrival_s[pair] = when_s
        self._clock.call_at(when_s, receiver.deliver, sender.agent, message)

    def _find_receivers(self, key: str) -> tuple[SimSession, ...]:
        if "*" in key:
            raise ProtocolViolation(f"published on {key!r}: only subscriptions may hold wildcards")
        found = dict(self._exact.get(key, {}))
        for matches, listeners in self._patterns.values():
            if matches(key):
                found.update(listeners)
        # In the order of joining: who hears first must not hang on who subscribed how.
        receivers = tuple(sorted(found, key=lambda session: session.number))
        if len(self._routes) >= MAX_ROUTES:
            self._routes.clear()
        self._routes[key] = receivers
        return receivers


def compile_pattern(pattern: str) -> Callable[[str], object]:
    """Make a matcher of a key expression: ``*`` is one chunk, ``**`` any number of them, also none.

    Args:
        pattern: chunks joined by ``/``, as in Zenoh.

    Returns:
        A function of a key; what it returns is true when the pattern matches.
    """
    chunks = {"**": "(?:/[^/]+)*", "*": "/[^/]+"}
    parts = (chunks.get(chunk) or "/" + re.escape(chunk) for chunk in pattern.split("/"))
    match = re.compile("".join(parts)).fullmatch
    return lambda key: match("/" + key)
