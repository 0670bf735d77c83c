"""A vehicle and a silent one that no way leads round: it tells of it, fetches elsewhere, and takes it back when that one is heard."""

from __future__ import annotations

import msgspec
import pytest
from atv1 import contracted, parked
from defaults import KEYS, PLANT
from effects import listening, published, sent
from rigs import VehicleRig
from spoken import announcement, award, transport

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Bid,
    Grant,
    ObstacleSeen,
    Reason,
    Removal,
    Removals,
    Resigned,
    Superseded,
)
from dray.messages.floor.obstacle import FORGOTTEN_AT_MOST_S
from dray.protocol.runtime.events import Effect
from dray.protocol.traffic.driving.wait import SHUT_OUT_S, ShutOut
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.job.transport_job import ASKS_AGAIN_S

DOCK = PLANT.node_of("S3")
[ENTRY] = {lane.start for lane in PLANT.roads.entering[DOCK]}
SHUT = ShutOut("ATV7", ((ENTRY, DOCK),), SHUT_OUT_S)


def shut_out(rig: VehicleRig, shut: ShutOut = SHUT) -> list[Effect]:
    """It has waited for ATV7."""
    agent = rig.agent
    assert isinstance(agent, Atv)
    before = len(rig.all)
    agent.obstacles.shut_out(shut, rig.now_s)
    rig.run(rig.now_s)
    return rig.all[before:]


def beat(rig: VehicleRig, **changes: object) -> list[Effect]:
    """ATV7 is heard."""
    rig.run(rig.now_s)
    told = msgspec.structs.replace(rig.heartbeats(AtvHeartbeat)[-1], atv="ATV7", **changes)
    return rig.on_message("ATV7", told)


def told(effects: list[Effect]) -> list[tuple[str, str, bool]]:
    return [(seen.start, seen.end, seen.there) for seen in published(effects, ObstacleSeen)]


def bids(effects: list[Effect]) -> list[Bid]:
    return list(sent(effects, Bid, to="M8"))


def obstructed(rig: VehicleRig) -> bool:
    assert isinstance(rig.agent, Atv)
    return (ENTRY, DOCK) in rig.agent.floor.obstructed


def removals(node: str = "") -> Removals:
    grant = Grant(person="anna", areas=(), everywhere=True, valid_until_s=1e6, signature=b"")
    return Removals(removals=(Removal(atv="ATV7", number=1, life=1, seq=1, grant=grant, node=node),))


def test_it_tells_all_and_gives_back_what_others_can_fetch_elsewhere() -> None:
    rig = contracted()
    effects = shut_out(rig)
    assert told(effects) == [(ENTRY, DOCK, True)]
    [resigned] = sent(effects, Resigned, to="M8")
    assert (resigned.reason, resigned.detail, resigned.short) == (Reason.WAY_BLOCKED, "ATV7", "S3")
    assert rig.heartbeats(AtvHeartbeat)[-1].status is not AtvStatus.ERROR, "it has to make room for others"


def test_what_is_on_board_stays_there() -> None:
    rig = contracted()
    rig.arrive()
    rig.picked()
    assert not sent(shut_out(rig), Resigned)


def test_where_all_is_shut_out_the_contract_waits() -> None:
    rig = contracted()
    storages = PLANT.storages_of(transport().item)
    lanes = tuple(
        (lane.start, lane.end) for each in storages for lane in PLANT.roads.entering[PLANT.node_of(each)]
    )
    assert not sent(shut_out(rig, ShutOut("ATV7", lanes, SHUT_OUT_S)), Resigned)


def shut_in(rig: VehicleRig, waited_s: float = SHUT_OUT_S) -> list[Effect]:
    """ATV7 holds the only way out of where it stands."""
    rig.run(rig.now_s + 1.0)
    here = rig.heartbeats(AtvHeartbeat)[-1].node
    lanes = tuple((lane.start, lane.end) for lane in PLANT.roads.leaving[here])
    return shut_out(rig, ShutOut("ATV7", lanes, waited_s))


def test_who_is_shut_in_itself_gives_back_what_others_can_come_to() -> None:
    rig = contracted()
    [resigned] = sent(shut_in(rig), Resigned, to="M8")
    assert (resigned.reason, resigned.detail) == (Reason.WAY_BLOCKED, "ATV7")
    assert not resigned.short, "its source can be reached"


def test_who_has_just_taken_over_waits_for_the_silent_one_first() -> None:
    assert not sent(shut_in(contracted(), 0.0), Resigned)


@pytest.mark.parametrize(
    ("until_s", "gives_back"),
    [(None, False), (1e6, False), (0.5, True)],
    ids=["always", "still", "until then"],
)
def test_nobody_gives_back_what_it_alone_may_carry_before_others_may(
    until_s: float | None, gives_back: bool
) -> None:
    rig = parked()
    work = transport(vehicle="ATV1", vehicle_until_s=until_s)
    assert sent(rig.on_message("M8", award(work=work)), Accepted)
    assert bool(sent(shut_in(rig), Resigned)) is gives_back


def test_a_contract_for_what_was_only_to_be_had_there_waits_longer() -> None:
    rig = parked()
    rig.on_message("ATV5", ObstacleSeen(atv="ATV5", start=ENTRY, end=DOCK, there=True, forget_in_s=500.0))
    assert sent(rig.on_message("M8", award()), Accepted)
    assert not sent(shut_out(rig), Resigned)
    assert sent(shut_out(rig, ShutOut("ATV7", SHUT.lanes, ASKS_AGAIN_S)), Resigned)


@pytest.mark.parametrize("sources", [("S3", "S1"), ("S1", "S3")])
def test_bids_leave_a_source_out_behind_an_obstacle_while_there_is_another_one(
    sources: tuple[str, ...],
) -> None:
    rig = parked()
    asked = announcement(work=transport(sources=sources))
    [before] = bids(rig.on_message("M8", asked))
    rig.on_message("ATV5", ObstacleSeen(atv="ATV5", start=ENTRY, end=DOCK, there=True, forget_in_s=500.0))
    [after] = bids(rig.on_message("M8", msgspec.structs.replace(asked, round=2)))
    assert (before.source, after.source) == ("S3", "S1")
    [only] = bids(
        rig.on_message("M8", msgspec.structs.replace(asked, task="M8-9", work=transport(sources=("S3",))))
    )
    assert only.source == "S3"


def test_it_is_forgotten_when_the_vehicle_is_heard_and_can_move() -> None:
    rig = contracted()
    assert KEYS.atv_heartbeat("ATV7") in listening(shut_out(rig))
    assert not told(beat(rig, status=AtvStatus.ERROR))
    assert obstructed(rig)
    effects = beat(rig, status=AtvStatus.IDLE)
    assert told(effects) == [(ENTRY, DOCK, False)]
    assert not obstructed(rig)
    assert not told(shut_out(rig)), "it was heard a moment ago"
    rig.now_s += SHUT_OUT_S
    assert told(shut_out(rig)) == [(ENTRY, DOCK, True)]


def test_it_is_forgotten_when_people_have_carried_the_vehicle_away() -> None:
    rig = contracted()
    assert KEYS.removals in listening(shut_out(rig))
    assert not told(rig.on_message("gateway", removals(node=ENTRY)))
    assert told(rig.on_message("gateway", removals())) == [(ENTRY, DOCK, False)]


def test_what_nobody_has_taken_back_is_forgotten_after_a_time() -> None:
    rig = contracted()
    shut_out(rig)
    rig.on_message("M8", Superseded(task="M8-1", epoch=2))
    rig.run(rig.now_s + FORGOTTEN_AT_MOST_S)
    assert not obstructed(rig)
    assert not told(beat(rig, status=AtvStatus.IDLE))


@pytest.mark.parametrize("now_s", [759.302, 876.697])
def test_what_is_told_is_kept_no_longer_than_may_be_said_however_moments_are_rounded(now_s: float) -> None:
    assert now_s + FORGOTTEN_AT_MOST_S - now_s > FORGOTTEN_AT_MOST_S
    rig = contracted()
    rig.run(now_s)
    [seen] = published(shut_out(rig), ObstacleSeen)
    assert seen.forget_in_s == FORGOTTEN_AT_MOST_S
