"""The bus on many computers: `dray.ports.Bus` on Zenoh.

One process has one Zenoh session, and any number of agents on it: one for a vehicle, some for a gateway.

    publish  {key}                           all subscribers with a matching pattern
    send     {plant}/agent/@{to}             one agent: no wildcard matches a chunk with an @; with
                                            certificates only this agent can read it (`letters`)
    join     {plant}/alive/{agent}/{life}/…  a liveliness token: presence, and the life (`tokens`)

Two threads meet here. Agents call on their loop, and a call goes straight into Zenoh's queues, which never block.
Incoming messages are read and verified on Zenoh's threads, and cross to the loop by a bounded queue. `Crossing`
defines what is dropped when it is full.

Messages that a link cannot take are lost at the sender or on the way, where they cannot be counted. So every message
carries its number (`Stamp`), and its receiver counts the missing numbers.

A router may lose another one's declaration, so every session has spares of its own ones (`Spares`).
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import zenoh
from zenoh.handlers import Callback

from dray.adapters.crossing import Crossing
from dray.adapters.security.letters import Letters, Place
from dray.adapters.security.seals import Seals
from dray.adapters.spares import Spares
from dray.adapters.zenoh.shares import TALKATIVE, Shares, ShareSpentError
from dray.adapters.zenoh.stamp import Stamp, Tally, read_stamp, write_stamp
from dray.adapters.zenoh.tokens import NO_LIFE, Token, Tokens
from dray.codec import decode_with_context, encode
from dray.errors import NewerVersion, ProtocolViolation, SealError, SettingsError, WireError
from dray.messages.keys import Keys
from dray.messages.kinds import Kind
from dray.messages.speakers import SHUT_OUT, kind_in, objection
from dray.supervision import Failures

if TYPE_CHECKING:
    from dray.adapters.zenoh.links import Links
    from dray.messages import Message
    from dray.ports import Receive

log = logging.getLogger(__name__)

MAX_OWNERS = 10_000
"""Maximum keys for which a session remembers the pattern that receives them: ten times those of a plant of three hundred
agents."""

PRESENCE_S = 2.0
"""Longest wait for neighbours' answers; on healthy links they come in milliseconds."""

UNREADABLE = "no message of ours"
NEWER = "a newer wire version"
UNSEALED = "not signed by its sender"
FAILED = "a fault of ours"
ON_A_PATTERN = "said on a pattern"
"""Zenoh delivers that to whoever hears a matching key. Its access control does not deny it, and a pattern has no owner."""


class _ShutOutError(Exception):
    """A message of an excluded agent has come."""


class Heard(NamedTuple):
    """A verified incoming message."""

    sender: str
    message: Message
    context: str
    stamp: Stamp


class ZenohSession:
    """One agent's session on the bus (see `dray.ports.Session`)."""

    def __init__(
        self, bus: ZenohBus, agent: str, receive: Receive, life: int, arrivals: Crossing | None = None
    ) -> None:
        self.agent = agent
        self._beside = arrivals is not None
        self._arrivals = arrivals or bus.arrivals
        self.context = ""
        self._bus = bus
        self._receive = receive
        self._left = False
        self._replaced = False
        """Another life was seen. Told to the loop once, however many others come and go."""
        self._said: Counter[str] = Counter()
        """Number of messages on each key; keys are few: agents, cells, products, dwell points."""
        self._heard = Tally()
        self._shares = Shares(self._heard, bus.speed)
        self._patterns: dict[str, zenoh.KeyExpr] = {}
        self._subscribers: dict[str, zenoh.Subscriber[None]] = {}
        self._owners: dict[str, str] = {}
        """The pattern that receives a key, so that a second matching pattern does not deliver it twice."""
        self.life = life
        # For others the later one is this session's.
        spare, self.token = bus.tokens.pair_of(agent, life)
        keys, inner = bus.keys, bus.inner
        own = keys.addressed(agent)
        self._own = inner.declare_subscriber(own, bus.on_zenohs_thread(partial(self._on_sample, own)))
        self._others = inner.liveliness().declare_subscriber(
            bus.tokens.all_of(agent), bus.on_zenohs_thread(self._see_other), history=True
        )
        self._alive = inner.liveliness().declare_token(bus.tokens.key(self.token))
        self._spares = Spares(inner)
        self._spares.of_subscription(own)
        self._spares.of_token(bus.tokens.key(spare))

    def publish(self, key: str, message: Message) -> None:
        """Publish to all subscribers of `key`."""
        if "*" in key:
            raise ProtocolViolation(f"published on {key!r}: only subscriptions may hold wildcards")
        self._say(key, message)

    def send(self, to: str, message: Message) -> None:
        """Send to one agent alone."""
        self._say(self._bus.keys.addressed(to), message, to)

    def subscribe(self, key: str) -> None:
        """Hear what is published on `key` from now on."""
        if not self._left and key not in self._patterns:
            self._patterns[key] = zenoh.KeyExpr(key)
            self._owners = {}
            heard = self._bus.on_zenohs_thread(partial(self._on_sample_of, key))
            self._subscribers[key] = self._bus.inner.declare_subscriber(key, heard)
            self._spares.of_subscription(key)

    def unsubscribe(self, key: str) -> None:
        """Stop hearing it."""
        if key in self._patterns:
            self._spares.withdraw(key)
            self._subscribers.pop(key).undeclare()
            del self._patterns[key]
            self._owners = {}
            self._heard.forget()

    def leave(self) -> None:
        """Leave the bus; nothing is received after the return."""
        if self._left:
            return
        self._left = True
        self._spares.end()
        self._alive.undeclare()
        self._others.undeclare()
        self._own.undeclare()
        for pattern in tuple(self._patterns):
            self.unsubscribe(pattern)
        self._bus.forget(self)

    # --- on the agent's loop ---------------------------------------------------------------------

    def _say(self, key: str, message: Message, to: str = "") -> None:
        bus = self._bus
        if self._left or bus.is_excluded(self.agent, bus.shut_out):
            bus.unsaid += 1
            return
        number, data = self._said[key] + 1, encode(self.agent, message, self.context)
        seal = b""
        if bus.letters is not None and to:
            letter = bus.letters.write(self.agent, Place(to, self.life, number), data)
            if letter is None:
                bus.unaddressed += 1
                return
            data, seal = letter
        elif bus.seals is not None:
            seal = bus.seals.seal(key, self.life, number, data)
        self._said[key] = number
        bus.inner.put(key, data, attachment=write_stamp(Stamp(self.life, number, seal)))

    def _arrive(self, sender: str, message: Message, context: str) -> None:
        if not self._left:
            self._bus.delivered += 1
            self.context = context
            self._receive(sender, message)
            self.context = ""

    def _give_way(self) -> None:
        if not self._left:
            log.warning("%s has joined the bus elsewhere; this one leaves", self.agent)
            self.leave()
            if not self._beside:  # Otherwise this is not the loop of the `replaced` callback.
                self._bus.replaced(self.agent)

    # --- on Zenoh's threads ----------------------------------------------------------------------

    def _on_sample_of(self, pattern: str, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        if "*" in key:
            self._bus.refuse(ON_A_PATTERN)
            return
        owners = self._owners
        owner = owners.get(key)
        if owner is None:
            if len(owners) >= MAX_OWNERS:
                owners.clear()
            owner = owners[key] = self._owner(key)
        if owner == pattern:
            self._on_sample(key, sample)

    def _owner(self, key: str) -> str:
        """The first of all matching patterns; none any more for messages that were under way."""
        patterns = tuple(self._patterns.items())
        return next((name for name, pattern in patterns if pattern.includes(key)), "")

    def _on_sample(self, key: str, sample: zenoh.Sample) -> None:
        bus = self._bus
        heard = bus.read(key, sample, self._shares)
        if heard is not None:
            sender, message, context, stamp = heard
            with bus.lock:
                bus.missed += self._heard.skipped(sender, key, stamp)
            self._arrivals.say(message, self._arrive, sender, message, context)

    def _see_other(self, sample: zenoh.Sample) -> None:
        """Another life of this agent is or was there: the latest life is the agent."""
        if self._replaced or sample.kind != zenoh.SampleKind.PUT:
            return
        other = self._bus.tokens.read(str(sample.key_expr))
        if other is not None and other.replaces(self.token):
            self._replaced = True
            self._bus.meet(other)
            self._arrivals.order(self._give_way)


class ZenohBus:
    """One process's connection to the bus (see `dray.ports.Bus`).

    It must be used on the loop on which it was created.

    Args:
        links: opened by this call, which takes some 10 ms; closed by `close`.
        plant: the plant's id.
        replaced: called when an agent of this process has joined elsewhere, and has left here.
        speed: seconds of the plant's clock per second.

    Attributes:
        keys: the plant's.
        seals: the known agents; None on a bus without certificates.
        letters: encryption of messages to one agent; None on a bus without certificates.
        tokens: the tokens of present agents.
        inner: Zenoh's session.
        lock: guards the counts of Zenoh's threads.
        arrivals: incoming messages that wait for their agent; counts the dropped ones.
        delivered: messages that reached an agent.
        unsaid: messages of agents that had left, or that know of their exclusion.
        unaddressed: letters to absent agents, or to those without a known certificate.
        missed: messages lost on the way, by the numbers of later ones.
        refused: incoming messages that reached nobody, by reason; reasons are few and fixed.
        failures: incoming messages whose handling failed by our own fault.
        shut_out: excluded agents for this process; replaced as a whole.
    """

    def __init__(
        self,
        links: Links,
        plant: str,
        replaced: Callable[[str], None] = lambda _: None,
        speed: float = 1.0,
    ) -> None:
        self.keys = Keys(plant)
        self.speed = speed
        self.arrivals = Crossing(asyncio.get_running_loop())
        self.replaced = replaced
        self.delivered = 0
        self.unsaid = 0
        self.unaddressed = 0
        self.refused: Counter[str] = Counter()
        self.failures = Failures("the bus")
        self.shut_out: frozenset[str] = frozenset()
        self._sessions: dict[str, ZenohSession] = {}
        self.missed = 0
        self.lock = threading.Lock()
        self.seals = None if links.identity is None else Seals(links.identity, plant, speed=speed)
        self.letters = None if self.seals is None else Letters(self.seals)
        self.tokens = Tokens(self.keys.alive, self.seals, self.refuse)
        self.inner = links.open()
        self._present: zenoh.Subscriber[None] | None = None
        if self.seals is not None:
            # Possible readers of letters: every token contains a certificate.
            meet = self.on_zenohs_thread(self._meet)
            self._present = self.inner.liveliness().declare_subscriber(
                self.tokens.everybody, meet, history=True
            )

    def join(
        self, agent: str, receive: Receive, life: int = NO_LIFE, arrivals: Crossing | None = None
    ) -> ZenohSession:
        """See `dray.ports.Bus.join`; also when another life has joined in another process.

        Args:
            agent: its id.
            receive: called on the loop of `arrivals`.
            life: its incarnation.
            arrivals: the queue to the agent's own loop, where that is not the bus's.

        Raises:
            SettingsError: the process's certificate does not name the agent.
        """
        if self.seals is not None and kind_in(agent, self.seals.agents) is None:
            raise SettingsError(agent, f"the certificate names {', '.join(self.seals.agents)} only")
        before = self._sessions.get(agent)
        if before is not None and before.life <= life:
            before.leave()
            before = None
        if self.seals is not None:
            # An earlier life elsewhere may have been met, with another certificate.
            self.seals.register.meet(agent, life, self.seals.certificate)
        session = ZenohSession(self, agent, receive, life, arrivals)
        if before is None:
            self._sessions[agent] = session
        else:
            session.leave()
        return session

    @contextmanager
    def beside(self) -> Iterator[Beside]:
        """The same bus for agents on the running loop, which may be another thread's."""
        yield Beside(self)

    async def agents_present(self) -> frozenset[str]:
        """The agents present now, in any process, as far as the links reach."""
        present: set[str] = set()
        all_answered = asyncio.Event()

        def note(reply: zenoh.Reply) -> None:
            key = "" if reply.ok is None else str(reply.ok.key_expr)
            # An agent counts once, whatever the number of its tokens.
            if self.tokens.agent_of(key) not in {"", *present} and (token := self.tokens.read(key)):
                present.add(token.agent)

        def end() -> None:
            self.arrivals.order(all_answered.set)

        tokens = Callback(note, end, indirect=False)
        self.inner.liveliness().get(self.tokens.everybody, tokens, timeout=PRESENCE_S)
        await all_answered.wait()
        return frozenset(present)

    def forget(self, session: ZenohSession) -> None:
        """Remove a session that has left."""
        if self._sessions.get(session.agent) is session:
            del self._sessions[session.agent]

    def is_excluded(self, agent: str, shut_out: frozenset[str]) -> bool:
        """Whether a list excludes an agent. With certificates it excludes no gateway whose token was seen. Thread-safe."""
        if agent not in shut_out:
            return False
        known = None if self.seals is None else self.seals.register.known(agent)
        return known is None or kind_in(agent, known.agents) is not Kind.GATEWAY

    def read(self, key: str, sample: zenoh.Sample, shares: Shares) -> Heard | None:
        """An incoming message on `key` for one agent; None, and counted as refused, when it is not acceptable. Thread-safe."""
        shut_out = self.shut_out  # One snapshot for all checks: a readmission in between skips none.
        try:
            attachment = sample.attachment
            stamp = read_stamp(b"" if attachment is None else attachment.to_bytes())
            kind, sender, message, context = self._open(
                key, stamp, sample.payload.to_bytes(), shut_out, shares
            )
        except ShareSpentError:
            reason = TALKATIVE
        except _ShutOutError:
            reason = SHUT_OUT
        except NewerVersion:
            reason = NEWER
        except SealError:
            reason = UNSEALED
        except WireError:
            reason = UNREADABLE
        else:
            shares.note(sender, key, stamp, kind)
            reason = objection(sender, kind, key, message, shut_out)
            if not reason:
                return Heard(sender, message, context, stamp)
        self.refuse(reason)
        return None

    def _open(
        self, key: str, stamp: Stamp, data: bytes, shut_out: frozenset[str], shares: Shares
    ) -> tuple[Kind | None, str, Message, str]:
        """The kind of the sender, its verified name, the message, and its context.

        Raises:
            ShareSpentError: the sender has used up its share.
            _ShutOutError: the sender is excluded. This check precedes signatures and encryption, so that many such messages cost
                little.
            WireError: it is unreadable, or its sender is not the claimed one.
        """
        reader = self.keys.addressee(key)
        if self.seals is None or self.letters is None:
            return None, *decode_with_context(data)
        if not reader:
            sender, message, context = decode_with_context(data)
            if self.is_excluded(sender, shut_out):
                raise _ShutOutError
            shares.check(sender, key, stamp)
            kind = self.seals.examine(stamp.seal, sender, key, stamp.life, stamp.number, data)
            return kind, sender, message, context
        writer = self.letters.named(stamp.seal, data)
        if self.is_excluded(writer, shut_out):
            raise _ShutOutError
        shares.check(writer, key, stamp)
        writer, kind, words = self.letters.read(stamp.seal, Place(reader, stamp.life, stamp.number), data)
        sender, message, context = decode_with_context(words)
        if sender != writer:
            raise SealError(f"{writer} has written it", data)
        return kind, sender, message, context

    def _meet(self, sample: zenoh.Sample) -> None:
        """Process a token. On Zenoh's threads."""
        key = str(sample.key_expr)
        if (
            sample.kind == zenoh.SampleKind.PUT
            and self.tokens.brings_news(key)
            and (token := self.tokens.read(key))
        ):
            own = self._sessions.get(token.agent)
            # The agent is here, unless this life replaces it: then letters are to be for that one, also from here.
            if own is None or token.replaces(own.token):
                self.meet(token)

    def meet(self, token: Token) -> None:
        """Write letters to this life of an agent from now on. Thread-safe."""
        if self.seals is not None:
            self.seals.register.meet(token.agent, token.life, token.certificate)

    def refuse(self, reason: str) -> None:
        """Count an incoming message that reaches nobody. Thread-safe."""
        with self.lock:
            self.refused[reason] += 1

    def on_zenohs_thread(self, on_sample: Callable[[zenoh.Sample], None]) -> Callback[zenoh.Sample]:
        """Call it on the thread on which a sample comes in: without a thread and an unbounded queue in between.

        A failure is counted and logged: Zenoh would ignore it silently.
        """

        def served(sample: zenoh.Sample) -> None:
            try:
                on_sample(sample)
            except Exception:  # noqa: BLE001 - whatever it is, it is about this one sample
                self.failures.note("a sample")

        return Callback(served, indirect=False)

    def leave(self) -> None:
        """Let all agents leave; no declarations remain on the links."""
        for session in tuple(self._sessions.values()):
            session.leave()
        if self._present is not None:
            self._present.undeclare()
            self._present = None

    def close(self) -> None:
        """Let all agents leave, and close the links. Twice is harmless."""
        # Zenoh 1.10 panics in threads of two neighbours that close at once with something declared (`resource.rs:491`).
        self.leave()
        self.inner.close()


class Beside:
    """The bus for agents on another loop: incoming messages cross to that loop by a queue of their own.

    Args:
        bus: the process's bus.
    """

    def __init__(self, bus: ZenohBus) -> None:
        self._bus = bus
        self._arrivals = Crossing(asyncio.get_running_loop())

    def join(self, agent: str, receive: Receive, life: int = NO_LIFE) -> ZenohSession:
        """See `ZenohBus.join`; use the session on the loop on which this was created."""
        return self._bus.join(agent, receive, life, self._arrivals)
