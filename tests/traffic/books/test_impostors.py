"""Who has stolen a vehicle's certificate, and not its key: it gives back nothing that the vehicle holds, whatever it says."""

from __future__ import annotations

from typing import Any

import pytest
from book_keeper import DISTRICT, HERE, LATER_S, PLACES, PLANT, Keeper, answers, beat, facts, wish, word
from msgspec.structs import replace

from dray.adapters.security.signing import VehicleKey
from dray.memory import BookMemory
from dray.messages import PlaceWished, Removals
from dray.messages.fact import NameMisused
from dray.messages.floor.traffic import HoldsAsked
from dray.protocol.runtime.events import Effect, Ignore, Send
from dray.protocol.runtime.throttle import TOLD_EVERY_S
from dray.protocol.traffic.books.bookkeeping import NOTE
from dray.protocol.traffic.books.district import NOT_ON_THE_FLOOR
from dray.protocol.traffic.books.impostors import ANOTHERS_KEY
from dray.protocol.traffic.books.roll_call import BESIDE_MAX, ROLL_S

OWN, STOLEN = VehicleKey("ATV1", b"o" * 32), VehicleKey("ATV1", b"s" * 32)
"""The vehicle's key, and what somebody else has drawn who has its certificate."""

ELSEWHERE = next(place for place in sorted(PLACES.all) if place != HERE)


def own(*holds: str, key: VehicleKey = OWN, **more: Any) -> PlaceWished:
    return key.sign(wish(*holds, **more))


@pytest.fixture
def keeper() -> Keeper:
    """ATV1 stands at `HERE`, and has seen its grant."""
    keeper = Keeper()
    keeper.told("ATV1", own(groups=((HERE,),)), 100.0)
    keeper.told("ATV1", beat(atv="ATV1"), 100.0)
    keeper.told("ATV1", own(HERE, seq=2, seen=keeper.book.version), 100.5)
    assert held(keeper) == {HERE}
    return keeper


def held(keeper: Keeper, atv: str = "ATV1") -> set[str]:
    return {line.place for line in keeper.book.of(atv)}


def ignored(effects: list[Effect]) -> list[str]:
    return [effect.reason for effect in effects if isinstance(effect, Ignore)]


def forged(said: PlaceWished) -> PlaceWished:
    """With the vehicle's key, and its signature of something else."""
    heard = own(HERE)
    return replace(said, key=heard.key, signature=heard.signature)


@pytest.mark.parametrize("sign", [STOLEN.sign, forged, lambda said: said], ids=["own key", "forged", "none"])
@pytest.mark.parametrize("life", [1, 2, 2**40])
def test_whoever_has_the_certificate_alone_gives_nothing_back(keeper: Keeper, sign: Any, life: int) -> None:
    said = sign(wish(life=life, seq=10**6, seen=keeper.book.version, removal=7))
    assert ignored(keeper.told("ATV1", said, 101.0)) == [ANOTHERS_KEY]
    keeper.told("ATV2", wish(groups=((HERE,),)), 102.0)
    assert keeper.holder(HERE) == "ATV1"
    keeper.told("ATV1", own(seq=3, seen=keeper.book.version), 103.0)
    assert keeper.holder(HERE) == "ATV2"


def test_the_next_life_of_the_vehicle_itself_goes_on_with_its_key(keeper: Keeper) -> None:
    (told,) = answers(keeper.told("ATV1", own(groups=((HERE,),), life=2), 101.0))
    assert [line.place for line in told.grants] == [HERE]
    keeper.told("ATV1", own(life=2, seq=2, seen=told.grants[0].number), 102.0)
    assert held(keeper) == set()


def test_people_are_told_once_a_minute_who_is_spoken_for_by_another(keeper: Keeper) -> None:
    said = [
        facts(keeper.told("ATV1", own(key=STOLEN, seq=seq), 101.0 + seq), NameMisused)
        for seq in range(int(TOLD_EVERY_S) + 1)
    ]
    expected = [NameMisused("ATV1")]
    assert [told for told in said if told] == [expected, expected]


def test_what_a_keeper_remembers_of_a_book_tells_whose_key_it_was(keeper: Keeper) -> None:
    commits = keeper.books.commits()
    note = next(commit.note for commit in commits if commit.name == NOTE + DISTRICT)
    assert note is not None
    again = Keeper({NOTE + DISTRICT: note}, 200.0)
    keeper.told("ATV1", own(HERE, seq=3, seen=keeper.book.version), 200.5)
    assert ignored(again.told("ATV1", own(key=STOLEN, life=9, seen=2**40), 201.0)) == [ANOTHERS_KEY]
    assert held(again) == {HERE}


def test_who_speaks_where_the_vehicle_holds_nothing_does_not_spoil_what_the_vehicle_says_there() -> None:
    keeper = Keeper()
    keeper.told("ATV1", own(key=STOLEN, life=2**40, seq=10**6, removal=10**9), 99.0)
    (told,) = answers(keeper.told("ATV1", own(groups=((HERE,),)), 100.0))
    assert (told.removal, told.mark) == (0, own().mark)
    assert held(keeper) == {HERE}


def test_the_owner_waits_where_somebody_else_holds_places_in_its_name() -> None:
    keeper = Keeper()
    keeper.told("ATV1", own(groups=((HERE,),), key=STOLEN), 99.0)
    assert {line.mark for line in keeper.book.of("ATV1")} == {own(key=STOLEN).mark}
    effects = keeper.told("ATV1", own(groups=((HERE,),)), 100.0)
    assert (answers(effects), facts(effects, NameMisused)) == ([], [NameMisused("ATV1")])


def test_a_persons_word_frees_what_is_held_under_any_key(keeper: Keeper) -> None:
    keeper.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    assert held(keeper) == set()
    keeper.told("ATV1", own(groups=((HERE,),), key=STOLEN, removal=1), LATER_S + 1.0)
    assert held(keeper) == {HERE}


def test_what_is_kept_without_a_key_belongs_to_the_key_that_asks_for_it_first(keeper: Keeper) -> None:
    keeper.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    keeper.told("gateway", Removals(removals=(word(2, atv="ATV1", node=HERE),)), LATER_S + 1.0)
    assert {line.mark for line in keeper.book.of("ATV1")} == {b""}
    keeper.told("ATV1", own(groups=((HERE,),), removal=2, life=2), LATER_S + 2.0)
    assert {line.mark for line in keeper.book.of("ATV1")} == {own().mark}


def called() -> tuple[Keeper, int]:
    """A keeper that has lost its memory, and the epoch under which it asks all vehicles."""
    keeper = Keeper({"other": BookMemory(0, 0, 0)})
    asked = [e.message for e in keeper.out if isinstance(e, Send) and isinstance(e.message, HoldsAsked)]
    return keeper, asked[0].epoch


@pytest.mark.parametrize("first", [OWN, STOLEN], ids=["vehicle first", "thief first"])
def test_in_a_roll_call_what_the_vehicle_holds_is_held_whatever_a_thief_tells(first: VehicleKey) -> None:
    keeper, epoch = called()
    told = {
        OWN: own(HERE, epoch=epoch, seen=5),
        STOLEN: own(key=STOLEN, epoch=epoch, seen=5, removal=10**9, life=9),
    }
    keeper.told("ATV1", told[first], 1.0)
    keeper.told("ATV1", next(said for key, said in told.items() if key is not first), 2.0)
    tell_all(keeper, epoch)
    assert held(keeper) == {HERE}
    keeper.told("ATV1", own(key=STOLEN, epoch=epoch, seen=keeper.book.version, seq=9), ROLL_S + 2.0)
    assert held(keeper) == {HERE}


def test_a_roll_call_in_which_too_many_tell_under_one_name_is_not_over() -> None:
    keeper, epoch = called()
    for number in range(BESIDE_MAX + 1):
        keeper.told("ATV1", own(key=VehicleKey("ATV1", bytes([number]) * 32), epoch=epoch), 1.0)
    tell_all(keeper, epoch)
    books = keeper.books.books
    assert books is not None
    assert books.awaited(ROLL_S + 60.0) == {"ATV1"}


def test_a_vehicle_that_is_heard_after_the_roll_call_still_holds_what_a_thief_has_not_told() -> None:
    keeper, epoch = called()
    keeper.told("ATV1", own(key=STOLEN, epoch=epoch), 1.0)
    tell_all(keeper, epoch)
    keeper.told("ATV1", own(HERE, epoch=epoch, seen=5), ROLL_S + 2.0)
    assert held(keeper) == {HERE}


def test_who_was_carried_away_in_a_roll_call_and_does_not_know_it_holds_nothing_afterwards() -> None:
    keeper, epoch = called()
    keeper.told("ATV1", beat(atv="ATV1"), 1.0)
    tell_all(keeper, epoch)
    keeper.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    assert keeper.books.books is not None
    assert keeper.books.books.awaited(LATER_S + 60.0) == set()
    keeper.told("ATV1", own(HERE, epoch=epoch, seen=5), LATER_S + 1.0)
    assert held(keeper) == set()


def tell_all(keeper: Keeper, epoch: int) -> None:
    for atv in PLANT.fleet:
        if atv != "ATV1":
            keeper.told(atv, wish(epoch=epoch), ROLL_S + 1.0)


def test_who_has_the_certificate_alone_keeps_no_dead_vehicle_on_the_floor(keeper: Keeper) -> None:
    for before_s in (3.0, 2.0, 1.0):
        keeper.told("ATV1", own(key=STOLEN, seq=10**6 - int(before_s)), LATER_S - before_s)
        keeper.told("ATV1", own(groups=((HERE,),)), LATER_S - before_s)
    effects = keeper.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    assert (ignored(effects), held(keeper)) == ([], set())


def test_nor_does_it_hinder_people_who_put_it_back(keeper: Keeper) -> None:
    keeper.told("gateway", Removals(removals=(word(atv="ATV1"),)), LATER_S)
    keeper.comes("B", HERE, now_s=LATER_S + 1.0)
    keeper.told("ATV1", own(key=STOLEN, seq=10**6), LATER_S + 1.0)
    put_back = Removals(removals=(word(2, atv="ATV1", node=HERE),))
    assert ignored(keeper.told("gateway", put_back, LATER_S + 1.0)) == []
    effects = keeper.told("ATV1", own(key=STOLEN, seq=10**6 + 1), LATER_S + 2.0)
    assert ignored(effects) == [NOT_ON_THE_FLOOR]
    keeper.told("B", wish(seq=2, seen=keeper.book.version), LATER_S + 3.0)
    assert held(keeper) == {HERE}
