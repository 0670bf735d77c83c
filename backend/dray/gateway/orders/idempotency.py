"""Idempotency: the key under which a request may be sent again until it is answered."""

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
"""How long an Idempotency-Key is remembered: longer than any client tries again."""

AT_WORK = "key-at-work"
"""The problem of a request whose key is just being answered."""

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
    """Each caller has its own keys: another one's order is not to be had by guessing."""
    return digest(f"{caller.kind} {caller.id} {key}")


AtWork = dict[str, asyncio.Event]
"""Keys whose requests are being answered, and what tells that one has been."""


@asynccontextmanager
async def alone(at_work: AtWork, key: str, *, waits: bool = False) -> AsyncIterator[None]:
    """Let only one request at a time work under a key.

    Args:
        at_work: keys whose requests are being answered.
        key: of this request.
        waits: wait until the key is free, for a person who cannot send again what a program can.

    Raises:
        Problem: 409, another request works under the key, and this one does not wait.
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
    """Refuse a key that was used for another order.

    Raises:
        Problem: 422.
    """
    if kept.fingerprint != fingerprint:
        reason = f"it was used for another order ({kept.order_id}); take a new key for a new order"
        raise Problem(
            HTTPStatus.UNPROCESSABLE_ENTITY,
            "key-used",
            "The Idempotency-Key was used for another body",
            f"Idempotency-Key: {reason}",
            errors=(FieldError("Idempotency-Key", reason),),
        )


def key_at_work() -> Problem:
    """Another request with the key is being answered: 409."""
    return Problem(
        HTTPStatus.CONFLICT,
        AT_WORK,
        "A request with this Idempotency-Key is still being answered",
        "wait for its answer, or send the same request again in a second",
        headers={"Retry-After": "1"},
    )
