"""Bodies in one process and their agents in others: the floor of a factory whose agents are processes.

    agent's process                                the floor's process
    Body.instruct --> {plant}/body/@{agent}/do --> Body.instruct
    Body.attach  <-- {plant}/body/@{agent}/told <-- reports, and the state after them, ten times a second
    Body.sense   is the state that was told last
    put_down      -- query {plant}/floor/@newcomers: a body that the plant file does not know
    count_pieces  -- query {plant}/floor/@pieces -> all pieces that are there now
    connect       -- query {plant}/body/@{agent} -> the state now; from then on this life's word counts

A real vehicle has its body on its own computer, and wires lose nothing. The bus may: who passes on what others
say may be killed. So instructions and reports are said until they are heard (`Exchange`), and whichever side has
too much to say lets go of the other: no part is left out, and the next life begins with the state of the body. A
killed agent leaves its body behind as hardware is left behind: a loaded vehicle stays loaded, and drives its way
to the end.

What comes in crosses to the loop by a bounded queue (`Crossing`). A letter that finds no room there is said again; a
question is refused.

A floor that begins anew knows nothing of the one before. To an agent that has taken over its body there, it
says nothing, so that the agent finds its body lost; and to the next life it says that the body is new.

There is no seal on these keys: whoever is on the bus may move simulated bodies.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, get_args

import msgspec
import zenoh
from zenoh.handlers import Callback

from dray.adapters.crossing import Crossing
from dray.body import BodyState, Instruction, Report
from dray.errors import PlantError, UnavailableError
from dray.plant.model import MachineSpec, VehicleSpec
from dray.ports import Body
from dray_sim.exchange import Exchange, Letter, Part
from dray_sim.floor import Floor, Pieces

TELL_EVERY_S = 0.1
"""How often a body's state is told when nothing happens: as the pose on a panel is refreshed."""

PATIENCE_S = 30.0
"""Longest wait for a floor, which may be starting too."""

AGAIN_S = 0.25
"""The floor is asked so often."""

LOOK_EVERY_S = 1.0
SILENT_LOOKS = 10
"""A body is asked whether it is there when so many looks one after the other find that it has told nothing, which
it does ten times between two of them. A cut link is gone round sooner."""

REFUSED = zenoh.Encoding.TEXT_PLAIN
"""Of an answer that is the floor's own; Zenoh's, that nobody has answered in time, say, are of other encodings."""

NO_LIFE = b"0"
"""Asks how a body is, and takes nothing over."""

Newcomer = VehicleSpec | MachineSpec
"""What may be put down on a floor that runs already."""

_KINDS: dict[str, Any] = {
    kind.__name__: kind for union in (Instruction, Report, BodyState, Newcomer) for kind in get_args(union)
}


class _Do(msgspec.Struct, array_like=True, frozen=True):
    """Instructions of one life of an agent."""

    life: int
    letter: Letter


class _Taken(msgspec.Struct, array_like=True, frozen=True):
    """How a body is, which life has it now, and whether any life has had it before."""

    state: Part
    life: int
    known: bool


class _Told(msgspec.Struct, array_like=True, frozen=True):
    """What a body tells the life that has it: reports, and how it is after them."""

    life: int
    letter: Letter
    state: Part


_encode = msgspec.msgpack.Encoder().encode


def _part(what: object) -> Part:
    return type(what).__name__, msgspec.Raw(_encode(what))


def _of(part: Part) -> Any:
    kind, raw = part
    return msgspec.msgpack.decode(raw, type=_KINDS[kind])


def _newcomers(plant: str) -> str:
    return f"{plant}/floor/@newcomers"


def _pieces(plant: str) -> str:
    return f"{plant}/floor/@pieces"


def _key(plant: str, agent: str) -> str:
    # No wildcard matches a chunk with an @, so nobody hears this by listening to everything.
    return f"{plant}/body/@{agent}"


async def _asked(session: zenoh.Session, key: str, question: bytes, what: str) -> bytes:
    """The answer of a floor, which may be starting too.

    Raises:
        UnavailableError: nobody answers, or the floor refuses.
    """
    try:
        async with asyncio.timeout(PATIENCE_S):
            answer = await _answer(session, key, question)
            while answer is None:
                await asyncio.sleep(AGAIN_S)
                answer = await _answer(session, key, question)
    except TimeoutError:
        raise UnavailableError(what, "nobody answers", "start `dray floor` first") from None
    return answer


async def _answer(session: zenoh.Session, key: str, question: bytes) -> bytes | None:
    """What is answered now; None when nobody does.

    Raises:
        UnavailableError: the floor refuses.
    """
    loop, end = asyncio.get_running_loop(), asyncio.Event()
    answers: list[bytes] = []
    refusals: list[str] = []

    def take(reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            answers.append(reply.ok.payload.to_bytes())
        elif reply.err is not None and reply.err.encoding == REFUSED:
            refusals.append(reply.err.payload.to_string())

    taken = Callback(take, lambda: loop.call_soon_threadsafe(end.set), indirect=False)
    session.get(key, taken, payload=question, timeout=PATIENCE_S)
    await end.wait()
    if refusals:
        raise UnavailableError("the floor", f"refuses: {refusals[0]}", "see which plant file it has")
    return answers[0] if answers else None


class RemoteBody:
    """Implements `dray.ports.Body` for a body that is on a floor elsewhere.

    Args:
        session: of the agent's process.
        plant: the plant's id.
        agent: whose body it is.
        life: a higher number than that of any life before; only the highest is obeyed.

    Attributes:
        is_new: no earlier life has had it; what such a life was bound by is about another body.
    """

    def __init__(self, session: zenoh.Session, plant: str, agent: str, life: int) -> None:
        self._session, self._key, self._life = session, _key(plant, agent), life
        self._crossing = Crossing(asyncio.get_running_loop())
        self._exchange = Exchange()
        self._report: Callable[[Report], None] = _nobody_hears
        self._state: BodyState
        self._silent = False
        self._given_up = False
        """The floor lacks as many instructions as are kept; it is told no more."""
        self.is_new = False
        session.declare_subscriber(f"{self._key}/told", Callback(self._hear, indirect=False))

    async def connect(self) -> None:
        """Take over the body, and learn how it is.

        Raises:
            UnavailableError: there is no floor, or no such body on it.
        """
        answer = await _asked(
            self._session, self._key, str(self._life).encode(), f"the body of {self._key.rpartition('@')[2]}"
        )
        taken = msgspec.msgpack.decode(answer, type=_Taken)
        self._state, self.is_new = _of(taken.state), not taken.known

    async def lost(self) -> None:
        """Wait until it is there no more: its floor has ended or has begun anew, or one has given the other up.

        A floor that is only busy, or to which a link is cut for a while, answers when it is asked.
        """
        while True:
            await self._silence()
            if self._given_up or not await self._is_there():
                return

    async def _is_there(self) -> bool:
        """Whether the floor still has the body, and this life has it there."""
        try:
            answer = await _answer(self._session, self._key, NO_LIFE)
        except UnavailableError:
            return True  # It has no time for questions, and is there to say so.
        return answer is not None and msgspec.msgpack.decode(answer, type=_Taken).life == self._life

    async def _silence(self) -> None:
        """Wait until it has told nothing for a while, in looks and not in seconds: we may be held up ourselves."""
        looks = 0
        while looks < SILENT_LOOKS and not self._given_up:
            self._silent = True
            await asyncio.sleep(LOOK_EVERY_S)
            looks = looks + 1 if self._silent else 0

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. After an instruction that could not be kept, all are in vain: the body is lost."""
        self._given_up |= self._exchange.full
        if not self._given_up:
            self._exchange.say(_part(instruction))
            self._write()

    def sense(self) -> BodyState:
        """See `dray.ports.Body`: how it was at most `TELL_EVERY_S` ago."""
        return self._state

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    def _write(self) -> None:
        self._session.put(f"{self._key}/do", _encode(_Do(self._life, self._exchange.write())))

    def _hear(self, sample: zenoh.Sample) -> None:
        self._crossing.offer(self._take, sample.payload.to_bytes())

    def _take(self, data: bytes) -> None:
        told = msgspec.msgpack.decode(data, type=_Told)
        if told.life != self._life:
            return
        self._silent = False
        self._state = _of(told.state)
        for report in self._exchange.read(told.letter):
            self._report(_of(report))
        if self._exchange.due:
            self._write()


async def put_down(session: zenoh.Session, plant: str, spec: Newcomer) -> None:
    """Put a vehicle or a machine on a floor elsewhere, unless it stands there already.

    Raises:
        UnavailableError: there is no floor, or it does not fit there.
    """
    await _asked(session, _newcomers(plant), _encode(_part(spec)), "the floor")


async def count_pieces(session: zenoh.Session, plant: str) -> Pieces:
    """Count all pieces of a floor elsewhere.

    Raises:
        UnavailableError: there is no floor.
    """
    answer = await _asked(session, _pieces(plant), b"", "the floor")
    return msgspec.msgpack.decode(answer, type=Pieces)


class FloorServer:
    """Lets agents elsewhere use the bodies of a floor, one agent each.

    Args:
        session: of the floor's process.
        plant: the plant's id.
        floor: newcomers are put down here.
    """

    def __init__(self, session: zenoh.Session, plant: str, floor: Floor) -> None:
        self._session, self._plant, self._floor = session, plant, floor
        self._crossing = Crossing(asyncio.get_running_loop())
        self._served = [self._serve(agent, body) for agent, body in floor.bodies.items()]
        session.declare_queryable(_newcomers(plant), _asking(self._crossing, self._receive))
        session.declare_queryable(_pieces(plant), _asking(self._crossing, self._count))

    async def run(self) -> None:
        """Tell how all bodies are, until cancelled."""
        while True:
            await asyncio.sleep(TELL_EVERY_S)
            for served in self._served:
                served.tell()

    def _serve(self, agent: str, body: Body) -> _Served:
        return _Served(self._session, self._crossing, _key(self._plant, agent), body)

    def _receive(self, query: zenoh.Query) -> None:
        with query:
            data = b"" if query.payload is None else query.payload.to_bytes()
            spec = _of(msgspec.msgpack.decode(data, type=Part))
            try:
                if spec.id not in self._floor.bodies:
                    self._served.append(self._serve(spec.id, self._floor.add(spec)))
            except PlantError as error:
                query.reply_err(str(error), encoding=REFUSED)
            else:
                query.reply(_newcomers(self._plant), b"there")

    def _count(self, query: zenoh.Query) -> None:
        with query:
            query.reply(_pieces(self._plant), _encode(self._floor.count()))


class _Served:
    """One body, and the life of its agent that it obeys."""

    def __init__(self, session: zenoh.Session, crossing: Crossing, key: str, body: Body) -> None:
        self._session, self._crossing, self._key, self._body = session, crossing, key, body
        self._life, self._known = 0, False
        self._exchange = Exchange()
        session.declare_queryable(key, _asking(crossing, self._answer))
        session.declare_subscriber(f"{key}/do", Callback(self._hear, indirect=False))
        body.attach(self._report)

    def tell(self) -> None:
        """Say how it is, and what is not heard yet, if anybody has taken it over."""
        if self._life:
            told = _Told(self._life, self._exchange.write(), _part(self._body.sense()))
            self._session.put(f"{self._key}/told", _encode(told))

    def _report(self, report: Report) -> None:
        if self._exchange.full:
            self._life = 0  # Dead or cut off: it has lost its body.
        if self._life:
            self._exchange.say(_part(report))
            self.tell()

    def _hear(self, sample: zenoh.Sample) -> None:
        """On Zenoh's threads."""
        self._crossing.offer(self._obey, sample.payload.to_bytes())

    def _answer(self, query: zenoh.Query) -> None:
        with query:
            life = int(query.payload.to_string()) if query.payload is not None else 0
            known = self._known
            if life > self._life:
                self._life, self._known, self._exchange = life, True, Exchange()
            query.reply(self._key, _encode(_Taken(_part(self._body.sense()), self._life, known)))

    def _obey(self, data: bytes) -> None:
        done = msgspec.msgpack.decode(data, type=_Do)
        if done.life == self._life:
            for instruction in self._exchange.read(done.letter):
                self._body.instruct(_of(instruction))


def _asking(crossing: Crossing, answer: Callable[[zenoh.Query], None]) -> Callback[zenoh.Query]:
    """Answers on the loop; refuses at once, on Zenoh's thread, when the loop is too far behind."""

    def ask(query: zenoh.Query) -> None:
        if not crossing.offer(answer, query):
            with query:
                query.reply_err("too much waits there", encoding=REFUSED)

    return Callback(ask, indirect=False)


def _nobody_hears(report: Report) -> None:
    """What a body reports before its agent listens; its state tells it all the same."""
