"""People are a machine's body: their words go to it, and its answers back, once each."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import facts, instructed, published, sent
from m7 import FULL, m7, outgoing
from msgspec import UNSET
from msgspec.structs import replace
from rigs import MachineRig
from seals import granted
from spoken import production

from dray.body import CycleDone, StockChanged, Word, WordTaken
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    PeopleAsBody,
    UnconfirmedLoad,
)
from dray.messages.fact import CommandObeyed, PieceMade, SparePieceMade, TaskClosed
from dray.messages.heartbeat import LOADS_TOLD
from dray.protocol.machine.people.command_handling import NO_PEOPLE

KIND = MachineCommandKind
MADE = MachineCommand(command="w1", kind=KIND.MADE, item="pump", quantity=2, issued_by="Maria")

REFUSED = WordTaken("shift-lead/w1", CommandRefusal.UNLIKELY, "1")


def worked() -> MachineRig:
    """M7, which people work, with a goal."""
    rig = MachineRig("M7", FULL)
    rig.people = True
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    return rig


def test_a_word_is_passed_on_and_answered_when_the_body_has_taken_it() -> None:
    rig = worked()
    effects = rig.on_message("gateway", granted("M7", MADE))
    assert instructed(effects, Word) == [Word("shift-lead/w1", KIND.MADE, "pump", 2)]
    assert sent(effects, CommandAnswered) == []
    effects = rig.report(WordTaken("shift-lead/w1"))
    assert sent(effects, CommandAnswered) == [CommandAnswered("w1", done=True)]
    [fact] = facts(effects, CommandObeyed)
    assert (fact.what, fact.done, fact.issued_by) == ("made", True, "Maria")


def test_one_that_comes_again_is_passed_on_and_answered_again_and_told_of_once() -> None:
    rig = worked()
    rig.on_message("gateway", granted("M7", MADE))
    rig.report(WordTaken("shift-lead/w1"))
    assert instructed(rig.on_message("gateway", granted("M7", MADE)), Word)
    effects = rig.report(WordTaken("shift-lead/w1", again=True))
    assert sent(effects, CommandAnswered) == [CommandAnswered("w1", done=True)]
    assert facts(effects, CommandObeyed) == []
    assert sent(rig.report(WordTaken("shift-lead/w1")), CommandAnswered) == []


@pytest.mark.parametrize("taken", [WordTaken("shift-lead/w1"), REFUSED])
def test_a_copy_that_comes_after_its_grants_end_gets_the_answer_of_its_word(taken: WordTaken) -> None:
    rig = worked()
    rig.on_message("gateway", granted("M7", MADE))
    [answer] = sent(rig.report(taken), CommandAnswered)
    effects = rig.on_message("gateway", granted("M7", MADE, valid_until_s=-1.0))
    assert sent(effects, CommandAnswered) == [answer]
    assert (instructed(effects, Word), facts(effects, CommandObeyed)) == ([], [])
    [other] = sent(
        rig.on_message("gateway", granted("M7", replace(MADE, command="w2"), valid_until_s=-1.0)),
        CommandAnswered,
    )
    assert other.reason is CommandRefusal.EXPIRED


def test_a_refusal_of_the_body_is_answered_with_the_expected_number() -> None:
    rig = worked()
    rig.on_message("gateway", granted("M7", MADE))
    effects = rig.report(WordTaken("shift-lead/w1", CommandRefusal.UNLIKELY, "1"))
    assert sent(effects, CommandAnswered) == [
        CommandAnswered("w1", done=False, reason=CommandRefusal.UNLIKELY, detail="1")
    ]


def test_a_machine_with_a_controller_takes_no_words() -> None:
    rig = m7(goal=24)
    effects = rig.on_message("gateway", granted("M7", MADE))
    assert instructed(effects, Word) == []
    assert sent(effects, CommandAnswered) == [
        CommandAnswered("w1", done=False, reason=CommandRefusal.NOT_SUPPORTED, detail=NO_PEOPLE)
    ]


@pytest.mark.parametrize(
    ("command", "refused"),
    [
        (MADE, CommandRefusal.NOT_GRANTED),
        (granted("M8", MADE), CommandRefusal.NOT_TRUSTED),
        (granted("M7", MADE, areas=()), CommandRefusal.NOT_HERE),
        (granted("M7", MADE, valid_until_s=-1.0), CommandRefusal.EXPIRED),
    ],
)
def test_nobody_speaks_for_a_machine_who_may_not(command: MachineCommand, refused: CommandRefusal) -> None:
    effects = worked().on_message("gateway", command)
    assert instructed(effects, Word) == []
    [answer] = sent(effects, CommandAnswered)
    assert answer.reason is refused


def test_its_heartbeats_tell_which_loads_wait_for_a_word() -> None:
    rig = worked()
    load = UnconfirmedLoad(vehicle="ATV3", item="housing", quantity=12)
    rig.loads = (load,) * (LOADS_TOLD + 1)
    rig.run(rig.now_s + 10.0)
    assert published(rig.all, MachineHeartbeat)[-1].people == PeopleAsBody(loads=(load,) * LOADS_TOLD)
    counted = m7()
    counted.run(10.0)
    assert counted.heartbeats(MachineHeartbeat)[-1].people is UNSET


def test_goods_that_people_count_are_what_goals_have() -> None:
    rig = worked()
    product = PLANT.machines["M7"].makes[0].product
    rig.seq += 1
    rig.stock[product] = 3
    rig.report(StockChanged(product, 3, rig.seq, counted=True))
    rig.run(rig.now_s + 10.0)
    [goods] = rig.reported_stock()[1]
    assert goods.level == 3
    assert rig.heartbeats(MachineHeartbeat)[-1].goals[0].made == 3


def test_a_piece_of_another_product_is_spare_and_what_is_being_made_goes_on() -> None:
    rig = MachineRig("M6", dict.fromkeys(PLANT.materials_of("M6"), 48))
    rig.people = True
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    seq = rig.seq = rig.seq + 1
    effects = rig.report(CycleDone("gear-unit-g2", seq))
    assert [fact.product for fact in facts(effects, SparePieceMade)] == ["gear-unit-g2"]
    effects = rig.report(CycleDone("pump-p3", seq + 1))
    assert [(fact.goal, fact.made) for fact in facts(effects, PieceMade)] == [("G1", 1)]


def test_goods_that_leave_by_hand_are_on_board_of_nobody_though_nobody_is_hired_for_them_yet() -> None:
    rig = worked()
    for _ in range(24):
        rig.cycle()
    assert outgoing(rig.all) == [("G1", 24)]
    rig.seq += 1
    rig.stock["pump-p3"] -= 4
    effects = rig.report(StockChanged("pump-p3", -4, rig.seq))
    assert [(fact.task, fact.outcome) for fact in facts(effects, TaskClosed)] == [("M7-1", "withdrawn")]
