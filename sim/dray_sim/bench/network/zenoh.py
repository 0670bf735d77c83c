"""Benchmark `zenoh`: the cost of the adapter beside bare Zenoh, between two processes on this computer.

All variants do the same: an asyncio program on each side sends a heartbeat to the other one and receives it on its
loop. Bare Zenoh carries bytes that were written beforehand and that no one decodes. The second baseline writes and
reads them too, with our codec. The adapter also numbers, judges and counts. With certificates, published messages are
signed and verified, and messages to one agent are encrypted and decrypted.

The second baseline is the fair one: any program on Zenoh must encode messages and decode them safely. The rest is the
cost of the adapter itself. The aim stands beside both.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import zenoh
from msgspec.structs import replace
from zenoh.handlers import Callback

from dray.adapters.addresses import free_addresses
from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.codec import decode, encode
from dray.errors import UnavailableError
from dray.messages import AtvHeartbeat
from dray.messages.kinds import Kind
from dray.ports import Session
from dray_sim.bench.network.bus import HEARTBEAT
from dray_sim.bench.row import Row, rates

ROUND_TRIPS = 2_000
MESSAGES = 20_000
"""Messages in one run: a second or less each."""

QUICK = 10
"""A quick run does a tenth."""

WINDOW = 500
"""Most messages under way: half a megabyte with seals, less than a link takes before it drops any."""

RECEIPT_EVERY = 100
"""Number of messages between two progress reports of the sink."""

MOST_OVER_FRAC = 0.2
"""The aim: a message costs at most a fifth more than with bare Zenoh."""

PATIENCE_S = 60.0
"""Longest time for the other process to start and to do a second's work, on a busy machine."""

PLANT = "bench"
HERE, RECEIPT, ECHO, SINK = "here", "receipt", "echo", "sink"

OnSample = Callable[[], None]


class Line(ABC):
    """A way of talking to the other process, used on a loop."""

    @abstractmethod
    def listen(self, name: str, on_sample: OnSample) -> None:
        """Call `on_sample` on the loop for every sample that comes for `name`."""

    @abstractmethod
    def say(self, to: str) -> None:
        """Say a heartbeat to `to`."""


class Bare(Line):
    """Zenoh alone, with the step that every asyncio program needs: cross from its threads to the loop."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session, self._loop = session, asyncio.get_running_loop()
        self._data = encode(HERE, HEARTBEAT)

    def listen(self, name: str, on_sample: OnSample) -> None:
        def cross(_: zenoh.Sample) -> None:
            self._loop.call_soon_threadsafe(on_sample)

        self._session.declare_subscriber(f"bare/{name}", Callback(cross, indirect=False))

    def say(self, to: str) -> None:
        self._session.put(f"bare/{to}", self._data)


class Read(Bare):
    """The same, with encoding and decoding of the messages."""

    def listen(self, name: str, on_sample: OnSample) -> None:
        def cross(sample: zenoh.Sample) -> None:
            decode(sample.payload.to_bytes())
            self._loop.call_soon_threadsafe(on_sample)

        self._session.declare_subscriber(f"read/{name}", Callback(cross, indirect=False))

    def say(self, to: str) -> None:
        self._session.put(f"read/{to}", encode(HERE, HEARTBEAT))


class Adapted(Line):
    """The adapter."""

    def __init__(self, bus: ZenohBus) -> None:
        self._bus = bus
        self._session: Session
        self._said: AtvHeartbeat

    def listen(self, name: str, on_sample: OnSample) -> None:
        self._session = self._bus.join(name, lambda _sender, _message: on_sample())
        self._said = replace(HEARTBEAT, atv=name)

    def say(self, to: str) -> None:
        self._session.send(to, self._said)


class Published(Adapted):
    """The adapter, with published messages."""

    def listen(self, name: str, on_sample: OnSample) -> None:
        super().listen(f"{name}-all", on_sample)
        self._session.subscribe(f"{PLANT}/{name}")

    def say(self, to: str) -> None:
        self._session.publish(f"{PLANT}/{to}", self._said)


class Caller:
    """This end of a line."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._answered = asyncio.Event()
        self._receipts = 0
        line.listen(HERE, self._answered.set)
        line.listen(RECEIPT, self._take_receipt)

    async def connect(self) -> None:
        """Return when the other end answers."""
        async with asyncio.timeout(PATIENCE_S):
            while not self._answered.is_set():
                self._line.say(ECHO)
                await asyncio.sleep(0.05)

    async def call(self, count: int) -> int:
        """Say something and wait for the echo, so many times."""
        for _ in range(count):
            self._answered.clear()
            self._line.say(ECHO)
            await self._answered.wait()
        return count

    async def flood(self, count: int) -> int:
        """Say as much as the other end can take; returns when it has heard all."""
        self._receipts = said = 0
        async with asyncio.timeout(PATIENCE_S):
            while self._receipts < count // RECEIPT_EVERY:
                self._answered.clear()
                while said < min(count, self._receipts * RECEIPT_EVERY + WINDOW):
                    self._line.say(SINK)
                    said += 1
                await self._answered.wait()
        return count

    def _take_receipt(self) -> None:
        self._receipts += 1
        self._answered.set()


@dataclass(frozen=True, slots=True)
class End:
    """The links of one of the two processes."""

    plain: Links
    sealed: Links

    async def open(self) -> list[Line]:
        """Bare Zenoh, the same with reading, the adapter, and that with certificates for all and for one reader.

        Call it on the running loop. They are closed with the process: a benchmark's is over soon.
        """
        plain, sealed = ZenohBus(self.plain, PLANT), ZenohBus(self.sealed, PLANT)
        return [Bare(plain.inner), Read(plain.inner), Adapted(plain), Published(sealed), Adapted(sealed)]


def measure(quick: bool) -> list[Row]:
    """Measure the adapter.

    Args:
        quick: a tenth of the work.
    """
    share = QUICK if quick else 1
    with tempfile.TemporaryDirectory() as folder, asyncio.Runner() as runner:
        this, other = _ends(Path(folder))
        with _running(other):
            bare, read, adapted, signed, sealed = runner.run(_callers(this))

            def compare(name: str, caller: Caller, baseline: Caller, against: str, *, aim: bool) -> list[Row]:
                trips, messages = ROUND_TRIPS // share, MESSAGES // share
                calls = rates(
                    lambda: runner.run(caller.call(trips)), lambda: runner.run(baseline.call(trips))
                )
                floods = rates(
                    lambda: runner.run(caller.flood(messages)), lambda: runner.run(baseline.flood(messages))
                )
                return [
                    _row(f"round trips{name}", calls, against, aim=aim),
                    _row(f"messages one way{name}", floods, against, aim=aim),
                ]

            return [
                *compare("", adapted, bare, "bare Zenoh", aim=True),
                *compare("", adapted, read, "bare Zenoh and the codec", aim=True),
                *compare(", TLS and signed", signed, bare, "bare Zenoh", aim=False),
                *compare(", TLS and encrypted for one reader", sealed, bare, "bare Zenoh", aim=False),
            ]


async def _callers(end: End) -> list[Caller]:
    callers = [Caller(line) for line in await end.open()]
    for caller in callers:
        await caller.connect()
    return callers


def _row(name: str, figures: tuple[float, float], against: str, *, aim: bool) -> Row:
    figure, baseline = figures
    note = f"{1e6 / figure:.0f} us each; {against}: {1e6 / baseline:.0f} us"
    target = baseline / (1 + MOST_OVER_FRAC) if aim else None
    return Row(f"zenoh: {name}", figure, "1/s", baseline, against, target, note)


def _ends(folder: Path) -> tuple[End, End]:
    """The ends of the lines, with certificates in `folder`; the first calls, the second listens."""
    authority = Authority.make(PLANT)
    authority.write(folder)
    names = (HERE, RECEIPT, ECHO, SINK)
    authority.issue(folder, PLANT, dict.fromkeys([*names, *(f"{name}-all" for name in names)], Kind.ATV))
    identity = Identity.in_folder(folder, HERE)
    plain, sealed = ((address,) for address in free_addresses(2))
    return (
        End(Links(peers=plain, plain=True), Links(peers=sealed, identity=identity)),
        End(Links(listen=plain, plain=True), Links(listen=sealed, identity=identity)),
    )


# --- the other process -----------------------------------------------------------------------------


@contextmanager
def _running(end: End) -> Iterator[None]:
    """The process at the other end; ended at the end."""
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    process = spawn.Process(target=_answer, args=(end, theirs), daemon=True)
    process.start()
    try:
        if not ours.poll(PATIENCE_S):
            raise UnavailableError("the other process", "has not started", "try again on a quieter machine")
        ours.recv()
        yield
    finally:
        process.terminate()
        process.join()


def _answer(end: End, ready: Connection) -> None:
    asyncio.run(_answer_on_loop(end, ready))


async def _answer_on_loop(end: End, ready: Connection) -> None:
    for line in await end.open():
        _answer_on_line(line)
    ready.send("ready")
    await asyncio.Event().wait()


def _answer_on_line(line: Line) -> None:
    heard = 0

    def count() -> None:
        nonlocal heard
        heard += 1
        if heard % RECEIPT_EVERY == 0:
            line.say(RECEIPT)

    line.listen(SINK, count)
    line.listen(ECHO, lambda: line.say(HERE))
