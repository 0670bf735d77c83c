"""Benchmark `projection`: the cost of showing a plant of 1,000 vehicles to people.

Heartbeats and facts go into the gateway's projection, frames come out of its hub. The baseline of the input is
encoding the same messages once as JSON, as a gateway that only forwards them must do. The baseline of the output is
encoding the same views without finding out which have changed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import msgspec

from dray.gateway.access.principal import ADMIN
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import Hub, Made, Pace, Room
from dray.gateway.live.stream_scopes import WholeScope
from dray.gateway.live.timescale import TimeScale
from dray.messages import AtvHeartbeat, Event, Message, Pose, Refusal, Role, Transport, TransportCost
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    AwardGiven,
    BidReceived,
    BidRefused,
    PhaseEntered,
    TaskClosed,
    TaskOpened,
)
from dray.messages.heartbeat import Phase
from dray.plant import default_plant
from dray.plant.model import PlantFile
from dray_sim.bench.network.bus import HEARTBEAT
from dray_sim.bench.row import Row, rates

VEHICLES = 1_000
"""The largest plant."""

RATE_HZ = 10
"""Frames per second; working vehicles say a heartbeat per second, so a tenth of them is in each."""

ROUNDS, QUICK_ROUNDS = 60, 6
"""Heartbeats of every vehicle in one run."""

TASKS, QUICK_TASKS = 3_000, 300
"""Transports in one run."""

BIDDERS = 6
"""Vehicles that answer an announcement; half of them with a bid."""

SNAPSHOTS, QUICK_SNAPSHOTS = 40, 4

TARGET_PER_S = 50_000.0
"""1,000 vehicles at 50 times real time."""

TARGET_FRAMES_PER_S = 100.0
"""A tenth of a core at ten frames a second."""


def measure(quick: bool) -> list[Row]:
    """Measure the projection.

    Args:
        quick: a tenth of the work.
    """
    heartbeats = _heartbeats(QUICK_ROUNDS if quick else ROUNDS)
    return [
        _folded("heartbeats", heartbeats, TARGET_PER_S),
        _folded("facts of transports", _facts(QUICK_TASKS if quick else TASKS), TARGET_PER_S),
        _frames(heartbeats),
        _snapshots(heartbeats[:VEHICLES], QUICK_SNAPSHOTS if quick else SNAPSHOTS),
    ]


def _folded(name: str, messages: Sequence[Message], target: float) -> Row:
    encoder = msgspec.json.Encoder()
    _file(VEHICLES)

    def fold() -> int:
        projection = _projection()
        for message in messages:
            projection.fold(message)
        return len(messages)

    def write() -> int:
        for message in messages:
            encoder.encode(message)
        return len(messages)

    figure, baseline = rates(fold, write)
    return Row(f"projection: {name} taken in", figure, "1/s", baseline, "writing them as JSON", target)


def _frames(heartbeats: Sequence[AtvHeartbeat]) -> Row:
    size = VEHICLES // RATE_HZ
    parts = [heartbeats[start : start + size] for start in range(0, len(heartbeats), size)]
    projection = _projection()
    _fold_all(projection, heartbeats[:VEHICLES])
    views = projection.atvs.views()[:size]
    encoder = msgspec.json.Encoder()
    wall_s = 0.0

    def make() -> int:
        nonlocal wall_s
        projection = _projection()
        hub = _hub(projection, lambda: wall_s)
        hub.join(ADMIN)
        for part in parts:
            _fold_all(projection, part)
            wall_s += 1 / RATE_HZ
            hub.tick()
        return len(parts)

    def write() -> int:
        for _ in parts:
            encoder.encode(views).decode()
        return len(parts)

    figure, baseline = rates(make, write)
    return Row(
        f"projection: frames, {size} vehicles in each",
        figure,
        "1/s",
        baseline,
        "writing as many views",
        TARGET_FRAMES_PER_S,
        "with taking in what they tell; the same for any number of browsers",
    )


def _snapshots(heartbeats: Sequence[AtvHeartbeat], count: int) -> Row:
    projection = _projection()
    _fold_all(projection, heartbeats)
    views = projection.atvs.views()
    encoder = msgspec.json.Encoder()

    def make() -> int:
        for _ in range(count):
            _room(projection).snapshot()
        return count

    def write() -> int:
        for _ in range(count):
            encoder.encode(views).decode()
        return count

    figure, baseline = rates(make, write)
    name = f"projection: snapshots of {VEHICLES:,} vehicles"
    return Row(name, figure, "1/s", baseline, "writing as many views")


@cache
def _file(vehicles: int) -> PlantFile:
    """Made once: reading is not measured here.

    It lists the senders, because the projection hears only few unknown ones.
    """
    file = default_plant().file
    fleet = tuple(msgspec.structs.replace(file.fleet[0], id=_name(number)) for number in range(vehicles))
    return msgspec.structs.replace(file, fleet=fleet)


def _name(number: int) -> str:
    return f"ATV-{number}"


def _projection() -> Projection:
    return Projection(_file(VEHICLES), TimeScale(0.0, 0.0))


def _hub(projection: Projection, wall_s: Callable[[], float]) -> Hub:
    return Hub(
        projection, wall_s=wall_s, steady_s=wall_s, rate_hz=RATE_HZ, queue_frames=32, clients=1, each=1
    )


def _room(projection: Projection) -> Room:
    return Room(WholeScope(projection), lambda: 0.0, Made(), Pace.LIVE)


def _fold_all(projection: Projection, messages: Sequence[Message]) -> None:
    for message in messages:
        projection.fold(message)


def _heartbeats(rounds: int) -> list[AtvHeartbeat]:
    """The heartbeats of all vehicles in turn, once a second."""
    return [
        msgspec.structs.replace(
            HEARTBEAT,
            atv=_name(number),
            seq=seq,
            at_s=seq + number / VEHICLES,
            pose=Pose(x_m=number / 10 + seq, y_m=12.25, heading_rad=1.57),
        )
        for seq in range(1, rounds + 1)
        for number in range(VEHICLES)
    ]


def _facts(tasks: int) -> list[Message]:
    """The events of transports, each from its announcement to its end."""
    told: list[Message] = []
    for task in range(tasks):
        for agent, fact in _transport(f"T-{task}", f"M-{task % 400}"):
            number = len(told) + 1
            told.append(Event(agent=agent, incarnation=1, number=number, at_s=float(task), fact=fact))
    return told


def _transport(task: str, machine: str) -> list[tuple[str, AnyFact]]:
    work = Transport(item="steel", quantity=8, sources=("S1",), destination=machine, ability="tote")
    cost = TransportCost(empty_way_s=20.0, loaded_way_s=15.0, energy_s=2.0, suitability_s=1.0)
    primary, winner = Role.PRIMARY, _name(0)
    told: list[tuple[str, AnyFact]] = [
        (
            machine,
            TaskOpened(
                task=task,
                epoch=1,
                role=primary,
                round=1,
                work=work,
                radius_m=20.0,
                deadline_s=300.0,
                bids_until_s=1.0,
            ),
        )
    ]
    for number in range(BIDDERS):
        atv = _name(number)
        if number % 2:
            told.append((atv, BidRefused(task=task, epoch=1, role=primary, reason=Refusal.BATTERY)))
        else:
            bid = BidReceived(
                task=task,
                epoch=1,
                role=primary,
                round=1,
                bidder=atv,
                cost=cost,
                total_s=cost.total_s,
                finish_s=90.0,
                source="S1",
            )
            told.append((machine, bid))
    told.append((machine, AwardGiven(task=task, epoch=1, role=primary, bidder=winner, rank=1)))
    answer = AwardAnswered(task=task, epoch=1, role=primary, bidder=winner, answer="accepted")
    told.append((machine, answer))
    steps = (Phase.APPROACHING, Phase.LOADING, Phase.CARRYING, Phase.UNLOADING, Phase.HANDING_OVER)
    told += [(winner, PhaseEntered(task=task, epoch=1, phase=step)) for step in steps]
    told.append((machine, TaskClosed(task=task, epoch=1, outcome="delivered", carrier=winner)))
    return told
