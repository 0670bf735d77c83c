"""Who is who, on disk: people, sessions, links, keys, lock-outs and the audit log."""

from __future__ import annotations

import asyncio

import msgspec
import pytest
from sqlalchemy import text
from sqlalchemy.exc import IntegrityError

from dray.store import Store, downgrade, upgrade
from dray.store.access.api_keys import ApiKey
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.access.digest import digest
from dray.store.access.lockouts import Lockout
from dray.store.access.login_links import LoginLink
from dray.store.access.people import Person
from dray.store.access.sessions import Session
from dray.store.database.searching import Sought

pytestmark = pytest.mark.anyio

ANA = Person(id="ana", name="Ana", role="operator", created_at_s=1.0, areas=("AREA1", "AREA2"))
BOSS = Person(id="boss", name="The boss", role="manager", created_at_s=2.0, password_hash="hash")
LOGIN = Session(id="s1", person_id="ana", created_at_s=10.0, used_at_s=10.0, expires_at_s=99.0)
KEY = ApiKey(id="k1", name="ERP", scopes="orders:read orders:write", created_at_s=5.0)


@pytest.fixture
async def people(store: Store) -> Store:
    async with store.write() as work:
        await work.people.add(ANA)
        await work.people.add(BOSS)
    return store


async def test_people_are_found_with_their_areas(people: Store) -> None:
    async with people.read() as work:
        assert await work.people.all() == [ANA, BOSS]
        assert await work.people.get("ana") == ANA
        assert await work.people.get("Ana") is None


async def test_people_change_and_move(people: Store) -> None:
    async with people.write() as work:
        await work.people.change("ana", badge_hash="b" * 64, disabled_at_s=3.0)
        await work.people.move("ana", ["AREA3"])
    async with people.read() as work:
        moved = await work.people.with_badge("b" * 64)
        assert moved == msgspec.structs.replace(ANA, areas=("AREA3",), badge_hash="b" * 64, disabled_at_s=3.0)
        assert moved.has_secret
        assert await work.people.get("boss") == BOSS


@pytest.mark.parametrize(
    "change",
    [{"id": "ana"}, {"role": "emperor"}, {"badge_hash": "b" * 64}],
    ids=["an id that somebody has", "a role that there is not", "a badge that somebody has"],
)
async def test_what_cannot_be_is_refused(people: Store, change: dict[str, str]) -> None:
    async with people.write() as work:
        await work.people.change("ana", badge_hash="b" * 64)
    other = msgspec.structs.replace(BOSS, **{"id": "other"} | change)
    with pytest.raises(IntegrityError):
        async with people.write() as work:
            await work.people.add(other)


async def test_a_session_is_found_by_its_token_which_is_written_nowhere(people: Store) -> None:
    async with people.write() as work:
        await work.sessions.add("the-token", LOGIN)
    async with people.read() as work:
        assert await work.sessions.find("the-token") == LOGIN
        assert await work.sessions.find("the-tokeN") is None
        assert await work.sessions.find(digest("the-token")) is None
    async with people.database.read() as connection:
        rows = (await connection.execute(text("SELECT * FROM sessions"))).all()
    assert "the-token" not in str(rows)


async def test_a_session_is_used_moved_and_ended_once(people: Store) -> None:
    async with people.write() as work:
        await work.sessions.add("one", LOGIN)
        await work.sessions.add("two", msgspec.structs.replace(LOGIN, id="s2"))
        await work.sessions.use(["s1"], 20.0)
        await work.sessions.station("s1", "M1")
        assert await work.sessions.end("s1", 30.0) == 1
        assert await work.sessions.end("s1", 40.0) == 0
        assert await work.sessions.end_all("ana", 50.0) == 1
    async with people.read() as work:
        assert await work.sessions.find("one") == msgspec.structs.replace(
            LOGIN, used_at_s=20.0, station="M1", ended_at_s=30.0
        )
        assert {each.id: each.ended_at_s for each in await work.sessions.some(["s1", "s2", "s3"])} == {
            "s1": 30.0,
            "s2": 50.0,
        }


async def test_old_sessions_and_links_are_forgotten(people: Store) -> None:
    async with people.write() as work:
        await work.sessions.add("one", LOGIN)
        await work.login_links.add("link", LoginLink("ana", 1.0, 99.0))
        for each in (work.sessions, work.login_links):
            await each.forget_before(99.0)
        assert await work.sessions.find("one") is not None
        assert await work.login_links.find("link") is not None
        for each in (work.sessions, work.login_links):
            await each.forget_before(99.5)
        assert await work.sessions.find("one") is None
        assert await work.login_links.find("link") is None


async def test_of_two_who_use_a_link_at_once_one_comes_in(people: Store) -> None:
    async with people.write() as work:
        await work.login_links.add("link", LoginLink("ana", 1.0, 99.0))

    async def use() -> bool:
        async with people.write() as work:
            return await work.login_links.use("link", 50.0)

    assert sorted(await asyncio.gather(use(), use(), use())) == [False, False, True]


async def test_a_link_that_is_too_old_or_taken_back_is_not_used(people: Store) -> None:
    async with people.write() as work:
        await work.login_links.add("old", LoginLink("ana", 1.0, 50.0))
        await work.login_links.add("back", LoginLink("ana", 1.0, 99.0))
        assert not await work.login_links.use("old", 50.0)
        await work.login_links.end_all("ana", 20.0)
        assert not await work.login_links.use("back", 30.0)
        assert not await work.login_links.use("never", 30.0)
        link = await work.login_links.find("back")
    assert link == LoginLink("ana", 1.0, 99.0, ended_at_s=20.0)


async def test_a_key_is_found_used_and_taken_back_once(store: Store) -> None:
    async with store.write() as work:
        await work.api_keys.add("secret", KEY)
        await work.api_keys.use("k1", 7.0)
        assert await work.api_keys.revoke("k1", 8.0) == 1
        assert await work.api_keys.revoke("k1", 9.0) == 0
        assert await work.api_keys.revoke("k2", 9.0) == 0
    kept = msgspec.structs.replace(KEY, used_at_s=7.0, revoked_at_s=8.0)
    async with store.read() as work:
        assert await work.api_keys.find("secret") == kept
        assert await work.api_keys.get("k1") == kept
        assert await work.api_keys.all() == [kept]
        assert await work.api_keys.find("k1") is None


async def test_failures_are_counted_by_a_name_that_is_written_nowhere(store: Store) -> None:
    async with store.write() as work:
        await work.lockouts.put("ana", Lockout(4, 10.0, 0.0))
        await work.lockouts.put("ana", Lockout(5, 11.0, 41.0))
        await work.lockouts.put("nobody", Lockout(1, 12.0, 0.0))
        assert await work.lockouts.get("ana") == Lockout(5, 11.0, 41.0)
        await work.lockouts.clear("nobody")
        assert await work.lockouts.get("nobody") is None
        await work.lockouts.forget_before(11.0)
        assert await work.lockouts.count() == 1
        await work.lockouts.forget_before(11.5)
        assert await work.lockouts.count() == 0
    async with store.write() as work:
        await work.lockouts.put("ana", Lockout(1, 10.0, 0.0))
    async with store.database.read() as connection:
        assert "ana" not in str((await connection.execute(text("SELECT * FROM lockouts"))).all())


async def test_a_secret_is_made_once(store: Store) -> None:
    async with store.write() as work:
        first = await work.secrets.get("salt")
        assert len(bytes.fromhex(first)) == 32
        assert await work.secrets.get("salt") == first
        assert await work.secrets.get("other") != first


def line(number: int, **fields: str) -> AuditRow:
    usual = {"who": "ana", "who_kind": "person", "action": "vehicle.command", "result": "done"}
    return AuditRow(position=number, at_s=100.0 + number, **usual | fields, detail={"kind": "stop"})


async def test_the_audit_log_is_read_newest_first_and_by_what_is_asked(store: Store) -> None:
    lines = [
        line(1, target="ATV1"),
        line(2, who="boss", target="ATV1", result="refused"),
        line(3, action="order.place", target="O-1"),
        line(4, target="ATV2", result="failed"),
    ]
    async with store.write() as work:
        assert [await work.audit.add(each) for each in lines] == [1, 2, 3, 4]

    async def positions(before: int | None = None, limit: int = 10, **wanted: object) -> list[int]:
        async with store.read() as work:
            rows = await work.audit.page(AuditFilter(**wanted), before, limit)
        return [row.position for row in rows]

    assert await positions() == [4, 3, 2, 1]
    assert await positions(limit=2) == [4, 3]
    assert await positions(before=3, limit=2) == [2, 1]
    assert await positions(who="boss") == [2]
    assert await positions(action="order.place") == [3]
    assert await positions(target="ATV1") == [2, 1]
    assert await positions(result="failed") == [4]
    assert await positions(since_s=102.0, until_s=104.0) == [3, 2]
    async with store.write() as work:
        assert await work.audit.prune(lines[1].at_s, 10) == 1
    assert await positions() == [4, 3, 2]
    async with store.read() as work:
        newest = (await work.audit.page(AuditFilter(), None, 1))[0]
    assert msgspec.json.encode(newest) == msgspec.json.encode(lines[3])


async def test_a_line_of_the_audit_log_is_found_by_a_part_of_its_texts_in_any_case(store: Store) -> None:
    async with store.write() as work:
        await work.audit.add(line(1, who="Jörg", target="ATV1", from_ip="10.0.0.7"))
        await work.audit.add(line(2, who="ana", target="O-2", action="order.place"))

    async def positions(*texts: str, named: tuple[str, ...] = ()) -> list[int]:
        words = tuple(Sought(text, named) for text in texts)
        async with store.read() as work:
            return [row.position for row in await work.audit.page(AuditFilter(words=words), None, 10)]

    assert await positions("JÖRG") == [1]
    assert await positions("PLACE") == [2]
    assert await positions("0.7", "vehicle") == [1]
    assert await positions("ana", "vehicle") == []
    assert await positions("%") == []
    # The detail of both names what they did: {"kind": "stop"}. A name has to fit as a whole.
    assert await positions("pump", named=("stop",)) == [2, 1]
    assert await positions("pump", named=("sto",)) == []


async def test_the_position_of_a_line_that_was_forgotten_is_never_given_again(store: Store) -> None:
    async with store.write() as work:
        await work.audit.add(line(1))
        assert await work.audit.prune(line(1).at_s + 1, 10) == 1
        assert await work.audit.add(line(2)) == 2


async def test_an_older_dray_that_comes_back_later_finds_its_orders_and_nobody_logged_in(
    people: Store,
) -> None:
    async with people.write() as work:
        await work.sessions.add("one", LOGIN)
    await downgrade(people.database, "0002")
    await upgrade(people.database)
    async with people.read() as work:
        assert await work.people.all() == []
        assert await work.sessions.find("one") is None
