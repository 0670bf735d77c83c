"""When a vehicle charges, whether it may work, and to whom it leaves its charger."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from defaults import PLANT

from dray.plant import Charging as Rules
from dray.plant import Hours, Plant
from dray.plant.charger_queue import RESERVE_FRAC, WORTH_FRAC
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray.protocol.vehicle.battery_reserve import BatteryReserve
from dray.protocol.vehicle.charging import GIVES_WAY_AGAIN_S, Charging

HERE = "ch2"
NIGHT = (Hours(start_h=22.0, end_h=6.0),)
HOUR_S = 3600.0


def plant_with(**rules: Any) -> Plant:
    types = tuple(msgspec.structs.replace(kind, charging=Rules(**rules)) for kind in PLANT.file.vehicle_types)
    return Plant(msgspec.structs.replace(PLANT.file, vehicle_types=types))


def vehicle(**rules: Any) -> Charging:
    return Charging(plant_with(**rules), "light")


def leaves(one: Charging, rival_frac: float, own_frac: float, **changes: Any) -> bool:
    circumstances = {"charging": True, "now_s": 0.0} | changes
    rival = circumstances.pop("rival", "ATV7")
    return one.gives_way(rival, rival_frac, battery_frac=own_frac, **circumstances)


def test_who_must_charge_takes_no_work_until_the_way_to_the_charger_was_worth_it() -> None:
    charging = vehicle()
    for level, works in ((0.26, True), (0.24, False), (0.3, False), (0.39, False), (0.4, True), (0.26, True)):
        charging.note(level, HERE)
        assert (charging.why_no_work(level) == "") is works, level
    charging.note(0.24, HERE)
    assert charging.why_no_work(0.24) == "must charge: 24% left, takes work again from 40% on"


def test_far_from_every_charger_a_vehicle_must_charge_earlier() -> None:
    needed_frac = BatteryReserve(PLANT, "light").needed_frac("a1")
    charging = vehicle(must_below_frac=0.0)
    charging.note(needed_frac + 0.001, "a1")
    assert not charging.is_needy
    charging.note(needed_frac - 0.001, "a1")
    assert charging.is_needy
    assert needed_frac > RESERVE_FRAC


@pytest.mark.parametrize(
    ("rules", "level", "now_s", "goes"),
    [
        ({}, 0.59, 0.0, True),
        ({}, 0.61, 0.0, False),
        ({"below_frac": 0.8}, 0.79, 0.0, True),
        ({"opportunity": False}, 0.3, 0.0, False),
        ({"opportunity": False}, 0.24, 0.0, True),
        ({"quiet_hours": NIGHT}, 0.5, 21.9 * HOUR_S, True),
        ({"quiet_hours": NIGHT}, 0.5, 22.0 * HOUR_S, False),
        ({"quiet_hours": NIGHT}, 0.5, 29.9 * HOUR_S, False),
        ({"quiet_hours": NIGHT}, 0.5, 30.0 * HOUR_S, True),
        ({"quiet_hours": NIGHT}, 0.2, 23.0 * HOUR_S, True),
        ({"quiet_hours": (Hours(start_h=0.0, end_h=24.0),)}, 0.5, 7.0 * HOUR_S, False),
        ({"quiet_hours": (Hours(start_h=9.0, end_h=11.5),)}, 0.5, (5 * 24 + 11.4) * HOUR_S, False),
        ({"quiet_hours": (Hours(start_h=9.0, end_h=11.5),)}, 0.5, (5 * 24 + 11.6) * HOUR_S, True),
    ],
)
def test_a_vehicle_without_work_goes_to_charge_by_the_rules_of_its_type(
    rules: dict[str, Any], level: float, now_s: float, goes: bool
) -> None:
    charging = vehicle(**rules)
    charging.note(level, HERE)
    assert charging.wants(level, now_s) is goes


def test_who_could_not_take_work_for_want_of_battery_charges_for_it_once() -> None:
    charging = vehicle(opportunity=False)
    charging.note(0.7, HERE)
    charging.note_short()
    assert charging.wants(0.7, 0.0)
    assert not charging.is_done(0.9, 0.0)
    charging.note(0.95, HERE)
    assert charging.is_done(0.95, 0.0)
    assert not charging.wants(0.7, 0.0)
    charging.note_short()
    assert not charging.wants(0.81, 0.0), "a charge of a few percent makes no difference"


def test_in_quiet_hours_a_charge_ends_when_there_is_enough() -> None:
    charging = vehicle(quiet_hours=NIGHT)
    assert charging.is_done(0.6, 23.0 * HOUR_S)
    assert not charging.is_done(0.59, 23.0 * HOUR_S)
    assert not charging.is_done(0.6, 12.0 * HOUR_S)
    assert charging.is_done(0.95, 12.0 * HOUR_S)


def test_a_full_vehicle_at_a_charger_does_not_plug_in_for_every_percent() -> None:
    charging = vehicle()
    assert not charging.plugs_in(0.94, 0.0)
    assert charging.plugs_in(0.89, 0.0)
    assert not vehicle(opportunity=False).plugs_in(0.5, 0.0)
    assert not vehicle(quiet_hours=NIGHT).plugs_in(0.5, 23.0 * HOUR_S)


@pytest.mark.parametrize(
    ("own", "rival", "leaves_it"),
    [
        (0.61, 0.4, True),
        (0.61, 0.61 - WORTH_FRAC + 0.01, False),
        (0.59, 0.3, False),
        (0.41, 0.2, True),
        (0.39, 0.2, False),
        (0.26, 0.09, True),
        (0.2, 0.09, False),
        (0.9, 0.8, False),
    ],
    ids=[
        "enough, and the other one needs it",
        "enough, and so has the other one",
        "it can still charge, and the other one still work",
        "it can work again, and the other one cannot",
        "it cannot work yet, and the other one can wait",
        "it cannot work yet, and the other one cannot wait",
        "both can wait no longer",
        "both have enough",
    ],
)
def test_a_charger_is_left_to_who_needs_it_more_when_that_is_worth_the_ways(
    own: float, rival: float, leaves_it: bool
) -> None:
    assert leaves(vehicle(), rival, own) is leaves_it


def test_who_stands_at_a_charger_for_nothing_leaves_it_to_anybody() -> None:
    charging = vehicle()
    for now_s in (0.0, 1.0, 2.0):
        assert leaves(charging, 0.94, 0.96, charging=False, now_s=now_s)


def test_one_that_says_again_and_again_to_be_empty_is_let_in_once_in_a_while() -> None:
    charging = vehicle()
    times_s = [float(minute * 60) for minute in range(180)]
    let_in = [now_s for now_s in times_s if leaves(charging, 0.0, 0.7, now_s=now_s)]
    assert let_in == [0.0, GIVES_WAY_AGAIN_S, 2 * GIVES_WAY_AGAIN_S, *let_in[3:]]
    assert len(let_in) == 6
    assert leaves(charging, 0.0, 0.7, rival="ATV8", now_s=1.0), "others are not to suffer for it"


def test_while_the_plant_rests_a_vehicle_charges_for_when_it_works() -> None:
    nights = WorkingHours(shifts=(WeeklySpan("06:00", "22:00"),))
    charging = Charging(Plant(msgspec.structs.replace(PLANT.file, working_time=nights)), "light")
    charging.note(0.7, HERE)
    assert charging.wants(0.7, 5 * HOUR_S)
    assert not charging.wants(0.7, 7 * HOUR_S)
    assert not charging.wants(0.85, 5 * HOUR_S)


def small_batteries(share: float) -> Plant:
    types = tuple(
        msgspec.structs.replace(kind, battery_wh=kind.battery_wh * share) for kind in PLANT.file.vehicle_types
    )
    return Plant(msgspec.structs.replace(PLANT.file, vehicle_types=types, chargers=PLANT.file.chargers[:2]))


def test_with_small_batteries_the_queue_at_the_chargers_is_kept_for() -> None:
    """Eight vehicles share two chargers: whoever is the last of four must still be there then."""
    plant = small_batteries(0.03)
    charging, queue = Charging(plant, "light"), plant.charger_queue
    base_frac, enough_frac = queue.base_frac("light"), queue.enough_frac("light")
    assert base_frac > RESERVE_FRAC + WORTH_FRAC
    assert BatteryReserve(plant, "light").needed_frac("a1") > base_frac
    charging.note(base_frac - 0.01, plant.node_of("CH1"))
    assert charging.is_needy
    charging.note(enough_frac - 0.01, plant.node_of("CH1"))
    assert charging.is_needy
    charging.note(enough_frac, plant.node_of("CH1"))
    assert not charging.is_needy
    assert leaves(charging, base_frac - 0.01, enough_frac)
    assert not leaves(charging, base_frac + 0.01, enough_frac - 0.01, rival="ATV8")


def test_who_spends_a_charge_in_minutes_is_let_in_again_after_minutes() -> None:
    charging = Charging(small_batteries(0.02), "light")
    times_s = [float(second) for second in range(0, 600, 5)]
    let_in = [now_s for now_s in times_s if leaves(charging, 0.0, 0.9, now_s=now_s)]
    assert 20.0 < let_in[1] - let_in[0] < 120.0
