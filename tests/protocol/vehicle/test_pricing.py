"""What a transport costs (paper, 4.1)."""

from __future__ import annotations

from typing import Any

import pytest
from defaults import PLANT
from spoken import transport

from dray.messages import Refusal
from dray.plant.charger_queue import RESERVE_FRAC
from dray.protocol.vehicle.pricing import (
    LOW_BATTERY_S,
    SPARE_ABILITY_S,
    Pricer,
    Quote,
    Unable,
    low_battery_s,
)

LIGHT = PLANT.vehicle_types["light"]
ROUTES = PLANT.routes("light")


def answer(kind: str = "light", **changes: Any) -> Quote | Unable:
    """What a vehicle at P3 with a good battery answers to the usual transport, with something changed."""
    work = changes.pop("work", transport())
    circumstances = {
        "node": "p3",
        "node_at_s": 0.0,
        "battery_frac": 0.9,
        "now_s": 0.0,
        "deadline_s": 3600.0,
    }
    return Pricer(PLANT, kind).quote(work, **(circumstances | changes))


def quote(kind: str = "light", **changes: Any) -> Quote:
    found = answer(kind, **changes)
    assert isinstance(found, Quote), found
    return found


def refusal(kind: str = "light", **changes: Any) -> Unable:
    found = answer(kind, **changes)
    assert isinstance(found, Unable), found
    return found


# --- the parts -----------------------------------------------------------------------------------


def test_the_parts_add_up_to_the_price() -> None:
    cost = quote().cost
    parts = (cost.empty_way_s, cost.loaded_way_s, cost.energy_s, cost.suitability_s)
    assert cost.total_s == pytest.approx(sum(parts))
    assert all(part >= 0.0 for part in parts)


def test_the_ways_are_those_of_the_plant() -> None:
    cost = quote().cost
    assert cost.empty_way_s == ROUTES.duration_s("p3", PLANT.node_of("S3"))
    assert cost.loaded_way_s == ROUTES.duration_s(PLANT.node_of("S3"), PLANT.node_of("M8"))


def test_the_promise_is_both_ways_and_both_manoeuvres() -> None:
    found = quote(now_s=1000.0, node_at_s=1000.0)
    ways_s = found.cost.empty_way_s + found.cost.loaded_way_s
    assert found.finish_s == pytest.approx(1000.0 + ways_s + LIGHT.load_s + LIGHT.unload_s)


def test_a_vehicle_that_is_under_way_adds_what_it_needs_to_its_next_node() -> None:
    standing, moving = quote(), quote(node_at_s=7.0)
    assert moving.cost.empty_way_s == pytest.approx(standing.cost.empty_way_s + 7.0)
    assert moving.finish_s == pytest.approx(standing.finish_s + 7.0)


def test_the_nearer_vehicle_is_cheaper() -> None:
    assert quote(node="s3-lane").cost.total_s < quote(node="p8").cost.total_s


def test_of_several_sources_the_cheapest_is_offered() -> None:
    sources = ("S8", "S3", "S1")
    best = quote(work=transport(sources=sources))
    alone_s = {each: quote(work=transport(sources=(each,))).cost.total_s for each in sources}
    assert best.source == min(alone_s, key=alone_s.__getitem__)
    assert best.cost.total_s == alone_s[best.source]


def test_of_several_sources_one_is_offered_that_can_be_kept_though_another_is_cheaper() -> None:
    # From here a heavy vehicle gets from S7 to M11 sooner than from S5, and uses more energy.
    work, here = transport(sources=("S5", "S7"), destination="M11"), "s7-lane"
    cheapest = quote("heavy", work=work, node=here)
    sooner = quote("heavy", work=transport(sources=("S7",), destination="M11"), node=here)
    assert cheapest.source == "S5"
    assert sooner.finish_s < cheapest.finish_s
    between_s = (sooner.finish_s + cheapest.finish_s) / 2
    assert quote("heavy", work=work, node=here, deadline_s=between_s) == sooner
    late = refusal("heavy", work=work, node=here, deadline_s=sooner.finish_s - 1.0)
    assert late.reason is Refusal.DEADLINE


def test_a_vehicle_that_could_do_rarer_work_is_held_back() -> None:
    assert quote("light").cost.suitability_s == 0.0
    assert quote("heavy").cost.suitability_s == SPARE_ABILITY_S


# --- the battery ---------------------------------------------------------------------------------


def test_an_emptier_battery_costs_more() -> None:
    full, half, low = (quote(battery_frac=frac).cost.energy_s for frac in (1.0, 0.4, 0.25))
    assert full < half < low


def test_above_half_the_battery_costs_nothing_but_its_energy() -> None:
    assert low_battery_s(1.0) == low_battery_s(0.5) == 0.0
    assert quote(battery_frac=1.0).cost.energy_s == quote(battery_frac=0.8).cost.energy_s


def test_an_empty_battery_costs_a_way_across_the_plant_and_no_more() -> None:
    assert low_battery_s(0.0) == LOW_BATTERY_S


def test_a_vehicle_that_would_not_reach_a_charger_afterwards_refuses() -> None:
    found = refusal(battery_frac=RESERVE_FRAC + 0.001)
    assert found.reason is Refusal.BATTERY
    assert "%" in found.detail


def test_a_vehicle_quotes_as_long_as_its_reserve_stays_untouched() -> None:
    quoted = [frac / 1000 for frac in range(1000) if isinstance(answer(battery_frac=frac / 1000), Quote)]
    least = min(quoted)
    assert least > RESERVE_FRAC
    assert quoted == [frac / 1000 for frac in range(round(least * 1000), 1000)]


def test_the_way_to_the_next_node_must_not_touch_the_reserve_and_costs_nothing() -> None:
    """A vehicle that stands at its node, and one that still drives 100 m to it with the same battery."""
    standing = [frac / 1000 for frac in range(1000) if isinstance(answer(battery_frac=frac / 1000), Quote)]
    on_the_way = [
        frac / 1000
        for frac in range(1000)
        if isinstance(answer(battery_frac=frac / 1000, node_in_m=100.0), Quote)
    ]
    used_frac = 100.0 * LIGHT.drive_wh_per_m / LIGHT.battery_wh
    assert used_frac > 0.002
    assert min(on_the_way) - min(standing) == pytest.approx(used_frac, abs=0.001)
    assert quote(node_in_m=100.0).cost == quote().cost
    assert refusal(battery_frac=min(standing), node_in_m=100.0).reason is Refusal.BATTERY


# --- the other refusals --------------------------------------------------------------------------


def test_a_vehicle_without_the_ability_refuses() -> None:
    pallet = transport(item="housing", quantity=24, sources=("S2",), ability="pallet")
    found = refusal(work=pallet)
    assert found.reason is Refusal.ABILITY
    assert "pallet" in found.detail
    assert isinstance(answer("heavy", work=pallet), Quote)


def test_a_vehicle_without_what_somebody_wants_beside_it_refuses() -> None:
    wanted = transport(also="pallet")
    found = refusal(work=wanted)
    assert found.reason is Refusal.ABILITY
    assert "pallet" in found.detail
    assert isinstance(answer("heavy", work=wanted), Quote)


def test_a_vehicle_that_would_be_late_refuses_and_says_by_how_much() -> None:
    finish_s = quote().finish_s
    assert isinstance(answer(deadline_s=finish_s), Quote)
    found = refusal(deadline_s=finish_s - 10.0)
    assert found.reason is Refusal.DEADLINE
    assert found.detail == "10 s too late"


@pytest.mark.parametrize("change", [{"sources": ("nowhere",)}, {"destination": "nowhere"}])
def test_a_vehicle_refuses_a_way_to_a_place_that_is_not_in_its_plant(change: dict[str, Any]) -> None:
    assert refusal(work=transport(**change)).reason is Refusal.NO_WAY


# --- a speed limit -------------------------------------------------------------------------------


def test_whoever_was_told_to_drive_slowly_bids_and_promises_what_it_can_keep() -> None:
    plain, slow = quote(), quote(speed_frac=0.2)
    assert slow.cost.empty_way_s == pytest.approx(5.0 * plain.cost.empty_way_s)
    assert slow.cost.loaded_way_s == pytest.approx(5.0 * plain.cost.loaded_way_s)
    handling_s = LIGHT.load_s + LIGHT.unload_s
    assert slow.finish_s == pytest.approx(5.0 * (plain.finish_s - handling_s) + handling_s)


def test_whoever_is_too_slow_for_a_deadline_leaves_it_to_others() -> None:
    deadline_s = 2.0 * quote().finish_s
    assert refusal(speed_frac=0.2, deadline_s=deadline_s).reason is Refusal.DEADLINE


def test_a_limit_of_next_to_nothing_is_still_a_number() -> None:
    assert quote(speed_frac=1e-9, deadline_s=float("inf")).finish_s < 1e6
