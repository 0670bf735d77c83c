"""A supervisor: its process runs as was asked last, whatever happens; others ask for a replacement by a socket."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import stat
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from actor import ends_at_once, make_actor

from dray.cli.fleet import control
from dray.cli.fleet.control import Refused, Replace, controlled
from dray.cli.fleet.process_registry import Member, RegistryWriter, State, read_registry
from dray.cli.fleet.process_specs import ProcessSpec
from dray.cli.fleet.process_supervisor import Filling, ProcessSupervisor, Replaced
from dray.cli.fleet.software import Software
from dray.errors import UnavailableError
from dray.messages import WIRE_VERSION

LONG_S = 60.0
"""Real seconds for what takes a moment on a computer with nothing else to do."""


class Kept:
    """A supervisor at work, and what its processes say."""

    def __init__(
        self,
        folder: Path,
        supervisor: ProcessSupervisor,
        keeping: asyncio.Task[None],
        words: asyncio.StreamReader,
    ) -> None:
        self.folder, self.supervisor, self.keeping, self._words = folder, supervisor, keeping, words

    @property
    def member(self) -> Member:
        return read_registry(self.folder).member("ATV1")

    async def says(self) -> str:
        """The next line that one of its processes says."""
        async with asyncio.timeout(LONG_S):
            return (await self._words.readline()).decode().rstrip()


@contextlib.asynccontextmanager
async def kept(
    folder: Path,
    software: Software,
    *,
    kind: str = "atv",
    leave_s: float = LONG_S,
    turns: asyncio.Semaphore | None = None,
) -> AsyncIterator[Kept]:
    """A supervisor of one process; what its lives say comes through a pipe in the place of their log."""
    pipe = folder / "ATV1.log"
    os.mkfifo(pipe)
    words = asyncio.StreamReader()
    reading = os.fdopen(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), "rb")
    # Held open here, so that there is no end between one process and the next.
    with pipe.open("ab"):
        transport, _ = await asyncio.get_running_loop().connect_read_pipe(
            lambda: asyncio.StreamReaderProtocol(words), reading
        )
        environment = {**os.environ, "TOLD": "here"}
        spec = ProcessSpec("ATV1", kind, ("agent", "atv", "ATV1"), "127.0.0.1:1", environment, "", pipe)
        registry = RegistryWriter(folder, "plant", plain=True)
        supervisor = ProcessSupervisor(
            spec, registry, turns or asyncio.Semaphore(), leave_s, Filling(software)
        )
        keeping = asyncio.create_task(supervisor.keep())
        try:
            yield Kept(folder, supervisor, keeping, words)
        finally:
            keeping.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await keeping
            transport.close()


def test_another_software_comes_when_the_old_one_has_left_in_order(tmp_path: Path) -> None:
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")

    async def story() -> None:
        async with kept(tmp_path, old) as there:
            assert await there.says() == "1.0 agent atv ATV1 here"
            done = await there.supervisor.replace(Filling(new, canary_tasks=3), at_once=False)
            assert (done.killed, done.starts) == (False, 2)
            assert await there.says() == "1.0 ends by SIGTERM"
            assert await there.says() == "2.0 agent atv ATV1 --probation 3 here"
            assert (there.member.software, there.member.state, there.member.starts) == (
                new,
                State.CANARY,
                2,
            )
            assert there.member.proven == old
            there.supervisor.settle()
            assert (there.member.state, there.member.proven) == (State.AT_WORK, new)
            there.member.signal(signal.SIGKILL)
            assert await there.says() == "2.0 agent atv ATV1 here"
            assert there.member.starts == 3

    asyncio.run(story())


def test_whoever_need_not_finish_ends_by_an_interrupt_as_all_do_when_the_fleet_ends(tmp_path: Path) -> None:
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")

    async def story() -> None:
        async with kept(tmp_path, old) as there:
            await there.says()
            await there.supervisor.replace(Filling(new), at_once=True)
            assert await there.says() == "1.0 ends by SIGINT"
            assert await there.says() == "2.0 agent atv ATV1 here"
            last = there
        assert await last.says() == "2.0 ends by SIGINT"

    asyncio.run(story())


def test_whoever_does_not_leave_in_time_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.cli.fleet.process_supervisor.STOP_S", 0.0)
    old, new = make_actor(tmp_path, "1.0", deaf=("SIGTERM",)), make_actor(tmp_path, "2.0")

    async def story() -> None:
        async with kept(tmp_path, old, leave_s=0.0) as there:
            await there.says()
            done = await there.supervisor.replace(Filling(new), at_once=False)
            assert done.killed
            assert await there.says() == "2.0 agent atv ATV1 here"

    asyncio.run(story())


def test_what_ends_by_itself_is_replaced_too(tmp_path: Path) -> None:
    async def story() -> None:
        async with kept(tmp_path, ends_at_once(tmp_path)) as there:
            assert [await there.says() for _ in range(2)] == ["dead", "dead"]
            done = await there.supervisor.replace(Filling(make_actor(tmp_path, "2.0")), at_once=False)
            assert not done.killed
            while (said := await there.says()) == "dead":
                pass
            assert said == "2.0 agent atv ATV1 here"

    asyncio.run(story())


def test_what_ends_again_and_again_is_started_ever_more_rarely(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    for name, seconds in (("REST_S", 0.01), ("REST_MAX_S", 0.04)):
        monkeypatch.setattr(f"dray.cli.fleet.process_supervisor.{name}", seconds)

    async def story() -> None:
        async with kept(tmp_path, ends_at_once(tmp_path)) as there:
            rests_s = list[float]()
            rest = there.supervisor._rest
            monkeypatch.setattr(
                there.supervisor, "_rest", lambda lived_s: rests_s.append(rest(lived_s)) or rests_s[-1]
            )
            for _ in range(7):
                assert await there.says() == "dead"
            assert rests_s[:5] == [0.01, 0.02, 0.04, 0.04, 0.04]
            monkeypatch.setattr("dray.cli.fleet.process_supervisor.STEADY_S", 0.0)
            while rests_s[-1] != 0.01:
                assert await there.says() == "dead"

    asyncio.run(story())
    assert "ATV1 has ended again, after 0 s: it is started in 0 s" in caplog.text


def test_another_software_is_not_made_to_wait_for_what_the_one_before_it_did(tmp_path: Path) -> None:
    async def story() -> None:
        async with kept(tmp_path, ends_at_once(tmp_path)) as there:
            await there.says()
            there.supervisor._rest_s = LONG_S
            await there.supervisor.replace(Filling(make_actor(tmp_path, "2.0")), at_once=True)
            assert there.supervisor._rest(0.0) == 1.0

    asyncio.run(story())


def test_what_hinders_a_start_is_told_and_tried_again_when_it_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("dray.cli.fleet.process_supervisor.REST_S", 0.05)
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")
    pipe, away = tmp_path / "ATV1.log", tmp_path / "away"

    async def story() -> None:
        async with kept(tmp_path, old) as there:
            await there.says()
            pipe.rename(away)
            pipe.mkdir()
            async with asyncio.timeout(LONG_S):
                with pytest.raises(IsADirectoryError):
                    await there.supervisor.replace(Filling(new), at_once=True)
            pipe.rmdir()
            away.rename(pipe)
            assert await there.says() == "1.0 ends by SIGINT"
            assert await there.says() == "2.0 agent atv ATV1 here"

    asyncio.run(story())
    assert "ATV1 cannot be started: [Errno 21]" in caplog.text


def test_what_is_killed_to_stay_away_is_started_when_its_time_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.cli.fleet.process_supervisor.REST_S", LONG_S)

    async def story() -> None:
        async with kept(tmp_path, make_actor(tmp_path, "1.0")) as there:
            assert await there.says() == "1.0 agent atv ATV1 here"
            assert there.supervisor.kill(away_s=0.05)
            assert await there.says() == "1.0 agent atv ATV1 here"
            assert there.member.starts == 2

    asyncio.run(story())


def test_who_stays_away_is_no_more_to_be_killed_and_comes_back_for_a_replacement(tmp_path: Path) -> None:
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")

    async def story() -> None:
        async with kept(tmp_path, old) as there, controlled(tmp_path, {"ATV1": there.supervisor}):
            await there.says()
            process = there.member
            assert await control.kill(tmp_path, "ATV1", away_s=1e6)
            await process.gone()
            assert not await control.kill(tmp_path, "ATV1", away_s=1e6)
            assert not there.member.runs
            await control.replace(tmp_path, Replace("ATV1", new))
            assert await there.says() == "2.0 agent atv ATV1 here"

    asyncio.run(story())


def test_a_roll_that_cannot_be_written_ends_nobody(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")
    hindrance = tmp_path / "fleet.new"
    hindrance.mkdir()

    async def story() -> None:
        async with kept(tmp_path, old) as there:
            assert await there.says() == "1.0 agent atv ATV1 here"
            assert "fleet.json is not up to date for other commands" in caplog.text
            hindrance.rmdir()
            async with asyncio.timeout(LONG_S):
                await there.supervisor.replace(Filling(new), at_once=True)
            assert (there.member.software, there.member.starts) == (new, 2)

    asyncio.run(story())


def test_a_floor_does_not_come_back(tmp_path: Path) -> None:
    async def story() -> None:
        async with kept(tmp_path, ends_at_once(tmp_path), kind="floor") as there:
            assert await there.says() == "dead"
            await asyncio.wait_for(there.keeping, LONG_S)
            assert there.member.starts == 1

    asyncio.run(story())


def _room(folder: Path, name: str) -> Path:
    room = folder / name
    room.mkdir()
    return room


def test_others_are_started_when_the_one_before_takes_part(tmp_path: Path) -> None:
    actor, turns = make_actor(tmp_path, "1.0"), asyncio.Semaphore(1)

    async def story() -> None:
        async with (
            kept(_room(tmp_path, "first"), actor, turns=turns) as first,
            kept(_room(tmp_path, "second"), actor, turns=turns) as second,
        ):
            await first.says()
            with pytest.raises(UnavailableError):
                assert second.member
            first.member.signal(signal.SIGUSR1)
            assert await second.says() == "1.0 agent atv ATV1 here"
            assert first.member.runs

    asyncio.run(story())


def test_who_ends_or_says_nothing_does_not_hold_up_others_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.cli.fleet.process_supervisor.READY_S", 0.0)
    turns = asyncio.Semaphore(1)

    async def story() -> None:
        async with (
            kept(_room(tmp_path, "first"), make_actor(tmp_path, "1.0"), turns=turns) as first,
            kept(_room(tmp_path, "second"), ends_at_once(tmp_path), turns=turns) as second,
        ):
            await first.says()
            monkeypatch.setattr("dray.cli.fleet.process_supervisor.READY_S", LONG_S)
            assert await second.says() == "dead"
            async with kept(_room(tmp_path, "third"), make_actor(tmp_path, "3.0"), turns=turns) as third:
                assert await third.says() == "3.0 agent atv ATV1 here"

    asyncio.run(story())


def test_kinds_that_know_no_probation_are_not_put_on_one(tmp_path: Path) -> None:
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")

    async def story() -> None:
        async with kept(tmp_path, old, kind="strategist") as there:
            await there.says()
            await there.supervisor.replace(Filling(new, canary_tasks=3), at_once=True)
            await there.says()
            assert await there.says() == "2.0 agent atv ATV1 here"

    asyncio.run(story())


def test_other_commands_reach_the_supervisor_by_a_socket_for_its_owner_alone(tmp_path: Path) -> None:
    deep = tmp_path / ("a" * 100) / ("b" * 100)
    deep.mkdir(parents=True)
    old, new = make_actor(tmp_path, "1.0"), make_actor(tmp_path, "2.0")
    nowhere = Software(str(tmp_path / "nothing"), "3.0", WIRE_VERSION)

    async def story() -> None:
        async with kept(deep, old) as there, controlled(deep, {"ATV1": there.supervisor}):
            await there.says()
            assert stat.S_IMODE((deep / control.SOCKET).stat().st_mode) == 0o600
            done = await control.replace(deep, Replace("ATV1", new, canary_tasks=2))
            assert isinstance(done, Replaced)
            assert done.starts == 2
            assert there.member.state is State.CANARY
            await control.settle(deep, "ATV1")
            assert there.member.state is State.AT_WORK
            stranger = await control.replace(deep, Replace("ATV2", new))
            assert stranger == Refused("there is no such process")
            missing = await control.replace(deep, Replace("ATV1", nowhere))
            assert isinstance(missing, Refused)
            assert "cannot be started" in missing.reason
            # What could not be started is replaced as everything else is.
            assert isinstance(await control.replace(deep, Replace("ATV1", old)), Replaced)
        with pytest.raises(UnavailableError, match="does not answer"):
            await control.settle(deep, "ATV1")

    asyncio.run(story())


@pytest.mark.parametrize("hindrance", ["a path that is none", "a folder in the place of the socket"])
def test_a_folder_in_which_no_socket_can_be_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hindrance: str
) -> None:
    if hindrance == "a path that is none":
        monkeypatch.setattr(control, "_short", lambda folder: contextlib.nullcontext("/proc/none/socket"))
    else:
        (tmp_path / control.SOCKET).mkdir()

    async def story() -> None:
        async with controlled(tmp_path, {}):
            pass

    with pytest.raises(UnavailableError, match=rf"{tmp_path}: .*; choose another --folder"):
        asyncio.run(story())
