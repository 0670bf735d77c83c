"""The control socket of a running `dray fleet up`, in the fleet's folder, for its owner alone.

    asked     {"type": "Replace", "name": "ATV3", "software": {...}, "canary_tasks": 3}
    answered  {"type": "Replaced", "left_s": 1.8, "starts": 2}   or   {"type": "Refused", "reason": "..."}

One line each, one question per connection. A replacement that has begun is completed, even if nobody waits for the answer any
more.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from collections.abc import AsyncIterator, Iterator, Mapping
from pathlib import Path

import msgspec

from dray.cli.fleet.process_supervisor import Filling, ProcessSupervisor, Replaced
from dray.cli.fleet.software import Software
from dray.errors import UnavailableError

SOCKET = "fleet.socket"
"""The socket's name in the fleet's folder."""

BACKLOG = 4
"""Maximum waiting connections: people type these commands."""


class Replace(msgspec.Struct, frozen=True, tag=True):
    """Replace one process; all its later lives use this software, too."""

    name: str
    software: Software
    canary_tasks: int = 0
    at_once: bool = False


class Settle(msgspec.Struct, frozen=True, tag=True):
    """This process has passed its time as a canary."""

    name: str


class Kill(msgspec.Struct, frozen=True, tag=True):
    """Kill this process, and restart it after these real seconds."""

    name: str
    away_s: float


class Settled(msgspec.Struct, frozen=True, tag=True):
    """The answer to `Settle`."""


class Killed(msgspec.Struct, frozen=True, tag=True):
    """The process was killed."""


class Refused(msgspec.Struct, frozen=True, tag=True):
    """The request is impossible."""

    reason: str


Question = Replace | Settle | Kill
Answer = Replaced | Settled | Killed | Refused

_question: msgspec.json.Decoder[Question] = msgspec.json.Decoder(Question)
_answer: msgspec.json.Decoder[Answer] = msgspec.json.Decoder(Answer)


async def replace(folder: Path, wanted: Replace) -> Replaced | Refused:
    """Ask the folder's `dray fleet up` to replace a process, and wait until it has.

    Raises:
        UnavailableError: nobody answers.
    """
    answer = await _ask(folder, wanted)
    return answer if isinstance(answer, Replaced | Refused) else Refused("it answers something else")


async def settle(folder: Path, name: str) -> None:
    """Tell the folder's `dray fleet up` that a canary has passed.

    Raises:
        UnavailableError: nobody answers.
    """
    await _ask(folder, Settle(name))


async def kill(folder: Path, name: str, away_s: float) -> bool:
    """Ask the folder's `dray fleet up` to kill a process, and restart it later; False when it does not run.

    Args:
        folder: the fleet's folder.
        name: the process's name.
        away_s: real seconds before the restart.

    Raises:
        UnavailableError: nobody answers.
    """
    return isinstance(await _ask(folder, Kill(name, away_s)), Killed)


@contextlib.asynccontextmanager
async def controlled(folder: Path, supervisors: Mapping[str, ProcessSupervisor]) -> AsyncIterator[None]:
    """Answer other commands, as long as the context lasts.

    Args:
        folder: the fleet's folder, without another server.
        supervisors: the supervisors, by name.

    Raises:
        UnavailableError: no socket can be created in that folder.
    """
    at_work: set[asyncio.Task[None]] = set()

    def let_in(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        serving = asyncio.create_task(_serve(supervisors, reader, writer))
        at_work.add(serving)
        serving.add_done_callback(at_work.discard)

    server = await asyncio.start_unix_server(let_in, sock=_bound(folder), backlog=BACKLOG)
    try:
        yield
    finally:
        server.close()
        for each in at_work:
            each.cancel()
        (folder / SOCKET).unlink(missing_ok=True)


def _bound(folder: Path) -> socket.socket:
    """The socket, for its owner alone."""
    listener = socket.socket(socket.AF_UNIX)
    try:
        (folder / SOCKET).unlink(missing_ok=True)
        with _short(folder) as path:
            listener.bind(path)
        (folder / SOCKET).chmod(0o600)
    except OSError as error:
        listener.close()
        reason = f"no socket can be made there: {error.strerror or error}"
        raise UnavailableError(str(folder), reason, "choose another --folder") from None
    return listener


async def _serve(
    supervisors: Mapping[str, ProcessSupervisor], reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    with contextlib.closing(writer), contextlib.suppress(ConnectionError):
        try:
            question = _question.decode(await reader.readline())
            answer = await _obey(supervisors, question)
        except (msgspec.MsgspecError, ValueError) as error:
            answer = Refused(f"not understood: {error}")
        writer.write(msgspec.json.encode(answer) + b"\n")
        await writer.drain()


async def _obey(supervisors: Mapping[str, ProcessSupervisor], question: Question) -> Answer:
    supervisor = supervisors.get(question.name)
    if supervisor is None:
        return Refused("there is no such process")
    if isinstance(question, Settle):
        supervisor.settle()
        return Settled()
    if isinstance(question, Kill):
        return Killed() if supervisor.kill(question.away_s) else Refused("it does not run")
    filling = Filling(question.software, question.canary_tasks)
    try:
        return await supervisor.replace(filling, at_once=question.at_once)
    except OSError as error:
        return Refused(f"{question.software.python} cannot be started: {error.strerror or error}")


async def _ask(folder: Path, question: Question) -> Answer:
    try:
        with _short(folder) as path:
            reader, writer = await asyncio.open_unix_connection(path)
        with contextlib.closing(writer):
            writer.write(msgspec.json.encode(question) + b"\n")
            return _answer.decode(await reader.readline())
    except (OSError, msgspec.MsgspecError):
        remedy = "its processes go on; `dray fleet down` ends them"
        raise UnavailableError(f"the `dray fleet up` of {folder}", "does not answer", remedy) from None


@contextlib.contextmanager
def _short(folder: Path) -> Iterator[str]:
    """A path of the socket short enough for an address (unix(7): 107 bytes), for any depth of the folder."""
    handle = os.open(folder, os.O_PATH | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{handle}/{SOCKET}"
    finally:
        os.close(handle)
