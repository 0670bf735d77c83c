"""Agents that were started differently: nobody drives into others for that, and somebody says what is wrong."""

from __future__ import annotations

import asyncio

import pytest
from msgspec.structs import replace

from dray.adapters.security.signing import SigningKey, TrustedKeys
from dray.memory import Note, TableMemory
from dray.messages import AtvHeartbeat, AtvStatus, HoldsAsked, Message, PlaceRequested
from dray.messages.keys import Keys
from dray.plant import Plant, load_plant
from dray.plant.model import VehicleSpec
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Commit, Effect, Ignore, Instruct, Received, Started
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.reservation_handling import NOTE, WITHOUT_TABLES, ReservationHandling
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.people.command_handling import ALONE
from dray_sim.bodies.floor import Floor
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners

KEY = SigningKey(b"k" * 32)
PLANT = load_plant("single-track")
TRAFFIC = TrafficMap(PLANT)


class Heartbeats:
    """The newest of each vehicle."""

    def __init__(self) -> None:
        self.newest: dict[str, AtvHeartbeat] = {}

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is AtvHeartbeat:
            self.newest[message.atv] = message


def test_a_vehicle_without_right_of_way_among_others_stands_at_once_and_says_why() -> None:
    async def main() -> None:
        listeners, heard = Listeners(), Heartbeats()
        factory = SimFactory(PLANT, clock(), seed=1, listener=listeners, traffic=True)
        overlaps = Overlaps(factory.vehicles, strict=False)
        listeners.add(heard, overlaps)
        life = asyncio.create_task(factory.run())
        await asyncio.sleep(10.0)
        kind = next(iter(PLANT.vehicle_types))
        node = PLANT.node_of("M1")
        factory.add_vehicle(
            VehicleSpec("ATV9", kind, node),
            lambda number, software, _: Atv("ATV9", PLANT, vehicle_type=kind, incarnation=number),
        )
        stood = factory.vehicles["ATV9"].sense().pose
        await asyncio.sleep(60.0)
        beat = heard.newest["ATV9"]
        assert (beat.status, beat.problem) == (AtvStatus.STOPPED, ALONE)
        assert factory.vehicles["ATV9"].sense().held
        assert factory.vehicles["ATV9"].sense().pose == stood
        assert not {AtvStatus.STOPPED, AtvStatus.ERROR} & {heard.newest[atv].status for atv in PLANT.fleet}
        overlaps.check_end(factory.clock.now_s())
        assert overlaps.count == 0
        life.cancel()

    run(main(), JUMP)


def started_alone(atv: str) -> Atv:
    agent = Atv(atv, PLANT, vehicle_type=PLANT.fleet[atv].type)

    async def state() -> None:
        agent.handle(Started(Floor(PLANT, clock(), seed=1).vehicles[atv].sense(), {}, ""), 0.0)

    run(state(), JUMP)
    return agent


@pytest.mark.parametrize(
    ("askers", "stands"),
    [(("M1", "M2"), True), (("M1", "M1"), False), (("M1", "ATV2"), False), (("M1", "nobody"), False)],
)
def test_two_replicas_of_tables_are_believed_and_nobody_else(askers: tuple[str, ...], stands: bool) -> None:
    agent = started_alone("ATV1")
    effects: list[Effect] = []
    for asker in askers:
        effects += agent.handle(Received(asker, HoldsAsked(district="M1.0", epoch=0)), 1.0)
    holds = [effect for effect in effects if isinstance(effect, Instruct)]
    assert (len(holds) == 1, agent.unfit() == ALONE) == (stands, stands)


def request(district: str) -> PlaceRequested:
    return PlaceRequested(
        district=district,
        life=1,
        seq=1,
        epoch=0,
        rank=(0, 0.0, "ATV1"),
        holds=(),
        groups=(),
        seen=0,
        stands=True,
        docked=False,
    )


def test_a_machine_without_right_of_way_says_why_it_answers_no_request() -> None:
    life = Life()
    table = ReservationHandling(
        "M1",
        PLANT,
        None,
        TrustedKeys(KEY.public),
        HeartbeatSubscriptions(Keys(PLANT.id).atv_heartbeat, life),
        life,
    ).handlers({})
    table[PlaceRequested]("ATV1", request("M1"), 0.0)
    assert life.effects == [Ignore(WITHOUT_TABLES)]


def changed() -> Plant:
    """The default plant with one of its nodes somewhere else."""
    file = PLANT.file
    moved = tuple(replace(node, x_m=node.x_m + 0.5) if node.id == "c3" else node for node in file.nodes)
    return Plant(replace(file, nodes=moved))


def test_a_district_that_is_another_one_by_another_plant_file_has_another_name() -> None:
    before, after = Places(PLANT), Places(changed())
    other = {place for place in before.all if before.district_of[place] != after.district_of[place]}
    assert "c3" in other
    assert len(other) < len(before.all) / 2
    assert Places(load_plant("single-track")).district_of == before.district_of


def test_the_table_of_a_district_that_is_no_more_is_forgotten() -> None:
    name = next(district for district, replicas in TRAFFIC.places.replicas_of.items() if "M1" in replicas)
    kept = TableMemory(0, 0, 1, ())
    memory: dict[str, Note] = {f"{NOTE}{name}": kept, f"{NOTE}M1.00000000": kept}
    heartbeats = HeartbeatSubscriptions(Keys(PLANT.id).atv_heartbeat, Life())
    tables = ReservationHandling("M1", PLANT, TRAFFIC, TrustedKeys(KEY.public), heartbeats, Life())
    tables.start(memory, 0.0)
    gone = [commit for commit in tables.commits() if commit.note is None]
    assert gone == [Commit(None, f"{NOTE}M1.00000000")]
    assert not [commit for commit in tables.commits() if commit.note is None]
