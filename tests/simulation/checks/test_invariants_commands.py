"""Invariants of stops and commands: their checks can fail, too."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace
from watched import Watched

from dray.adapters.security.signing import SigningKey
from dray.body import Drive
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CommandKind,
    OutOfService,
    Pose,
    Role,
    VehicleCommand,
)
from dray.messages.fact import AtvStatusChanged, CommandObeyed, ContractTaken
from dray_sim.bodies.vehicle.vehicle import SimVehicle


def command(what: str) -> CommandObeyed:
    return CommandObeyed(command=what, what=what, done=True)


def give(
    watched: Watched,
    atv: str,
    *kinds: str,
    key: SigningKey | None = None,
    areas: tuple[str, ...] | None = None,
    valid_until_s: float = 1e6,
) -> None:
    """Somebody commands a vehicle, with a grant."""
    for kind in kinds:
        granted = (key or watched.factory.authority).grant(
            atv,
            VehicleCommand(command=kind, kind=CommandKind(kind)),
            person="operator",
            areas=areas,
            valid_until_s=valid_until_s,
        )
        watched.say("operator", granted, f">{atv}")


def test_a_resume_without_an_acknowledge_is_noticed(watched: Watched) -> None:
    give(watched, "ATV2", "stop", "resume")
    watched.say("ATV2", command("stop"))
    watched.say("ATV2", command("resume"))
    assert watched.broken == 5


def test_a_stop_that_ends_by_itself_is_noticed(watched: Watched) -> None:
    give(watched, "ATV2", "stop")
    watched.say("ATV2", command("stop"))
    watched.say("ATV2", AtvStatusChanged(status=AtvStatus.WORKING))
    assert watched.broken == 5


def stopped_heartbeat(vehicle: SimVehicle) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=vehicle.id,
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.STOPPED,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node=vehicle.sense().node,
        speed_mps=0.0,
        battery_frac=1.0,
    )


def stop(watched: Watched, vehicle: SimVehicle) -> None:
    """Stop it, and let it stand for longer than braking takes."""
    give(watched, vehicle.id, "stop")
    watched.say(vehicle.id, command("stop"))
    for _ in range(15):
        watched.say(vehicle.id, stopped_heartbeat(vehicle))


def drive_off(watched: Watched, vehicle: SimVehicle) -> None:
    here = vehicle.sense().node
    way = watched.factory.plant.routes("heavy").way(here, "c3")
    vehicle.instruct(Drive(order=1, nodes=way.nodes, released=len(way.nodes)))
    watched.factory.clock.time_s += 5.0
    watched.say(vehicle.id, stopped_heartbeat(vehicle))


def test_a_stopped_vehicle_that_moves_is_noticed(watched: Watched) -> None:
    vehicle = watched.factory.vehicles["ATV2"]
    stop(watched, vehicle)
    assert watched.broken == 0
    drive_off(watched, vehicle)
    assert watched.broken == 5


def test_a_stop_is_not_forgotten_with_the_power(watched: Watched) -> None:
    vehicle = watched.factory.vehicles["ATV2"]
    stop(watched, vehicle)
    vehicle.power_off()
    vehicle.power_on()
    drive_off(watched, vehicle)
    assert watched.broken == 5


def test_people_may_carry_a_stopped_vehicle(watched: Watched) -> None:
    vehicle = watched.factory.vehicles["ATV2"]
    stop(watched, vehicle)
    vehicle.place_at("c3")
    watched.say(vehicle.id, stopped_heartbeat(vehicle))
    assert watched.broken == 0


ATV1_IN = "AREA2"


def test_a_command_that_was_granted_for_here_and_now_breaks_nothing(watched: Watched) -> None:
    give(watched, "ATV1", "stop", areas=(ATV1_IN,))
    watched.say("ATV1", command("stop"))
    assert watched.broken == 0


def test_a_refused_command_breaks_nothing(watched: Watched) -> None:
    watched.say("ATV1", replace(command("stop"), done=False))
    assert watched.broken == 0


def test_a_command_that_nobody_has_given_is_noticed(watched: Watched) -> None:
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


def test_a_command_without_a_grant_is_noticed(watched: Watched) -> None:
    watched.say("operator", VehicleCommand(command="stop", kind=CommandKind.STOP), ">ATV1")
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


@pytest.mark.parametrize(
    "grant",
    [
        {"areas": ("AREA4",)},
        {"areas": ()},
        {"valid_until_s": 1.0},
        {"key": SigningKey(b"a stranger's key, 32 bytes long.")},
    ],
    ids="".join,
)
def test_a_grant_for_another_place_or_time_or_by_a_stranger_is_noticed(
    watched: Watched, grant: dict[str, Any]
) -> None:
    give(watched, "ATV1", "stop", **grant)
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


def test_a_grant_for_another_vehicle_is_noticed(watched: Watched) -> None:
    give(watched, "ATV3", "stop")
    watched.say("ATV1", command("stop"))
    assert watched.broken == 9


def test_a_contract_that_is_taken_out_of_service_is_noticed(watched: Watched) -> None:
    beat = replace(stopped_heartbeat(watched.factory.vehicles["ATV2"]), status=AtvStatus.IDLE)
    out = replace(beat, out_of_service=OutOfService(by="Maria", since_s=0.0))
    taken = ContractTaken(task="M8-1", epoch=1, role=Role.SECONDARY, coordinator="M8")
    watched.say("ATV2", out)
    watched.say("ATV3", out, "a neighbour passes it on")
    watched.say("ATV3", taken)
    watched.say("ATV2", replace(beat, seq=2))
    watched.say("ATV3", out, "and once more")
    assert watched.broken == 0
    watched.say("ATV2", replace(out, seq=3))
    watched.say("ATV2", taken)
    assert watched.broken == 16
