"""Finding a place to charge, to park or to wait, with nobody in the middle."""

from __future__ import annotations

import msgspec
import pytest
from defaults import KEYS, PLANT
from effects import listening, published

from dray.messages import DwellPointClaimed
from dray.plant import Plant
from dray.plant.charger_queue import WORTH_FRAC
from dray.protocol.runtime.events import Publish, Subscribe
from dray.protocol.runtime.life import Life
from dray.protocol.vehicle.dwell_points import (
    APPROACH_S,
    BLOCKED_S,
    MUCH_NEARER,
    TAKEN_MEMORY_S,
    DwellPoints,
    Hold,
)
from dray.protocol.vehicle.idle_positioning import WaitingPlaces
from dray.protocol.vehicle.reserve import STAYS_S
from dray_sim.plants.raster import draw_raster


class Driver:
    """One vehicle's side of a contest."""

    def __init__(self, atv: str = "ATV5") -> None:
        self.life = Life()
        self.out = self.life.effects
        self.dwell_points = DwellPoints(atv, PLANT, "light", KEYS, self.life)

    def seek(self, *, charger: bool = True, battery_frac: float = 0.5, now_s: float = 0.0) -> bool:
        return self.dwell_points.seek(charger=charger, node="e3", battery_frac=battery_frac, now_s=now_s)

    @property
    def claims(self) -> list[DwellPointClaimed]:
        return [effect.message for effect in self.life.effects if isinstance(effect, Publish)]

    @property
    def keys(self) -> set[str]:
        return listening(self.life.effects)


def rival(
    dwell_point: str, atv: str = "ATV7", battery_frac: float = 0.5, *, standing: bool = False
) -> DwellPointClaimed:
    return DwellPointClaimed(dwell_point=dwell_point, atv=atv, battery_frac=battery_frac, standing=standing)


def test_the_nearest_dwell_point_of_the_kind_is_claimed_on_its_own_key() -> None:
    driver = Driver()
    assert driver.seek()
    routes = PLANT.routes("light")
    nearest = min(PLANT.chargers, key=lambda each: routes.duration_s("e3", PLANT.node_of(each)))
    assert driver.dwell_points.dwell_point == nearest
    assert driver.dwell_points.is_charger
    assert driver.dwell_points.hold is Hold.CLAIMED
    assert driver.claims == [rival(nearest, "ATV5")]
    assert driver.keys == {KEYS.dwell_point(nearest)}


def test_whoever_claims_listens_before_it_speaks() -> None:
    driver = Driver()
    driver.seek()
    assert [type(effect) for effect in driver.out] == [Subscribe, Publish]


def test_parking_places_are_sought_apart_from_chargers() -> None:
    driver = Driver()
    assert driver.seek(charger=False)
    assert driver.dwell_points.dwell_point in PLANT.parkings
    assert not driver.dwell_points.is_charger


@pytest.mark.parametrize(
    ("claim", "keeps"),
    [
        ({"battery_frac": 0.4}, False),
        ({"battery_frac": 0.6}, True),
        ({"battery_frac": 0.5, "atv": "ATV7"}, True),
        ({"battery_frac": 0.5, "atv": "ATV3"}, False),
        ({"battery_frac": 0.9, "standing": True}, False),
    ],
    ids=["emptier rival", "fuller rival", "larger id", "smaller id", "occupant"],
)
def test_a_contest_goes_to_the_occupant_then_the_emptier_battery_then_the_smaller_id(
    claim: dict[str, object], keeps: bool
) -> None:
    driver = Driver("ATV5")
    driver.seek(battery_frac=0.5)
    dwell_point = driver.dwell_points.dwell_point
    lost = driver.dwell_points.on_claim(msgspec.structs.replace(rival(dwell_point), **claim), 0.5)
    assert lost is not keeps
    assert driver.dwell_points.dwell_point == (dwell_point if keeps else "")
    assert len(driver.claims) == (2 if keeps else 1)


def test_an_occupant_objects_to_everybody_and_is_never_driven_out() -> None:
    driver = Driver("ATV5")
    driver.seek(battery_frac=0.9)
    driver.dwell_points.arrive(0.0)
    dwell_point = driver.dwell_points.dwell_point
    for claim in (rival(dwell_point, "ATV1", 0.01), rival(dwell_point, "ATV9", 0.99)):
        assert not driver.dwell_points.on_claim(claim, 10.0)
    assert driver.dwell_points.hold is Hold.STANDING
    assert [claim.standing for claim in driver.claims] == [False, True, True]


def held_off_s(*, standing: bool) -> float:
    """How long a rival that never charges can keep a vehicle from the only charger by words."""
    one = Plant(msgspec.structs.replace(PLANT.file, chargers=PLANT.file.chargers[:1]))
    life = Life()
    dwell_points = DwellPoints("ATV5", one, "light", KEYS, life)
    for now_s in range(0, 24 * 3600, 30):
        if not dwell_points.seek(charger=True, node="e3", battery_frac=0.5, now_s=float(now_s)):
            continue
        liar = rival(dwell_points.dwell_point, battery_frac=0.0, standing=standing)
        if not dwell_points.on_claim(liar, now_s + 0.5):
            return float(now_s)
    return float("inf")


def test_a_claim_is_believed_for_as_long_as_it_can_be_true() -> None:
    assert APPROACH_S < held_off_s(standing=False) < APPROACH_S + 120.0
    full_s = max(kind.battery_wh / kind.charge_w for kind in PLANT.vehicle_types.values()) * 3600.0
    assert 1.31 * full_s < held_off_s(standing=True) < 2.0 * full_s + APPROACH_S


def test_a_rival_is_believed_that_lets_the_vehicle_charge_in_between() -> None:
    """With small batteries the same two meet at a charger every few minutes."""
    one = Plant(msgspec.structs.replace(PLANT.file, chargers=PLANT.file.chargers[:1]))
    dwell_points = DwellPoints("ATV5", one, "light", KEYS, Life())
    emptier = rival(next(iter(one.chargers)), battery_frac=0.1)
    for meeting in range(10):
        now_s = 0.5 * APPROACH_S * meeting
        assert dwell_points.seek(charger=True, node="e3", battery_frac=0.5, now_s=now_s)
        assert dwell_points.on_claim(emptier, now_s + 0.5), meeting
        assert dwell_points.seek(charger=True, node="e3", battery_frac=0.5, now_s=now_s + 100.0)
        dwell_points.arrive(now_s + 200.0)
        dwell_points.leave(now_s + 200.0)


def test_a_parking_place_may_be_stood_in_for_ever() -> None:
    driver = Driver()
    assert driver.seek(charger=False, now_s=0.0)
    first = driver.dwell_points.dwell_point
    for day in range(30):
        now_s = day * 86_400.0
        while driver.seek(charger=False, now_s=now_s) and driver.dwell_points.dwell_point != first:
            driver.dwell_points.on_claim(rival(driver.dwell_points.dwell_point, standing=True), now_s)
        assert driver.dwell_points.on_claim(rival(first, standing=True), now_s)


def test_a_dwell_point_that_is_left_to_another_one_is_lost_without_a_word() -> None:
    driver = Driver()
    driver.dwell_points.stand("CH2", 0.9, 0.0)
    said = len(driver.claims)
    assert driver.dwell_points.on_claim(rival("CH2", battery_frac=0.2), 1.0, plugged=True, gives_way=True)
    assert len(driver.claims) == said
    assert driver.dwell_points.hold is Hold.NONE
    assert driver.dwell_points.is_taken("CH2", 2.0)


def test_a_charger_of_no_use_is_not_asked_for_again_before_somebody_can_have_seen_to_it() -> None:
    driver = Driver()
    driver.seek(now_s=0.0)
    useless = driver.dwell_points.dwell_point
    driver.dwell_points.block(0.0)
    for now_s in (1.0, BLOCKED_S - 1.0):
        driver.seek(now_s=now_s)
        assert driver.dwell_points.dwell_point != useless
    driver.seek(now_s=BLOCKED_S + 1.0)
    assert driver.dwell_points.dwell_point == useless


def test_where_no_way_leads_to_a_charger_there_is_none_to_ask_for() -> None:
    lanes = tuple(lane for lane in PLANT.file.lanes if "e3" not in (lane.start, lane.end))
    alone = Plant(msgspec.structs.replace(PLANT.file, lanes=lanes))
    dwell_points = DwellPoints("ATV5", alone, "light", KEYS, Life())
    assert not dwell_points.seek(charger=True, node="e3", battery_frac=0.5, now_s=0.0)


def test_a_vehicle_that_begins_in_a_dwell_point_stands_there() -> None:
    driver = Driver("ATV5")
    driver.dwell_points.stand("CH2", 0.9, 0.0)
    assert driver.claims == [rival("CH2", "ATV5", 0.9, standing=True)]
    assert not driver.dwell_points.on_claim(rival("CH2", battery_frac=0.01), 1.0)


def test_a_dwell_point_that_was_lost_is_not_asked_for_again_soon() -> None:
    driver = Driver("ATV5")
    driver.seek(now_s=0.0)
    first = driver.dwell_points.dwell_point
    driver.dwell_points.on_claim(rival(first, battery_frac=0.1), 1.0)
    driver.seek(now_s=2.0)
    assert driver.dwell_points.dwell_point not in ("", first)
    driver.seek(now_s=1.0 + TAKEN_MEMORY_S)
    assert driver.dwell_points.dwell_point == first


def test_when_every_dwell_point_is_taken_there_is_none_to_ask_for() -> None:
    driver = Driver("ATV5")
    for _ in PLANT.chargers:
        assert driver.seek()
        driver.dwell_points.on_claim(rival(driver.dwell_points.dwell_point, standing=True), 1.0)
    assert not driver.seek(now_s=2.0)
    assert driver.dwell_points.dwell_point == ""
    assert driver.dwell_points.hold is Hold.NONE


def test_claims_of_other_dwell_points_and_of_nobody_else_mean_nothing() -> None:
    driver = Driver("ATV5")
    assert not driver.dwell_points.on_claim(rival("CH1", battery_frac=0.0), 1.0)
    driver.seek()
    dwell_point = driver.dwell_points.dwell_point
    other = next(each for each in PLANT.chargers if each != dwell_point)
    assert not driver.dwell_points.on_claim(rival(other, battery_frac=0.0), 1.0)
    assert not driver.dwell_points.on_claim(rival(dwell_point, "ATV5", 0.0), 1.0)
    assert driver.dwell_points.dwell_point == dwell_point
    assert len(driver.claims) == 1


def test_a_dwell_point_that_is_left_is_defended_no_longer() -> None:
    driver = Driver("ATV5")
    driver.seek()
    dwell_point = driver.dwell_points.dwell_point
    driver.dwell_points.leave(0.0)
    driver.dwell_points.leave(0.0)
    assert driver.keys == set()
    assert not driver.dwell_points.on_claim(rival(dwell_point), 1.0)
    assert len(driver.claims) == 1


def test_the_battery_of_a_claim_does_not_change_while_it_stands() -> None:
    driver = Driver("ATV5")
    driver.seek(battery_frac=0.5)
    dwell_point = driver.dwell_points.dwell_point
    for _ in range(3):
        driver.dwell_points.on_claim(rival(dwell_point, battery_frac=0.7), 1.0)
    assert {claim.battery_frac for claim in driver.claims} == {0.5}
    assert published(driver.out, DwellPointClaimed) == [rival(dwell_point, "ATV5", 0.5)]


DOCKS = {PLANT.node_of(place) for place in PLANT.places}


@pytest.mark.parametrize("machine", PLANT.machines)
def test_it_is_near_and_nobodys_dock(machine: str) -> None:
    dock = PLANT.node_of(machine)
    spot = WaitingPlaces(PLANT, "light").nearest(dock)
    assert spot not in DOCKS
    routes = PLANT.routes("light")
    assert routes.duration_s(dock, spot) <= min(
        routes.duration_s(dock, node) for node in PLANT.nodes if node not in DOCKS
    )


def test_who_stands_at_nobodys_dock_stays() -> None:
    assert WaitingPlaces(PLANT, "light").nearest("e3") == "e3"


def test_where_every_node_is_a_dock_it_is_a_source_warehouse() -> None:
    file = PLANT.file
    spare = [node for node in PLANT.nodes if node not in DOCKS]
    parkings = tuple(
        msgspec.structs.replace(file.parkings[0], id=f"Q{number}", node=node)
        for number, node in enumerate(spare)
    )
    full = Plant(msgspec.structs.replace(file, parkings=(*file.parkings, *parkings)))
    assert WaitingPlaces(full, "light").nearest(PLANT.node_of("M8")) == PLANT.node_of(
        PLANT.source_warehouses[0]
    )


def test_a_dead_end_that_leads_to_no_dock_is_none() -> None:
    file = PLANT.file
    here = PLANT.nodes[PLANT.node_of("M8")]
    pit = msgspec.structs.replace(here, id="pit", x_m=here.x_m + 0.2)
    lane = msgspec.structs.replace(file.lanes[0], start=here.id, end="pit", both_ways=False)
    plant = Plant(msgspec.structs.replace(file, nodes=(*file.nodes, pit), lanes=(*file.lanes, lane)))
    assert WaitingPlaces(plant, "light").nearest(here.id) == WaitingPlaces(PLANT, "light").nearest(here.id)


@pytest.mark.parametrize(
    ("emptier_frac", "keeps"), [(0.01, True), (WORTH_FRAC - 0.01, True), (WORTH_FRAC + 0.01, False)]
)
def test_on_its_way_to_a_charger_a_vehicle_is_turned_round_only_for_what_a_charge_is_worth(
    emptier_frac: float, keeps: bool
) -> None:
    """Both sides reach the same verdict: the rival hears a claim that it can beat, or one that it cannot."""
    driver, other = Driver("ATV5"), Driver("ATV7")
    driver.seek(battery_frac=0.5)
    charger = driver.dwell_points.dwell_point
    driver.dwell_points.set_off()
    other.seek(battery_frac=0.5 - emptier_frac)
    lost = driver.dwell_points.on_claim(other.claims[-1], 100.0)
    assert lost is not keeps
    if keeps:
        assert other.dwell_points.on_claim(driver.claims[-1], 100.1)
    assert {driver.dwell_points.dwell_point, other.dwell_points.dwell_point} >= {charger}


def test_who_must_charge_looks_for_a_parking_place_near_its_charger() -> None:
    driver = Driver()
    charger = driver.dwell_points.battery_reserve.nearest_charger("e3")
    routes = PLANT.routes("light")
    dwell_points = driver.dwell_points
    assert dwell_points.seek(charger=False, node="e3", battery_frac=0.2, now_s=0.0, near=charger)
    nearest = min(PLANT.parkings, key=lambda each: routes.duration_s(charger, PLANT.node_of(each)))
    assert dwell_points.dwell_point == nearest


SMALL = Plant(
    msgspec.structs.replace(
        PLANT.file,
        vehicle_types=tuple(
            msgspec.structs.replace(kind, battery_wh=12.0) for kind in PLANT.file.vehicle_types
        ),
    )
)
"""The same with batteries that last for minutes."""


def way_to_charger_s(node: str) -> float:
    return min(SMALL.routes("light").duration_s(node, SMALL.node_of(each)) for each in SMALL.chargers)


FAR = max(sorted(SMALL.stops), key=way_to_charger_s)
"""The node from which the way to a charger is longest."""


def with_small_battery() -> DwellPoints:
    return DwellPoints("ATV5", SMALL, "light", KEYS, Life())


def test_a_charger_that_the_battery_does_not_reach_is_waited_past_for_a_nearer_one() -> None:
    ways = sorted(
        (SMALL.routes("light").way(FAR, SMALL.node_of(each)).length_m, each) for each in SMALL.chargers
    )
    (near_m, near), (next_m, _) = ways[:2]
    assert next_m > near_m + 1.0
    queue = SMALL.charger_queue
    way = SMALL.routes("light").way(FAR, SMALL.node_of(near))
    just_frac = queue.way_frac("light", way.length_m, way.duration_s) + 0.001
    for battery_frac, found in ((just_frac, False), (1.0, True)):
        points = with_small_battery()
        assert points.seek(charger=True, node=FAR, battery_frac=just_frac, now_s=0.0)
        points.on_claim(rival(near, battery_frac=0.0), 0.0)
        assert points.seek(charger=True, node=FAR, battery_frac=battery_frac, now_s=1.0) is found


def test_who_waits_far_from_a_charger_goes_much_nearer_and_then_stays() -> None:
    points = with_small_battery()
    assert points.seek_nearer(FAR, 0.2, 0.0)
    stands = SMALL.stand_of(points.dwell_point)
    assert way_to_charger_s(stands) <= MUCH_NEARER * way_to_charger_s(FAR)
    least_s = way_to_charger_s(stands)
    a_little_away = [
        node for node in sorted(SMALL.stops) if least_s < way_to_charger_s(node) < least_s / MUCH_NEARER
    ]
    assert a_little_away
    assert not any(with_small_battery().seek_nearer(node, 0.2, 1.0) for node in a_little_away)


def test_a_charger_of_the_reserve_is_asked_for_when_no_other_is_left() -> None:
    plant = draw_raster(17)
    shut = [each for each in plant.chargers if plant.stand_of(each) in plant.spare_places.shut]
    assert shut
    life = Life()
    points = DwellPoints("V1", plant, plant.fleet["V1"].type, KEYS, life)
    beside = plant.stand_of(shut[0])
    asked: list[str] = []
    for now_s in range(len(plant.chargers)):
        assert points.seek(charger=True, node=beside, battery_frac=0.5, now_s=float(now_s))
        asked.append(points.dwell_point)
        points.stand(points.dwell_point, 0.5, float(now_s))
        assert points.reserve.is_member(float(now_s)) is (points.dwell_point in shut)
        points.block(float(now_s))
    assert set(asked[-len(shut) :]) == set(shut)


def test_who_stands_at_a_place_of_the_reserve_belongs_to_it_and_who_drives_there_does_not_yet() -> None:
    plant = draw_raster(17)
    spare = plant.spare_places
    points = DwellPoints("V1", plant, plant.fleet["V1"].type, KEYS, Life())
    assert points.seek_spare(spare.reserve, spare.reserve[0], 0.5, 0.0)
    assert not points.reserve.is_member(0.0)
    points.arrive(1.0)
    assert points.reserve.is_member(1.0)


def test_who_leaves_the_reserve_for_another_place_belongs_to_it_until_it_has_stood_there_for_a_time() -> None:
    plant = draw_raster(17)
    spare = plant.spare_places
    points = DwellPoints("V1", plant, plant.fleet["V1"].type, KEYS, Life())
    points.stand(spare.reserve[0], 0.5, 0.0)
    assert points.seek_spare(spare.clear, spare.clear[0], 0.5, 10.0)
    assert points.reserve.is_member(10.0 + 2 * STAYS_S), "on its way"
    points.arrive(1000.0)
    assert points.reserve.is_member(1000.0 + STAYS_S - 1.0)
    assert not points.reserve.is_member(1000.0 + STAYS_S)
