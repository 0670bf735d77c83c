"""Questions to the process of a body, and their timeouts."""

from __future__ import annotations

import asyncio

import zenoh
from zenoh.handlers import Callback

from dray.adapters.remote_body.wire import BodySpec, Moved, added_key, encode, moved_key, to_part
from dray.body import Drop, Pick
from dray.errors import UnavailableError

PATIENCE_S = 30.0
"""Longest wait for a floor, which may be starting, too. On a busy computer a restarted router may miss other processes'
declarations for the whole session (eclipse-zenoh/zenoh#1886). A process that gives up and is restarted finds the
floor."""

ANSWER_S = 3.0
"""Longest wait for one answer: the floor may be busy, or a relaying process may just have been killed."""

ASKED_TIMES = 10
"""Maximum attempts at a reachable floor without an answer: as long as the wait for a missing floor."""

AGAIN_S = 0.25
"""Delay between attempts at a missing floor."""

REFUSED = zenoh.Encoding.TEXT_PLAIN
"""The encoding of the floor's own refusals; Zenoh's errors, such as a timeout, have other encodings."""


async def ask_until_answered(session: zenoh.Session, key: str, question: bytes, what: str) -> bytes:
    """The answer of a floor, which may be starting, too.

    Raises:
        UnavailableError: nobody answers, or the floor refuses.
    """
    try:
        async with asyncio.timeout(PATIENCE_S):
            answer = await ask(session, key, question)
            while answer is None:
                await asyncio.sleep(AGAIN_S)
                answer = await ask(session, key, question)
    except TimeoutError:
        links = len(session.info.routers_zid())
        remedy = "start `dray floor` first; if it runs, see that its plant file has this and that DRAY_BUS_PEERS leads there"
        raise UnavailableError(what, f"nobody answers over {links} links", remedy) from None
    return answer


async def ask(session: zenoh.Session, key: str, question: bytes) -> bytes | None:
    """The answer; None when nobody is there, or when every attempt failed.

    A question or its answer may be lost like any relayed message, so a repeated question must change nothing.

    Raises:
        UnavailableError: the floor refuses.
    """
    for _ in range(ASKED_TIMES):
        reply = await _reply(session, key, question)
        if reply is None:
            return None
        if reply.ok is not None:
            return reply.ok.payload.to_bytes()
        if reply.err is not None and reply.err.encoding == REFUSED:
            refusal = reply.err.payload.to_string()
            raise UnavailableError(
                "the floor", f"refuses: {refusal}", "see which plant file and settings it has"
            )
    return None


async def _reply(session: zenoh.Session, key: str, question: bytes) -> zenoh.Reply | None:
    """The one reply to a question, possibly Zenoh's timeout error; None when nobody is there."""
    loop, end = asyncio.get_running_loop(), asyncio.Event()
    replies: list[zenoh.Reply] = []
    taken = Callback(replies.append, lambda: loop.call_soon_threadsafe(end.set), indirect=False)
    session.get(key, taken, payload=question, timeout=ANSWER_S)
    await end.wait()
    return replies[0] if replies else None


async def put_down(session: zenoh.Session, plant: str, spec: BodySpec) -> None:
    """Put a vehicle or a machine on a floor elsewhere, unless it stands there already.

    Raises:
        UnavailableError: there is no floor, or the body does not fit there.
    """
    await ask_until_answered(session, added_key(plant), encode(to_part(spec)), "the floor")


async def tell_moved(
    session: zenoh.Session, plant: str, vehicle: str, life: int, action: Pick | Drop | None = None
) -> str:
    """Tell a floor elsewhere about a pick or drop of a vehicle that is not simulated there.

    Args:
        session: the session of the agent's process.
        plant: the plant's id.
        vehicle: its id.
        life: its agent's life.
        action: the transfer; None only asks whether the floor counts for this vehicle.

    Returns:
        The reason why it is not counted; empty when it is.

    Raises:
        UnavailableError: there is no floor, or it does not count for this vehicle.
    """
    moved = Moved(vehicle, life, None if action is None else to_part(action))
    answer = await ask_until_answered(session, moved_key(plant), encode(moved), "the floor")
    return answer.decode()
