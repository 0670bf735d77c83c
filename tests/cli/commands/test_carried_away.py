"""`dray carried-away`: a person's word in the database, with a line in the audit log."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import msgspec
import pytest

from dray.messages import Event, RemovalRefusal
from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused
from dray.store import open_store
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.factory.removals import RemovalRow

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def dray(call: Run, monkeypatch: pytest.MonkeyPatch, database: str) -> Run:
    monkeypatch.setattr("dray.cli.commands.administration.console.getpass.getuser", lambda: "maria")
    return lambda *args: call("carried-away", *args, "--db", database)


def look(database: str) -> tuple[list[RemovalRow], list[AuditRow]]:
    async def read() -> tuple[list[RemovalRow], list[AuditRow]]:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with store.read() as work:
            found = await work.removals.all(), await work.audit.page(AuditFilter(), None, 10)
        await store.close()
        return found

    return asyncio.run(read())


def test_a_word_is_kept_with_who_has_said_it_and_names_no_heartbeat(dray: Run, database: str) -> None:
    code, out, _ = dray("GHOST", "--off-the-floor")
    assert code == 0
    assert "GHOST is said to be off the floor" in out
    (row,), (line,) = look(database)
    assert (row.atv, row.by, row.node, row.is_bare, row.granted_in) == ("GHOST", "maria", "", True, None)
    assert (line.action, line.target, line.who) == ("vehicle.carry_away", "GHOST", "maria")


def test_a_later_word_has_a_higher_number(dray: Run, database: str) -> None:
    dray("ATV3", "--off-the-floor")
    (first,), _ = look(database)
    dray("ATV3", "--off-the-floor")
    (then,), _ = look(database)
    assert then.number > first.number


@pytest.mark.parametrize(
    ("args", "said"), [(("ATV3",), "--off-the-floor"), (("no id!", "--off-the-floor"), "ATV")]
)
def test_what_is_not_said_in_so_many_words_is_not_said(
    dray: Run, database: str, args: tuple[str, ...], said: str
) -> None:
    code, _, error = dray(*args)
    assert code != 0
    assert said in error
    assert look(database) == ([], [])


def answer(database: str, *answers: tuple[str, PlacesFreed | PlaceKept | RemovalRefused]) -> None:
    """What machines have told, and a gateway has stored."""
    events = [
        Event(agent=agent, incarnation=1, number=number, at_s=float(number), fact=fact)
        for number, (agent, fact) in enumerate(answers, 1)
    ]

    async def store() -> None:
        opened = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with opened.write() as work:
            await work.events.add(events, lambda plant_s: plant_s)
        await opened.close()

    asyncio.run(store())


def test_without_a_vehicle_it_lists_who_is_off_the_floor_and_what_machines_have_answered(
    dray: Run, database: str
) -> None:
    dray("ATV3", "--off-the-floor")
    (earlier,), _ = look(database)
    dray("ATV3", "--off-the-floor")
    dray("GHOST", "--off-the-floor")
    number = next(row.number for row in look(database)[0] if row.atv == "ATV3")
    answer(
        database,
        ("M2", RemovalRefused("ATV3", earlier.number, RemovalRefusal.EXPIRED)),
        ("M4", RemovalRefused("ATV3", number, RemovalRefusal.HEARD_SINCE)),
        ("M5", PlacesFreed(atv="ATV3", number=number, by="console:maria", places=("b3", "c3"))),
    )
    code, out, _ = dray()
    assert code == 0
    words = " ".join(out.split())
    assert "ATV3 - maria" in words
    assert "M4: it has heard the vehicle after the report" in words
    assert "M5: b3, c3 free" in words
    assert "no answer yet" in words
    assert "M2" not in words


def test_the_place_where_a_vehicle_is_put_back_is_listed_once_it_is_kept(dray: Run, database: str) -> None:
    dray("ATV3", "--off-the-floor")
    put_back(database, "c3")
    _, out, _ = dray()
    assert "ATV3 c3 maria" in " ".join(out.split())
    assert "no answer yet" in out
    (row,), _ = look(database)
    answer(database, ("M5", PlaceKept(atv="ATV3", number=row.number, place="c3")))
    _, out, _ = dray()
    assert "M5: c3 is kept for it, put it down there" in " ".join(out.split())


def put_back(database: str, node: str) -> None:
    """What a person says on a panel about the only vehicle that is off the floor."""
    (row,), _ = look(database)

    async def put() -> None:
        opened = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with opened.write() as work:
            await work.removals.put(msgspec.structs.replace(row, node=node))
        await opened.close()

    asyncio.run(put())


def test_off_the_floor_needs_the_name_of_the_vehicle(dray: Run, database: str) -> None:
    code, _, error = dray("--off-the-floor")
    assert code != 0
    assert "name the vehicle" in error
    assert look(database) == ([], [])


# --- put back ---------------------------------------------------------------------------------------


def test_a_place_is_asked_for_where_the_vehicle_is_put_back(dray: Run, database: str) -> None:
    dray("ATV3", "--off-the-floor")
    (before,), _ = look(database)
    code, out, _ = dray("ATV3", "--put-back", "P2")
    assert code == 0
    assert "p2 is asked for, for ATV3" in out
    (row,), lines = look(database)
    assert (row.atv, row.node, row.by) == ("ATV3", "p2", "maria")
    assert row.number > before.number
    assert {line.action for line in lines} == {"vehicle.carry_away", "vehicle.put_back"}


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("ATV3", "--put-back", "P2"), "nobody has said that ATV3 was carried away"),
        (("ATV3", "--put-back", "nowhere"), "no node or place"),
        (("ATV3", "--put-back", "P2", "--off-the-floor"), "first"),
        (("--put-back", "P2"), "name the vehicle"),
    ],
)
def test_a_place_that_cannot_be_kept_for_it_is_refused(
    dray: Run, database: str, args: tuple[str, ...], said: str
) -> None:
    code, _, error = dray(*args)
    assert code != 0
    assert said in " ".join(error.split())
    assert look(database) == ([], [])
