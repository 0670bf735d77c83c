"""A carrier that an earlier life let in and that has forgotten its task: a person is asked whether its load is there."""

from __future__ import annotations

import pytest
from effects import committed, facts, instructed, published, sent
from m7 import NO_HOUSINGS, docked, handover
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from seals import granted
from spoken import production, rhb

from dray.body import Book, DockReady
from dray.messages import (
    CallState,
    CommandAnswered,
    CommandRefusal,
    HandoverAccepted,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Reason,
    TaskAnnounced,
)
from dray.messages.fact import TaskClosed
from dray.protocol.liveness.failure_detector import UNNAMED_S

KIND = MachineCommandKind
TASK = "M7-1"
AGES_S = 1800.0
BROUGHT = [Book("ATV2", "housing", 24, task=TASK, epoch=1)]


def restarted(before: MachineRig, *, opened: tuple[str, ...] = ()) -> MachineRig:
    """M7's next life, with its notes and a dock that is open for these."""
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=before.agent._life.incarnation + 1)
    rig.answers, rig.opened, rig.memory, rig.now_s = True, opened, committed(before.all), before.now_s
    rig.start()
    return rig


def let_in() -> MachineRig:
    """M7's body does not count. M7's agent was started again while ATV2 unloaded 24 housings there."""
    first = BlindRig("M7", NO_HOUSINGS)
    first.answers = True
    first.start()
    first.take_goal("G1", production(quantity=24))
    first.hire(TASK, "ATV2")
    first.on_message("ATV2", docked())
    first.report(DockReady(vehicle="ATV2"))
    return restarted(first, opened=("ATV2",))


def forgets(rig: MachineRig, *, load: str = "", node: str = "c1") -> None:
    """ATV2 is heard without the task, for longer than a message can take."""
    until_s = rig.now_s + UNNAMED_S + 2.0
    while rig.now_s < until_s:
        rig.run(rig.now_s + 1.0)
        beat = rhb("ATV2", 1000 + int(rig.now_s), rig.now_s)
        rig.on_message("ATV2", replace(beat, node=node, load=load, load_quantity=24 if load else 0))


def held() -> MachineRig:
    rig = let_in()
    forgets(rig)
    return rig


def says(rig: MachineRig, kind: MachineCommandKind) -> CommandRefusal | None:
    """A person's word; why it was refused."""
    command = MachineCommand(command=f"C{len(rig.all)}", kind=kind, task=TASK, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("M7", command)), CommandAnswered)
    return answer.reason


def is_sought(rig: MachineRig) -> bool:
    """Whether another carrier was sought."""
    return any((each.task, each.epoch) == (TASK, 2) for each in published(rig.all, TaskAnnounced))


def calls(rig: MachineRig) -> list[HelpCall]:
    return [each for each in published(rig.all, HelpCall) if each.goods == TASK]


def ends(rig: MachineRig) -> list[str]:
    return [each.outcome for each in facts(rig.all, TaskClosed) if each.task == TASK]


def is_held(rig: MachineRig) -> bool:
    rig.run(rig.now_s + 6.0)
    [brief] = [each for each in rig.heartbeats(MachineHeartbeat)[-1].tasks if each.task == TASK]
    return brief.trouble is Reason.DISPUTED


@pytest.mark.parametrize("node", ["c1", "m7"])
def test_nothing_is_booked_or_sent_for_and_a_person_is_called_however_long_that_takes(node: str) -> None:
    rig = let_in()
    forgets(rig, node=node)
    rig.run(rig.now_s + AGES_S)
    assert is_held(rig)
    assert (is_sought(rig), instructed(rig.all, Book), ends(rig)) == (False, [], [])
    assert calls(rig)[-1].reason == "24 housing for M7 perhaps put down by ATV2, which has forgotten it"


def test_a_load_that_a_person_has_seen_is_booked_in_once_and_delivered() -> None:
    rig = held()
    rig.run(rig.now_s + 6.0)
    assert says(rig, KIND.LOAD_THERE) is None
    assert ends(rig) == []
    rig.stocked("housing", 24, "ATV2")
    assert (instructed(rig.all, Book), ends(rig)) == (BROUGHT, ["delivered"])
    rig.run(rig.now_s + 6.0)
    assert calls(rig)[-1].state is CallState.ENDED
    effects = rig.on_message("ATV2", handover())
    assert (instructed(effects, Book), len(sent(effects, HandoverAccepted))) == ([], 1)
    assert says(rig, KIND.LOAD_THERE) is CommandRefusal.NOT_HELD


def test_a_load_that_a_person_has_not_found_is_fetched_again() -> None:
    rig = held()
    assert says(rig, KIND.LOAD_MISSING) is None
    rig.run(rig.now_s + 1.0)
    assert (is_sought(rig), instructed(rig.all, Book)) == (True, [])


@pytest.mark.parametrize("kind", [None, KIND.LOAD_MISSING])
def test_a_carrier_that_tells_after_all_is_believed(kind: MachineCommandKind | None) -> None:
    rig = held()
    if kind is not None:
        assert says(rig, kind) is None
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT
    rig.stocked("housing", 24, "ATV2")
    assert ends(rig) == ["delivered"]


@pytest.mark.parametrize("is_said", [False, True])
def test_it_is_still_asked_and_booked_after_a_restart(*, is_said: bool) -> None:
    first = held()
    if is_said:
        says(first, KIND.LOAD_THERE)
    rig = restarted(first)
    assert instructed(rig.all, Book) == (BROUGHT if is_said else [])
    assert is_held(rig)
    if not is_said:
        assert says(rig, KIND.LOAD_THERE) is None
    rig.stocked("housing", 24, "ATV2")
    assert (instructed(rig.all, Book), ends(rig)) == (BROUGHT, ["delivered"])


def test_nothing_is_booked_while_its_carrier_is_at_the_dock_again() -> None:
    rig = restarted(held(), opened=("ATV2",))
    assert says(rig, KIND.LOAD_THERE) is CommandRefusal.DOCK_OPEN
    assert is_held(rig)


def test_nobody_is_asked_about_a_load_that_is_on_board() -> None:
    rig = let_in()
    forgets(rig, load="housing")
    assert is_sought(rig)


def test_nobody_is_asked_about_a_carrier_that_was_never_let_in() -> None:
    rig = restarted(let_in())
    forgets(rig)
    assert is_sought(rig)


def test_it_is_asked_about_what_no_goal_needs_any_more() -> None:
    rig = held()
    rig.agent._flow.give_back(rig.now_s)
    assert is_held(rig)
