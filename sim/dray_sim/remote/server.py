"""The floor's side: agents elsewhere use its bodies, one agent each; real vehicles report their picks and drops."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import msgspec
import zenoh
from zenoh.handlers import Callback

from dray.adapters.crossing import Crossing
from dray.adapters.remote_body.exchange import Exchange, Part
from dray.adapters.remote_body.questions import REFUSED
from dray.adapters.remote_body.wire import (
    NO_LIFE,
    BodyReport,
    BodySpec,
    Do,
    Moved,
    Taken,
    added_key,
    body_key,
    encode,
    from_part,
    moved_key,
    to_part,
)
from dray.adapters.spares import Spares
from dray.body import Report
from dray.errors import PlantError
from dray.ports import Body
from dray.supervision import Failures
from dray_sim.bodies.floor import Floor
from dray_sim.remote.pieces import pieces_key

TELL_EVERY_S = 0.1
"""Interval between two reports of an unchanged body: that of a panel's pose."""


@dataclass(frozen=True, slots=True)
class Traffic:
    """Counts of the messages between bodies and their agents.

    Attributes:
        bodies: how many there are, by whether an agent has them: TAKEN, FREE or LOST.
        reports: from bodies.
        waiting: reports without a known receipt.
        again: repetitions of reports.
        instructions: from agents.
        refused: messages without an effect, by reason.
    """

    bodies: Mapping[str, int]
    reports: int
    waiting: int
    again: int
    instructions: int
    refused: Mapping[str, int]


TAKEN, FREE, LOST = "taken", "free", "lost"
"""States of a body: a life of its agent has it; none has had it yet; one had it and has missed too much."""

EARLIER_LIFE, FULL = "of an earlier life", "a full queue"
"""Why a letter is refused."""


class FloorServer:
    """Lets agents elsewhere use the bodies of a floor, one agent each.

    Args:
        session: of the floor's process.
        plant: the plant's id.
        floor: its bodies; further ones are put down here.
        refusal: why one more body cannot be put down; by default there is no obstacle.
        foreign: vehicles that are not simulated: places count the picks and drops that they report. Their doubles
            here are off the floor, without agents. For any other vehicle only its body here counts.
        controlled: bodies with another use, as machines with controllers: they have no agents here.

    Attributes:
        failures: bodies whose state could not be reported, by our own fault; the others go on.

    Raises:
        KeyError: a foreign one is no vehicle of the floor.
    """

    def __init__(
        self,
        session: zenoh.Session,
        plant: str,
        floor: Floor,
        refusal: Callable[[BodySpec], str] = lambda _: "",
        foreign: Collection[str] = (),
        controlled: Collection[str] = (),
    ) -> None:
        self._session, self._plant, self._floor = session, plant, floor
        self._refusal = refusal
        self._crossing = Crossing(asyncio.get_running_loop())
        self.failures = Failures("the floor")
        self._moved: dict[str, tuple[tuple[int, int], bytes]] = {}
        """Newest transfer by life and number, and the answer, by foreign vehicle."""
        self._foreign = frozenset(foreign)
        for atv in self._foreign:
            floor.lift(atv)
            session.declare_queryable(body_key(plant, atv), _answering(self._crossing, _refuse_double))
        for machine in controlled:
            session.declare_queryable(
                body_key(plant, machine), _answering(self._crossing, _refuse_controlled)
            )
        others = {*self._foreign, *controlled}
        self._served = [
            self._serve(agent, body) for agent, body in floor.bodies.items() if agent not in others
        ]
        self._spares = Spares(session)
        answers = {
            added_key(plant): self._receive,
            moved_key(plant): self._follow,
            pieces_key(plant): self._count,
        }
        for key, answer in answers.items():
            session.declare_queryable(key, _answering(self._crossing, answer))
            self._spares.of_queryable(key)

    async def run(self) -> None:
        """Tell how all bodies are, until cancelled."""
        while True:
            await asyncio.sleep(TELL_EVERY_S)
            for served in self._served:
                try:
                    served.tell()
                except Exception:  # noqa: BLE001 - any error concerns this one body only
                    self.failures.note("telling how a body is")

    def end(self) -> None:
        """Let no agent have a body any more; its session may be closed then."""
        self._spares.end()
        for served in self._served:
            served.end()

    @property
    def traffic(self) -> Traffic:
        """The present counts."""
        served = self._served
        counts = sum((each.counts for each in served), Counter[str]())
        return Traffic(
            bodies=dict.fromkeys((TAKEN, FREE, LOST), 0) | Counter(each.state for each in served),
            reports=counts["reports"],
            waiting=sum(each.waiting for each in served),
            again=counts["again"],
            instructions=counts["instructions"],
            refused={
                EARLIER_LIFE: sum(each.refused for each in served),
                FULL: self._crossing.dropped_messages,
            },
        )

    def _serve(self, agent: str, body: Body) -> _Served:
        return _Served(self._session, self._crossing, body_key(self._plant, agent), body)

    def _receive(self, query: zenoh.Query) -> None:
        with query:
            data = b"" if query.payload is None else query.payload.to_bytes()
            spec = from_part(msgspec.msgpack.decode(data, type=Part))
            try:
                if spec.id not in self._floor.bodies:
                    if reason := self._refusal(spec):
                        query.reply_err(reason, encoding=REFUSED)
                        return
                    self._served.append(self._serve(spec.id, self._floor.add(spec)))
            except PlantError as error:
                query.reply_err(str(error), encoding=REFUSED)
            else:
                query.reply(added_key(self._plant), b"there")

    def _follow(self, query: zenoh.Query) -> None:
        with query:
            data = b"" if query.payload is None else query.payload.to_bytes()
            moved = msgspec.msgpack.decode(data, type=Moved)
            if moved.vehicle not in self._foreign:
                reason = f"{moved.vehicle} is simulated here; start the floor with it in DRAY_FOREIGN"
                query.reply_err(reason, encoding=REFUSED)
                return
            query.reply(moved_key(self._plant), self._counted(moved))

    def _counted(self, moved: Moved) -> bytes:
        """Count a transfer once, however often it is told."""
        if moved.action is None:
            return b""
        action = from_part(moved.action)
        number, before = (moved.life, action.order), self._moved.get(moved.vehicle)
        if before is None or before[0] < number:
            before = self._moved[moved.vehicle] = number, self._floor.follow(moved.vehicle, action).encode()
        return before[1]

    def _count(self, query: zenoh.Query) -> None:
        with query:
            query.reply(pieces_key(self._plant), encode(self._floor.count()))


class _Served:
    """One body, and the life of its agent that it obeys.

    Attributes:
        refused: letters of earlier lives.
    """

    def __init__(self, session: zenoh.Session, crossing: Crossing, key: str, body: Body) -> None:
        self._session, self._crossing, self._key, self._body = session, crossing, key, body
        self._life = NO_LIFE
        self._known = self._inherited = False
        """Whether any life has had it; and whether one had it before the life that has it now."""
        self._exchange = Exchange()
        self._past = Counter[str]()
        """Counts of earlier lives: sums must never fall."""
        self.refused = 0
        session.declare_queryable(key, _answering(crossing, self._answer))
        session.declare_subscriber(f"{key}/do", Callback(self._on_sample, indirect=False))
        self._spares = Spares(session)
        self._spares.of_queryable(key)
        self._spares.of_subscription(f"{key}/do")
        body.attach(self._report)

    @property
    def state(self) -> str:
        """Whether an agent has it."""
        if self._life:
            return TAKEN
        return LOST if self._known else FREE

    @property
    def waiting(self) -> int:
        """Reports that are not heard yet."""
        return self._exchange.kept

    @property
    def counts(self) -> Counter[str]:
        """Counts of all lives."""
        now = self._exchange
        return self._past + Counter(reports=now.said, again=now.again, instructions=now.heard)

    def tell(self) -> None:
        """Report its state and all unheard reports, if an agent has taken it over."""
        if self._life:
            told = BodyReport(self._life, self._exchange.write(), to_part(self._body.sense()))
            self._session.put(f"{self._key}/told", encode(told))

    def let_go(self) -> None:
        """Stop reporting and obeying, until the next life takes it over."""
        self._life = NO_LIFE

    def end(self) -> None:
        """Let go for good."""
        self._spares.end()
        self.let_go()

    def _report(self, report: Report) -> None:
        if self._exchange.full:
            self.let_go()  # The agent is dead or cut off, and has lost the body.
        if self._life:
            self._exchange.say(to_part(report))
            self.tell()

    def _on_sample(self, sample: zenoh.Sample) -> None:
        """Runs on Zenoh's threads."""
        self._crossing.offer(self._obey, sample.payload.to_bytes())

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            life = int(query.payload.to_string()) if query.payload is not None else NO_LIFE
            if life > self._life:
                self._past = self.counts
                self._inherited, self._known = self._known, True
                self._life, self._exchange = life, Exchange()
            query.reply(self._key, encode(Taken(to_part(self._body.sense()), self._life, self._inherited)))

    def _obey(self, data: bytes) -> None:
        done = msgspec.msgpack.decode(data, type=Do)
        if done.life != self._life:
            self.refused += 1
            return
        for instruction in self._exchange.read(done.letter):
            self._body.instruct(from_part(instruction))


def _refuse_double(query: zenoh.Query) -> None:
    with query:
        query.reply_err("it has a body of its own, as DRAY_FOREIGN says", encoding=REFUSED)


def _refuse_controlled(query: zenoh.Query) -> None:
    with query:
        reason = (
            "it is not used over the bus here: start its agent with the --body that the floor was started for, "
            "a machine's with the --mapping that the floor has written"
        )
        query.reply_err(reason, encoding=REFUSED)


def _answering(crossing: Crossing, answer: Callable[[zenoh.Query], None]) -> Callback[zenoh.Query]:
    """Answers on the loop; refuses at once, on Zenoh's thread, when the loop is too far behind."""

    def queue(query: zenoh.Query) -> None:
        if not crossing.offer(answer, query):
            with query:
                query.reply_err("too much waits there", encoding=REFUSED)

    return Callback(queue, indirect=False)
