"""Readiness: who was started tells whoever listens, as services of systemd do, and nobody else."""

from __future__ import annotations

import asyncio
import socket
from pathlib import Path

import pytest

from dray.cli.runtime.readiness import VARIABLE, listening, tell_ready

LONG_S = 60.0
"""Real seconds for what takes a moment on a computer with nothing else to do."""


def test_only_the_listener_that_is_named_hears_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    async def story() -> None:
        with listening() as mine, listening() as other:
            waiting = asyncio.create_task(other.ready())
            monkeypatch.setenv(VARIABLE, mine.environment[VARIABLE])
            tell_ready()
            await asyncio.wait_for(mine.ready(), LONG_S)
            assert not waiting.done()
            waiting.cancel()

    asyncio.run(story())


def test_a_service_may_tell_other_things_first_and_several_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    async def story() -> None:
        with listening() as listener, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as teller:
            address = "\0" + listener.environment[VARIABLE][1:]
            teller.sendto(b"STATUS=reads its journal", address)
            hearing = asyncio.create_task(listener.ready())
            await asyncio.sleep(0)
            assert not hearing.done()
            teller.sendto(b"STATUS=drives\nREADY=1", address)
            await asyncio.wait_for(hearing, LONG_S)

    asyncio.run(story())


def test_a_listener_may_have_a_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as inbox:
        inbox.bind(str(tmp_path / "notify"))
        inbox.settimeout(LONG_S)
        monkeypatch.setenv(VARIABLE, str(tmp_path / "notify"))
        tell_ready()
        assert inbox.recv(100) == b"READY=1"


@pytest.mark.parametrize("address", ["", "@nobody-listens-here", "/nowhere/notify"])
def test_nobody_to_tell_is_no_fault(monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    monkeypatch.setenv(VARIABLE, address)
    tell_ready()
