"""The console: commands that change access data directly in the database, with lines in the audit log."""

from __future__ import annotations

import asyncio
import getpass
import time
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

from dray.cli.runtime.options import load_settings
from dray.store import open_store
from dray.store.access.audit import AuditRow
from dray.store.work import Work

T = TypeVar("T")


def transact(db: str | None, work: Callable[[Work], Awaitable[T]]) -> T:
    """Run one transaction of the database.

    Args:
        db: its URL, if an option gave one.
        work: the work; undone when it raises.

    Raises:
        UnavailableError: the database cannot be opened.
    """
    return asyncio.run(_transact(load_settings(database_url=db).database_url, work))


async def reached_at(work: Work, url: str | None) -> str:
    """Where people reach the gateway, without a slash at the end.

    Args:
        work: a transaction of its database.
        url: the address that an option gave, if one did.

    Returns:
        That one, else DRAY_PUBLIC_URL, else where the newest gateway on the database was reached, else DRAY_HOST and
        DRAY_PORT.
    """
    settings = load_settings()
    here = f"http://{settings.host}:{settings.port}"
    return (url or settings.public_url or await work.addresses.newest() or here).rstrip("/")


async def note(work: Work, action: str, target: str, **detail: Any) -> None:
    """Write a line of the audit log, in the transaction of its action."""
    row = AuditRow(
        at_s=time.time(),
        who=account(),
        who_kind="console",
        action=action,
        target=target,
        result="done",
        detail=detail,
    )
    await work.audit.add(row)


async def _transact(url: str, work: Callable[[Work], Awaitable[T]]) -> T:
    store = await open_store(url)
    try:
        async with store.write() as transaction:
            return await work(transaction)
    finally:
        await store.close()


def account() -> str:
    """The user of this computer; empty if unknown."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return ""
