"""The documents of a machine's goals: each is verified before a piece is made by it (paper, 4.1: CAD and CAM data).

The machine's body fetches them, since it is the one that uses them. Of a document that cannot be used all pieces wait that need it,
and no others; it is fetched again after a while, so whoever puts right what lies at its address has to do no more. What is
verified counts until no goal needs it: the next goal that does has it verified again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice

from dray.body import DocumentRead, ReadDocument, Report
from dray.messages import Document, DocumentBrief, DocumentState, Production
from dray.messages.product import DOCUMENTS_TOLD
from dray.protocol.machine.production import GoalBook
from dray.protocol.runtime.life import Life
from dray.states import States, Transitions

AGAIN_S = 60.0
"""After so long what could not be used, or was not answered, is asked for again: a person who puts it right waits no longer."""

READ_AGAIN = "read again"
"""The alarm for that, with the document."""

_S = DocumentState

TRANSITIONS: Transitions[DocumentState] = {
    _S.UNREAD: {_S.READING: "a goal needs it"},
    _S.READING: {
        _S.READING: "asked again, for want of an answer",
        _S.VERIFIED: "its checksum is right",
        _S.DIFFERS: "its checksum is another",
        _S.UNREACHABLE: "it cannot be fetched",
    },
    _S.VERIFIED: {},
    _S.DIFFERS: {_S.READING: "asked again"},
    _S.UNREACHABLE: {_S.READING: "asked again"},
}


class GoalDocuments:
    """What one machine has to know to make its goals.

    Args:
        goals: what it makes.
        life: its agent's; its alarm is named `READ_AGAIN`.
        changed: called with the time when a document has been read.

    Attributes:
        reports, alarms: what to call with a report, or an alarm.
    """

    def __init__(self, goals: GoalBook, life: Life, changed: Callable[[float], None]) -> None:
        self._goals, self._life, self._changed = goals, life, changed
        self._states: dict[Document, States[DocumentState]] = {}
        """Of every document that a goal needs."""
        self._found: dict[Document, str] = {}
        """In words, of those that cannot be used."""
        self.reports: dict[type[Report], Callable[[DocumentRead, float], None]] = {
            DocumentRead: self._on_read
        }
        self.alarms = {READ_AGAIN: self._again}

    def update(self, now_s: float) -> None:
        """Have read what goals need, and forget what none needs any more."""
        needed = {document for _, document in self._needed()}
        for document in [each for each in self._states if each not in needed]:
            self._life.cancel((READ_AGAIN, document))
            del self._states[document]
            self._found.pop(document, None)
        for _, document in self._needed():
            if document not in self._states:
                what = f"document {document.name}"
                self._states[document] = States(what, TRANSITIONS, DocumentState.UNREAD)
                self._read(document, now_s)

    def ready(self, work: Production) -> bool:
        """Whether all that is to be known of a goal's product is verified."""
        return all(self._is(document, DocumentState.VERIFIED) for document in work.definition.documents)

    def briefs(self) -> tuple[DocumentBrief, ...]:
        """What the heartbeat tells of them."""
        told = {}
        for product, document in self._needed():
            if (state := self._states.get(document)) is not None:
                found = self._found.get(document, "")
                told[product, document] = DocumentBrief(product, document, state.now, found[:200])
        return tuple(islice(told.values(), DOCUMENTS_TOLD))

    def hindrance(self) -> str:
        """What keeps goals from being made, in words; empty for nothing."""
        for brief in self.briefs():
            if brief.state is not DocumentState.VERIFIED:
                found = f" ({brief.detail})" if brief.detail else ""
                return f"document {brief.document.name} of {brief.product} is {brief.state}{found}"
        return ""

    def _needed(self) -> Iterator[tuple[str, Document]]:
        for goal in self._goals.confirmed():
            for document in goal.work.definition.documents:
                yield goal.work.product, document

    def _is(self, document: Document, state: DocumentState) -> bool:
        known = self._states.get(document)
        return known is not None and known.now is state

    def _read(self, document: Document, now_s: float) -> None:
        self._states[document].enter(DocumentState.READING)
        self._life.instruct(ReadDocument(document))
        self._life.alarm((READ_AGAIN, document), now_s + AGAIN_S)

    def _again(self, document: Document, now_s: float) -> None:
        if document in self._states and not self._is(document, DocumentState.VERIFIED):
            self._read(document, now_s)

    def _on_read(self, report: DocumentRead, now_s: float) -> None:
        if not self._is(report.document, DocumentState.READING):
            self._life.ignore("a document that nobody waits for")
            return
        self._states[report.document].enter(report.state)
        self._found[report.document] = report.detail
        self._changed(now_s)
