"""How much of the floor one vehicle is granted, whatever it says."""

from __future__ import annotations

from math import dist

import pytest
from replica import HERE, LATER_S, PLACES, PLANT, Replica, answers, beat, request, word

from dray.memory import TableMemory
from dray.messages import Message, Removals
from dray.messages.floor.traffic import Blocked, HoldsAsked
from dray.protocol.runtime.events import Effect, Ignore, Send
from dray.protocol.traffic.reservations.district import NEVER_GRANTED, NOT_HEARD_THERE
from dray.protocol.traffic.reservations.reach import RUN_MAX
from dray.protocol.traffic.reservations.recovery_poll import POLL_S

STRANGER = "A"
"""It has a certificate, and the plant file does not know it."""

NEAREST = sorted(PLACES.all, key=lambda place: dist(PLACES.at_m[place], PLACES.at_m[HERE]))
GROUPS = tuple((place,) for place in NEAREST[:64])
FARTHEST = NEAREST[-1]
FAR_OFF = next(node for node in PLANT.nodes if PLACES.place_of(node) == FARTHEST)
ACROSS = max(PLACES.all, key=lambda place: dist(PLACES.at_m[place], PLACES.at_m[FARTHEST]))


@pytest.fixture
def replica() -> Replica:
    return Replica()


def held(replica: Replica, atv: str) -> set[str]:
    return {line.place for line in replica.table.of(atv)}


def ignored(effects: list[Effect]) -> list[str]:
    return [effect.reason for effect in effects if isinstance(effect, Ignore)]


@pytest.mark.parametrize("atv", [STRANGER, "ATV1"])
def test_what_no_table_has_granted_is_nobodys_however_often_it_is_said(replica: Replica, atv: str) -> None:
    replica.told(atv, request(*NEAREST[:64]), 99.0)
    replica.told(atv, beat(atv=atv), 100.0)
    replica.told(atv, request(*NEAREST[:64], seq=2), 101.0)
    assert held(replica, atv) == set()


def test_a_stranger_is_granted_nothing_before_it_was_heard(replica: Replica) -> None:
    (told,) = answers(replica.told(STRANGER, request(groups=((HERE,),)), 99.0))
    assert (told.grants, told.blocked, told.by) == ((), Blocked.WAIT, STRANGER)
    replica.told(STRANGER, beat(), 100.0)
    assert held(replica, STRANGER) == {HERE}


def test_one_of_the_plant_drives_in_before_its_next_heartbeat_and_not_on(replica: Replica) -> None:
    replica.told("ATV1", request(groups=GROUPS[:3]), 99.0)
    assert held(replica, "ATV1") == {HERE}
    replica.told("ATV1", beat(atv="ATV1"), 100.0)
    assert held(replica, "ATV1") == set(NEAREST[:3])


def test_nobody_has_more_than_a_run_of_places(replica: Replica) -> None:
    replica.told(STRANGER, request(groups=GROUPS), 99.0)
    replica.told(STRANGER, beat(), 100.0)
    assert held(replica, STRANGER) == set(NEAREST[:RUN_MAX])
    replica.told(STRANGER, request(*NEAREST[:RUN_MAX], seq=2, groups=((FARTHEST,),)), 101.0)
    assert held(replica, STRANGER) == set(NEAREST[:RUN_MAX])


def test_what_is_far_from_where_it_was_heard_is_not_granted_before_it_is_heard_there(
    replica: Replica,
) -> None:
    assert dist(PLACES.at_m[HERE], PLACES.at_m[FARTHEST]) > PLACES.reach_m(0.0)
    replica.comes("ATV1", HERE, now_s=100.0)
    replica.told("ATV1", request(HERE, seq=2, groups=((FARTHEST,),)), 100.0)
    replica.told("ATV1", request(seq=3, seen=replica.table.version, groups=((FARTHEST,),)), 100.0)
    assert held(replica, "ATV1") == set()
    replica.told("ATV1", beat(atv="ATV1", seq=8, node=FAR_OFF), 101.0)
    assert held(replica, "ATV1") == {FARTHEST}


def test_whoever_was_not_heard_for_long_is_granted_nothing_more(replica: Replica) -> None:
    replica.comes("ATV1", HERE, now_s=100.0)
    replica.told("ATV1", request(HERE, seq=2, seen=1, groups=((NEAREST[1],),)), LATER_S)
    assert held(replica, "ATV1") == {HERE}
    replica.told("ATV1", beat(atv="ATV1", seq=8), LATER_S + 1.0)
    assert held(replica, "ATV1") == {HERE, NEAREST[1]}


def called() -> tuple[Replica, int]:
    """A replica that has lost its tables, and the epoch of its recovery poll."""
    replica = Replica({"nothing": TableMemory(0, 0, 0)})
    asked = [effect.message for effect in replica.out if isinstance(effect, Send)]
    (epoch,) = {message.epoch for message in asked if isinstance(message, HoldsAsked)}
    return replica, epoch


def test_in_a_recovery_poll_nobody_holds_more_than_one_run() -> None:
    replica, epoch = called()
    first, second, *others = PLANT.fleet
    replica.told(first, request(*NEAREST[100:164], epoch=epoch), 1.0)
    replica.told(second, request(ACROSS, FARTHEST, epoch=epoch), 1.0)
    for number, atv in enumerate(others):
        replica.told(atv, request(NEAREST[number], epoch=epoch, seen=number), POLL_S + 1.0)
    assert replica.table.atvs == tuple(others)


@pytest.mark.parametrize(("node", "holds"), [("", set()), (HERE, {HERE}), (FAR_OFF, set())])
def test_in_a_recovery_poll_a_stranger_holds_what_is_where_it_is_heard(node: str, holds: set[str]) -> None:
    replica, epoch = called()
    if node:
        replica.told(STRANGER, beat(node=node), 1.0)
    replica.told(STRANGER, request(HERE, epoch=epoch), 1.0)
    for atv in PLANT.fleet:
        replica.told(atv, request(epoch=epoch), POLL_S + 1.0)
    assert held(replica, STRANGER) == holds


def test_one_that_nobody_has_asked_in_a_recovery_poll_tells_later_what_it_holds_once_it_is_heard_there() -> (
    None
):
    replica, epoch = called()
    for atv in PLANT.fleet:
        replica.told(atv, request(epoch=epoch), POLL_S + 1.0)
    late = request(HERE, epoch=epoch, seen=70)
    assert ignored(replica.told(STRANGER, late, POLL_S + 2.0)) == [NOT_HEARD_THERE]
    replica.told(STRANGER, beat(), POLL_S + 3.0)
    replica.told(STRANGER, late, POLL_S + 4.0)
    assert held(replica, STRANGER) == {HERE}
    assert replica.table.version > 70
    replica.told(STRANGER, request(HERE, NEAREST[1], seq=2, epoch=epoch, seen=70), POLL_S + 5.0)
    assert held(replica, STRANGER) == {HERE}


def test_who_says_to_have_seen_what_was_never_granted_gives_nothing_back(replica: Replica) -> None:
    replica.comes("ATV1", HERE, now_s=100.0)
    assert ignored(replica.told("ATV1", request(seq=10**6, seen=2**40), 101.0)) == [NEVER_GRANTED]
    assert held(replica, "ATV1") == {HERE}
    replica.told("ATV1", request(seq=2, seen=replica.table.version), 102.0)
    assert held(replica, "ATV1") == set()


def test_whoever_holds_something_and_was_never_heard_is_carried_away_by_a_persons_word(
    replica: Replica,
) -> None:
    replica.told("ATV1", request(groups=((HERE,),)), 99.0)
    removal: Message = Removals(removals=(word(atv="ATV1", heard=(0, 0)),))
    replica.told("gateway", removal, LATER_S)
    assert held(replica, "ATV1") == set()
