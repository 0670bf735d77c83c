"""A vehicle charges and parks when there is nothing to carry."""

from __future__ import annotations

from collections.abc import Collection

from atv1 import SETTLED_S, command, contracted, handing_over, last_beat, parked
from defaults import KEYS, PLANT
from effects import committed, facts, instructed, listening, published
from msgspec.structs import replace
from rigs import VehicleRig
from spoken import award

from dray.body import Charge, Drive
from dray.messages import (
    AtvStatus,
    CommandKind,
    DockOpened,
    DwellPointClaimed,
    HandoverAccepted,
    Reason,
    Release,
    Role,
)
from dray.messages.fact import AtvStatusChanged
from dray.plant import Plant
from dray.protocol.runtime.events import Effect
from dray.protocol.vehicle.dwell_points import CONTEST_S
from dray.protocol.vehicle.idle_positioning import SETTLE_S, TRIES


def test_a_vehicle_with_a_low_battery_claims_a_charger_waits_drives_and_charges() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S)
    claim = published(rig.all, DwellPointClaimed)[-1]
    assert claim.dwell_point in PLANT.chargers
    assert instructed(rig.all, Drive) == []
    rig.run(SETTLED_S + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(claim.dwell_point)
    rig.arrive()
    assert rig.last(Charge).charger == claim.dwell_point
    beat = last_beat(rig)
    assert (beat.status, beat.dwell_point) == (AtvStatus.CHARGING, claim.dwell_point)


def test_a_parked_vehicle_whose_battery_gets_low_goes_to_charge_by_itself() -> None:
    rig = parked(node="p8", battery_frac=0.9)
    assert instructed(rig.run(120.0), Drive) == []
    rig.battery_frac = 0.55
    [drive] = instructed(rig.run(130.0), Drive)
    assert drive.nodes[-1] in {charger.node for charger in PLANT.chargers.values()}


def test_a_full_vehicle_leaves_the_charger_and_parks_out_of_the_way() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    effects = rig.charged()
    assert [fact.status for fact in facts(effects, AtvStatusChanged)] == [AtvStatus.IDLE]
    rig.run(rig.now_s + CONTEST_S)
    assert rig.last(Drive).nodes[-1] in {place.node for place in PLANT.parkings.values()}
    assert KEYS.dwell_point("CH2") not in listening(rig.all)
    rig.arrive()
    assert instructed(rig.run(600.0), Drive) == []


def test_a_vehicle_that_has_done_its_work_waits_a_moment_and_then_parks() -> None:
    rig = handing_over()
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    drives = len(instructed(rig.all, Drive))
    rig.run(rig.now_s + 3.9)
    assert len(instructed(rig.all, Drive)) == drives
    rig.run(rig.now_s + 2.0)
    assert rig.last(Drive).nodes[-1] in {place.node for place in PLANT.parkings.values()}


def test_work_ends_the_charge_and_the_dwell_point_is_free() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.on_message("M8", award())
    assert KEYS.dwell_point("CH2") not in listening(rig.all)
    beat = last_beat(rig)
    assert (beat.status, beat.dwell_point) == (AtvStatus.WORKING, "")
    rig.arrive()
    rig.run(rig.now_s + 60.0)
    assert len(instructed(rig.all, Charge)) == 1


def test_a_claim_that_is_lost_is_followed_by_another() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S)
    first = published(rig.all, DwellPointClaimed)[-1].dwell_point
    rival = DwellPointClaimed(dwell_point=first, atv="ATV7", battery_frac=0.3, standing=False)
    rig.on_message("ATV7", rival)
    rig.run(SETTLED_S + 0.1)
    second = published(rig.all, DwellPointClaimed)[-1].dwell_point
    assert second in PLANT.chargers
    assert second != first
    rig.run(SETTLED_S + 0.1 + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(second)


def test_a_claim_that_is_lost_on_the_way_is_followed_by_another() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S + CONTEST_S)
    first = last_beat(rig).dwell_point
    rig.on_message("ATV7", DwellPointClaimed(dwell_point=first, atv="ATV7", battery_frac=0.5, standing=True))
    rig.run(SETTLED_S + 2 * CONTEST_S)
    second = last_beat(rig).dwell_point
    assert second != first
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(second)


def asked_for(
    rig: VehicleRig, dwell_point: str, battery_frac: float, *, standing: bool = False
) -> list[Effect]:
    """ATV0 wants a dwell point."""
    claim = DwellPointClaimed(
        dwell_point=dwell_point, atv="ATV0", battery_frac=battery_frac, standing=standing
    )
    return rig.on_message("ATV0", claim)


def test_who_charges_keeps_its_charger_until_it_has_enough() -> None:
    rig = parked(node="ch2", battery_frac=0.2)
    rig.run(SETTLED_S)
    rig.battery_frac = 0.35
    [objection] = published(asked_for(rig, "CH2", 0.15), DwellPointClaimed)
    assert objection.standing
    rig.run(60.0)
    assert instructed(rig.all, Drive) == []
    assert last_beat(rig).dwell_point == "CH2"


def test_who_has_charged_enough_leaves_its_charger_to_an_emptier_one_and_waits_at_a_parking_place() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.battery_frac = 0.7
    assert published(asked_for(rig, "CH2", 0.2), DwellPointClaimed) == [], "silence is what leaves it"
    rig.run(rig.now_s + CONTEST_S)
    assert rig.last(Drive).nodes[-1] in {place.node for place in PLANT.parkings.values()}
    assert last_beat(rig).status is AtvStatus.IDLE
    assert KEYS.dwell_point("CH2") not in listening(rig.all)


def test_who_is_plugged_in_does_not_believe_that_another_one_stands_there() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    assert published(asked_for(rig, "CH2", 0.4, standing=True), DwellPointClaimed)[0].standing
    assert instructed(rig.run(60.0), Drive) == []


def test_a_rival_that_never_stops_is_not_answered_as_fast_as_it_talks() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    answers = [
        len(published(asked_for(rig, "CH2", 0.4, standing=True), DwellPointClaimed)) for _ in range(100)
    ]
    assert sum(answers) == 1


def test_a_stopped_vehicle_leaves_its_charger_to_nobody_since_it_cannot_drive() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    command(rig, CommandKind.STOP)
    rig.battery_frac = 0.9
    [objection] = published(asked_for(rig, "CH2", 0.1), DwellPointClaimed)
    assert objection.standing


def test_a_charger_that_gives_no_power_is_left_for_another_one_after_a_few_tries() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    for _ in range(TRIES):
        assert rig.last(Charge).charger == "CH2"
        rig.failed(Charge, "occupied by ATV9")
        rig.run(rig.now_s + SETTLE_S)
    claim = published(rig.all, DwellPointClaimed)[-1]
    assert claim.dwell_point in PLANT.chargers
    assert claim.dwell_point != "CH2"
    rig.run(rig.now_s + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == PLANT.node_of(claim.dwell_point)


def claim_all(rig: VehicleRig, places: Collection[str]) -> None:
    """ATV7 stands at each place that the vehicle claims, as many times as there are such places."""
    for _ in places:
        rig.run(rig.now_s + 0.1)
        dwell_point = published(rig.all, DwellPointClaimed)[-1].dwell_point
        rig.on_message(
            "ATV7", DwellPointClaimed(dwell_point=dwell_point, atv="ATV7", battery_frac=0.1, standing=True)
        )


def test_who_finds_neither_a_charger_nor_a_parking_place_waits_at_nobodys_dock() -> None:
    dock = PLANT.node_of("M8")
    rig = parked(node=dock, battery_frac=0.5)
    rig.run(SETTLED_S)
    claim_all(rig, PLANT.dwell_points)
    rig.run(rig.now_s + 0.1)
    waits_at = rig.last(Drive).nodes[-1]
    assert waits_at not in {PLANT.node_of(place) for place in PLANT.places}
    rig.arrive()
    rig.run(rig.now_s + 20.0)
    assert rig.last(Drive).nodes[-1] == waits_at


def test_who_must_charge_and_finds_no_charger_waits_at_a_parking_place_and_asks_again() -> None:
    rig = parked(node=PLANT.node_of("M8"), battery_frac=0.2)
    rig.run(SETTLED_S)
    claim_all(rig, PLANT.chargers)
    rig.run(rig.now_s + CONTEST_S + 0.1)
    assert rig.last(Drive).nodes[-1] in {place.node for place in PLANT.parkings.values()}
    rig.arrive()
    claims = published(rig.run(rig.now_s + 120.0), DwellPointClaimed)
    assert any(claim.dwell_point in PLANT.chargers for claim in claims)


def test_when_every_charger_is_taken_the_vehicle_asks_again_later_and_does_not_spin() -> None:
    rig = parked(node="p8", battery_frac=0.5)
    rig.run(SETTLED_S)
    claim_all(rig, PLANT.chargers)
    rig.run(rig.now_s + 0.1)
    claims = len([effect for effect in rig.all if published([effect], DwellPointClaimed)])
    rig.run(rig.now_s + 20.0)
    assert len([effect for effect in rig.all if published([effect], DwellPointClaimed)]) == claims
    rig.run(rig.now_s + 90.0)
    assert len([effect for effect in rig.all if published([effect], DwellPointClaimed)]) > claims


def test_a_vehicle_that_finds_no_charger_keeps_the_parking_place_it_stands_in() -> None:
    rig = parked(node="p3", battery_frac=0.5)
    rig.run(SETTLED_S)
    for _ in PLANT.chargers:
        for dwell_point in PLANT.chargers:
            rig.on_message(
                "ATV7",
                DwellPointClaimed(dwell_point=dwell_point, atv="ATV7", battery_frac=0.1, standing=True),
            )
        rig.run(rig.now_s + 0.1)
    assert KEYS.dwell_point("P3") in listening(rig.all)
    [objection] = published(
        rig.on_message(
            "ATV8", DwellPointClaimed(dwell_point="P3", atv="ATV8", battery_frac=0.1, standing=False)
        ),
        DwellPointClaimed,
    )
    assert objection.standing


def test_two_that_believe_to_stand_in_one_dwell_point_do_not_argue_for_ever() -> None:
    rigs = [VehicleRig("ATV1", node="p3", battery_frac=0.9), VehicleRig("ATV2", node="p3", battery_frac=0.8)]
    claims = [(rig, claim) for rig in rigs for claim in published(rig.start(), DwellPointClaimed)]
    heard = 0
    while claims and heard < 100:
        speaker, claim = claims.pop(0)
        heard += 1
        for rig in rigs:
            if rig is not speaker:
                effects = rig.on_message(speaker.agent.id, claim) + rig.run(rig.now_s)
                claims += [(rig, answer) for answer in published(effects, DwellPointClaimed)]
    assert heard < 10
    rigs[0].run(SETTLED_S)
    assert rigs[0].last(Drive).nodes[-1] != "p3"


def test_a_vehicle_that_arrives_elsewhere_does_not_stand_in_the_dwell_point_that_it_has_claimed() -> None:
    rig = contracted()
    rig.on_message("M8", Release(task="M8-1", epoch=1, role=Role.PRIMARY, reason=Reason.NO_ANSWER, number=1))
    claim = published(rig.run(rig.now_s + SETTLE_S), DwellPointClaimed)[-1]
    rig.arrive()
    assert rig.node == "s3"
    rival = DwellPointClaimed(dwell_point=claim.dwell_point, atv="ATV9", battery_frac=0.1, standing=False)
    assert not any(claim.standing for claim in published(rig.on_message("ATV9", rival), DwellPointClaimed))


def test_a_nearly_full_vehicle_leaves_the_charger_to_others() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.battery_frac = 0.94
    assert instructed(rig.run(30.0), Drive) == []
    rig.battery_frac = 0.95
    [drive] = instructed(rig.run(40.0), Drive)
    assert drive.nodes[-1] in {place.node for place in PLANT.parkings.values()}
    assert last_beat(rig).status is AtvStatus.IDLE


def test_vehicles_that_start_together_do_not_look_for_a_charger_together() -> None:
    claims_s = set()
    for atv in PLANT.fleet:
        rig = VehicleRig(atv, node="p8", battery_frac=0.5)
        rig.start()
        while not any(claim.dwell_point in PLANT.chargers for claim in published(rig.all, DwellPointClaimed)):
            rig.run(rig.agent.wake_at_s)
        claims_s.add(rig.now_s)
    assert min(claims_s) >= SETTLE_S
    assert max(claims_s) <= 2 * SETTLE_S
    assert len(claims_s) > len(PLANT.fleet) / 2


def test_a_charge_that_fails_is_given_up_and_sought_anew() -> None:
    rig = parked(node="ch2", battery_frac=0.5)
    rig.run(SETTLED_S)
    rig.failed(Charge, "no contact")
    assert last_beat(rig).status is AtvStatus.IDLE
    effects = rig.run(rig.now_s + 30.0)
    assert published(effects, DwellPointClaimed)


def test_a_vehicle_that_starts_in_a_dwell_point_with_a_contract_holds_no_dwell_point_and_rests_after_its_work() -> (
    None
):
    before = parked(node="p3")
    before.on_message("M8", award())
    rig = VehicleRig("ATV1", node="p3", incarnation=2)
    rig.memory, rig.now_s = committed(before.all), before.now_s
    rig.start()
    assert published(rig.all, DwellPointClaimed) == []
    for step in (rig.arrive, rig.picked, rig.arrive):
        step()
    claim = DwellPointClaimed(dwell_point="P3", atv="ATV5", battery_frac=0.2, standing=False)
    assert published(rig.on_message("ATV5", claim), DwellPointClaimed) == []
    assert last_beat(rig).dwell_point == ""
    rig.on_message("M8", DockOpened(task="M8-1", epoch=1, station="M8"))
    rig.dropped()
    rig.on_message("M8", HandoverAccepted(task="M8-1", epoch=1))
    effects = rig.run(rig.now_s + SETTLE_S + CONTEST_S)
    assert instructed(effects, Drive)[-1].nodes[-1] in {
        PLANT.node_of(dwell_point) for dwell_point in PLANT.dwell_points
    }


def without_parking(vehicles: int) -> Plant:
    """The plant of all these tests, with as many vehicles and no parking place."""
    file = PLANT.file
    spec = file.fleet[0]
    free = [node for node in PLANT.stops if node not in {one.node for one in file.fleet}]
    more = tuple(
        replace(spec, id=f"MORE{number}", node=node)
        for number, node in enumerate(free[: vehicles - len(file.fleet)], 1)
    )
    return Plant(replace(file, parkings=(), fleet=(*file.fleet, *more)[:vehicles]))


def test_a_vehicle_without_a_dwell_point_claims_a_spare_place_of_the_roads_and_stays_there() -> None:
    plant = without_parking(12)
    spare = plant.spare_places.all
    assert len(spare) == 12 - len(plant.chargers)
    rig = parked(plant=plant, node="s3")
    rig.run(SETTLED_S)
    claim = published(rig.all, DwellPointClaimed)[-1]
    assert claim.dwell_point in spare
    rig.run(SETTLED_S + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == claim.dwell_point
    rig.arrive()
    assert instructed(rig.run(rig.now_s + 600.0), Drive) == []
    assert last_beat(rig).dwell_point == claim.dwell_point


def test_a_spare_place_that_somebody_stands_at_is_left_to_it() -> None:
    rig = parked(plant=without_parking(12), node="s3")
    rig.run(SETTLED_S)
    first = published(rig.all, DwellPointClaimed)[-1].dwell_point
    rig.on_message(
        "MORE1", DwellPointClaimed(dwell_point=first, atv="MORE1", battery_frac=0.9, standing=True)
    )
    rig.run(rig.now_s + CONTEST_S)
    second = published(rig.all, DwellPointClaimed)[-1].dwell_point
    assert second not in ("", first)
    rig.run(rig.now_s + CONTEST_S)
    assert rig.last(Drive).nodes[-1] == second
