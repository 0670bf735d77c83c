"""The traffic log: each agent's right-of-way messages, a file each, for later analysis.

A line is written before a message is sent, or before a received one is handled. It survives any end of the process. Times are
those of the computer's monotonic clock, which its processes share, so lines of several files can be ordered.
`dray_sim.checks.floor.traffic_log_check` analyses them.
"""

from __future__ import annotations

import contextlib
import logging
import os
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec

from dray.adapters.telemetry.passing import PassingSession
from dray.codec import decode, encode
from dray.messages import (
    HoldsAsked,
    Message,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    YieldAsked,
    YieldRefused,
)
from dray.ports import Bus, Receive, Session

LOGGED = (PlaceRequested, PlaceGranted, PlaceConfirmed, HoldsAsked, YieldAsked, YieldRefused)

FILE_MAX_BYTES = 512 * 2**20
"""Maximum size of one agent's file: a day of a machine that keeps the table of a busy district. Then writing stops."""

SAID, HEARD = "said", "heard"

BEGUN = "begun"
"""A simulated floor has begun: no vehicle of an earlier one is left."""

_log = logging.getLogger(__name__)
_encode = msgspec.json.Encoder().encode


class Line(msgspec.Struct, frozen=True, omit_defaults=True):
    """One message that an agent has sent or received, or one observation of a vehicle on a simulated floor."""

    at_s: float
    """Time of the monotonic clock."""
    agent: str
    life: int = 0
    did: str = ""
    """`SAID`, `HEARD` or `BEGUN`; empty for an observation on the floor."""
    other: str = ""
    """The receiver or the sender."""
    envelope: msgspec.Raw = msgspec.Raw()
    """The message as on the wire."""
    lane: tuple[str, str] | None = None
    """The lane that the vehicle entered."""
    overlap: str = ""
    """Another vehicle in the same place."""

    @property
    def message(self) -> Message:
        """The message of the line.

        Raises:
            WireError: it is unreadable.
        """
        return decode(bytes(self.envelope))[1]


class TrafficLog:
    """A file of lines.

    Args:
        folder: created when missing.
        name: the file's name.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._file: int | None = None
        self._written = 0
        path = folder / f"{name}.jsonl"
        with self._given_up_on_error(path):
            folder.mkdir(parents=True, exist_ok=True)
            self._file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
            self._written = os.fstat(self._file).st_size
        self._path = path

    def write(self, line: Line) -> None:
        """Add a line by one call, so that a killed process leaves no partial line."""
        if self._file is None:
            return
        data = _encode(line) + b"\n"
        with self._given_up_on_error(self._path):
            if self._written + len(data) > FILE_MAX_BYTES:
                raise OSError(f"has {FILE_MAX_BYTES / 2**20:.0f} MiB")
            self._written += os.write(self._file, data)

    def close(self) -> None:
        """Write no more."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    @contextlib.contextmanager
    def _given_up_on_error(self, path: Path) -> Iterator[None]:
        """Stop logging after an error: it must not end an agent."""
        try:
            yield
        except OSError as error:
            _log.warning("%s is written no further: %s", path, error.strerror or error)
            self.close()


class TrafficLoggedSession(PassingSession):
    """One agent's session on the bus (see `dray.ports.Session`)."""

    def __init__(self, inner: Session, agent: str, life: int, log: TrafficLog) -> None:
        super().__init__(inner)
        self._agent, self._life, self._lines = agent, life, log

    def send(self, to: str, message: Message) -> None:
        """Log the message and send it to one agent alone."""
        if isinstance(message, LOGGED):
            self._lines.write(_line(self._agent, self._life, SAID, to, self._agent, message))
        self.inner.send(to, message)

    def leave(self) -> None:
        """Leave the bus."""
        self.inner.leave()
        self._lines.close()


class TrafficLoggedBus:
    """A bus that logs agents' right-of-way messages (see `dray.ports.Bus`).

    Args:
        bus: the bus itself.
        folder: for the files.
    """

    def __init__(self, bus: Bus, folder: Path) -> None:
        self._bus, self._folder = bus, folder

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        """See `dray.ports.Bus.join`."""
        log = TrafficLog(self._folder, agent)

        def on_message(sender: str, message: Message) -> None:
            if isinstance(message, LOGGED):
                log.write(_line(agent, life, HEARD, sender, sender, message))
            receive(sender, message)

        return TrafficLoggedSession(self._bus.join(agent, on_message, life), agent, life, log)


def read_traffic_log(folder: Path) -> list[Line]:
    """All lines of a folder by time; at equal times sent messages come before received ones.

    Raises:
        OSError: reading failed.
        msgspec.DecodeError: a line does not belong to such a log.
    """
    decoder = msgspec.json.Decoder(Line)
    lines = [
        decoder.decode(text)
        for file in sorted(folder.glob("*.jsonl"))
        for text in file.read_bytes().splitlines()
    ]
    return sorted(lines, key=lambda line: (line.at_s, line.did != SAID))


def _line(agent: str, life: int, did: str, other: str, sender: str, message: Message) -> Line:
    envelope = msgspec.Raw(encode(sender, message))
    return Line(time.monotonic(), agent, life, did, other, envelope)
