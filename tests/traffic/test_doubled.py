"""A vehicle under whose name somebody else speaks: it stops, says so, and goes on when a person has seen to it."""

from __future__ import annotations

import asyncio

from dray.messages import AtvHeartbeat, AtvStatus, HelpCall, Message, PlaceGranted
from dray.plant import load_plant
from dray.protocol.vehicle.people.command_handling import DOUBLED
from dray.protocol.vehicle.people.problem_handling import DOUBLED_S
from dray_sim.checks.floor.held_places import HeldPlaces
from dray_sim.checks.floor.overlaps import Overlaps
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners

PLANT = load_plant("single-track")


class Told:
    """What ATV1 has told of itself."""

    def __init__(self) -> None:
        self.heard: list[AtvHeartbeat] = []
        self.calls: set[str] = set()

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        if type(message) is AtvHeartbeat and message.atv == "ATV1":
            self.heard.append(message)
        if type(message) is HelpCall and message.caller == "ATV1":
            self.calls.add(message.reason)


def test_a_vehicle_that_is_answered_what_it_has_not_said_stops_and_is_an_alarm_until_that_is_over() -> None:
    async def main() -> tuple[Told, float]:
        listeners, told = Listeners(), Told()
        factory = SimFactory(PLANT, clock(), seed=1, listener=listeners, traffic=True)
        listeners.add(told, HeldPlaces(factory), Overlaps(factory.vehicles))
        life = asyncio.create_task(factory.run())
        await asyncio.sleep(20.0)
        assert factory.traffic is not None
        places = factory.traffic.places
        district = places.district_of[places.place_of(told.heard[-1].node)]
        forged = PlaceGranted(district=district, epoch=0, life=1, upto=10**6, grants=())
        factory.workers["ATV1"].inbox.on_message(places.replicas_of[district][0], forged)
        said_s = clock().now_s()
        await asyncio.sleep(DOUBLED_S + 30.0)
        life.cancel()
        await asyncio.gather(life, return_exceptions=True)
        return told, said_s

    told, said_s = run(main(), JUMP)
    since = [heartbeat for heartbeat in told.heard if heartbeat.at_s >= said_s]
    assert {heartbeat.status for heartbeat in since} == {AtvStatus.STOPPED}
    assert {heartbeat.problem for heartbeat in since if heartbeat.at_s < said_s + DOUBLED_S} == {DOUBLED}
    assert told.calls == {DOUBLED}
    assert since[-1].problem == ""
    assert since[-1].floor
    assert since[-1].floor.holds
