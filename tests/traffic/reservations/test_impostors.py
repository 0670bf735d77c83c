"""Who has stolen a vehicle's certificate, and not its key: it gives back nothing that the vehicle holds, whatever it says."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace
from replica import DISTRICT, HERE, LATER_S, PLACES, PLANT, Replica, answers, beat, facts, request, word

from dray.adapters.security.signing import VehicleKey
from dray.memory import TableMemory
from dray.messages import PlaceRequested, Removals
from dray.messages.fact import NameMisused
from dray.messages.floor.traffic import HoldsAsked
from dray.protocol.runtime.events import Effect, Ignore, Send
from dray.protocol.runtime.throttle import TOLD_EVERY_S
from dray.protocol.traffic.numbers import FAR
from dray.protocol.traffic.reservations.district import BEYOND_COUNT, INSISTS_S, NOT_ON_THE_FLOOR
from dray.protocol.traffic.reservations.impostors import ANOTHERS_KEY
from dray.protocol.traffic.reservations.recovery_poll import BESIDE_MAX, POLL_S
from dray.protocol.traffic.reservations.reservation_handling import NOTE

OWN, STOLEN = VehicleKey("ATV1", b"o" * 32), VehicleKey("ATV1", b"s" * 32)
"""The vehicle's key, and what somebody else has drawn who has its certificate."""

ELSEWHERE = next(place for place in sorted(PLACES.all) if place != HERE)


def own(*holds: str, key: VehicleKey = OWN, **more: Any) -> PlaceRequested:
    return key.sign(request(*holds, **more))


@pytest.fixture
def replica() -> Replica:
    """ATV1 stands at `HERE`, and has seen its grant."""
    replica = Replica()
    replica.told("ATV1", own(groups=((HERE,),)), 100.0)
    replica.told("ATV1", beat(atv="ATV1"), 100.0)
    replica.told("ATV1", own(HERE, seq=2, seen=replica.table.version), 100.5)
    assert held(replica) == {HERE}
    return replica


def held(replica: Replica, atv: str = "ATV1") -> set[str]:
    return {line.place for line in replica.table.of(atv)}


def ignored(effects: list[Effect]) -> list[str]:
    return [effect.reason for effect in effects if isinstance(effect, Ignore)]


def forged(said: PlaceRequested) -> PlaceRequested:
    """With the vehicle's key, and its signature of something else."""
    heard = own(HERE)
    return replace(said, key=heard.key, signature=heard.signature)


@pytest.mark.parametrize("sign", [STOLEN.sign, forged, lambda said: said], ids=["own key", "forged", "none"])
@pytest.mark.parametrize("life", [1, 2, 2**40])
def test_whoever_has_the_certificate_alone_gives_nothing_back(replica: Replica, sign: Any, life: int) -> None:
    said = sign(request(life=life, seq=10**6, seen=replica.table.version, removal=7))
    assert ignored(replica.told("ATV1", said, 101.0)) == [ANOTHERS_KEY]
    replica.told("ATV2", request(groups=((HERE,),)), 102.0)
    assert replica.holder(HERE) == "ATV1"
    replica.told("ATV1", own(seq=3, seen=replica.table.version), 103.0)
    assert replica.holder(HERE) == "ATV2"


def test_the_next_life_of_the_vehicle_itself_goes_on_with_its_key(replica: Replica) -> None:
    (told,) = answers(replica.told("ATV1", own(groups=((HERE,),), life=2), 101.0))
    assert [line.place for line in told.grants] == [HERE]
    replica.told("ATV1", own(life=2, seq=2, seen=told.grants[0].number), 102.0)
    assert held(replica) == set()


def test_people_are_told_once_a_minute_who_is_spoken_for_by_another(replica: Replica) -> None:
    said = [
        facts(replica.told("ATV1", own(key=STOLEN, seq=seq), 101.0 + seq), NameMisused)
        for seq in range(int(TOLD_EVERY_S) + 1)
    ]
    expected = [NameMisused("ATV1")]
    assert [told for told in said if told] == [expected, expected]


def test_what_a_replica_remembers_of_a_table_tells_whose_key_it_was(replica: Replica) -> None:
    commits = replica.reservations.commits()
    note = next(commit.note for commit in commits if commit.name == NOTE + DISTRICT)
    assert note is not None
    again = Replica({NOTE + DISTRICT: note}, 200.0)
    replica.told("ATV1", own(HERE, seq=3, seen=replica.table.version), 200.5)
    assert ignored(again.told("ATV1", own(key=STOLEN, life=9, seen=2**40), 201.0)) == [ANOTHERS_KEY]
    assert held(again) == {HERE}


def test_who_speaks_where_the_vehicle_holds_nothing_does_not_spoil_what_the_vehicle_says_there() -> None:
    replica = Replica()
    replica.told("ATV1", own(key=STOLEN, life=2**40, seq=10**6, removal=10**9), 99.0)
    (told,) = answers(replica.told("ATV1", own(groups=((HERE,),)), 100.0))
    assert (told.removal, told.mark) == (0, own().mark)
    assert held(replica) == {HERE}


def test_the_owner_waits_where_somebody_else_holds_places_in_its_name() -> None:
    replica = Replica()
    replica.told("ATV1", own(groups=((HERE,),), key=STOLEN), 99.0)
    assert {line.mark for line in replica.table.of("ATV1")} == {own(key=STOLEN).mark}
    effects = replica.told("ATV1", own(groups=((HERE,),)), 100.0)
    assert (answers(effects), facts(effects, NameMisused)) == ([], [NameMisused("ATV1")])


def test_a_persons_word_frees_what_is_held_under_any_key(replica: Replica) -> None:
    replica.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    assert held(replica) == set()
    replica.told("ATV1", own(groups=((HERE,),), key=STOLEN, removal=1), LATER_S + 1.0)
    assert held(replica) == {HERE}


def test_what_is_kept_without_a_key_belongs_to_the_key_that_asks_for_it_first(replica: Replica) -> None:
    replica.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    replica.told("gateway", Removals(removals=(word(2, atv="ATV1", node=HERE),)), LATER_S + 1.0)
    assert {line.mark for line in replica.table.of("ATV1")} == {b""}
    replica.told("ATV1", own(groups=((HERE,),), removal=2, life=2), LATER_S + 2.0)
    assert {line.mark for line in replica.table.of("ATV1")} == {own().mark}


def called() -> tuple[Replica, int]:
    """A replica that has lost its memory, and the epoch under which it asks all vehicles."""
    replica = Replica({"other": TableMemory(0, 0, 0)})
    asked = [e.message for e in replica.out if isinstance(e, Send) and isinstance(e.message, HoldsAsked)]
    return replica, asked[0].epoch


@pytest.mark.parametrize("first", [OWN, STOLEN], ids=["vehicle first", "thief first"])
def test_in_a_recovery_poll_what_the_vehicle_holds_is_held_whatever_a_thief_tells(first: VehicleKey) -> None:
    replica, epoch = called()
    told = {
        OWN: own(HERE, epoch=epoch, seen=5),
        STOLEN: own(key=STOLEN, epoch=epoch, seen=5, removal=10**9, life=9),
    }
    replica.told("ATV1", told[first], 1.0)
    replica.told("ATV1", next(said for key, said in told.items() if key is not first), 2.0)
    tell_all(replica, epoch)
    assert held(replica) == {HERE}
    replica.told("ATV1", own(key=STOLEN, epoch=epoch, seen=replica.table.version, seq=9), POLL_S + 2.0)
    assert held(replica) == {HERE}


def test_a_recovery_poll_in_which_too_many_tell_under_one_name_is_not_over() -> None:
    replica, epoch = called()
    for number in range(BESIDE_MAX + 1):
        replica.told("ATV1", own(key=VehicleKey("ATV1", bytes([number]) * 32), epoch=epoch), 1.0)
    tell_all(replica, epoch)
    tables = replica.reservations.tables
    assert tables is not None
    assert tables.awaited(POLL_S + 60.0) == {"ATV1"}


def test_a_vehicle_that_is_heard_after_the_recovery_poll_still_holds_what_a_thief_has_not_told() -> None:
    replica, epoch = called()
    replica.told("ATV1", own(key=STOLEN, epoch=epoch), 1.0)
    tell_all(replica, epoch)
    replica.told("ATV1", own(HERE, epoch=epoch, seen=5), POLL_S + 2.0)
    assert held(replica) == {HERE}


def test_who_was_carried_away_in_a_recovery_poll_and_does_not_know_it_holds_nothing_afterwards() -> None:
    replica, epoch = called()
    replica.told("ATV1", beat(atv="ATV1"), 1.0)
    tell_all(replica, epoch)
    replica.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    assert replica.reservations.tables is not None
    assert replica.reservations.tables.awaited(LATER_S + 60.0) == set()
    replica.told("ATV1", own(HERE, epoch=epoch, seen=5), LATER_S + 1.0)
    assert held(replica) == set()


def tell_all(replica: Replica, epoch: int) -> None:
    for atv in PLANT.fleet:
        if atv != "ATV1":
            replica.told(atv, request(epoch=epoch), POLL_S + 1.0)


def test_who_has_the_certificate_alone_keeps_no_dead_vehicle_on_the_floor(replica: Replica) -> None:
    for before_s in (3.0, 2.0, 1.0):
        replica.told("ATV1", own(key=STOLEN, seq=10**6 - int(before_s)), LATER_S - before_s)
        replica.told("ATV1", own(groups=((HERE,),)), LATER_S - before_s)
    effects = replica.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    assert (ignored(effects), held(replica)) == ([], set())


def test_nor_does_it_hinder_people_who_put_it_back(replica: Replica) -> None:
    replica.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    replica.comes("B", HERE, now_s=LATER_S + 1.0)
    replica.told("ATV1", own(key=STOLEN, seq=10**6), LATER_S + 1.0)
    put_back = Removals(removals=(word(2, atv="ATV1", node=HERE),))
    assert ignored(replica.told("gateway", put_back, LATER_S + 1.0)) == []
    effects = replica.told("ATV1", own(key=STOLEN, seq=10**6 + 1), LATER_S + 2.0)
    assert ignored(effects) == [NOT_ON_THE_FLOOR]
    replica.told("B", request(seq=2, seen=replica.table.version), LATER_S + 3.0)
    assert held(replica) == {HERE}


AHEAD = 10**15
"""A removal that a thief claims to know: people reach that number in ten thousand years."""


def insist(replica: Replica, number: int = 1, until_s: float = LATER_S + INSISTS_S) -> None:
    """A gateway repeats a person's word."""
    now_s = LATER_S
    while now_s <= until_s:
        replica.told("gateway", Removals(removals=(word(number, atv="ATV1"),)), now_s)
        now_s += 2.0


def test_who_claims_to_know_of_a_later_removal_is_carried_away_by_a_word_that_people_repeat() -> None:
    replica = Replica()
    replica.told("ATV1", own(groups=((HERE,),), key=STOLEN, removal=AHEAD), 99.0)
    replica.told("ATV1", beat(atv="ATV1", removal=AHEAD), 99.0)
    assert held(replica) == {HERE}
    insist(replica)
    assert held(replica) == set()
    replica.told("ATV2", request(groups=((HERE,),)), LATER_S + INSISTS_S + 1.0)
    assert replica.holder(HERE) == "ATV2"


def test_an_older_word_of_people_that_is_under_way_frees_nothing(replica: Replica) -> None:
    """The vehicle knows of a removal that this table has not heard of yet."""
    replica.told("ATV1", own(groups=((HERE,),), removal=5, life=2), 101.0)
    assert held(replica) == {HERE}
    insist(replica, 4, LATER_S + INSISTS_S - 2.0)
    assert held(replica) == {HERE}
    insist(replica, 5, LATER_S + 3.0 * INSISTS_S)
    assert held(replica) == {HERE}, "the vehicle was granted it after this very removal"


@pytest.mark.parametrize("claimed", [0, AHEAD])
def test_people_end_a_recovery_poll_in_which_too_many_tell_under_one_name(claimed: int) -> None:
    replica, epoch = called()
    for number in range(BESIDE_MAX + 1):
        key = VehicleKey("ATV1", bytes([number]) * 32)
        replica.told("ATV1", own(HERE, key=key, epoch=epoch, removal=claimed), 1.0)
    tell_all(replica, epoch)
    tables = replica.reservations.tables
    assert tables is not None
    assert not tables.districts[DISTRICT].leads
    insist(replica)
    assert tables.districts[DISTRICT].leads
    assert held(replica) == set()


def test_after_a_persons_word_the_vehicle_is_heard_again_however_far_its_numbers_were_said_to_be(
    replica: Replica,
) -> None:
    """A thief of the key, too, has said the last number of the last life."""
    replica.told("ATV1", own(HERE, life=FAR, seq=FAR, seen=replica.table.version), 101.0)
    replica.told("ATV1", own(groups=((HERE,),), life=2), 102.0)
    assert answers(list(replica.out)) == []
    replica.told("gateway", Removals(removals=(word(atv="ATV1", heard=(FAR, FAR)),)), LATER_S + 5.0)
    assert held(replica) == set()
    (told,) = answers(replica.told("ATV1", own(groups=((HERE,),), life=2, seq=2, removal=1), LATER_S + 6.0))
    assert [line.place for line in told.grants] == [HERE]


@pytest.mark.parametrize("number", [{"seq": FAR + 1}, {"life": FAR + 1}], ids=str)
def test_a_number_that_no_vehicle_reaches_is_not_heard_and_costs_the_owner_nothing(
    replica: Replica, number: dict[str, int]
) -> None:
    said = own(HERE, seen=replica.table.version, **number)
    assert ignored(replica.told("ATV1", said, 101.0)) == [BEYOND_COUNT]
    (told,) = answers(replica.told("ATV1", own(HERE, seq=3, seen=replica.table.version), 102.0))
    assert told.upto == 3
