"""Goods on board of a vehicle that has failed: they wait for a person's word, and each piece counts once."""

from __future__ import annotations

import msgspec
import pytest
from defaults import PLANT
from effects import award_number, committed, facts, published, sent
from left_aboard import GONE_S, KIND, NODE, PUMPS, TASK, beats, fetched, loaded, says, stranded, told
from m7 import handover, m7
from rigs import MachineRig
from spoken import accepted

from dray.body import Broken
from dray.messages import (
    Award,
    CommandRefusal,
    Confirmed,
    Docked,
    MachineCommandKind,
    MachineHeartbeat,
    Problem,
    Reason,
    Role,
    StrandedGoods,
    Superseded,
    TaskAnnounced,
    Transport,
    Withdrawn,
)
from dray.messages.fact import CarrierChanged, TaskClosed
from dray.protocol.machine.production import GOODS_LEAVE_S
from dray.protocol.takeover.left_aboard import WRITTEN_OFF_AFTER_S

# --- they wait -------------------------------------------------------------------------------------


def test_goods_of_a_dead_vehicle_keep_their_secondary_and_say_where_they_are() -> None:
    rig = stranded()
    brief = told(rig)
    assert (brief.primary, brief.secondary, brief.epoch) == ("ATV2", "ATV1", 1)
    assert brief.trouble is Reason.SILENT
    assert isinstance(brief.stranded, StrandedGoods)
    assert (brief.stranded.atv, brief.stranded.node) == ("ATV2", "a1")
    assert brief.stranded.until_s == pytest.approx(rig.now_s + WRITTEN_OFF_AFTER_S, abs=6.0)


def test_they_are_made_again_after_the_stated_time_and_not_before() -> None:
    rig = stranded()
    stranded_until = told(rig).stranded
    assert isinstance(stranded_until, StrandedGoods)
    rig.run(stranded_until.until_s - 1.0)
    assert facts(rig.all, TaskClosed) == []
    assert not rig.is_cycling
    rig.run(stranded_until.until_s)
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["withdrawn"]
    assert rig.is_cycling
    assert sent(rig.all, Withdrawn, to="ATV2")


def test_a_vehicle_that_is_heard_again_goes_on_with_them() -> None:
    rig = stranded()
    beats(rig, "ATV2", 2)
    brief = told(rig)
    assert (brief.stranded, brief.trouble, brief.epoch) == (msgspec.UNSET, None, 1)
    rig.on_message("ATV2", handover(TASK, quantity=PUMPS))
    rig.on_message("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=PUMPS))
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["delivered"]


def test_a_goal_that_others_could_make_is_not_offered_while_its_goods_wait() -> None:
    rig = m7(goal=2 * PUMPS)
    rig.cycles(PUMPS)
    rig.hire(TASK, "ATV2")
    rig.on_message("ATV2", Docked(task=TASK, epoch=1, station="M7"))
    rig.stocked("pump-p3", -PUMPS, "ATV2")
    beats(rig, "ATV2", 1)
    rig.run(rig.now_s + GONE_S)
    assert told(rig).stranded is not msgspec.UNSET
    rig.broken = "it stands"
    rig.report(Broken("it stands", Problem(), resettable=False))
    assert says(rig, KIND.HAND_OVER, task="") is None
    rig.run(rig.now_s + GOODS_LEAVE_S + 10.0)
    assert offered(rig) == []
    assert says(rig, KIND.WRITE_OFF) is None
    rig.run(rig.now_s + 2.0)
    assert offered(rig) == ["G1"]


def offered(rig: MachineRig) -> list[str]:
    return [goal.goal for goal in rig.heartbeats(MachineHeartbeat)[-1].goals if goal.offered is True]


# --- they are handed over --------------------------------------------------------------------------


def test_the_secondary_is_asked_first_to_fetch_them_where_a_person_hands_them_over() -> None:
    rig = stranded()
    before = len(published(rig.all, TaskAnnounced))
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    award = sent(rig.all, Award, to="ATV1")[-1]
    assert (award.role, award.epoch, award.source) == (Role.PRIMARY, 2, NODE)
    assert isinstance(award.work, Transport)
    assert (award.work.sources, award.work.handed_at, award.work.quantity) == ((NODE,), NODE, PUMPS)
    assert len(published(rig.all, TaskAnnounced)) == before
    assert sent(rig.all, Superseded, to="ATV2") == [Superseded(task=TASK, epoch=2)]
    assert facts(rig.all, CarrierChanged)[-1].reason is Reason.HANDED_BY_PERSON


def test_who_names_no_node_hands_them_over_at_the_nearest_one_beside_the_vehicle() -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS) is None
    work = sent(rig.all, Award, to="ATV1")[-1].work
    assert isinstance(work, Transport)
    # The lane before the dock of the source warehouse.
    assert work.handed_at == "source-lane"


def test_without_a_secondary_everybody_is_asked() -> None:
    rig = stranded(watched=False)
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    work = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(work, Transport)
    assert work.handed_at == NODE


def test_goods_that_were_fetched_are_delivered_and_not_made_again() -> None:
    rig = stranded()
    fetched(rig)
    assert told(rig).stranded is msgspec.UNSET
    assert (told(rig).primary, told(rig).source) == ("ATV1", NODE)
    assert rig.stock["pump-p3"] == 0
    rig.on_message("ATV1", handover(TASK, epoch=2, quantity=PUMPS))
    rig.on_message("STRATEGIST", Confirmed(task="G1", epoch=1, arrived=PUMPS))
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["delivered"]
    rig.run(rig.now_s + 2.0 * WRITTEN_OFF_AFTER_S)
    assert not rig.is_cycling


def test_who_has_promised_to_hand_them_over_may_forget_it() -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    rig.run(rig.now_s + WRITTEN_OFF_AFTER_S + 10.0)
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["withdrawn"]
    assert rig.is_cycling


def test_what_is_brought_back_to_the_machine_after_all_is_sent_from_there() -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    rig.on_message("ATV1", accepted(TASK, epoch=2, number=award_number(rig.all, "ATV1", TASK)))
    rig.stocked("pump-p3", PUMPS)
    work = published(rig.all, TaskAnnounced)[-1].work
    assert isinstance(work, Transport)
    assert (work.sources, work.handed_at, told(rig).epoch) == (("M7",), "", 3)
    assert told(rig).stranded is msgspec.UNSET


def test_what_is_brought_back_while_everybody_is_being_asked_serves_its_goal_from_there() -> None:
    rig = stranded(watched=False)
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    rig.stocked("pump-p3", PUMPS)
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["withdrawn"]
    last = published(rig.all, TaskAnnounced)[-1]
    assert last.task != TASK
    assert isinstance(last.work, Transport)
    assert (last.work.quantity, last.work.sources) == (PUMPS, ("M7",))
    assert not rig.is_cycling


def test_the_second_carrier_may_die_with_them_too() -> None:
    rig = stranded()
    fetched(rig)
    rig.run(rig.now_s + GONE_S)
    again = told(rig).stranded
    assert isinstance(again, StrandedGoods)
    assert again.atv == "ATV1"
    assert says(rig, KIND.FETCH_GOODS, node="c2") is None
    assert told(rig).epoch == 3


# --- they are written off ---------------------------------------------------------------------------


def test_what_a_person_writes_off_is_made_again_at_once() -> None:
    rig = stranded()
    assert says(rig, KIND.WRITE_OFF) is None
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["withdrawn"]
    assert rig.is_cycling


def test_what_nobody_fetches_can_still_be_written_off() -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    assert says(rig, KIND.WRITE_OFF) is None
    assert [fact.outcome for fact in facts(rig.all, TaskClosed)] == ["withdrawn"]


# --- who says what is not so --------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [KIND.FETCH_GOODS, KIND.WRITE_OFF])
@pytest.mark.parametrize("task", [TASK, "M7-9", ""])
def test_a_word_about_goods_that_do_not_wait_is_refused(kind: MachineCommandKind, task: str) -> None:
    rig = loaded()
    assert says(rig, kind, task=task, node=NODE) is CommandRefusal.NOT_STRANDED
    assert told(rig).epoch == 1


@pytest.mark.parametrize("node", ["nowhere", "M7"])
def test_a_node_that_is_none_is_refused(node: str) -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS, node=node) is CommandRefusal.NO_SUCH_NODE
    assert told(rig).epoch == 1


def test_they_are_handed_over_once_and_never_after_they_were_written_off() -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is CommandRefusal.NOT_STRANDED
    assert says(rig, KIND.WRITE_OFF) is None
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is CommandRefusal.NOT_STRANDED
    assert says(rig, KIND.WRITE_OFF) is CommandRefusal.NOT_STRANDED


def test_whoever_answers_for_the_place_where_they_are_may_say_it() -> None:
    here = PLANT.nodes["a1"]
    [area] = PLANT.areas_near(here.x_m, here.y_m, 0.0)
    [other] = [each for each in PLANT.areas if each != area][:1]
    rig = stranded()
    assert says(rig, KIND.WRITE_OFF, areas=(other,)) is CommandRefusal.NOT_HERE
    assert says(rig, KIND.WRITE_OFF, areas=(area,)) is None


def test_the_first_carrier_cannot_deliver_them_once_another_one_fetches_them() -> None:
    rig = stranded()
    assert says(rig, KIND.FETCH_GOODS, node=NODE) is None
    effects = rig.on_message("ATV2", handover(TASK, quantity=PUMPS))
    assert sent(effects, Superseded, to="ATV2") == [Superseded(task=TASK, epoch=2)]


# --- another life ---------------------------------------------------------------------------------


def test_the_next_life_waits_for_them_as_long_as_this_one_would_have() -> None:
    rig = stranded()
    until = told(rig).stranded
    assert isinstance(until, StrandedGoods)
    again = MachineRig("M7", rig.stock, incarnation=2)
    again.memory, again.now_s = committed(rig.all), rig.now_s
    again.start()
    assert told(again).stranded == until
    assert says(again, KIND.FETCH_GOODS, node=NODE) is None
    assert told(again).epoch == 2
    third = MachineRig("M7", rig.stock, incarnation=3)
    third.memory, third.now_s = committed(again.all), again.now_s
    third.start()
    assert told(third).stranded == msgspec.structs.replace(until, handed_at=NODE)
    third.run(until.until_s + 1.0)
    assert [fact.outcome for fact in facts(third.all, TaskClosed)] == ["withdrawn"]
