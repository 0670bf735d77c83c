"""A replacement: whether the new process is ready, as far as that is asked for and not heard."""

from __future__ import annotations

import socketserver
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from dray.cli.fleet.rollout.replacement import _answers


@contextmanager
def server(answer: bytes) -> Iterator[str]:
    """A gateway on paper: it says one thing to whoever asks; its address."""

    class Handler(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            while self.rfile.readline().strip():
                pass
            self.wfile.write(answer)

    with socketserver.TCPServer(("127.0.0.1", 0), Handler) as listener:
        thread = threading.Thread(target=listener.serve_forever, args=(0.01,))
        thread.start()
        yield f"http://127.0.0.1:{listener.server_address[1]}/readyz"
        listener.shutdown()
        thread.join()


@pytest.mark.parametrize(
    ("answer", "ready"),
    [
        (b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n", True),
        (b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n", False),
        (b"something else\r\n\r\n", False),
        (b"", False),
    ],
    ids=["ready", "not ready", "no gateway", "silent"],
)
def test_a_gateway_is_ready_when_it_says_so(answer: bytes, ready: bool) -> None:
    with server(answer) as url:
        assert _answers(url) == ready


def test_a_gateway_on_this_computer_is_asked_without_a_proxy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:1")
    for name in ("no_proxy", "NO_PROXY"):
        monkeypatch.delenv(name, raising=False)
    # Python looks at the environment once for all.
    monkeypatch.setattr("urllib.request._opener", None)
    with server(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n") as url:
        assert _answers(url)
