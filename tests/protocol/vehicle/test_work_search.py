"""A vehicle that had no time asks for work that waits, and takes the most urgent (`work_search`)."""

from __future__ import annotations

import pytest
from atv1 import contracted, handing_over, parked
from defaults import PLANT
from effects import published, sent
from rigs import MachineRig, VehicleRig
from spoken import announcement, bid, production

from dray.messages import (
    Award,
    Bid,
    HandoverAccepted,
    Role,
    TaskAnnounced,
    Transport,
    WorkSought,
)
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.runtime.events import Publish
from dray.protocol.vehicle.work_search import ANSWER_S, ASK_AGAIN_S, ASKS, COLLECT_S, PAUSE_S


def everybody(task: str = "M8-9", needed_s: float = 0.0, coordinator: str = "M8") -> TaskAnnounced:
    """An announcement that reaches the whole plant."""
    return announcement(task=task, needed_s=needed_s, coordinator=coordinator, round=4)


def freed(*refused: TaskAnnounced) -> VehicleRig:
    """ATV1, which has refused these while it was at work, and has just handed over."""
    rig = handing_over()
    for message in refused:
        rig.on_message(message.coordinator, message)
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    return rig


def asked(rig: VehicleRig) -> int:
    return sum(isinstance(effect, Publish) and isinstance(effect.message, WorkSought) for effect in rig.all)


def test_who_had_no_time_when_everybody_was_asked_asks_as_soon_as_it_is_free() -> None:
    rig = freed(everybody())
    [sought] = published(rig.all, WorkSought)
    assert (sought.atv, sought.abilities) == ("ATV1", PLANT.vehicle_types["light"].abilities)


def test_who_has_refused_nothing_says_nothing() -> None:
    rig = freed()
    rig.run(rig.now_s + 60.0)
    assert asked(rig) == 0


def test_what_only_those_near_by_were_asked_for_is_not_waited_for() -> None:
    rig = freed(announcement(task="M8-9", radius_m=PLANT.diameter_m / 2))
    rig.run(rig.now_s + 60.0)
    assert asked(rig) == 0


def test_it_bids_for_the_most_urgent_of_what_it_is_offered() -> None:
    rig = freed(everybody())
    rig.on_message("M8", everybody("M8-7", needed_s=500.0))
    rig.on_message("M7", everybody("M7-3", needed_s=200.0, coordinator="M7"))
    assert not [each for each in sent(rig.all, Bid) if each.task in ("M8-7", "M7-3")]
    rig.run(rig.now_s + COLLECT_S)
    assert [each.task for each in sent(rig.all, Bid) if each.role is Role.PRIMARY][-1:] == ["M7-3"]
    assert "M8-7" not in [each.task for each in sent(rig.all, Bid)]


def test_it_bids_for_the_next_one_when_nothing_comes_of_it() -> None:
    rig = freed(everybody())
    rig.on_message("M8", everybody("M8-7", needed_s=500.0))
    rig.on_message("M7", everybody("M7-3", needed_s=200.0, coordinator="M7"))
    rig.run(rig.now_s + COLLECT_S + ANSWER_S)
    assert [each.task for each in sent(rig.all, Bid)][-2:] == ["M7-3", "M8-7"]


def test_who_gets_work_stops_asking() -> None:
    rig = freed(everybody())
    rig.on_message("M8", everybody("M8-7"))
    rig.run(rig.now_s + COLLECT_S)
    offered = everybody("M8-7")
    award = Award(
        task="M8-7", epoch=1, role=Role.PRIMARY, work=offered.work, deadline_s=offered.deadline_s, number=7
    )
    rig.on_message("M8", award)
    before = asked(rig)
    rig.run(rig.now_s + 5.0)
    assert asked(rig) == before


def test_a_question_that_may_be_lost_is_asked_again_and_then_no_more() -> None:
    rig = freed(everybody())
    rig.run(rig.now_s + ASKS * (COLLECT_S + ASK_AGAIN_S) + 60.0)
    assert asked(rig) == ASKS


def test_after_offers_that_came_to_nothing_it_pauses() -> None:
    rig = freed(everybody())
    rig.on_message("M8", everybody("M8-7"))
    begun_s = rig.now_s
    rig.run(begun_s + COLLECT_S + ANSWER_S + PAUSE_S - 1.0)
    assert asked(rig) == 1
    rig.run(begun_s + COLLECT_S + ANSWER_S + PAUSE_S + 6.0)
    assert asked(rig) == 2


def test_an_offer_that_comes_late_is_answered_all_the_same() -> None:
    rig = freed(everybody())
    rig.run(rig.now_s + COLLECT_S + 1.0)
    rig.on_message("M8", everybody("M8-7"))
    rig.run(rig.now_s + COLLECT_S)
    assert [each.task for each in sent(rig.all, Bid)][-1] == "M8-7"


def test_who_was_too_empty_asks_when_there_is_more_in_its_battery() -> None:
    rig = parked(node="ch2", battery_frac=0.06)
    rig.run(20.0)
    rig.on_message("M8", everybody())
    rig.run(rig.now_s + 30.0)
    assert asked(rig) == 0
    rig.battery_frac = 0.39
    rig.run(rig.now_s + 6.0)
    assert asked(rig) == 0, "it must charge some more before it works again"
    rig.battery_frac = 0.4
    rig.run(rig.now_s + 6.0)
    assert asked(rig) >= 1


# --- the coordinator -----------------------------------------------------------------------------


def waiting() -> tuple[MachineRig, TaskAnnounced]:
    """M7, whose housings nobody has had time to bring; and their announcement."""
    rig = MachineRig("M7", {"housing": 0, "impeller": 90, "seal-kit": 120})
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.run(rig.now_s + 30.0)
    [first] = {each.task: each for each in published(rig.all, TaskAnnounced)}.values()
    assert first.radius_m >= PLANT.diameter_m
    return rig, first


def abilities_of(message: TaskAnnounced) -> tuple[str, ...]:
    assert isinstance(message.work, Transport)
    return (message.work.ability,)


def test_a_machine_offers_what_waits_to_the_one_that_asks_and_to_nobody_else() -> None:
    rig, waits = waiting()
    effects = rig.on_message("ATV1", WorkSought(atv="ATV1", abilities=abilities_of(waits)))
    [offered] = sent(effects, TaskAnnounced, to="ATV1")
    assert (offered.task, offered.needed_s) == (waits.task, waits.needed_s)
    assert published(effects, TaskAnnounced) == []


def test_its_bid_is_taken_at_once() -> None:
    rig, waits = waiting()
    effects = rig.on_message("ATV1", WorkSought(atv="ATV1", abilities=abilities_of(waits)))
    [offered] = sent(effects, TaskAnnounced, to="ATV1")
    effects = rig.on_message("ATV1", bid(50.0, task=offered.task, round=offered.round))
    assert [award.task for award in sent(effects, Award, to="ATV1")] == [waits.task]


def test_who_has_bid_in_vain_in_this_round_may_bid_for_an_offer() -> None:
    rig, waits = waiting()
    rig.on_message("ATV1", WorkSought(atv="ATV1", abilities=abilities_of(waits)))
    effects = rig.on_message("ATV1", bid(50.0, task=waits.task, round=waits.round))
    [award] = sent(effects, Award, to="ATV1")
    rig.run(rig.now_s + 15.0)  # It does not answer, and is released.
    effects = rig.on_message("ATV1", WorkSought(atv="ATV1", abilities=abilities_of(waits)))
    [offered] = sent(effects, TaskAnnounced, to="ATV1")
    effects = rig.on_message("ATV1", bid(50.0, task=offered.task, round=offered.round))
    assert [each.number for each in sent(effects, Award, to="ATV1")] == [award.number + 1]


@pytest.mark.parametrize("abilities", [(), ("cold",)])
def test_what_a_vehicle_cannot_carry_is_not_offered_to_it(abilities: tuple[str, ...]) -> None:
    rig, _ = waiting()
    assert sent(rig.on_message("ATV1", WorkSought(atv="ATV1", abilities=abilities)), TaskAnnounced) == []


def test_a_machine_for_which_nothing_waits_offers_nothing() -> None:
    rig = MachineRig("M7", {"housing": 72, "impeller": 90, "seal-kit": 120})
    rig.start()
    assert sent(rig.on_message("ATV1", WorkSought(atv="ATV1", abilities=("tote",))), TaskAnnounced) == []


def test_what_is_less_urgent_is_not_announced_while_the_same_vehicles_are_sought_in_vain() -> None:
    rig = MachineRig("M7", {"housing": 0, "impeller": 90, "seal-kit": 120})
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.run(rig.now_s + 600.0)
    announced = published(rig.all, TaskAnnounced)
    rounds = {each.task: max(one.round for one in announced if one.task == each.task) for each in announced}
    # Rounds of one task, ever more rarely; before, there were more than twenty-five in ten minutes.
    assert max(rounds.values()) <= 11


def test_rests_grow_with_the_age_of_the_auction() -> None:
    rules = AuctionRules()
    assert rules.rest_in_s(1) == rules.rest_s
    assert rules.rest_in_s(9, 50.0) == 50.0
    assert rules.rest_in_s(9, 5000.0) == rules.rest_aged_max_s


def test_a_vehicle_at_work_asks_for_nothing() -> None:
    rig = contracted()
    rig.on_message("M8", everybody())
    rig.run(rig.now_s + 5.0)
    assert asked(rig) == 0
