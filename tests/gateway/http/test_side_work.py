"""Side work: in processes, with bounds, and a place for everybody."""

from __future__ import annotations

import asyncio
import os
import resource
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from answers import problem
from gateway_kit import PRODUCT, House

from dray.errors import PlantError, PlantErrors
from dray.gateway.access.principal import Scope
from dray.gateway.http import bounded_process
from dray.gateway.http.bounded_process import NICE, NICEST
from dray.gateway.http.problems import Problem
from dray.gateway.http.provided import provided
from dray.gateway.http.request_bodies import RowsFile
from dray.gateway.http.side_work import COMMAND, EACH, MOST_BYTES, WAITING, SideWork
from dray.gateway.http.unread import read
from dray.plant import parse_plant

pytestmark = pytest.mark.anyio

FILE = {"csv": f"customer,product,quantity\nHall 3,{PRODUCT},5\n", "dry_run": True}


def given(side: SideWork, caller: str, pipe: Path) -> asyncio.Task[int]:
    """A piece that goes on until somebody reads the pipe."""
    return asyncio.create_task(side.do(caller, Path.write_text, pipe, "x"))


async def test_work_is_done_in_another_process_which_is_kept(side: SideWork) -> None:
    first = await side.do("a", os.getpid)
    assert first != os.getpid()
    assert await side.do("b", os.getpid) == first


async def test_side_work_stands_back_for_the_gateway_also_where_sessions_share_the_processor(
    side: SideWork, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bounded_process, "NICE", NICE)
    process = await side.do("a", os.getpid)
    # In a session of its own its niceness would count among its own processes only.
    assert os.getsid(process) == os.getsid(0)
    assert os.getpgid(process) == process
    nice = min(os.getpriority(os.PRIO_PROCESS, 0) + NICE, NICEST)
    assert os.getpriority(os.PRIO_PROCESS, process) == nice


async def test_memory_has_its_bound_also_where_the_priority_cannot_be_set(
    side: SideWork, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_all: int) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "setpriority", refused)
    process = await side.do("a", os.getpid)
    assert resource.prlimit(process, resource.RLIMIT_AS) == (MOST_BYTES, MOST_BYTES)


async def test_what_work_raises_comes_whole_out_of_its_process(side: SideWork) -> None:
    with pytest.raises(Problem) as refused:
        await side.do("a", read, RowsFile, b'{"csv": 1, "x": 2}')
    assert (refused.value.status, [each.field for each in refused.value.errors]) == (422, ["csv", "x"])
    with pytest.raises(Problem, match="at character 1"):
        await side.do("a", read, RowsFile, b"{")
    with pytest.raises(PlantErrors) as faults:
        await side.do("a", parse_plant, "plant: x\nname: 1\n", "draft")
    assert all(isinstance(each, PlantError) and each.file == "draft" for each in faults.value.errors)
    assert str(faults.value).startswith("draft:")


async def test_who_has_a_long_piece_leaves_a_place_to_all_others(side: SideWork, pipe: Path) -> None:
    held = [given(side, "greedy", pipe) for _ in range(EACH)]
    await asyncio.sleep(0)
    with pytest.raises(Problem) as refused:
        await side.do("greedy", os.getpid)
    assert (refused.value.status, refused.value.kind) == (429, "too-many-files")
    assert await side.do("other", int, "7") == 7
    assert not any(each.done() for each in held)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    await asyncio.gather(*held)
    os.close(reader)
    assert await side.do("greedy", int, "8") == 8


async def test_only_so_many_pieces_wait_in_all(side: SideWork, pipe: Path) -> None:
    held = [given(side, f"caller {number}", pipe) for number in range(WAITING)]
    await asyncio.sleep(0)
    with pytest.raises(Problem) as refused:
        await side.do("one more", int, "7")
    assert (refused.value.status, refused.value.kind) == (503, "too-many-files")
    for each in held:
        each.cancel()
    await asyncio.gather(*held, return_exceptions=True)
    # Whoever has gone holds no place.
    assert await side.do("one more", int, "7") == 7


async def test_a_piece_that_takes_too_long_or_too_much_is_ended_and_the_next_is_done(
    side: SideWork, pipe: Path
) -> None:
    with pytest.raises(Problem) as refused:
        await side.do("a", bytes, 2 * MOST_BYTES)
    assert (refused.value.status, refused.value.kind) == (422, "too-much-work")
    assert await side.do("a", int, "7") == 7
    hasty = SideWork(most_s=0.01)
    with pytest.raises(Problem, match="given up after"):
        await given(hasty, "a", pipe)
    assert not hasty._all


async def test_a_piece_is_measured_by_its_work_and_not_by_how_long_a_busy_computer_takes_for_it(
    pipe: Path,
) -> None:
    side = SideWork((*COMMAND[:-1], "0.3"))
    # It waits for longer than it may work; what it waits for comes after another piece has used up its time.
    waits = given(side, "a", pipe)
    with pytest.raises(Problem) as refused:
        await side.do("b", sum, range(10**12))
    assert (refused.value.status, refused.value.kind) == (422, "too-much-work")
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    await waits
    os.close(reader)
    assert await side.do("b", int, "7") == 7
    await side.close()


async def test_a_process_that_has_ended_meanwhile_is_replaced(side: SideWork) -> None:
    os.kill(await side.do("a", os.getpid), 9)
    [process] = side._all
    await process.wait()
    assert await side.do("a", int, "7") == 7


async def test_after_the_end_nothing_is_left(pipe: Path) -> None:
    side = SideWork()
    held = given(side, "a", pipe)
    await side.do("b", int, "7")
    await side.close()
    with suppress(Problem):
        await held
    assert not side._all


async def test_a_key_that_reads_files_without_end_is_told_so_and_others_read_theirs(
    house: House, pipe: Path
) -> None:
    key, greedy = await house.key(Scope.ORDERS_WRITE)
    side = provided(house.app, SideWork)
    held = [given(side, f"key {key.id}", pipe) for _ in range(EACH)]
    await asyncio.sleep(0)
    answer = await house.client.post("/api/orders/import", json=FILE, headers=greedy)
    assert answer.headers["Retry-After"] == "5"
    problem(answer, 429, "too-many-files")
    assert (await house.client.post("/api/orders/import", json=FILE)).status_code == 200
    for each in held:
        each.cancel()
    await asyncio.gather(*held, return_exceptions=True)


WORK = (
    "dray.gateway.routes.factory.plant_draft_work",
    "dray.gateway.orders.csv_import",
    "dray.gateway.products.judging",
)
"""Modules of pieces of side work."""


def test_no_piece_loads_the_packages_of_a_database() -> None:
    """They would take a second of whoever is served first by a new process."""
    loaded = f"import sys, {', '.join(WORK)}; print(*sys.modules)"
    told = subprocess.run([sys.executable, "-c", loaded], capture_output=True, text=True, check=True)
    assert {*WORK} <= {*told.stdout.split()}
    assert "sqlalchemy" not in told.stdout.split()
