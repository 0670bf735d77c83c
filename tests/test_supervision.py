"""Tasks that serve others go on when one message makes them fail: that is counted, and said at ERROR."""

from __future__ import annotations

import asyncio
import contextlib
import logging

import pytest

from dray.errors import UnavailableError
from dray.supervision import MOST_S, Failures, Supervisor, keep_looking
from dray_sim.clock.loop import JUMP, run


class Fails(Exception):
    """An error of ours."""


class Task:
    """It fails so often, and each time after so long; then it ends."""

    def __init__(self, times: int, after_s: float = 0.0) -> None:
        self.begun_s: list[float] = []
        self._times, self._after_s = times, after_s

    async def run(self) -> None:
        self.begun_s.append(asyncio.get_running_loop().time())
        await asyncio.sleep(self._after_s)
        if len(self.begun_s) <= self._times:
            raise Fails("of a word that nobody had thought of")


def kept(task: Task) -> Supervisor:
    supervisor = Supervisor()
    run(supervisor.keep("stream", task.run), JUMP)
    return supervisor


def test_a_task_that_fails_is_started_again_counted_and_told(caplog: pytest.LogCaptureFixture) -> None:
    task = Task(times=2)
    with caplog.at_level(logging.ERROR, "dray.supervision"):
        supervisor = kept(task)
    assert len(task.begun_s) == 3
    assert supervisor.restarts == {"stream": 2}
    assert [record.levelno for record in caplog.records] == [logging.ERROR] * 2
    assert "stream has failed" in caplog.text
    assert "nobody had thought of" in caplog.text


def test_one_that_does_not_fail_is_counted_with_none() -> None:
    assert kept(Task(times=0)).restarts == {"stream": 0}


def test_one_that_fails_again_and_again_waits_longer_each_time() -> None:
    task = Task(times=9)
    kept(task)
    waits_s = [after - before for before, after in zip(task.begun_s, task.begun_s[1:], strict=False)]
    assert waits_s == [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 60.0, 60.0, 60.0]


def test_one_that_has_gone_on_for_a_while_is_started_at_once_again() -> None:
    task = Task(times=4, after_s=MOST_S)
    kept(task)
    waits_s = [after - before for before, after in zip(task.begun_s, task.begun_s[1:], strict=False)]
    assert waits_s == [MOST_S + 1.0] * 4


def test_one_that_is_cancelled_ends() -> None:
    async def main() -> Supervisor:
        supervisor = Supervisor()
        task = asyncio.create_task(supervisor.keep("stream", asyncio.Event().wait))  # type: ignore[arg-type]
        await asyncio.sleep(1.0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        return supervisor

    assert run(main(), JUMP).restarts == {"stream": 0}


def test_messages_that_fail_are_counted_by_kind_and_told_when_their_number_has_doubled(
    caplog: pytest.LogCaptureFixture,
) -> None:
    failures = Failures("Yard/4711")
    with caplog.at_level(logging.ERROR, "dray.supervision"):
        for kind, times in (("state", 9), ("connection", 1)):
            for _ in range(times):
                try:
                    {}["of a word that nobody had thought of"]
                except KeyError:
                    failures.note(kind)
    assert failures.counts == {"state": 9, "connection": 1}
    assert failures.total == 10
    told = [record.getMessage().partition(",")[2] for record in caplog.records]
    assert [words.split()[0] for words in told] == ["1", "2", "4", "8", "1"]
    assert {record.levelno for record in caplog.records} == {logging.ERROR}
    assert "Yard/4711: state has failed" in caplog.text
    assert "nobody had thought of" in caplog.text


@pytest.mark.parametrize(("at_once", "looked_s"), [(False, [2.0, 4.0, 6.0]), (True, [0.0, 2.0, 4.0, 6.0])])
def test_one_that_looks_from_time_to_time_goes_on_when_the_database_is_away(
    at_once: bool, looked_s: list[float]
) -> None:
    seen_s: list[float] = []
    away: list[UnavailableError] = []

    async def look() -> None:
        seen_s.append(asyncio.get_running_loop().time())
        if len(seen_s) == 2:
            raise UnavailableError("database", "is locked", "end what uses it")

    async def a_while() -> None:
        begun_s = asyncio.get_running_loop().time()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(7.0):
                await keep_looking(look, 2.0, away.append, at_once=at_once)
        assert [at_s - begun_s for at_s in seen_s] == looked_s

    run(a_while(), JUMP)
    assert [error.reason for error in away] == ["is locked"]


def test_our_own_fault_ends_one_that_looks_from_time_to_time() -> None:
    async def look() -> None:
        raise Fails("of a word that nobody had thought of")

    with pytest.raises(Fails):
        run(keep_looking(look, 2.0, lambda _: None), JUMP)


def test_a_listener_that_fails_is_counted_and_one_without_its_disk_ends_whoever_tells_it() -> None:
    failures, heard = Failures("Yard/4711"), list[int]()

    def listener(value: int) -> None:
        if value == 0:
            raise ZeroDivisionError
        if value < 0:
            raise UnavailableError("the journal", "is full", "make room")
        heard.append(value)

    for value in (1, 0, 2):
        failures.tell("state", listener, value)
    assert (heard, failures.counts) == ([1, 2], {"state": 1})
    with pytest.raises(UnavailableError):
        failures.tell("state", listener, -1)
