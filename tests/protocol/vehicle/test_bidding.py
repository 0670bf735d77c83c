"""Whether a vehicle bids, and what it says when it does not (paper, 4.1)."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from defaults import PLANT
from effects import facts, sent
from spoken import announcement, award, production, transport

from dray.messages import Bid, DockTime, Refusal, Role, TransportCost, Wait
from dray.messages.fact import BidRefused, BidSent
from dray.protocol.contract_net.trust.probation import Probation
from dray.protocol.contract_net.waits import Waits
from dray.protocol.runtime.events import Effect, Record, Send
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.bidding import (
    MAX_WATCHES,
    PLACES_TOLD,
    RESERVE_AFTER_S,
    Bidder,
    Standing,
)
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.pricing import Quote, Unable
from dray_sim.plants.raster import draw_raster

SPOT = PLANT.nodes["p3"]
FREE = Standing(
    node="p3",
    node_at_s=0.0,
    x_m=SPOT.x_m,
    y_m=SPOT.y_m,
    speed_frac=1.0,
    battery_frac=0.9,
    unfit="",
    busy_with="",
    watches=0,
)


def standing(**changes: Any) -> Standing:
    return msgspec.structs.replace(FREE, **changes)


def bidder(kind: str, life: Life) -> Bidder:
    return Bidder("ATV1", PLANT, kind, Probation(0), Charging(PLANT, kind), Waits(), life)


def on_announcement(circumstances: Standing = FREE, *, kind: str = "light", **changes: Any) -> list[Effect]:
    """What a vehicle does about an announcement."""
    life = Life()
    bidder(kind, life).on_announced(announcement(**changes), circumstances, 0.0)
    return life.effects


def review(circumstances: Standing = FREE, **changes: Any) -> Quote | Unable:
    return bidder("light", []).review(award(**changes), circumstances, 0.0)


def test_a_free_vehicle_bids_straight_to_the_coordinator_with_its_breakdown() -> None:
    out = on_announcement()
    [bid] = sent(out, Bid, to="M8")
    assert (bid.task, bid.epoch, bid.role, bid.round) == ("M8-1", 1, Role.PRIMARY, 1)
    assert bid.source == "S3"
    assert bid.cost.total_s > bid.cost.loaded_way_s > 0.0
    assert bid.finish_s > 0.0


def test_a_bid_leaves_before_it_is_recorded_as_sent() -> None:
    said, recorded = on_announcement()
    assert isinstance(said, Send)
    assert isinstance(recorded, Record)
    assert isinstance(recorded.fact, BidSent)
    assert recorded.fact.total_s == said.message.cost.total_s


def test_a_bid_names_the_round_and_epoch_that_it_answers() -> None:
    [bid] = sent(on_announcement(round=7, epoch=3), Bid)
    assert (bid.round, bid.epoch) == (7, 3)


def test_a_vehicle_outside_of_the_circle_says_nothing() -> None:
    assert on_announcement(x_m=SPOT.x_m + 25.1, y_m=SPOT.y_m, radius_m=25.0) == []


def test_a_vehicle_on_the_edge_of_the_circle_bids() -> None:
    assert sent(on_announcement(x_m=SPOT.x_m + 25.0, y_m=SPOT.y_m, radius_m=25.0), Bid)


def test_a_refusal_is_said_once_for_a_task_however_often_it_is_announced() -> None:
    life = Life()
    one = bidder("light", life)
    busy, empty = standing(busy_with="M7-1"), standing(battery_frac=0.05)
    for number in range(1, 6):
        one.on_announced(announcement(round=number), standing(busy_with=f"M7-{number}"), 0.0)
    assert len(facts(life.effects, BidRefused)) == 1
    one.on_announced(announcement(round=6), empty, 0.0)
    assert [fact.reason for fact in facts(life.effects, BidRefused)] == [Refusal.BUSY, Refusal.BATTERY]
    one.on_announced(announcement(task="M8-2"), empty, 0.0)
    one.on_announced(announcement(epoch=2), empty, 0.0)
    assert len(facts(life.effects, BidRefused)) == 4
    for number in (7, 9):
        one.on_announced(announcement(round=number, epoch=2), FREE, 0.0)
        one.on_announced(announcement(round=number + 1, epoch=2), busy, 0.0)
    assert len(facts(life.effects, BidRefused)) == 6, "who has bid meanwhile has news when it refuses"


def test_one_that_must_charge_takes_work_again_when_it_has_charged() -> None:
    life = Life()
    one = bidder("light", life)
    for level, bids in ((0.3, 1), (0.2, 1), (0.39, 1), (0.4, 2)):
        one.on_announced(announcement(), standing(battery_frac=level), 0.0)
        assert len(sent(life.effects, Bid)) == bids, level


@pytest.mark.parametrize(
    ("circumstances", "changes", "reason", "detail"),
    [
        ({"unfit": "stopped by an operator"}, {}, Refusal.NOT_FIT, "stopped by an operator"),
        ({"busy_with": "M7-1"}, {}, Refusal.BUSY, "M7-1"),
        ({"battery_frac": 0.05}, {}, Refusal.BATTERY, "must charge: 5% left"),
        ({"battery_frac": 0.05}, {"role": Role.SECONDARY, "primary": "ATV2"}, Refusal.BATTERY, "must charge"),
        ({}, {"deadline_s": 5.0}, Refusal.DEADLINE, "too late"),
        ({}, {"work": transport(ability="pallet")}, Refusal.ABILITY, "pallet"),
        ({}, {"work": production()}, Refusal.ABILITY, "not a transport"),
        ({}, {"work": transport(sources=("nowhere",))}, Refusal.NO_WAY, "not in this plant"),
        ({}, {"role": Role.SECONDARY, "primary": "ATV1"}, Refusal.IS_PRIMARY, ""),
        ({}, {"role": Role.SECONDARY, "primary": ""}, Refusal.IS_PRIMARY, ""),
        (
            {"watches": MAX_WATCHES},
            {"role": Role.SECONDARY, "primary": "ATV2"},
            Refusal.WATCHING_ENOUGH,
            "3 tasks",
        ),
    ],
    ids=lambda value: value.value if isinstance(value, Refusal) else "",
)
def test_a_refusal_is_an_event_with_its_reason_and_no_message(
    circumstances: dict[str, Any], changes: dict[str, Any], reason: Refusal, detail: str
) -> None:
    out = on_announcement(standing(**circumstances), **changes)
    [refused] = facts(out, BidRefused)
    assert refused.reason is reason
    assert detail in refused.detail
    assert len(out) == 1


def test_watches_do_not_keep_a_vehicle_from_work_of_its_own() -> None:
    assert sent(on_announcement(standing(watches=MAX_WATCHES)), Bid)


def test_a_watch_is_bid_for_even_when_its_deadline_is_past() -> None:
    assert sent(on_announcement(role=Role.SECONDARY, primary="ATV2", deadline_s=-1.0), Bid)


def test_an_award_is_reviewed_from_where_the_vehicle_is_by_then() -> None:
    near, far = review(), review(standing(node="p8"))
    assert isinstance(near, Quote)
    assert isinstance(far, Quote)
    assert far.finish_s > near.finish_s


def test_an_award_is_reviewed_for_the_source_it_names() -> None:
    both = transport(sources=("S8", "S3"))
    for source in both.sources:
        found = review(work=both, source=source)
        assert isinstance(found, Quote)
        assert found.source == source


@pytest.mark.parametrize(
    ("circumstances", "reason"),
    [
        ({"busy_with": "M7-1"}, Refusal.BUSY),
        ({"unfit": "a wheel is stuck"}, Refusal.NOT_FIT),
        ({"battery_frac": 0.05}, Refusal.BATTERY),
        ({"node_in_m": 20_000.0}, Refusal.BATTERY),
    ],
)
def test_an_award_is_declined_when_things_have_changed_since_the_bid(
    circumstances: dict[str, Any], reason: Refusal
) -> None:
    found = review(standing(**circumstances))
    assert isinstance(found, Unable)
    assert found.reason is reason


# --- waits ---------------------------------------------------------------------------------------


def test_a_promise_and_a_price_count_what_the_coordinator_tells_of_waits() -> None:
    [plain] = sent(on_announcement(), Bid)
    [waits] = sent(on_announcement(waits=(Wait(place="M8", wait_s=40.0),)), Bid)
    assert isinstance(waits.cost, TransportCost)
    assert waits.cost.waiting_s == 40.0
    # Who stands uses energy, too, though little.
    assert plain.cost.total_s + 40.0 < waits.cost.total_s < plain.cost.total_s + 42.0
    assert waits.finish_s == pytest.approx(plain.finish_s + 40.0)


def test_a_promise_and_a_price_count_who_is_at_the_dock_before_it() -> None:
    [plain] = sent(on_announcement(), Bid)
    comes_s = plain.finish_s - PLANT.vehicle_types["light"].unload_s
    before = DockTime(atv="ATV9", comes_s=comes_s - 10.0, leaves_s=comes_s + 17.0)
    own = DockTime(atv="ATV1", comes_s=comes_s - 10.0, leaves_s=comes_s + 90.0)
    behind = DockTime(atv="ATV8", comes_s=comes_s + 10.0, leaves_s=comes_s + 50.0)
    told = Wait(place="M8", wait_s=0.0, expected=(before, own, behind))
    [bid] = sent(on_announcement(waits=(told,)), Bid)
    assert isinstance(bid.cost, TransportCost)
    assert bid.cost.waiting_s == pytest.approx(17.0)
    assert bid.finish_s == pytest.approx(plain.finish_s + 17.0)


def test_a_source_at_which_nobody_waits_is_chosen_before_a_nearer_one_at_which_all_do() -> None:
    work = transport(sources=("S3", "S6"))
    [near] = sent(on_announcement(work=work), Bid)
    [far] = sent(on_announcement(work=work, waits=(Wait(place=near.source, wait_s=500.0),)), Bid)
    assert {near.source, far.source} == {"S3", "S6"}
    assert isinstance(far.cost, TransportCost)
    assert far.cost.waiting_s == 0.0


def test_no_coordinator_tells_of_more_places_than_a_transport_has() -> None:
    told = tuple(Wait(place=f"X{number}", wait_s=1.0) for number in range(PLACES_TOLD))
    [bid] = sent(on_announcement(waits=(*told, Wait(place="M8", wait_s=40.0))), Bid)
    assert isinstance(bid.cost, TransportCost)
    assert bid.cost.waiting_s == 0.0


# --- a fleet that is too large for the roads ----------------------------------------------------------


def at(now_s: float, circumstances: Standing, **changes: Any) -> list[Effect]:
    """What a vehicle does about an announcement at a time."""
    life = Life()
    bidder("light", life).on_announced(
        announcement(deadline_s=now_s + 900.0, needed_s=500.0, **changes), circumstances, now_s
    )
    return life.effects


def test_the_reserve_leaves_work_to_others_until_it_has_waited_for_long() -> None:
    reserve = standing(is_reserve=True)
    early, late = 500.0 + RESERVE_AFTER_S - 1.0, 500.0 + RESERVE_AFTER_S
    [refused] = facts(at(early, reserve), BidRefused)
    assert refused.reason is Refusal.NOT_FIT
    assert "reserve" in refused.detail
    assert sent(at(early, reserve), Bid) == []
    assert len(sent(at(late, reserve), Bid)) == 1
    assert len(sent(at(early, FREE), Bid)) == 1


def test_the_reserve_carries_what_nobody_else_may_and_watches_those_at_work() -> None:
    reserve = standing(is_reserve=True)
    assert len(sent(at(0.0, reserve, work=transport(vehicle="ATV1")), Bid)) == 1
    assert len(sent(at(0.0, reserve, role=Role.SECONDARY, primary="ATV2"), Bid)) == 1


@pytest.mark.parametrize(("seed", "leaves"), [(17, True), (4, False)])
def test_the_reserve_carries_what_too_few_others_can(seed: int, leaves: bool) -> None:
    """In raster 4 two of five vehicles carry what only the larger type can; the reserve may be both of them."""
    plant = draw_raster(seed)
    large = plant.vehicle_types["all"]
    rare = large.abilities[-1]
    item = next(name for name in (*plant.materials, *plant.products) if plant.ability_of(name) == rare)
    source, machine = next(iter(plant.storages)), next(iter(plant.machines))
    life = Life()
    spot = plant.nodes[plant.spare_places.reserve[0]]
    circumstances = standing(node=spot.id, x_m=spot.x_m, y_m=spot.y_m, is_reserve=True)
    carrier = Bidder("V1", plant, large.id, Probation(0), Charging(plant, large.id), Waits(), life)
    work = transport(item=item, sources=(source,), destination=machine, ability=rare)
    asked = announcement(work=work, x_m=spot.x_m, y_m=spot.y_m, coordinator=machine)
    carrier.on_announced(asked, circumstances, 0.0)
    assert (sent(life.effects, Bid) == []) is leaves
