"""Idempotency: the key under which a request may be repeated until it is answered."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import Annotated

from fastapi import Header

from dray.gateway.access.principal import Principal
from dray.gateway.http.problems import FieldError, Problem
from dray.store.access.digest import digest
from dray.store.orders.idempotency_keys import KeptAnswer

KEYS_KEPT_S = 7 * 86_400.0
"""Seconds for which an Idempotency-Key is remembered: longer than any client retries."""

AT_WORK = "key-at-work"
"""Problem of a request whose key is in use."""

Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        pattern=r"^[\x21-\x7e]+$",
        description="Any text that is new for a new order. Sent again with the same body it gets the same "
        "answer, so an order can be sent until it is answered.",
    ),
]


def own_key(caller: Principal, key: str) -> str:
    """A caller's own form of a key, so that nobody gets another caller's order by guessing."""
    return digest(f"{caller.kind} {caller.id} {key}")


AtWork = dict[str, asyncio.Event]
"""Keys in use -> event set when the request has been answered."""


@asynccontextmanager
async def alone(at_work: AtWork, key: str, *, waits: bool = False) -> AsyncIterator[None]:
    """Let only one request at a time use a key.

    Args:
        at_work: keys in use.
        key: this request's key.
        waits: whether to wait for the key, for a person, who cannot retry like a program.

    Raises:
        Problem: 409, another request uses the key, and this one does not wait.
    """
    while key in at_work:
        if not waits:
            raise key_at_work()
        await at_work[key].wait()
    done = at_work[key] = asyncio.Event()
    try:
        yield
    finally:
        del at_work[key]
        done.set()


def refuse_other_body(kept: KeptAnswer, fingerprint: str) -> None:
    """Refuse a key that was used for another request.

    Raises:
        Problem: 422.
    """
    if kept.fingerprint != fingerprint:
        reason = f"it was used for another request ({kept.order_id}); take a new key for each new one"
        raise Problem(
            HTTPStatus.UNPROCESSABLE_ENTITY,
            "key-used",
            "The Idempotency-Key was used for another body",
            f"Idempotency-Key: {reason}",
            errors=(FieldError("Idempotency-Key", reason),),
        )


def key_at_work() -> Problem:
    """The problem, 409: another request with the key is in progress."""
    return Problem(
        HTTPStatus.CONFLICT,
        AT_WORK,
        "A request with this Idempotency-Key is still being answered",
        "wait for its answer, or send the same request again in a second",
        headers={"Retry-After": "1"},
    )
