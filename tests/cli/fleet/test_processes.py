"""Processes by number and birth: ours are signalled, and no stranger ever is."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from dray.adapters.processes import Process, birth_of


@pytest.fixture
def child() -> Iterator[subprocess.Popen[bytes]]:
    """A process that ends when its input does."""
    with subprocess.Popen(["cat"], stdin=subprocess.PIPE) as process:
        yield process
        process.kill()


def test_a_process_runs_until_it_has_ended_also_while_nobody_has_asked_how(
    child: subprocess.Popen[bytes],
) -> None:
    process = Process.of(child.pid)
    assert process.runs
    assert process.signal(signal.SIGKILL)
    asyncio.run(process.gone())
    # Its parent has not waited for it: its number is taken still, by nobody.
    assert child.returncode is None
    assert not process.runs
    assert not process.signal(signal.SIGTERM)


def test_who_has_the_number_of_another_is_not_signalled(child: subprocess.Popen[bytes]) -> None:
    before = Process(child.pid, birth_of(child.pid) + "0")
    assert not before.runs
    assert not before.signal(signal.SIGKILL)
    asyncio.run(before.gone())
    assert child.poll() is None
    assert child.communicate(b"")[0] is None
    assert child.returncode == 0


def test_two_processes_have_different_births_or_numbers(child: subprocess.Popen[bytes]) -> None:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as other:
        assert Process.of(child.pid) != Process.of(other.pid)
        other.communicate(b"\n")


def test_a_number_that_a_thread_has_by_now_is_no_process() -> None:
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    try:
        assert thread.native_id is not None
        for born in (birth_of(thread.native_id), "another birth"):
            process = Process(thread.native_id, born)
            assert not process.signal(signal.SIGTERM)
            asyncio.run(process.gone())
    finally:
        done.set()
        thread.join()


def test_a_number_that_nobody_has_is_no_process() -> None:
    with subprocess.Popen(["true"]) as ended:
        ended.wait()
    assert not Process.of(ended.pid).runs
    assert not Process(ended.pid, "").signal(signal.SIGTERM)
