"""A vehicle tells how it is, and endures what it is told (paper, 3.2)."""

from __future__ import annotations

import msgspec
import pytest
from atv1 import contracted, last_beat, parked
from defaults import PLANT
from effects import deeds, facts, sent
from msgspec import UNSET
from msgspec.structs import replace
from rigs import VehicleRig
from spoken import accepted, announcement, award, bid, mhb, production, rhb

from dray.body import ProblemCleared, ProblemRaised
from dray.codec import decode, encode
from dray.errors import ProtocolViolation
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Bid,
    BodyWait,
    Declined,
    Docked,
    DwellPointClaimed,
    GoalClosed,
    Handover,
    OrderReleased,
    Refusal,
)
from dray.messages.fact import BidRefused

# --- heartbeats -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rig", "interval_s"), [(parked, 5.0), (contracted, 1.0)])
def test_an_idle_vehicle_beats_every_five_seconds_and_a_working_one_every_second(
    rig: object, interval_s: float
) -> None:
    vehicle: VehicleRig = rig()  # type: ignore[operator]
    vehicle.run(60.0)
    vehicle.all.clear()
    vehicle.run(120.0)
    times_s = [beat.at_s for beat in vehicle.heartbeats(AtvHeartbeat)]
    gaps_s = [round(after - before, 6) for before, after in zip(times_s, times_s[1:], strict=False)]  # noqa: RUF007
    assert set(gaps_s) == {interval_s}
    assert len(gaps_s) >= 60 / interval_s - 2


def test_a_vehicle_without_a_task_beats_every_second_for_as_long_as_it_has_a_problem() -> None:
    rig = parked()
    rig.run(60.0)
    rig.report(ProblemRaised(reason="a wheel is stuck"))
    rig.run(80.0)
    rig.report(ProblemCleared())
    rig.run(120.0)
    times_s = [beat.at_s for beat in rig.heartbeats(AtvHeartbeat)]
    assert sum(60.0 <= at_s < 80.0 for at_s in times_s) >= 20
    assert sum(100.0 <= at_s < 120.0 for at_s in times_s) == 4


def test_what_a_body_waits_for_is_told_from_ten_seconds_on_and_not_any_more_when_it_has_ended() -> None:
    rig = parked()
    wait = BodyWait("its action pick", since_s=62.0, until="that is FINISHED or FAILED")
    plain = rig.sense
    rig.sense = lambda: replace(plain(), wait=wait)  # type: ignore[method-assign]
    rig.run(100.0)
    rig.sense = plain  # type: ignore[method-assign]
    rig.run(120.0)
    told = {beat.at_s: beat.body_wait for beat in rig.heartbeats(AtvHeartbeat)}
    assert {said for at_s, said in told.items() if at_s < 72.0 or at_s > 100.0} == {UNSET}
    assert {said for at_s, said in told.items() if 72.0 <= at_s < 100.0} == {wait}


@pytest.mark.parametrize("reckoned", [True, False])
def test_that_its_battery_does_not_tell_is_in_its_heartbeats_and_bids(reckoned: bool) -> None:
    rig = parked()
    plain = rig.sense
    rig.sense = lambda: replace(plain(), battery_reckoned=reckoned)  # type: ignore[method-assign]
    rig.run(60.0)
    assert rig.heartbeats(AtvHeartbeat)[-1].battery_reckoned is reckoned
    [bid] = sent(rig.on_message("M8", announcement(radius_m=1e4)), Bid)
    assert bid.battery_reckoned is (reckoned or UNSET)
    assert decode(encode("ATV1", bid)) == ("ATV1", bid)


def test_vehicles_that_start_together_do_not_beat_together() -> None:
    seconds_s = set()
    for atv in PLANT.fleet:
        rig = VehicleRig(atv)
        rig.start()
        rig.run(30.0)
        seconds_s.add(round(rig.heartbeats(AtvHeartbeat)[-1].at_s % 5.0, 3))
    assert len(seconds_s) > len(PLANT.fleet) / 2


def test_a_change_of_status_is_told_at_once() -> None:
    rig = parked()
    rig.run(12.0)
    rig.now_s = 12.1
    rig.on_message("M8", award())
    beat = last_beat(rig)
    assert (beat.at_s, beat.status) == (12.1, AtvStatus.WORKING)


def test_heartbeats_are_numbered_without_a_gap_in_their_life() -> None:
    rig = contracted()
    rig.run(30.0)
    beats = rig.heartbeats(AtvHeartbeat)
    assert [beat.seq for beat in beats] == list(range(1, len(beats) + 1))
    assert {beat.incarnation for beat in beats} == {1}


# --- robustness -------------------------------------------------------------------------------------


def test_what_is_not_meant_for_a_vehicle_is_ignored() -> None:
    rig = contracted()
    for message in (
        bid(1.0),
        accepted(),
        mhb("M8"),
        rhb("ATV9", 1, 0.0),
        GoalClosed(goal="G1"),
        OrderReleased(order="O1", items=(), due_s=1.0),
        Docked(task="M8-1", epoch=1, station="M8"),
        Handover(task="M8-1", epoch=1, quantity=1),
        DwellPointClaimed(dwell_point="CH1", atv="ATV9", battery_frac=0.1, standing=False),
    ):
        assert deeds(rig.on_message("X", message)) == [], message


def test_a_goal_is_not_for_vehicles() -> None:
    rig = parked()
    [refused] = facts(rig.on_message("S", announcement(work=production())), BidRefused)
    assert refused.reason is Refusal.ABILITY
    [declined] = sent(rig.on_message("S", award(work=production())), Declined)
    assert declined.reason is Refusal.ABILITY


def test_a_vehicle_without_a_body_is_our_own_bug() -> None:
    class Ghost(VehicleRig):
        def sense(self) -> None:  # type: ignore[override]
            return None

    with pytest.raises(ProtocolViolation, match="needs a vehicle's body"):
        Ghost().start()


def test_being_woken_for_nothing_is_harmless() -> None:
    rig = contracted()
    rig.run(10.0)
    assert rig.wake() == []
    assert rig.wake() == []


def test_a_vehicle_leaves_what_it_is_told_as_it_is() -> None:
    rig = contracted()
    body = rig.sense()
    before = msgspec.json.encode(body)
    rig.run(30.0)
    rig.arrive()
    assert msgspec.json.encode(body) == before
