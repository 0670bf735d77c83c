"""Renderings: one piece of work for all who ask, and nobody waits for the turn of somebody else."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from pathlib import Path

import pytest
from side_work_kit import count_pieces

from dray.gateway.http.problems import Problem
from dray.gateway.http.renderings import Renderings
from dray.gateway.http.side_work import EACH, SideWork

pytestmark = pytest.mark.anyio

KEY = ("draft", "d-1", 1)


async def test_all_who_ask_meanwhile_wait_for_one_piece_of_work(
    side: SideWork, pipe: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    renderings, pieces = Renderings(side), count_pieces(monkeypatch)
    asked = [
        asyncio.create_task(renderings.of(KEY, f"caller {number}", Path.read_bytes, pipe))
        for number in range(3 * EACH)
    ]
    await asyncio.to_thread(pipe.write_bytes, b"made")
    assert set(await asyncio.gather(*asked)) == {b"made"}
    assert await renderings.of(KEY, "later", bytes, b"never made") == b"made"
    assert len(pieces) == 1
    assert await renderings.of((*KEY[:2], 2), "later", bytes, b"a new version") == b"a new version"


async def test_a_reader_does_not_wait_for_a_turn_of_somebody_else(side: SideWork, pipe: Path) -> None:
    renderings = Renderings(side)
    held = [asyncio.create_task(side.do("greedy", Path.read_bytes, pipe)) for _ in range(EACH - 1)]
    behind = asyncio.create_task(renderings.of(KEY, "greedy", bytes, b"made"))
    await asyncio.sleep(0)
    assert await renderings.of(KEY, "other", bytes, b"made") == b"made"
    assert not any(each.done() for each in (*held, behind))
    for each in held:
        each.cancel()
    await asyncio.gather(*held, return_exceptions=True)
    assert await behind == b"made"


async def test_a_failure_is_told_to_the_one_whose_work_it_was(side: SideWork, tmp_path: Path) -> None:
    renderings, missing = Renderings(side), tmp_path / "missing"
    failing = asyncio.create_task(renderings.of(KEY, "a", Path.read_bytes, missing))
    await asyncio.sleep(0)
    other = asyncio.create_task(renderings.of(KEY, "b", bytes, b"made"))
    with pytest.raises(FileNotFoundError):
        await failing
    assert await other == b"made"


async def test_whoever_has_too_many_pieces_is_told_so_and_reads_what_is_kept(
    side: SideWork, pipe: Path
) -> None:
    renderings = Renderings(side)
    renderings.keep(KEY, b"kept")
    held = [asyncio.create_task(side.do("greedy", Path.read_bytes, pipe)) for _ in range(EACH)]
    await asyncio.sleep(0)
    assert await renderings.of(KEY, "greedy", bytes, b"made") == b"kept"
    with pytest.raises(Problem) as refused:
        await renderings.of(("other",), "greedy", bytes, b"made")
    assert refused.value.status == 429
    for each in held:
        each.cancel()
    with suppress(asyncio.CancelledError):
        await asyncio.gather(*held, return_exceptions=True)


def test_what_is_kept_has_a_bound_and_what_was_asked_for_longest_ago_goes_first() -> None:
    renderings = Renderings(SideWork(), kept_bytes=10)
    renderings.keep(("a",), b"1234")
    renderings.keep(("b",), b"1234")
    assert renderings.get(("a",)) == b"1234"
    renderings.keep(("c",), b"1234")
    assert [renderings.get((key,)) for key in "abc"] == [b"1234", None, b"1234"]
    renderings.keep(("c",), b"12")
    renderings.keep(("d",), b"1234")
    assert [renderings.get((key,)) for key in "acd"] == [b"1234", b"12", b"1234"]
    renderings.keep(("e",), b"12345678901")
    assert renderings.get(("e",)) is None
    assert renderings.get(("a",)) == b"1234"
