"""Metrics of a process at a port of its own: read on its loop, told to whoever asks."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Iterable
from http import HTTPStatus
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest
from prometheus_client import Metric
from prometheus_client.core import GaugeMetricFamily

from dray import __version__
from dray.adapters.telemetry import metrics_port as module
from dray.adapters.telemetry.metrics_port import metrics_port, new_registry
from dray.errors import UnavailableError

PATIENCE_S = 90.0
"""For an answer that takes milliseconds."""


def ask(port: int) -> str:
    with urlopen(f"http://127.0.0.1:{port}/metrics", timeout=PATIENCE_S) as answer:
        text: str = answer.read().decode()
        return text


async def thread_that_reads() -> Iterable[Metric]:
    return (GaugeMetricFamily("reader", "Which thread reads.", value=threading.get_ident()),)


def test_whatever_is_told_is_read_on_the_loop() -> None:
    async def test() -> str:
        async with metrics_port("127.0.0.1:0", thread_that_reads) as port:
            return await asyncio.to_thread(ask, port)

    told = asyncio.run(test())
    assert float(told.splitlines()[-1].split()[1]) == threading.get_ident()


def test_every_process_tells_its_version_and_what_it_takes_of_the_computer() -> None:
    async def test() -> str:
        async def read() -> Iterable[Metric]:
            return new_registry().collect()

        async with metrics_port("127.0.0.1:0", read) as port:
            return await asyncio.to_thread(ask, port)

    told = asyncio.run(test())
    assert f'dray_build_info{{version="{__version__}"}} 1.0' in told
    assert "process_cpu_seconds_total" in told
    assert "process_resident_memory_bytes" in told


def test_a_process_whose_loop_hangs_does_not_answer(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "ANSWER_S", 0.05)

    async def test() -> None:
        async with metrics_port("127.0.0.1:0", thread_that_reads) as port:
            with pytest.raises(HTTPError) as refused:
                ask(port)  # on the loop, which does nothing else meanwhile
            assert refused.value.code == HTTPStatus.INTERNAL_SERVER_ERROR
            refused.value.close()

    asyncio.run(test())
    assert "TimeoutError" in capfd.readouterr().err


def test_whoever_let_the_system_choose_a_port_finds_it_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    async def test() -> int:
        async with metrics_port("127.0.0.1:0", thread_that_reads) as port:
            return port

    with caplog.at_level("INFO"):
        port = asyncio.run(test())
    assert f"metrics on port {port} of 127.0.0.1" in caplog.text


def test_the_port_is_free_again_at_the_end() -> None:
    async def test() -> None:
        async with metrics_port("127.0.0.1:0", thread_that_reads) as port:
            pass
        async with metrics_port(f"127.0.0.1:{port}", thread_that_reads) as again:
            assert again == port

    asyncio.run(test())


@pytest.mark.parametrize("host", ["127.0.0.1", "nowhere.invalid", "a..b"])
def test_an_address_that_is_not_to_be_had_is_told_with_a_remedy(host: str) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        address = f"{host}:{taken.getsockname()[1]}"

        async def test() -> None:
            async with metrics_port(address, thread_that_reads):
                pass

        with pytest.raises(UnavailableError, match=rf"metrics at {address}: .*DRAY_METRICS_LISTEN"):
            asyncio.run(test())
