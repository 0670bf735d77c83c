"""`dray user` and `dray key`: who may log in, and what other systems may do, in the database that a gateway uses."""

from __future__ import annotations

import asyncio
import io
import re
import sys
import time
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

import pytest
from argon2 import PasswordHasher
from variants import later, variants

from dray.adapters.security.signing import TrustedKeys
from dray.cli.commands.administration import key as key_command
from dray.gateway.access.login.hasher import Hasher
from dray.gateway.access.login.login import BADGE_SALT
from dray.gateway.routes.keys import KEY_OPEN_MOST, NAMES_MAX
from dray.store import Work, open_store
from dray.store.access.audit import AuditFilter
from dray.store.access.login_links import LoginLink
from dray.store.access.people import Person
from dray.store.access.sessions import Session

T = TypeVar("T")

Run = Callable[..., tuple[int, str, str]]

WORDS = "four words are good"

CHEAP = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)


@pytest.fixture
def dray(call: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch, database: str) -> Run:
    """Run a command on that database, with this on its standard input: exit code, stdout, stderr."""
    monkeypatch.setenv("COLUMNS", "160")
    monkeypatch.setattr("dray.gateway.access.login.hasher.PasswordHasher", lambda: CHEAP)

    def run(*args: str, typed: str = "") -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "stdin", io.StringIO(typed))
        return call(*args, "--db", database)

    return run


def look(database: str, work: Callable[[Work], Awaitable[T]]) -> T:
    async def read() -> T:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        try:
            async with store.write() as transaction:
                return await work(transaction)
        finally:
            await store.close()

    return asyncio.run(read())


def person(database: str, name: str) -> Person | None:
    return look(database, lambda work: work.people.get(name))


def audited(database: str) -> list[tuple[str, str, str, str]]:
    rows = look(database, lambda work: work.audit.page(AuditFilter(), None, 100))
    return [(row.who_kind, row.action, row.target, row.result) for row in reversed(rows)]


@pytest.fixture
def ana(dray: Run) -> None:
    assert dray("user", "add", "ana", "--area", "AREA1", "--called", "Ana at the presses")[0] == 0


@pytest.fixture
def boss(dray: Run) -> None:
    assert dray("user", "add", "boss", "--role", "manager")[0] == 0


def test_somebody_new_is_kept_and_listed(dray: Run, database: str, ana: None, boss: None) -> None:
    kept = person(database, "ana")
    assert kept is not None
    assert (kept.name, kept.role, kept.areas) == ("Ana at the presses", "operator", ("AREA1",))
    assert not kept.has_secret
    _, out, _ = dray("user", "list")
    ana_line, boss_line = (
        next(line for line in out.splitlines() if line.split()[:1] == [x]) for x in ("ana", "boss")
    )
    assert "AREA1" in ana_line
    assert "by link only" in ana_line
    assert "everywhere" in boss_line
    assert audited(database) == [
        ("console", "user.add", "ana", "done"),
        ("console", "user.add", "boss", "done"),
    ]


def test_the_public_key_of_gateways_is_printed_and_stays_the_same(dray: Run, database: str) -> None:
    code, out, _ = dray("key", "signing")
    assert code == 0
    assert re.fullmatch(r"[0-9a-f]{64}\n", out)
    assert dray("key", "signing")[1] == out
    TrustedKeys(bytes.fromhex(out.strip()))


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("add", "ana", "--area", "AREA1"), "already"),
        *later(
            (("add", "Ana", "--area", "AREA1"), "small letters"),
            (("add", "a b", "--area", "AREA1"), "small letters"),
            (("add", "x" * 65, "--area", "AREA1"), "small letters"),
        ),
        (("add", "eva"), "an operator needs one"),
        (("add", "eva", "--area", "AREA9"), "no 'AREA9'; choose of AREA1, AREA2"),
        (("add", "eva", "--role", "emperor"), "manager, operator"),
        (("add", "eva", "--role", "manager", "--area", "AREA1"), "a manager works everywhere"),
        (("password", "ana"), "dray user pin"),
        *later(
            (("pin", "eva"), "there is no 'eva'"),
            (("link", "eva"), "there is no 'eva'"),
        ),
        (("disable", "eva"), "there is no 'eva'"),
        (("link", "ana", "--hours", "0"), "--hours"),
    ],
)
def test_what_cannot_be_is_refused_and_changes_nothing(
    dray: Run, database: str, ana: None, args: tuple[str, ...], told: str
) -> None:
    before = audited(database)
    code, out, err = dray("user", *args, typed=f"{WORDS}\n")
    assert (code, out) == (2, "")
    assert told in err
    assert audited(database) == before


def test_a_password_is_kept_as_a_hash_and_ends_what_was_before(dray: Run, database: str, boss: None) -> None:
    async def log_in(work: Work) -> None:
        session = Session(id="s", person_id="boss", created_at_s=1.0, used_at_s=1.0, expires_at_s=1e10)
        await work.sessions.add("token", session)
        await work.login_links.add("link", LoginLink("boss", 1.0, 1e10))

    look(database, log_in)
    code, out, err = dray("user", "password", "boss", typed=f"{WORDS}\n")
    assert (code, err) == (0, "")
    assert WORDS not in out
    kept = person(database, "boss")
    assert kept is not None
    assert kept.password_hash is not None
    assert CHEAP.verify(kept.password_hash, WORDS)

    async def left(work: Work) -> tuple[Any, bool]:
        session = await work.sessions.find("token")
        return session and session.ended_at_s, await work.login_links.use("link", 2.0)

    ended_at_s, usable = look(database, left)
    assert ended_at_s is not None
    assert not usable
    assert audited(database)[-1] == ("console", "user.password", "boss", "done")


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("", "12 to 256 characters"),
        *later(
            ("short", "12 to 256 characters"),
            ("x" * 257, "12 to 256 characters"),
            ("aaaaaaaaaaaaaa", "too easy"),
        ),
        ("i am the boss now", "too easy"),
    ],
)
def test_a_weak_password_is_refused(dray: Run, database: str, boss: None, typed: str, told: str) -> None:
    code, _, err = dray("user", "password", "boss", typed=typed + "\n")
    assert code == 2
    assert told in err
    kept = person(database, "boss")
    assert kept is not None
    assert not kept.has_secret


@pytest.mark.parametrize(
    "typed",
    variants(
        ["12345", "1234567890123", "40271a", "", "٤٠٢٧١٩", "123456", "000000", "654321", "890123"],
        "12345",
        "٤٠٢٧١٩",
        "654321",
    ),
)
def test_a_weak_pin_is_refused(dray: Run, ana: None, typed: str) -> None:
    code, _, err = dray("user", "pin", "ana", typed=typed + "\n")
    assert code == 2
    assert "PIN" in err


def test_a_pin_is_kept_as_a_hash(dray: Run, database: str, ana: None) -> None:
    assert dray("user", "pin", "ana", typed="402719\n")[0] == 0
    kept = person(database, "ana")
    assert kept is not None
    assert kept.pin_hash is not None
    assert CHEAP.verify(kept.pin_hash, "402719")
    assert "PIN" in dray("user", "list")[1]


def test_a_badge_is_found_by_its_code_and_belongs_to_one(dray: Run, database: str, ana: None) -> None:
    code = dray("user", "badge", "ana")[1].strip()
    salt = look(database, lambda work: work.secrets.get(BADGE_SALT))
    found = look(database, lambda work: work.people.with_badge(Hasher(CHEAP).badge_hash(code, salt)))
    assert found is not None
    assert found.id == "ana"
    dray("user", "add", "eva", "--area", "AREA2")
    status, _, err = dray("user", "badge", "eva", "--read", typed=f"{code}\n")
    assert status == 2
    assert "somebody else has this badge" in err
    assert dray("user", "badge", "eva", "--read", typed="0012345678\n")[0] == 0
    assert dray("user", "badge", "eva", "--read", typed="0012\n")[0] == 2


def test_a_link_is_printed_once_and_ends_the_one_before(dray: Run, database: str, ana: None) -> None:
    first = dray("user", "link", "ana")[1].strip()
    assert re.fullmatch(r"http://127\.0\.0\.1:8000/login/[\w-]{43}", first)
    second = dray("user", "link", "ana", "--hours", "2", "--url", "https://dray.plant/")[1].strip()
    assert second.startswith("https://dray.plant/login/")

    async def both(work: Work) -> tuple[bool, LoginLink | None]:
        link = await work.login_links.find(second.rpartition("/")[2])
        return await work.login_links.use(first.rpartition("/")[2], time.time()), link

    used, link = look(database, both)
    assert not used
    assert link is not None
    assert link.expires_at_s == pytest.approx(time.time() + 7200, abs=60)


def test_who_is_disabled_is_told_so_and_may_come_back(dray: Run, database: str, ana: None) -> None:
    assert dray("user", "disable", "ana")[0] == 0
    assert "disabled" in dray("user", "list")[1]
    assert dray("user", "enable", "ana")[0] == 0
    kept = person(database, "ana")
    assert kept is not None
    assert kept.disabled_at_s is None


def test_a_key_is_printed_once_listed_and_taken_back(dray: Run, database: str) -> None:
    code, out, _ = dray(
        "key", "create", "ERP", "--scope", "orders:write", "--scope", "orders:read", "--days", "30"
    )
    assert code == 0
    token = out.strip()
    assert re.fullmatch(r"dray_[\w-]{43}", token)
    key = look(database, lambda work: work.api_keys.find(token))
    assert key is not None
    assert (key.name, key.scopes) == ("ERP", "orders:write orders:read")
    assert key.expires_at_s == pytest.approx(time.time() + 30 * 86_400, abs=60)
    listed = dray("key", "list")[1]
    assert key.id in listed
    assert token not in listed
    assert dray("key", "revoke", key.id)[1] == "taken back\n"
    assert dray("key", "revoke", key.id)[1] == "it was taken back already\n"
    assert "taken back" in dray("key", "list")[1]
    assert audited(database) == [
        ("console", "key.create", key.id, "done"),
        ("console", "key.revoke", key.id, "done"),
    ]


def test_a_key_that_calls_is_made_with_limits_and_listed_with_them(dray: Run, database: str) -> None:
    calls = ("--scope", "transports:call")
    limits = ("--place", "M8", "--place", "M9", "--item", "shaft", "--open", "4", "--open-each", "2")
    code, out, err = dray("key", "create", "Cell", *calls, *limits, "--priority", "high")
    assert code == 0, err
    key = look(database, lambda work: work.api_keys.find(out.strip()))
    assert key is not None
    assert (key.places, key.items, key.open_max, key.open_each_max) == ("M8 M9", "shaft", 4, 2)
    assert key.priority == "high"
    assert "(4 open, 2 for a place, high at the highest, at M8 M9, of shaft)" in dray("key", "list")[1]
    token = dray("key", "create", "WMS", *calls)[1].strip()
    usual = look(database, lambda work: work.api_keys.find(token))
    assert usual is not None
    assert (usual.places, usual.open_max, usual.open_each_max, usual.priority) == ("", 50, 20, "normal")


def test_the_command_and_the_gateway_have_the_same_bounds_of_a_key() -> None:
    assert (key_command.OPEN_MOST, key_command.NAMES_MAX) == (KEY_OPEN_MOST, NAMES_MAX)


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("create", "ERP", "--scope", "orders:read", "--open", "5"), "--open"),
        (("create", "ERP", "--scope", "transports:call", "--place", "M 8"), "--place"),
        (("create", "ERP", "--scope", "transports:call", "--item", ""), "--item"),
        (
            ("create", "ERP", "--scope", "transports:call", "--place", "M99"),
            "no 'M99' in the plant dray; it has M1, M2",
        ),
        (
            ("create", "ERP", "--scope", "transports:call", "--item", "gold"),
            "no 'gold' in the plant dray; it has housing, shaft",
        ),
        (("create", "ERP", "--scope", "transports:call", "--open", "5", "--open-each", "6"), "together, 5"),
        (("create", "ERP", "--scope", "transports:call", "--priority", "now"), "urgent"),
        (("create", "ERP", "--scope", "transports:call", "--open", "1251"), "1250"),
        (("create", "ERP", "--scope", "orders:eat"), "orders:read"),
        (("create", " ", "--scope", "orders:read"), "characters"),
        (("create", "ERP"), "--scope"),
        (("create", "ERP", "--scope", "orders:read", "--days", "0"), "--days"),
        (("revoke", "nothing"), "no key 'nothing'"),
    ],
)
def test_a_key_that_cannot_be_is_refused(dray: Run, args: tuple[str, ...], told: str) -> None:
    code, out, err = dray("key", *args)
    assert (code, out) == (2, "")
    assert told in err
