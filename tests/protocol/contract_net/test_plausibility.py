"""What cannot be is refused, whoever says it, and what can be is not."""

from __future__ import annotations

import math

import pytest
from defaults import PLANT
from msgspec.structs import replace
from spoken import bid, goal_bid, production, transport

from dray.messages import Bid, Implausible, Transport
from dray.messages.base import CLOCK_WRONG_S
from dray.plant import Plant
from dray.protocol.contract_net.trust.plausibility import (
    LATE_S,
    LATEST_GOAL_S,
    UNDER_WAY_S,
    Plausibility,
    by_our_clock,
    clock_ahead_s,
)
from dray.protocol.vehicle.pricing import Pricer, Unable
from dray_sim.plants.draw import draw_plant

CHECK = Plausibility(PLANT)
NOW_S = 1000.0


def objection(offer: Bid, work: Transport | None = None) -> str:
    return CHECK.objection(work or transport(), offer, NOW_S)


def with_cost(**parts_s: float) -> Bid:
    honest = bid(200.0)
    return replace(honest, cost=replace(honest.cost, **parts_s))


@pytest.mark.parametrize("plant", [PLANT, draw_plant(269, small=True), draw_plant(21, small=True)], ids=str)
def test_every_price_and_every_promise_of_an_honest_vehicle_is_believed(plant: Plant) -> None:
    check = Plausibility(plant)
    for work in transports_of(plant):
        for kind, vehicle in plant.vehicle_types.items():
            pricer = Pricer(plant, kind)
            for node in plant.nodes:
                quote = pricer.quote(
                    work, node=node, node_at_s=NOW_S, battery_frac=1.0, now_s=NOW_S, deadline_s=math.inf
                )
                if work.ability not in vehicle.abilities or isinstance(quote, Unable):
                    continue
                offer = replace(bid(0.0), cost=quote.cost, finish_s=quote.finish_s, source=quote.source)
                assert check.objection(work, offer, NOW_S + UNDER_WAY_S) is None
                assert check.believed_s(work, offer, quote.finish_s, NOW_S) == quote.finish_s


def transports_of(plant: Plant) -> list[Transport]:
    """One of each material to each machine that needs it."""
    return [
        Transport(
            item=material,
            quantity=1,
            sources=plant.storages_of(material),
            destination=machine,
            ability=plant.ability_of(material),
        )
        for machine in plant.machines
        for material in plant.materials_of(machine)
    ]


@pytest.mark.parametrize(
    ("offer", "reason"),
    [
        (bid(0.0), Implausible.TOO_CHEAP),
        (with_cost(loaded_way_s=-1e11), Implausible.NEGATIVE),
        (with_cost(energy_s=-1.0), Implausible.NEGATIVE),
        (with_cost(suitability_s=math.nan), Implausible.NOT_A_NUMBER),
        (with_cost(empty_way_s=math.inf), Implausible.NOT_A_NUMBER),
        (bid(200.0, finish_s=math.nan), Implausible.NOT_A_NUMBER),
        (bid(200.0, finish_s=NOW_S), Implausible.TOO_SOON),
        (bid(200.0, finish_s=0.0), Implausible.BEFORE_NOW),
        (bid(200.0, source="S1"), Implausible.OTHER_SOURCE),
        (goal_bid("T1", 200.0), Implausible.OTHER_WORK),
    ],
)
def test_what_cannot_be_is_refused(offer: Bid, reason: str) -> None:
    assert objection(offer) == reason


def test_a_machine_cannot_be_paid_for_a_goal() -> None:
    offer = goal_bid("G1", -1.0)
    assert CHECK.objection(production(), replace(offer, finish_s=NOW_S), NOW_S) == Implausible.NEGATIVE
    assert CHECK.objection(production(), replace(goal_bid("G1", 90.0), finish_s=NOW_S), NOW_S) is None


def test_a_promise_beyond_the_longest_way_buys_no_time() -> None:
    work = transport()
    assert CHECK.believed_s(work, None, 1e11, NOW_S) == NOW_S + CHECK.longest_s(work)
    assert CHECK.believed_s(work, bid(50.0), 1e11, NOW_S) < NOW_S + CHECK.longest_s(work)
    assert CHECK.believed_s(work, None, 0.0, NOW_S) == NOW_S


# --- clocks --------------------------------------------------------------------------------------


def by_clock(ahead_s: float, **fields: float) -> Bid:
    """A bid of a minute's work, made now by a clock that is ahead."""
    honest = bid(200.0, finish_s=NOW_S + ahead_s + 260.0)
    return replace(honest, at_s=NOW_S + ahead_s, **fields)


@pytest.mark.parametrize("ahead_s", [0.0, 0.9, -1.0, -UNDER_WAY_S])
def test_what_a_link_and_an_honest_clock_explain_is_no_wrong_clock(ahead_s: float) -> None:
    assert clock_ahead_s(NOW_S + ahead_s, NOW_S) == 0.0
    assert by_our_clock(by_clock(ahead_s), NOW_S) == by_clock(ahead_s)


@pytest.mark.parametrize("ahead_s", [2.0, 60.0, CLOCK_WRONG_S, -10.0, -60.0, -CLOCK_WRONG_S])
def test_a_clock_that_is_a_little_wrong_is_made_up_for(ahead_s: float) -> None:
    righted = by_our_clock(by_clock(ahead_s), NOW_S)
    assert righted.finish_s == pytest.approx(NOW_S + 260.0)
    assert CHECK.objection(transport(), righted, NOW_S) is None


@pytest.mark.parametrize("ahead_s", [3600.0, -3600.0, -1.9e9, 1e11, -(CLOCK_WRONG_S + 1.0)])
def test_a_clock_that_is_wrong_is_not_believed_in_anything(ahead_s: float) -> None:
    offer = by_clock(ahead_s)
    assert by_our_clock(offer, NOW_S) == offer
    assert CHECK.objection(transport(), offer, NOW_S) == Implausible.CLOCK
    assert clock_ahead_s(offer.at_s, NOW_S) == pytest.approx(ahead_s)


def test_who_does_not_tell_when_it_was_said_is_judged_by_what_it_promises() -> None:
    honest = bid(200.0, finish_s=NOW_S + 260.0)
    assert CHECK.objection(transport(), honest, NOW_S) is None
    late = replace(honest, finish_s=NOW_S + 1.5 * 200.0 + 2.0 * CHECK.handling_max_s + LATE_S + 1.0)
    assert CHECK.objection(transport(), late, NOW_S) == Implausible.TOO_LATE


def test_a_goal_may_take_weeks_and_is_believed_as_long_as_it_takes() -> None:
    goal = replace(goal_bid("G1", 1e6), finish_s=NOW_S + 1e6)
    assert CHECK.objection(production(), goal, NOW_S) is None
    assert CHECK.believed_s(production(), goal, goal.finish_s, NOW_S) == goal.finish_s
    assert (
        CHECK.objection(production(), replace(goal, finish_s=NOW_S + LATEST_GOAL_S + 1.0), NOW_S)
        == Implausible.TOO_LATE
    )
