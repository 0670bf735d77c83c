"""A machine's access to the documents of a product (see `dray.body`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from dray.messages.base import Part, Text
from dray.messages.product import Document, DocumentState


class ReadDocument(Part, frozen=True):
    """Fetch a document, verify its checksum, and have it ready. Answered with `DocumentRead`; twice is harmless."""

    document: Document


class DocumentRead(Part, frozen=True):
    """The result of fetching a document."""

    document: Document
    state: DocumentState
    """`VERIFIED`, `DIFFERS` or `UNREACHABLE`."""
    detail: Text = ""
    """The findings, for an unusable document."""


class Documents(Protocol):
    """A body's source of documents.

    Blocking: no method blocks. `told` is called once for each call, later, on the caller's loop.
    """

    def read(self, document: Document, told: Callable[[DocumentRead], None]) -> None:
        """Fetch a document and verify it."""
        ...
