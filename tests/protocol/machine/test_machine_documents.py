"""Documents of a goal's product: verified before the first piece, and a bad one holds up nobody else."""

from __future__ import annotations

import pytest
from effects import committed, instructed
from m7 import FULL, m7
from msgspec import UNSET
from msgspec.structs import replace
from rigs import MachineRig
from spoken import production

from dray.body import DocumentRead, ReadDocument
from dray.messages import (
    Document,
    DocumentBrief,
    DocumentState,
    MachineHeartbeat,
    Production,
    Reason,
    Withdrawn,
)
from dray.messages.fact import MachineStatusChanged
from dray.messages.heartbeat_stock import with_stock
from dray.messages.product import DOCUMENTS_TOLD
from dray.protocol.machine.documents import AGAIN_S
from dray.protocol.runtime.events import Ignore, Record

CAM = Document("CAM program", "https://plm.example/p1.nc", "text/plain", "ab" * 32)
GUIDE = Document("Instruction", "https://plm.example/p1.pdf", "application/pdf", "cd" * 32)


def work(*documents: Document, quantity: int = 2) -> Production:
    plain = production(quantity=quantity)
    return replace(plain, definition=replace(plain.definition, documents=documents))


def read(
    rig: MachineRig, document: Document, state: DocumentState = DocumentState.VERIFIED, detail: str = ""
) -> None:
    rig.report(DocumentRead(document, state, detail))


def asked(rig: MachineRig) -> list[Document]:
    return [each.document for each in instructed(rig.all, ReadDocument)]


def told(rig: MachineRig) -> list[DocumentBrief]:
    """What the heartbeats tell of documents by now."""
    rig.run(rig.now_s + 20.0)
    last: MachineHeartbeat | None = None
    for heartbeat in rig.heartbeats(MachineHeartbeat):
        last = with_stock(heartbeat, last)
    assert last is not None
    return [] if last.documents is UNSET else list(last.documents)


def test_a_goal_with_documents_waits_until_all_of_them_are_verified() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work(CAM, GUIDE))
    assert asked(rig) == [CAM, GUIDE]
    read(rig, CAM)
    assert not rig.is_cycling
    read(rig, GUIDE)
    assert rig.is_cycling


def test_a_goal_without_documents_waits_for_none() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work())
    assert asked(rig) == []
    assert rig.is_cycling
    assert all(beat.documents is UNSET for beat in rig.heartbeats(MachineHeartbeat))


@pytest.mark.parametrize("state", [DocumentState.DIFFERS, DocumentState.UNREACHABLE])
def test_a_document_that_cannot_be_used_holds_up_only_the_goal_that_needs_it(state: DocumentState) -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work(CAM), deadline_s=100.0)
    rig.take_goal("G2", work(quantity=1), deadline_s=200.0)
    read(rig, CAM, state, "its SHA-256 is 00")
    rig.cycle()
    assert not rig.is_cycling
    [brief] = told(rig)
    assert (brief.document, brief.state, brief.detail) == (CAM, state, "its SHA-256 is 00")
    reasons = [
        effect.fact.reason
        for effect in rig.all
        if isinstance(effect, Record) and isinstance(effect.fact, MachineStatusChanged)
    ]
    assert f"document CAM program of pump-p3 is {state} (its SHA-256 is 00)" in reasons


def test_what_could_not_be_used_is_read_again_and_then_made() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work(CAM))
    read(rig, CAM, DocumentState.DIFFERS)
    rig.run(AGAIN_S + 1.0)
    assert asked(rig) == [CAM, CAM]
    read(rig, CAM)
    assert rig.is_cycling
    assert [brief.state for brief in told(rig)] == [DocumentState.VERIFIED]
    rig.run(rig.now_s + 3 * AGAIN_S)
    assert asked(rig) == [CAM, CAM]


def test_a_body_that_does_not_answer_is_asked_again() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work(CAM))
    rig.run(AGAIN_S + 1.0)
    assert asked(rig) == [CAM, CAM]


def test_what_no_goal_needs_any_more_is_forgotten_and_verified_anew_for_the_next_one() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work(CAM, quantity=1))
    read(rig, CAM)
    rig.on_message("STRATEGIST", Withdrawn(task="G1", epoch=1, reason=Reason.NOT_NEEDED))
    assert told(rig) == []
    read(rig, CAM)
    assert rig.all[-1] == Ignore("a document that no goal waits for")
    rig.take_goal("G2", work(CAM, quantity=1))
    assert asked(rig) == [CAM, CAM]


def test_the_next_life_verifies_them_before_it_goes_on() -> None:
    rig = m7(FULL)
    rig.take_goal("G1", work(CAM, quantity=2))
    read(rig, CAM)
    rig.cycle()
    again = MachineRig("M7", rig.stock, incarnation=2)
    again.memory, again.now_s = committed(rig.all), rig.now_s
    again.start()
    assert asked(again) == [CAM]
    assert not again.is_cycling
    read(again, CAM)
    assert again.is_cycling


def test_a_heartbeat_tells_of_no_more_documents_than_it_can_carry() -> None:
    rig = m7(FULL)
    for number in range(DOCUMENTS_TOLD + 4):
        rig.take_goal(f"G{number}", work(replace(CAM, sha256=f"{number:064d}"), quantity=1))
    assert len(asked(rig)) == DOCUMENTS_TOLD + 4
    assert len(told(rig)) == DOCUMENTS_TOLD
