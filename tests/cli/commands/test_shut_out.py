"""`dray shut-out` and `dray readmit`: decisions in the database, with a line in the audit log."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from dray.store import open_store
from dray.store.access.audit import AuditFilter, AuditRow
from dray.store.factory.exclusions import Exclusion

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def dray(call: Run, monkeypatch: pytest.MonkeyPatch, database: str) -> Run:
    monkeypatch.setattr("dray.cli.commands.administration.console.getpass.getuser", lambda: "maria")
    return lambda *args: call(*args, "--db", database)


def look(database: str) -> tuple[list[Exclusion], list[AuditRow]]:
    async def read() -> tuple[list[Exclusion], list[AuditRow]]:
        store = await open_store(database.replace("sqlite:", "sqlite+aiosqlite:"))
        async with store.read() as work:
            found = await work.exclusions.all(), await work.audit.page(AuditFilter(), None, 10)
        await store.close()
        return found

    return asyncio.run(read())


def test_an_agent_is_shut_out_with_a_reason_that_the_audit_log_keeps(dray: Run, database: str) -> None:
    code, out, _ = dray("shut-out", "ATV3", "--reason", "does not move")
    assert code == 0
    assert "ATV3 is shut out" in out
    (exclusion,), (line,) = look(database)
    assert (exclusion.agent, exclusion.by, exclusion.reason) == ("ATV3", "maria", "does not move")
    assert (line.action, line.target, line.who, line.who_kind) == (
        "agent.shut_out",
        "ATV3",
        "maria",
        "console",
    )
    assert b"does not move" in bytes(line.detail)


def test_who_is_shut_out_is_listed_with_the_reason(dray: Run) -> None:
    dray("shut-out", "ATV3", "--reason", "does not move")
    code, out, _ = dray("shut-out")
    assert code == 0
    (line,) = (line for line in out.splitlines() if "ATV3" in line)
    assert "maria" in line
    assert "does not move" in line


def test_a_second_reason_does_not_replace_the_first(dray: Run, database: str) -> None:
    dray("shut-out", "ATV3", "--reason", "does not move")
    code, out, _ = dray("shut-out", "ATV3", "--reason", "another")
    assert (code, out) == (0, "ATV3 was shut out already, by maria: does not move\n")
    assert len(look(database)[1]) == 1


def test_a_readmitted_agent_is_in_no_list(dray: Run, database: str) -> None:
    dray("shut-out", "ATV3", "--reason", "does not move")
    code, out, _ = dray("readmit", "ATV3")
    assert code == 0
    assert "ATV3 is readmitted" in out
    exclusions, lines = look(database)
    assert exclusions == []
    assert lines[0].action == "agent.readmit"


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("shut-out", "ATV3"), "--reason"),
        (("shut-out", "ATV3", "--reason", " "), "--reason"),
        (("shut-out", "ATV3", "--reason", "x" * 201), "--reason"),
        (("shut-out", "ATV3", "--reason", "a\nb"), "--reason"),
        (("shut-out", "ATV*", "--reason", "x"), "is no id"),
        (("readmit", "ATV3"), "is not shut out"),
    ],
)
def test_what_cannot_be_used_is_named_and_nothing_is_done(
    dray: Run, database: str, args: tuple[str, ...], told: str
) -> None:
    code, _, err = dray(*args)
    assert code == 2
    assert told in err
    assert look(database) == ([], [])
