"""A vehicle that hears that it was carried away: it drives on nothing that is not its own."""

from __future__ import annotations

from atv1 import command, last_beat, parked
from effects import instructed, sent
from placing import TRAFFIC, answer
from rigs import VehicleRig
from spoken import award

from dray.body import Drive, Hold, Unhold
from dray.messages import Accepted, AtvStatus, CommandKind, Declined, PlaceRequested


def placed() -> VehicleRig:
    rig = parked(traffic=TRAFFIC)
    answer(rig)
    return rig


def test_it_takes_no_work_before_it_is_told_that_its_place_is_its_own() -> None:
    rig = parked(traffic=TRAFFIC)
    assert sent(rig.on_message("M8", award()), Declined)
    answer(rig)
    assert sent(rig.on_message("M8", award(epoch=2)), Accepted)


def test_one_that_drives_stops_until_a_person_has_seen_to_it_and_then_asks_anew() -> None:
    rig = placed()
    rig.on_message("M8", award())
    answer(rig)
    assert instructed(rig.all, Drive)
    effects = answer(rig, removal=1, grants=False)
    assert instructed(effects, Hold)
    rig.run(rig.now_s + 1.0)
    beat = last_beat(rig)
    assert beat.status is AtvStatus.STOPPED
    assert (beat.floor.holds, beat.floor.removal) == ((), 1)  # type: ignore[union-attr]
    request = sent(rig.all, PlaceRequested)[-1]
    assert (request.removal, request.holds) == (1, ())
    assert command(rig, CommandKind.ACKNOWLEDGE).done
    assert command(rig, CommandKind.RESUME).done
    assert instructed(rig.all, Unhold)


def test_one_that_stands_asks_anew_and_goes_on() -> None:
    rig = placed()
    effects = answer(rig, removal=1, grants=False)
    assert not instructed(effects, Hold)
    rig.run(rig.now_s + 1.0)
    request = sent(rig.all, PlaceRequested)[-1]
    assert (request.removal, request.holds) == (1, ())
    answer(rig, removal=1)
    assert sent(rig.on_message("M8", award()), Accepted)
