"""The database: checks that it is reachable and writable, has the newest tables, and which key signs commands."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

from sqlalchemy import URL, make_url

from dray.cli.runtime.ready.finding import Finding, missing, ok, unknown
from dray.errors import UnavailableError
from dray.settings import Settings
from dray.store.database.database import Database
from dray.store.database.migrate import revisions
from dray.store.work import Store

SIGNER = "gateway"
"""The name of the signing key in the database, which all its gateways share."""


QUIET_S = 300.0
"""Maximum silence of the historian in seconds: for each agent heard it writes at least once a minute."""


async def database(settings: Settings, now_s: float) -> AsyncIterator[Finding]:
    """Findings about the database, and from it.

    Args:
        settings: its URL, and the keys that agents trust.
        now_s: unix time.
    """
    name, url = "database", make_url(settings.database_url)
    shown = url.set(drivername=url.get_backend_name()).render_as_string(hide_password=True)
    upgrade = f"dray db upgrade --db {shown}"
    if _lacks_file(url):
        yield missing(name, f"there is no file {url.database}", upgrade)
        return
    try:
        opened = await Database.open(settings.database_url)
    except UnavailableError as error:
        yield missing(name, f"{error.what}: {error.reason}", error.remedy)
        return
    try:
        found, newest, known = await revisions(opened)
        if found == newest:
            one = " (SQLite: for one computer)" if url.get_backend_name() == "sqlite" else ""
            yield ok(name, f"{shown}{one}: can be written, at migration {newest}")
            async with Store(opened).read() as work:
                yield _historian(await work.samples.newest_s(), now_s)
                yield _signing(await work.signing_keys.public(SIGNER), settings)
        elif known:
            yield missing(name, f"at migration {found or 'none'} and not {newest}", upgrade)
        else:
            yield missing(name, f"at migration {found}, which is of a newer Dray", "install that Dray")
    except UnavailableError as error:
        yield missing(name, f"{error.what}: {error.reason}", error.remedy)
    finally:
        await opened.close()


def _lacks_file(url: URL) -> bool:
    """Whether opening the database would create it."""
    return url.get_backend_name() == "sqlite" and not Path(url.database or "").is_file()


def _historian(newest_s: float | None, now_s: float) -> Finding:
    name, todo = "historian", "start dray historian with the same DRAY_DATABASE_URL; if it runs, see its log"
    if newest_s is None:
        return missing(name, "it has recorded no agent yet", todo)
    age_s = max(0.0, now_s - newest_s)
    if age_s > QUIET_S:
        return missing(name, f"it has recorded no agent for {age_s / 60:.0f} min", todo)
    return ok(name, "it records")


def _signing(public: str | None, settings: Settings) -> Finding:
    name, todo = (
        "signed commands",
        "print the key with dray key signing, and name it in DRAY_TRUSTED_KEYS of every agent",
    )
    if public is None:
        return missing(name, "no gateway has started with this database", "dray gateway, or dray key signing")
    if not settings.trusted_keys:
        seen = "DRAY_TRUSTED_KEYS is not set here: the keys that agents trust are unknown"
        return unknown(name, seen, todo)
    if public not in {each.lower() for each in settings.trusted_keys}:
        seen = "DRAY_TRUSTED_KEYS does not name the key of this database: agents refuse all commands"
        return missing(name, seen, todo)
    return ok(name, "DRAY_TRUSTED_KEYS names the key of this database")
