"""Vehicles that people carry away: whose word frees their places, when, and what is told to one that comes back."""

from __future__ import annotations

from typing import Any

import pytest
from book_keeper import (
    AREA,
    DIED_S,
    DISTRICT,
    ELSEWHERE,
    FORGER,
    GONE_S,
    HERE,
    LATER_S,
    PLANT,
    Keeper,
    answers,
    beat,
    facts,
    wish,
    word,
)
from msgspec import UNSET

from dray.memory import BookMemory
from dray.messages import Removals
from dray.messages.fact import PlaceKept, PlacesFreed
from dray.messages.floor.traffic import Blocked, HoldsAsked
from dray.messages.heartbeat import AWAITED_MAX
from dray.protocol.runtime.events import Publish, Send, Subscribe, Unsubscribe
from dray.protocol.traffic.books.roll_call import QUIET_S, ROLL_S
from dray.protocol.traffic.removal_authorisation import EXPIRED, IS_HEARD, NOT_THERE, NOT_TRUSTED, TOO_EARLY


@pytest.fixture
def keeper() -> Keeper:
    """A has died with two places."""
    keeper = Keeper()
    keeper.comes("A", HERE, ELSEWHERE, now_s=DIED_S)
    return keeper


def test_what_a_vehicle_held_is_free_once_and_that_is_told(keeper: Keeper) -> None:
    effects = keeper.told("gateway", Removals(removals=(word(),)), LATER_S)
    assert (keeper.holder(HERE), keeper.holder(ELSEWHERE)) == ("", "")
    (freed,) = facts(effects, PlacesFreed)
    assert (freed.by, set(freed.places)) == ("eve", {HERE, ELSEWHERE})
    again = keeper.told("gateway", Removals(removals=(word(),)), LATER_S + 1.0)
    assert facts(again, PlacesFreed) == []


def test_nobody_believes_it_of_a_vehicle_that_may_be_speaking_on_a_bad_link(keeper: Keeper) -> None:
    assert keeper.remove(DIED_S + GONE_S - 0.1) == [IS_HEARD]
    assert keeper.holder(HERE) == "A"


def test_nor_of_one_that_was_heard_after_the_word_was_given(keeper: Keeper) -> None:
    keeper.told("A", beat(seq=8), DIED_S + 1.0)
    assert keeper.remove(LATER_S + 1000.0) == [IS_HEARD]
    assert keeper.remove(LATER_S + 1000.0, heard=(1, 8)) == []


def test_nor_of_one_that_still_asks_for_places(keeper: Keeper) -> None:
    keeper.told("A", wish(HERE, seq=2), LATER_S - 1.0)
    assert keeper.remove() == [IS_HEARD]


def test_what_it_has_said_long_before_is_no_sign_that_it_lives(keeper: Keeper) -> None:
    old = wish(HERE, ELSEWHERE, seq=1)
    keeper.told("A", old, LATER_S - 1.0)
    assert keeper.remove() == []


def test_a_keeper_that_has_just_begun_to_listen_believes_nothing() -> None:
    assert Keeper(now_s=LATER_S - 1.0).remove() == [TOO_EARLY]


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ({"key": FORGER}, NOT_TRUSTED),
        ({"until_s": LATER_S - 1.0}, EXPIRED),
        ({"areas": ("nowhere",)}, NOT_THERE),
        ({"areas": ()}, NOT_THERE),
        ({"areas": (AREA,), "node": ELSEWHERE}, NOT_THERE),
    ],
)
def test_only_who_may_command_where_the_vehicle_was_may_say_so(
    keeper: Keeper, how: dict[str, Any], why: str
) -> None:
    assert keeper.remove(**how) == [why]
    assert keeper.holder(HERE) == "A"


def test_the_area_where_it_was_heard_last_is_enough_for_all_that_it_held(keeper: Keeper) -> None:
    assert keeper.remove(areas=(AREA,)) == []
    assert keeper.holder(ELSEWHERE) == ""


def test_a_stale_word_frees_nothing_that_was_granted_since(keeper: Keeper) -> None:
    keeper.remove()
    keeper.told("A", wish(removal=1, life=2, groups=((HERE,),)), LATER_S + 10.0)
    keeper.told("A", beat(life=2, seq=1, removal=1), LATER_S + 10.0)
    assert keeper.holder(HERE) == "A"
    for number in (0, 1):
        keeper.remove(LATER_S + 1000.0, number=number)
        assert keeper.holder(HERE) == "A"


def test_who_comes_back_with_a_removal_that_this_book_has_not_heard_of_holds_nothing_of_before(
    keeper: Keeper,
) -> None:
    keeper.told("A", wish(removal=5, life=2, groups=((HERE,),)), LATER_S)
    keeper.told("A", beat(life=2, seq=1, removal=5), LATER_S)
    assert (keeper.holder(HERE), keeper.holder(ELSEWHERE)) == ("A", "")


def test_one_that_stands_there_and_was_only_deaf_is_told_that_nothing_is_its_own(keeper: Keeper) -> None:
    keeper.remove()
    keeper.comes("B", HERE, now_s=LATER_S + 1.0)
    (told,) = answers(keeper.told("A", beat(seq=8), LATER_S + 2.0))
    assert (told.removal, told.grants) == (1, ())
    (told,) = answers(keeper.told("A", wish(HERE, ELSEWHERE, seq=2), LATER_S + 2.0))
    assert (told.removal, told.grants) == (1, ())
    assert (keeper.holder(HERE), keeper.holder(ELSEWHERE)) == ("B", "")
    (told,) = answers(keeper.told("A", wish(seq=3, removal=1, groups=((HERE,),)), LATER_S + 3.0))
    assert (told.by, told.at, told.grants) == ("B", HERE, ())


def test_the_place_to_which_it_comes_back_is_kept_for_it(keeper: Keeper) -> None:
    keeper.remove()
    effects = keeper.told("gateway", Removals(removals=(word(2, node=ELSEWHERE),)), LATER_S + 1.0)
    assert facts(effects, PlaceKept) == [PlaceKept(atv="A", number=2, place=ELSEWHERE)]
    keeper.told("B", wish(groups=((ELSEWHERE,),)), LATER_S + 2.0)
    keeper.told("B", beat(atv="B"), LATER_S + 2.0)
    assert keeper.holder(ELSEWHERE) == "A"
    (told,) = answers(keeper.told("A", wish(life=2, groups=((ELSEWHERE,),)), LATER_S + 3.0))
    assert (told.removal, [line.place for line in told.grants]) == (2, [ELSEWHERE])


def test_a_place_that_another_one_holds_is_not_kept_before_it_is_free(keeper: Keeper) -> None:
    keeper.remove()
    keeper.comes("B", HERE, now_s=LATER_S + 1.0)
    word_of = Removals(removals=(word(2, node=HERE),))
    assert facts(keeper.told("gateway", word_of, LATER_S + 2.0), PlaceKept) == []
    given_back = keeper.told("B", wish(seq=2, seen=keeper.book.version), LATER_S + 3.0)
    assert facts(given_back, PlaceKept) == [PlaceKept(atv="A", number=2, place=HERE)]


def test_one_that_is_carried_away_once_more_leaves_the_place_that_was_kept(keeper: Keeper) -> None:
    keeper.remove()
    keeper.remove(LATER_S + 1.0, number=2, node=HERE)
    keeper.remove(LATER_S + 2.0, number=3)
    assert keeper.holder(HERE) == ""


def test_the_next_life_of_a_keeper_knows_who_was_carried_away(keeper: Keeper) -> None:
    keeper.remove()
    (commit,) = keeper.books.commits()
    assert isinstance(commit.note, BookMemory)
    again = Keeper({commit.name: commit.note}, LATER_S)
    again.told("A", wish(HERE, seq=9), LATER_S + 1.0)
    assert again.holder(HERE) == ""


def test_a_carried_vehicle_keeps_no_roll_call_waiting() -> None:
    keeper = Keeper({"nothing": BookMemory(0, 0, 0)})
    asked = [effect.message for effect in keeper.out if isinstance(effect, Send)]
    epochs = {message.epoch for message in asked if isinstance(message, HoldsAsked)}
    (epoch,) = epochs
    books = keeper.books.books
    assert books is not None
    for atv in PLANT.fleet:
        if atv != "ATV1":
            keeper.told(atv, wish(epoch=epoch), 90.0)
    assert not books.districts[DISTRICT].leads
    assert keeper.books.awaited(90.0) is UNSET
    assert keeper.books.awaited(90.0 + QUIET_S) == ("ATV1",)
    assert keeper.remove(atv="ATV1") == []
    assert books.districts[DISTRICT].leads
    assert keeper.books.awaited(LATER_S) is UNSET
    (told,) = answers(keeper.told("ATV1", wish(HERE, epoch=epoch), LATER_S + 1.0))
    assert (told.removal, told.grants) == (1, ())


def test_of_vehicles_that_have_had_no_time_to_tell_nobody_is_awaited() -> None:
    keeper = Keeper({"nothing": BookMemory(0, 0, 0)})
    assert keeper.books.awaited(ROLL_S - 0.1) is UNSET
    assert keeper.books.awaited(ROLL_S) == tuple(sorted(PLANT.fleet))[:AWAITED_MAX]


def test_a_wish_that_was_overtaken_gives_nothing_back(keeper: Keeper) -> None:
    """It was said before the vehicle knew that the place where it stands is its own."""
    keeper.told("A", wish(HERE, seq=3, seen=2), 101.0)
    keeper.told("A", wish(seq=2, seen=2, groups=((HERE,),)), 102.0)
    keeper.told("B", wish(groups=((HERE,),)), 103.0)
    keeper.told("B", beat(atv="B"), 103.0)
    assert keeper.holder(HERE) == "A"


def listened_to(keeper: Keeper, before: int) -> list[tuple[type, str]]:
    return [
        (type(effect), effect.key.rsplit("/", 1)[1])
        for effect in keeper.out[before:]
        if isinstance(effect, Subscribe | Unsubscribe)
    ]


def test_a_keeper_listens_to_those_that_its_book_is_about_and_to_nobody_else() -> None:
    keeper = Keeper()
    assert listened_to(keeper, 0) == [(Subscribe, "removals")]
    keeper.told("A", wish(groups=((HERE,),)), 99.0)
    assert listened_to(keeper, 0) == [(Subscribe, "A")]
    keeper.told("A", beat(), 99.5)
    keeper.told("A", wish(HERE, seq=2, groups=((ELSEWHERE,),)), 100.0)
    assert listened_to(keeper, 0) == []
    keeper.told("A", wish(seq=3, seen=keeper.book.version), 101.0)
    assert listened_to(keeper, 0) == [(Unsubscribe, "A")]
    keeper.told("gateway", Removals(removals=(word(),)), LATER_S)
    assert listened_to(keeper, 0) == [(Subscribe, "A")]


def test_whoever_is_in_a_book_and_was_never_heard_is_silent_after_a_while() -> None:
    keeper = Keeper()
    keeper.told("ATV1", wish(groups=((HERE,),)), 99.0)
    for now_s, why in ((100.0, Blocked.WAIT), (200.0, Blocked.SILENT)):
        told = keeper.told("ATV2", wish(seq=int(now_s), groups=((HERE,),)), now_s)
        assert [answer.blocked for answer in answers(told)] == [why]


def test_a_keeper_tells_who_holds_something_in_its_district() -> None:
    keeper = Keeper()
    keeper.comes("A", HERE, now_s=DIED_S)
    (district,) = keeper.books.books.districts.values()  # type: ignore[union-attr]
    words = []
    for now_s in (101.0, 101.2, 102.0, 104.1, 200.0):
        keeper.out.clear()
        district.tick(now_s)
        words += [(now_s, e.message) for e in keeper.out if isinstance(e, Publish)]
    assert [(at_s, [(v.atv, v.holds, v.silent) for v in told.vehicles]) for at_s, told in words] == [
        (101.0, [("A", (HERE,), False)]),
        (104.1, [("A", (HERE,), False)]),
        (200.0, [("A", (HERE,), True)]),
    ]
    assert [told.number for _, told in words] == [1, 2, 3]
