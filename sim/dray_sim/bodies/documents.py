"""The document store of simulated workcells: every document is correct until a caller spoils it."""

from __future__ import annotations

from collections.abc import Callable

from dray.body.documents import DocumentRead
from dray.messages import Document, DocumentState
from dray.ports import Clock

FETCHED_S = 1.0
"""Time to fetch a document and to compute its checksum."""


class SimDocuments:
    """Implements `dray.body.documents.Documents`.

    Args:
        clock: the plant's clock.

    Attributes:
        lies: by address, the checksum of a document that differs from the correct one; None where it cannot be
            fetched.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self.lies: dict[str, str | None] = {}

    def read(self, document: Document, told: Callable[[DocumentRead], None]) -> None:
        """See `dray.body.documents.Documents`."""
        self._clock.call_at(self._clock.now_s() + FETCHED_S, lambda: told(self._find(document)))

    def _find(self, document: Document) -> DocumentRead:
        found = self.lies.get(document.address, document.sha256)
        if found is None:
            return DocumentRead(document, DocumentState.UNREACHABLE, "no answer")
        if found != document.sha256:
            return DocumentRead(document, DocumentState.DIFFERS, f"its SHA-256 is {found[:12]}")
        return DocumentRead(document, DocumentState.VERIFIED)
