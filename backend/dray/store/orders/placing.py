"""Placing: orders with their links, idempotency keys and audit lines, in one transaction.

An answered order is on disk with all that belongs to it, even if the process dies. Concurrent requests need no more statements than
one alone, and share its commit (`dray.store.database.together`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import msgspec
from sqlalchemy import Connection, delete

from dray.errors import DrayError
from dray.store.access.audit import AuditRow, row_of_line
from dray.store.access.digest import digest
from dray.store.database.database import Database
from dray.store.database.dialect import AtOnce
from dray.store.database.insertion import Insertion, Rows
from dray.store.database.together import Together
from dray.store.orders.idempotency_keys import KeptAnswer, known_answers
from dray.store.orders.orders import Order, rows_of_items, rows_of_orders
from dray.store.tables import audit, idempotency_keys, order_items, orders, tracking_links

FORGOTTEN_EVERY_S = 600.0
"""Wall seconds between two deletions of old keys, which are stored for days."""


_INSERTION = Insertion(
    *(orders, order_items, tracking_links, idempotency_keys, audit), once=idempotency_keys.c.key
)


class Placement(msgspec.Struct, frozen=True):
    """The result of preparing a request."""

    orders: Sequence[Order]
    """At least one."""
    answer: str
    """The answer to the request."""


class Wish(msgspec.Struct, frozen=True, kw_only=True):
    """A request to place orders."""

    key: str = ""
    """The Idempotency-Key; empty for none."""
    fingerprint: str = ""
    """A digest of the request."""
    prepare: Callable[[], Placement]
    """Creates the orders, or refuses them by a `DrayError`. It is called at this process's turn to write, so that times have the order of
    its commits; in another thread, and perhaps again. For a known key its result is dropped."""
    line: Callable[[str], AuditRow] | None = None
    """Makes the line of the audit log, from its subject."""


class Placed(msgspec.Struct, frozen=True):
    """The result of a wish."""

    orders: Sequence[Order] = ()
    """The new orders; empty when an earlier request with its key has placed them."""
    kept: KeptAnswer | None = None
    refused: DrayError | None = None
    """The refusal, with nothing written; None otherwise."""


class Placing:
    """Places orders.

    Args:
        database: the database.
        keys_kept_s: retention of keys, in seconds.
    """

    def __init__(self, database: Database, *, keys_kept_s: float) -> None:
        self._together: Together[Wish, Placed] = Together(database, self._write, self._at_once)
        self._keys_kept_s, self._forgotten_at_s = keys_kept_s, 0.0

    async def place(self, wish: Wish) -> tuple[Sequence[Order], KeptAnswer]:
        """Place orders once; they are on disk when this returns.

        Returns:
            The orders, none when an earlier request with its key has placed them; and the answer.

        Raises:
            DrayError: the wish's own refusal.
            UnavailableError: writing is impossible at present.
        """
        placed = await self._together.do(wish)
        if placed.kept is None:
            assert placed.refused is not None  # noqa: S101 - one of the two is
            raise placed.refused
        return placed.orders, placed.kept

    def _at_once(self, wishes: Sequence[Wish]) -> AtOnce[Sequence[Placed]] | None:
        """One statement for all wishes, if none is refused and no key must be deleted: the usual case."""
        done = [_placed(wish, None) for wish in wishes]
        rows = _rows(wishes, done)
        if self._is_time(rows) or any(placed.refused for placed in done):
            return None
        return _INSERTION.at_once(rows, [wish.key for wish in wishes if wish.key], done)

    def _write(self, connection: Connection, wishes: Sequence[Wish]) -> Sequence[Placed]:
        known = known_answers(connection, [wish.key for wish in wishes if wish.key])
        done = [_placed(wish, known.get(wish.key)) for wish in wishes]
        rows = _rows(wishes, done)
        if rows.orders or rows.lines:
            _INSERTION.write(connection, rows)
        if self._is_time(rows):
            self._forget(connection, rows)
        return done

    def _is_time(self, rows: _Rows) -> bool:
        """Whether old keys must be deleted now."""
        return bool(rows.keys) and abs(_at_s(rows) - self._forgotten_at_s) >= FORGOTTEN_EVERY_S

    def _forget(self, connection: Connection, rows: _Rows) -> None:
        self._forgotten_at_s = _at_s(rows)
        too_old = idempotency_keys.c.at_s < self._forgotten_at_s - self._keys_kept_s
        connection.execute(delete(idempotency_keys).where(too_old))


class _Rows(NamedTuple):
    """Rows of the tables, in the order of writing."""

    orders: Rows
    items: Rows
    links: Rows
    keys: Rows
    lines: Rows


def _placed(wish: Wish, known: KeptAnswer | None) -> Placed:
    if known is not None:
        return Placed(kept=known)
    try:
        placement = wish.prepare()
    except DrayError as error:
        return Placed(refused=error)
    first = placement.orders[0]
    kept = KeptAnswer(wish.key, wish.fingerprint, first.id, placement.answer, first.created_at_s)
    return Placed(placement.orders, kept)


def _rows(wishes: Sequence[Wish], done: Sequence[Placed]) -> _Rows:
    new = [order for placed in done for order in placed.orders]
    answers = [placed.kept for placed in done if placed.orders and placed.kept and placed.kept.key]
    return _Rows(
        orders=rows_of_orders(new),
        items=rows_of_items(new),
        links=[
            {
                "token_hash": digest(order.token),
                "order_id": order.id,
                "created_at_s": order.created_at_s,
                "expires_at_s": None,
                "revoked_at_s": None,
            }
            for order in new
        ],
        keys=[msgspec.structs.asdict(answer) for answer in answers],
        lines=[
            row_of_line(wish.line(placed.kept.order_id))
            for wish, placed in zip(wishes, done, strict=True)
            if wish.line and placed.kept and placed.kept.fingerprint == wish.fingerprint
        ],
    )


def _at_s(rows: _Rows) -> float:
    """The time of the first key."""
    at_s = rows.keys[0]["at_s"]
    assert isinstance(at_s, float)  # noqa: S101 - as its table has it
    return at_s
