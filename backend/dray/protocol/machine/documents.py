"""The documents of a machine's goals: each is verified before a piece is made by it (paper, 4.1: CAD and CAM data).

The machine's body fetches them, because it uses them. A document that cannot be used holds up only the pieces that
need it. It is fetched again after a while, so a person only has to correct the file at its address. A verified
document counts until no goal needs it; the next goal has it verified again.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from dray.body import DocumentRead, ReadDocument
from dray.messages import Document, DocumentBrief, DocumentState, Production
from dray.messages.product import DOCUMENTS_TOLD
from dray.protocol.machine.production import GoalBook
from dray.protocol.runtime.life import Life
from dray.states import States, Transitions

AGAIN_S = 60.0
"""Interval for fetching an unusable or unanswered document again (s): the longest wait after its correction."""

READ_AGAIN = "read again"
"""Alarm of the next fetch, with the document."""

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
    """The documents that one machine needs for its goals.

    Args:
        goals: the machine's goals.
        life: the agent's life; its alarm is named `READ_AGAIN`.

    Attributes:
        alarms: handlers for the agent's table.
    """

    def __init__(self, goals: GoalBook, life: Life) -> None:
        self._goals, self._life = goals, life
        self._states: dict[Document, States[DocumentState]] = {}
        """State of every document that a goal needs."""
        self._found: dict[Document, str] = {}
        """Reasons of unusable documents, in words."""
        self.alarms = {READ_AGAIN: self._again}

    def update(self, now_s: float) -> None:
        """Have needed documents read, and forget others."""
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

    def on_read(self, report: DocumentRead) -> bool:
        """Handle the body's report; False if no goal waits for that document."""
        if not self._is(report.document, DocumentState.READING):
            self._life.ignore("a document that no goal waits for")
            return False
        self._states[report.document].enter(report.state)
        self._found[report.document] = report.detail
        return True

    def ready(self, work: Production) -> bool:
        """Whether all documents of a goal's product are verified."""
        return all(self._is(document, DocumentState.VERIFIED) for document in work.definition.documents)

    def briefs(self) -> tuple[DocumentBrief, ...]:
        """The documents' entries in the heartbeat."""
        told = {}
        for product, document in self._needed():
            if (state := self._states.get(document)) is not None:
                found = self._found.get(document, "")
                told[product, document] = DocumentBrief(product, document, state.now, found[:200])
        return tuple(islice(told.values(), DOCUMENTS_TOLD))

    def hindrance(self) -> str:
        """What keeps goals from being made, in words; empty for none."""
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
