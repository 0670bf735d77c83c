"""Documents over HTTP: fetched, verified, laid ready; whatever else lies at the address is said, and never used."""

from __future__ import annotations

import asyncio
import hashlib
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from dray.adapters import documents
from dray.adapters.documents import DocumentReader, FetchedDocuments, fetch
from dray.body import BodyState, DocumentRead, Instruction, ReadDocument, SetPace, WorkcellState
from dray.messages import Document, DocumentState

CONTENT = b"G21 G90\nM30\n"

PATHS = {"/p1.nc": (200, CONTENT, {}), "/moved": (302, b"", {"Location": "file:///etc/hostname"})}


class _Handler(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        status, content, headers = PATHS.get(self.path, (404, b"", {}))
        self.send_response(status)
        for name, value in headers.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """Where a store of documents answers."""
    http = ThreadingHTTPServer(("127.0.0.1", 0), _Handler)
    thread = threading.Thread(target=http.serve_forever, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{http.server_port}"
    http.shutdown()
    http.server_close()
    thread.join()


def document(address: str, content: bytes = CONTENT) -> Document:
    return Document("CAM program", address, "text/plain", hashlib.sha256(content).hexdigest())


def test_what_has_the_right_checksum_is_verified_and_lies_ready(server: str, tmp_path: Path) -> None:
    wanted = document(f"{server}/p1.nc")
    assert fetch(wanted, tmp_path / "ready").state is DocumentState.VERIFIED
    [ready] = (tmp_path / "ready").iterdir()
    assert (ready.name, ready.read_bytes()) == (wanted.sha256, CONTENT)


def test_what_lies_ready_is_not_fetched_again_unless_it_has_spoiled(server: str, tmp_path: Path) -> None:
    wanted = document(f"{server}/p1.nc")
    fetch(wanted, tmp_path)
    gone = Document(wanted.name, f"{server}/gone", wanted.media_type, wanted.sha256)
    assert fetch(gone, tmp_path).state is DocumentState.VERIFIED
    (tmp_path / wanted.sha256).write_bytes(b"spoiled")
    assert fetch(gone, tmp_path).state is DocumentState.UNREACHABLE
    assert fetch(wanted, tmp_path).state is DocumentState.VERIFIED
    assert (tmp_path / wanted.sha256).read_bytes() == CONTENT


def test_what_has_another_checksum_is_told_and_not_kept(server: str, tmp_path: Path) -> None:
    read = fetch(document(f"{server}/p1.nc", b"other"), tmp_path)
    assert read.state is DocumentState.DIFFERS
    assert hashlib.sha256(CONTENT).hexdigest() in read.detail
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("path", ["/gone", "/moved"])
def test_what_cannot_be_fetched_is_told_with_the_reason(server: str, tmp_path: Path, path: str) -> None:
    read = fetch(document(f"{server}{path}"), tmp_path)
    assert read.state is DocumentState.UNREACHABLE
    assert read.detail


def test_no_address_leads_to_a_file_of_the_machine(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_bytes(CONTENT)
    assert fetch(document(secret.as_uri())).state is DocumentState.UNREACHABLE


def test_what_never_ends_is_given_up(server: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(documents, "SIZE_MAX", 4)
    read = fetch(document(f"{server}/p1.nc"), tmp_path)
    assert read.state is DocumentState.UNREACHABLE
    assert list(tmp_path.iterdir()) == []


class Cell:
    """A body that remembers what it was told."""

    def __init__(self) -> None:
        self.told: list[Instruction] = []

    def instruct(self, instruction: Instruction) -> None:
        self.told.append(instruction)

    def sense(self) -> BodyState:
        return WorkcellState(stock={}, seq=0, cycling="", broken="")

    def attach(self, report: object) -> None:
        pass


@pytest.mark.anyio
async def test_a_body_that_reads_leaves_all_else_to_the_one_behind_it(server: str, tmp_path: Path) -> None:
    cell, heard = Cell(), asyncio.Queue[DocumentRead]()
    reading = FetchedDocuments(tmp_path)
    body = DocumentReader(cell, reading)
    body.attach(heard.put_nowait)  # type: ignore[arg-type]
    body.instruct(SetPace(0.5))
    body.instruct(ReadDocument(document(f"{server}/p1.nc")))
    assert (await asyncio.wait_for(heard.get(), 60.0)).state is DocumentState.VERIFIED
    assert cell.told == [SetPace(0.5)]
    reading.close()
