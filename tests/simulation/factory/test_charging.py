"""Few chargers for many vehicles: nobody runs flat, nobody holds a charger for nothing, and work gets done.

Batteries hold a tenth of the usual, so that an hour shows what a day would: a vehicle that stands lasts for 100
minutes, and is charged in five.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from random import Random

import msgspec
import pytest
from variants import in_campaigns

from dray.body import VehicleState
from dray.messages import DwellPointClaimed, Message
from dray.messages.kinds import Kind
from dray.plant import Plant, VehicleSpec, load_plant
from dray.protocol.vehicle.charging import Charging
from dray.protocol.vehicle.dwell_points import BLOCKED_S
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY
from dray_sim.explore.play import play as play_run
from dray_sim.explore.run import draw
from dray_sim.explore.small_plant import with_scarce_power
from dray_sim.plants.generator import generate_plant
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Played, Shift, Stage, play

LOOK_S = 15.0
"""How often somebody looks at the vehicles."""

HOUR_S = 3600.0
BATTERY_SHARE = 0.1

TOO_LATE_FRAC = 0.02

WITHIN = 40
"""Seeds of the search in which a vehicle that runs flat must be seen."""


@dataclass(frozen=True, slots=True)
class Look:
    """All vehicles at one moment."""

    at_s: float
    atvs: dict[str, VehicleState]


def small(*, vehicles: int, chargers: int, parkings: int = 8, battery_frac: float | None = None) -> Plant:
    """The plant `single-track`, whose batteries are the smaller ones, with less of everything."""
    file = load_plant("single-track").file
    return Plant(
        msgspec.structs.replace(
            file,
            # The second one of the plant can carry everything.
            fleet=tuple(_charged(spec, battery_frac) for spec in (*file.fleet[1:], file.fleet[0])[:vehicles]),
            chargers=file.chargers[:chargers],
            parkings=file.parkings[:parkings],
            vehicle_types=tuple(
                msgspec.structs.replace(kind, battery_wh=kind.battery_wh * BATTERY_SHARE)
                for kind in file.vehicle_types
            ),
        )
    )


def _charged(spec: VehicleSpec, battery_frac: float | None) -> VehicleSpec:
    return spec if battery_frac is None else msgspec.structs.replace(spec, battery_frac=battery_frac)


async def looking(stage: Stage, *, until_s: float) -> list[Look]:
    looks = []
    while stage.now_s() < until_s:
        await stage.until_s(stage.now_s() + LOOK_S)
        atvs = {atv: vehicle.sense() for atv, vehicle in stage.factory.vehicles.items()}
        looks.append(Look(stage.now_s(), atvs))
    return looks


async def watch(stage: Stage) -> list[Look]:
    """Let the shift pass, and until everything is delivered that was ordered, half as long again at most."""
    looks = await looking(stage, until_s=stage.shift.duration_s)
    while stage.undelivered() and stage.now_s() < 1.5 * stage.shift.duration_s:
        looks += await looking(stage, until_s=stage.now_s() + 60.0)
    return looks


def played(
    plant: Plant,
    *,
    hours: float,
    load: float,
    script: Callable[[Stage], Awaitable[list[Look]]] = watch,
    seed: int = 1,
) -> tuple[list[Look], Played[list[Look]]]:
    shift = Shift("charging", duration_s=hours * HOUR_S, load=load)
    result = play(shift, plant, seed, script)
    assert result.invariants == HELD
    assert result.result is not None
    return result.result, result


def flat(looks: list[Look]) -> set[str]:
    return {atv for look in looks for atv, state in look.atvs.items() if state.problem == BATTERY_EMPTY}


def lowest(looks: list[Look]) -> float:
    return min(state.battery_frac for look in looks for state in look.atvs.values())


def all_delivered(result: Played[list[Look]]) -> bool:
    return result.report.orders_delivered == result.report.orders_placed > 0


def standing_s(looks: list[Look], nodes: set[str]) -> float:
    """The longest that a vehicle stands at one of these nodes with nothing on board."""
    longest = 0
    lasts: dict[str, int] = {}
    for look in looks:
        for atv, state in look.atvs.items():
            there = state.node in nodes and state.next_node == state.node and not state.load
            lasts[atv] = lasts.get(atv, 0) + 1 if there else 0
            longest = max(longest, lasts[atv])
    return longest * LOOK_S


# --- numbers of vehicles and chargers -----------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "parkings",
    [
        pytest.param(8, id="with parking places", marks=pytest.mark.slow),
        pytest.param(0, id="with no parking place"),
    ],
)
def test_two_vehicles_share_one_charger(parkings: int) -> None:
    plant = small(vehicles=2, chargers=1, parkings=parkings, battery_frac=0.5)
    looks, _ = played(plant, hours=4.0, load=0.0)
    assert flat(looks) == set()
    charged = {atv: sum(look.atvs[atv].charging for look in looks) for atv in plant.fleet}
    assert min(charged.values()) > 0
    assert lowest(looks) > 0.2, "nobody is kept waiting by one that has enough"


@pytest.mark.slow
def test_two_vehicles_with_one_charger_carry_on() -> None:
    looks, result = played(small(vehicles=2, chargers=1), hours=2.0, load=0.15)
    assert flat(looks) == set()
    assert all_delivered(result)


@pytest.mark.slow
def test_six_vehicles_share_one_charger() -> None:
    plant = small(vehicles=6, chargers=1, battery_frac=0.3)
    looks, result = played(plant, hours=2.0, load=0.3)
    assert flat(looks) == set()
    assert all_delivered(result)
    assert lowest(looks) > 0.05
    charging = [sum(state.charging for state in look.atvs.values()) for look in looks]
    assert max(charging) == 1


@pytest.mark.slow
def test_one_vehicle_with_one_charger_works_on() -> None:
    looks, result = played(small(vehicles=1, chargers=1, parkings=1), hours=2.0, load=0.08)
    assert flat(looks) == set()
    assert all_delivered(result)


@pytest.mark.slow
def test_where_every_dwell_point_is_a_charger_work_is_done() -> None:
    plant = small(vehicles=4, chargers=4, parkings=0, battery_frac=0.4)
    looks, result = played(plant, hours=2.0, load=0.3)
    assert flat(looks) == set()
    assert all_delivered(result)


@pytest.mark.slow
def test_without_a_free_parking_place_nobody_waits_at_a_machine() -> None:
    plant = small(vehicles=6, chargers=1, parkings=1, battery_frac=0.5)
    looks, result = played(plant, hours=1.5, load=0.1)
    assert flat(looks) == set()
    assert all_delivered(result)
    docks = {machine.node for machine in plant.machines.values()}
    assert standing_s(looks, docks) < 120.0


def drawn(seed: int) -> Plant:
    """Any plant with few chargers, perhaps one, with few or no parking places and small batteries."""
    random = Random(f"{seed} few chargers")
    file = with_scarce_power(generate_plant(seed, random.randint(1, 6), random.randint(2, 10)).file, random)
    kinds = {kind.id: kind for kind in file.vehicle_types}
    # What vehicles use that only stand must come back, and half as much again for their driving.
    used_w = 1.5 * sum(kinds[spec.type].idle_w for spec in file.fleet)
    enough = math.ceil(used_w / min(kind.charge_w for kind in file.vehicle_types))
    kept = min(len(file.chargers), max(enough, random.randint(1, len(file.chargers))))
    fleet = tuple(_charged(spec, round(random.uniform(0.2, 0.9), 2)) for spec in file.fleet)
    return Plant(msgspec.structs.replace(file, chargers=file.chargers[:kept], fleet=fleet))


@pytest.mark.parametrize("seed", in_campaigns(range(40), 0, 13, 27, 38))
def test_in_plants_drawn_at_random_nobody_runs_flat(seed: int) -> None:
    looks, result = played(drawn(seed), hours=1.5, load=0.05, seed=seed)
    assert flat(looks) == set()
    assert result.report.orders_delivered > 0 or result.report.orders_placed == 0


# --- what others do -----------------------------------------------------------------------------------


DEAD_S = 1500.0
"""A vehicle that needs a charge when this begins is nearly empty at its end."""


async def dies_at_the_charger(stage: Stage) -> list[Look]:
    """The first vehicle that is charged dies there, and stays; another one finds it. Then it lives again."""
    while not (plugged := [atv for atv, each in stage.factory.vehicles.items() if each.sense().charging]):
        await stage.until_s(stage.now_s() + 1.0)
    stage.factory.power_off(plugged[0])
    looks = await looking(stage, until_s=stage.now_s() + DEAD_S)
    stage.factory.power_on(plugged[0])
    return looks + await looking(stage, until_s=stage.now_s() + HOUR_S)


def test_a_dead_vehicle_at_a_charger_is_gone_round() -> None:
    plant = small(vehicles=3, chargers=2, battery_frac=0.5)
    looks, _ = played(plant, hours=3.0, load=0.0, script=dies_at_the_charger)
    assert flat(looks) == set()
    assert lowest(looks) > 0.1


@pytest.mark.slow
def test_a_dead_vehicle_at_the_only_charger_is_visited_now_and_then_and_not_besieged() -> None:
    plant = small(vehicles=2, chargers=1, battery_frac=0.5)
    looks, _ = played(plant, hours=3.0, load=0.0, script=dies_at_the_charger)
    charger = plant.node_of("CH1")
    dead = next(atv for atv, state in looks[0].atvs.items() if state.node == charger)
    other = next(atv for atv in plant.fleet if atv != dead)
    there = [look.atvs[other].node == charger for look in looks if look.at_s < looks[0].at_s + DEAD_S]
    arrivals = sum(now and not before for before, now in zip([False, *there], there, strict=False))
    assert 1 <= arrivals <= DEAD_S / BLOCKED_S + 1
    assert sum(there) * LOOK_S < 0.2 * DEAD_S, "it waits elsewhere"
    assert any(look.atvs[other].charging for look in looks), "it is charged when the way is free again"
    assert other not in flat(looks)


async def dies_on_its_way(stage: Stage) -> list[Look]:
    """Who has claimed the only charger crashes before it is there."""
    factory = stage.factory
    claimed = None
    while claimed is None:
        await stage.until_s(stage.now_s() + 1.0)
        for atv, heartbeat in stage.witness.atvs.items():
            if (
                heartbeat.dwell_point in stage.plant.chargers
                and factory.vehicles[atv].sense().speed_mps > 0.0
            ):
                claimed = atv
    factory.crash(claimed)
    return await looking(stage, until_s=stage.now_s() + 1000.0)


def test_a_claim_of_a_dead_vehicle_holds_no_charger() -> None:
    looks, _ = played(
        small(vehicles=2, chargers=1, battery_frac=0.5), hours=1.0, load=0.0, script=dies_on_its_way
    )
    assert any(state.charging for look in looks for state in look.atvs.values())


LIAR = "ATV9"


def let_lie(stage: Stage, *, standing: bool) -> None:
    """Somebody claims every charger whenever anybody does, with an empty battery, and is nowhere near."""
    factory = stage.factory

    def on_message(sender: str, message: Message) -> None:
        if isinstance(message, DwellPointClaimed) and sender != LIAR:
            claim = DwellPointClaimed(
                dwell_point=message.dwell_point, atv=LIAR, battery_frac=0.0, standing=standing
            )
            session.publish(factory.keys.dwell_point(message.dwell_point), claim)

    factory.bus.kinds[LIAR] = Kind.ATV
    session = factory.bus.join(LIAR, on_message)
    for charger in stage.plant.chargers:
        session.subscribe(factory.keys.dwell_point(charger))


@pytest.mark.slow
@pytest.mark.parametrize(
    "standing",
    [pytest.param(False, id="is on its way", marks=pytest.mark.slow), pytest.param(True, id="stands there")],
)
def test_one_that_claims_every_charger_and_never_comes_keeps_nobody_from_charging(standing: bool) -> None:
    async def script(stage: Stage) -> list[Look]:
        let_lie(stage, standing=standing)
        return await watch(stage)

    plant = small(vehicles=2, chargers=1, battery_frac=0.5)
    looks, _ = played(plant, hours=4.0, load=0.0, script=script)
    assert flat(looks) == set()
    assert all(any(look.atvs[atv].charging for look in looks) for atv in plant.fleet)


# --- the search ---------------------------------------------------------------------------------------


def charge_only_when_it_is_too_late(patch: pytest.MonkeyPatch) -> None:
    """A vehicle works as long as its reserve lasts, and goes to charge when it has used that, too."""
    patch.setattr(Charging, "why_no_work", lambda _self, _battery_frac: "")
    patch.setattr(Charging, "wants", lambda _self, battery_frac, _now_s: battery_frac < TOO_LATE_FRAC)


@pytest.mark.slow
def test_the_search_sees_that_somebody_runs_flat(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = [draw(seed, "batteries") for seed in range(WITHIN)]
    charge_only_when_it_is_too_late(monkeypatch)
    found = (play_run(run).broken for run in runs)
    assert any("run flat" in broken for broken in found)
