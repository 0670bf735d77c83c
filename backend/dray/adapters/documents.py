"""Documents over HTTP: fetched, verified by checksum, and stored for a machine's control.

A file in the folder is named by its checksum, so machines that make the same product fetch it once. It is verified on each use,
because files decay. Own threads fetch the documents, so a silent server delays nobody.
"""

from __future__ import annotations

import asyncio
import hashlib
import os
import tempfile
import urllib.error
import urllib.request
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPException
from pathlib import Path

from dray.body import BodyState, DocumentRead, Instruction, ReadDocument, Report
from dray.body.documents import Documents
from dray.messages import Document, DocumentState
from dray.ports import Body

SIZE_MAX = 256 * 2**20
"""Maximum bytes: large CAM programs have some dozen MB. An endless answer must not fill the disk."""

PATIENCE_S = 20.0
"""Timeout of each server answer."""

THREADS = 4
"""Threads for fetching: a machine has few goals with few documents at a time."""

_CHUNK = 2**16

_opener = urllib.request.OpenerDirector()
# Not `build_opener`: neither an address nor a redirect may lead to a file or to FTP.
for _handler in (
    urllib.request.ProxyHandler(),
    urllib.request.HTTPHandler(),
    urllib.request.HTTPSHandler(),
    urllib.request.HTTPDefaultErrorHandler(),
    urllib.request.HTTPRedirectHandler(),
    urllib.request.HTTPErrorProcessor(),
    urllib.request.UnknownHandler(),
):
    _opener.add_handler(_handler)


class FetchedDocuments:
    """Implements `dray.body.documents.Documents`.

    Args:
        folder: the store; None for verification only.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder
        self._threads = ThreadPoolExecutor(THREADS, thread_name_prefix="documents")

    def read(self, document: Document, told: Callable[[DocumentRead], None]) -> None:
        """See `dray.body.documents.Documents`."""
        loop = asyncio.get_running_loop()
        future = self._threads.submit(fetch, document, self._folder)

        def done() -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(told, future.result())

        future.add_done_callback(lambda _future: done())

    def close(self) -> None:
        """Start no more fetches; running ones end by themselves."""
        self._threads.shutdown(wait=False, cancel_futures=True)


class DocumentReader:
    """A body that reads documents, and passes all other instructions to another one (see `dray.ports.Body`).

    Args:
        body: the other body.
        documents: their source.
    """

    def __init__(self, body: Body, documents: Documents) -> None:
        self._body, self._documents = body, documents
        self._report: Callable[[Report], None] | None = None

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`."""
        if isinstance(instruction, ReadDocument):
            self._documents.read(instruction.document, self._tell)
        else:
            self._body.instruct(instruction)

    def sense(self) -> BodyState:
        """See `dray.ports.Body`."""
        return self._body.sense()

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report
        self._body.attach(report)

    def _tell(self, read: DocumentRead) -> None:
        if self._report is not None:
            self._report(read)


def fetch(document: Document, folder: Path | None = None) -> DocumentRead:
    """Fetch a document, unless it is stored already, and verify it.

    Args:
        document: the document.
        folder: the store; None for none.
    """
    ready = None if folder is None else folder / document.sha256
    try:
        if ready is not None and ready.exists() and _digest_of(ready) == document.sha256:
            return DocumentRead(document, DocumentState.VERIFIED)
        found = _fetch(document, ready)
    except (OSError, HTTPException, ValueError) as error:
        return DocumentRead(document, DocumentState.UNREACHABLE, _words(error))
    if found != document.sha256:
        return DocumentRead(document, DocumentState.DIFFERS, f"its SHA-256 is {found}")
    return DocumentRead(document, DocumentState.VERIFIED)


def _fetch(document: Document, ready: Path | None) -> str:
    """The checksum of the file at the address; a correct file is stored afterwards.

    Raises:
        OSError, HTTPException, ValueError: fetching or writing failed.
    """
    digest, size = hashlib.sha256(), 0
    if ready is not None:
        ready.parent.mkdir(parents=True, exist_ok=True)
    with (
        _opener.open(document.address, timeout=PATIENCE_S) as answer,
        tempfile.NamedTemporaryFile(dir=None if ready is None else ready.parent, delete=False) as file,
    ):
        try:
            while chunk := answer.read(_CHUNK):
                size += len(chunk)
                if size > SIZE_MAX:
                    raise ValueError(f"it has more than {SIZE_MAX // 2**20} MB")
                digest.update(chunk)
                if ready is not None:
                    file.write(chunk)
            file.flush()
            if ready is not None and digest.hexdigest() == document.sha256:
                os.replace(file.name, ready)  # noqa: PTH105 - an open temporary file has a name and no path
        finally:
            Path(file.name).unlink(missing_ok=True)
    return digest.hexdigest()


def _digest_of(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()


def _words(error: Exception) -> str:
    if isinstance(error, urllib.error.HTTPError):
        return f"the server answers {error.code}"
    if isinstance(error, urllib.error.URLError):
        return str(error.reason)[:200]
    return str(error)[:200] or type(error).__name__
