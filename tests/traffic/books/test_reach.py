"""How much of the floor one vehicle is granted, whatever it says."""

from __future__ import annotations

from math import dist

import pytest
from book_keeper import HERE, LATER_S, PLACES, PLANT, Keeper, answers, beat, wish, word

from dray.memory import BookMemory
from dray.messages import Message, Removals
from dray.messages.floor.traffic import Blocked, HoldsAsked
from dray.protocol.runtime.events import Effect, Ignore, Send
from dray.protocol.traffic.books.district import NEVER_GRANTED, NOT_HEARD_THERE
from dray.protocol.traffic.books.reach import RUN_MAX
from dray.protocol.traffic.books.roll_call import ROLL_S

STRANGER = "A"
"""It has a certificate, and the plant file does not know it."""

NEAREST = sorted(PLACES.all, key=lambda place: dist(PLACES.at_m[place], PLACES.at_m[HERE]))
GROUPS = tuple((place,) for place in NEAREST[:64])
FARTHEST = NEAREST[-1]
FAR_OFF = next(node for node in PLANT.nodes if PLACES.place_of(node) == FARTHEST)
ACROSS = max(PLACES.all, key=lambda place: dist(PLACES.at_m[place], PLACES.at_m[FARTHEST]))


@pytest.fixture
def keeper() -> Keeper:
    return Keeper()


def held(keeper: Keeper, atv: str) -> set[str]:
    return {line.place for line in keeper.book.of(atv)}


def ignored(effects: list[Effect]) -> list[str]:
    return [effect.reason for effect in effects if isinstance(effect, Ignore)]


@pytest.mark.parametrize("atv", [STRANGER, "ATV1"])
def test_what_no_book_has_granted_is_nobodys_however_often_it_is_said(keeper: Keeper, atv: str) -> None:
    keeper.told(atv, wish(*NEAREST[:64]), 99.0)
    keeper.told(atv, beat(atv=atv), 100.0)
    keeper.told(atv, wish(*NEAREST[:64], seq=2), 101.0)
    assert held(keeper, atv) == set()


def test_a_stranger_is_granted_nothing_before_it_was_heard(keeper: Keeper) -> None:
    (told,) = answers(keeper.told(STRANGER, wish(groups=((HERE,),)), 99.0))
    assert (told.grants, told.blocked, told.by) == ((), Blocked.WAIT, STRANGER)
    keeper.told(STRANGER, beat(), 100.0)
    assert held(keeper, STRANGER) == {HERE}


def test_one_of_the_plant_drives_in_before_its_next_heartbeat_and_not_on(keeper: Keeper) -> None:
    keeper.told("ATV1", wish(groups=GROUPS[:3]), 99.0)
    assert held(keeper, "ATV1") == {HERE}
    keeper.told("ATV1", beat(atv="ATV1"), 100.0)
    assert held(keeper, "ATV1") == set(NEAREST[:3])


def test_nobody_has_more_than_a_run_of_places(keeper: Keeper) -> None:
    keeper.told(STRANGER, wish(groups=GROUPS), 99.0)
    keeper.told(STRANGER, beat(), 100.0)
    assert held(keeper, STRANGER) == set(NEAREST[:RUN_MAX])
    keeper.told(STRANGER, wish(*NEAREST[:RUN_MAX], seq=2, groups=((FARTHEST,),)), 101.0)
    assert held(keeper, STRANGER) == set(NEAREST[:RUN_MAX])


def test_what_is_far_from_where_it_was_heard_is_not_granted_before_it_is_heard_there(keeper: Keeper) -> None:
    assert dist(PLACES.at_m[HERE], PLACES.at_m[FARTHEST]) > PLACES.reach_m(0.0)
    keeper.comes("ATV1", HERE, now_s=100.0)
    keeper.told("ATV1", wish(HERE, seq=2, groups=((FARTHEST,),)), 100.0)
    keeper.told("ATV1", wish(seq=3, seen=keeper.book.version, groups=((FARTHEST,),)), 100.0)
    assert held(keeper, "ATV1") == set()
    keeper.told("ATV1", beat(atv="ATV1", seq=8, node=FAR_OFF), 101.0)
    assert held(keeper, "ATV1") == {FARTHEST}


def test_whoever_was_not_heard_for_long_is_granted_nothing_more(keeper: Keeper) -> None:
    keeper.comes("ATV1", HERE, now_s=100.0)
    keeper.told("ATV1", wish(HERE, seq=2, seen=1, groups=((NEAREST[1],),)), LATER_S)
    assert held(keeper, "ATV1") == {HERE}
    keeper.told("ATV1", beat(atv="ATV1", seq=8), LATER_S + 1.0)
    assert held(keeper, "ATV1") == {HERE, NEAREST[1]}


def called() -> tuple[Keeper, int]:
    """A keeper that has lost its books, and the epoch of its roll call."""
    keeper = Keeper({"nothing": BookMemory(0, 0, 0)})
    asked = [effect.message for effect in keeper.out if isinstance(effect, Send)]
    (epoch,) = {message.epoch for message in asked if isinstance(message, HoldsAsked)}
    return keeper, epoch


def test_in_a_roll_call_nobody_holds_more_than_one_run() -> None:
    keeper, epoch = called()
    first, second, *others = PLANT.fleet
    keeper.told(first, wish(*NEAREST[100:164], epoch=epoch), 1.0)
    keeper.told(second, wish(ACROSS, FARTHEST, epoch=epoch), 1.0)
    for number, atv in enumerate(others):
        keeper.told(atv, wish(NEAREST[number], epoch=epoch, seen=number), ROLL_S + 1.0)
    assert keeper.book.atvs == tuple(others)


@pytest.mark.parametrize(("node", "holds"), [("", set()), (HERE, {HERE}), (FAR_OFF, set())])
def test_in_a_roll_call_a_stranger_holds_what_is_where_it_is_heard(node: str, holds: set[str]) -> None:
    keeper, epoch = called()
    if node:
        keeper.told(STRANGER, beat(node=node), 1.0)
    keeper.told(STRANGER, wish(HERE, epoch=epoch), 1.0)
    for atv in PLANT.fleet:
        keeper.told(atv, wish(epoch=epoch), ROLL_S + 1.0)
    assert held(keeper, STRANGER) == holds


def test_one_that_nobody_has_asked_in_a_roll_call_tells_later_what_it_holds_once_it_is_heard_there() -> None:
    keeper, epoch = called()
    for atv in PLANT.fleet:
        keeper.told(atv, wish(epoch=epoch), ROLL_S + 1.0)
    late = wish(HERE, epoch=epoch, seen=70)
    assert ignored(keeper.told(STRANGER, late, ROLL_S + 2.0)) == [NOT_HEARD_THERE]
    keeper.told(STRANGER, beat(), ROLL_S + 3.0)
    keeper.told(STRANGER, late, ROLL_S + 4.0)
    assert held(keeper, STRANGER) == {HERE}
    assert keeper.book.version > 70
    keeper.told(STRANGER, wish(HERE, NEAREST[1], seq=2, epoch=epoch, seen=70), ROLL_S + 5.0)
    assert held(keeper, STRANGER) == {HERE}


def test_who_says_to_have_seen_what_was_never_granted_gives_nothing_back(keeper: Keeper) -> None:
    keeper.comes("ATV1", HERE, now_s=100.0)
    assert ignored(keeper.told("ATV1", wish(seq=10**6, seen=2**40), 101.0)) == [NEVER_GRANTED]
    assert held(keeper, "ATV1") == {HERE}
    keeper.told("ATV1", wish(seq=2, seen=keeper.book.version), 102.0)
    assert held(keeper, "ATV1") == set()


def test_whoever_holds_something_and_was_never_heard_is_carried_away_by_a_persons_word(
    keeper: Keeper,
) -> None:
    keeper.told("ATV1", wish(groups=((HERE,),)), 99.0)
    removal: Message = Removals(removals=(word(atv="ATV1", heard=(0, 0)),))
    keeper.told("gateway", removal, LATER_S)
    assert held(keeper, "ATV1") == set()
