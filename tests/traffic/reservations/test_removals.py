"""Vehicles that people carry away: whose word frees their places, when, and what is told to one that comes back."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import UNSET
from msgspec.structs import replace
from replica import (
    AREA,
    DIED_S,
    DISTRICT,
    ELSEWHERE,
    FORGER,
    GONE_S,
    HERE,
    LATER_S,
    PLANT,
    Replica,
    answers,
    beat,
    facts,
    request,
    word,
)

from dray.memory import TableMemory
from dray.messages import RemovalRefusal, Removals
from dray.messages.fact import PlaceKept, PlacesFreed, RemovalRefused
from dray.messages.floor.traffic import Blocked, HoldsAsked
from dray.messages.heartbeat import AWAITED_MAX
from dray.protocol.runtime.events import Ignore, Publish, Send, Subscribe, Unsubscribe
from dray.protocol.runtime.throttle import TOLD_EVERY_S
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.removal_authorisation import (
    BEFORE_S,
    EXPIRED,
    HEARD_SINCE,
    IS_HEARD,
    LISTEN_S,
    NO_PLACE,
    NOT_THERE,
    NOT_TRUSTED,
    TOO_EARLY,
)
from dray.protocol.traffic.reservations.copies import Copies
from dray.protocol.traffic.reservations.recovery_poll import POLL_S, QUIET_S
from dray.protocol.traffic.reservations.refused_removals import REFUSALS


@pytest.fixture
def replica() -> Replica:
    """A has died with two places."""
    replica = Replica()
    replica.comes("A", HERE, ELSEWHERE, now_s=DIED_S)
    return replica


def test_what_a_vehicle_held_is_free_once_and_that_is_told(replica: Replica) -> None:
    effects = replica.told("gateway", Removals(removals=(word(),)), LATER_S)
    assert (replica.holder(HERE), replica.holder(ELSEWHERE)) == ("", "")
    (freed,) = facts(effects, PlacesFreed)
    assert (freed.by, set(freed.places)) == ("eve", {HERE, ELSEWHERE})
    again = replica.told("gateway", Removals(removals=(word(),)), LATER_S + 1.0)
    assert facts(again, PlacesFreed) == []


def test_nobody_believes_it_of_a_vehicle_that_may_be_speaking_on_a_bad_link(replica: Replica) -> None:
    assert replica.remove(DIED_S + GONE_S - 0.1) == [IS_HEARD]
    assert replica.holder(HERE) == "A"


def test_nor_of_one_that_was_heard_after_the_word_was_given(replica: Replica) -> None:
    replica.told("A", beat(seq=8), DIED_S + 1.0)
    assert replica.remove(LATER_S + 1000.0) == [HEARD_SINCE]
    assert replica.remove(LATER_S + 1000.0, heard=(1, 8)) == []


OUTDATED = (1, 3)
"""A heartbeat that a gateway names which was cut off before the vehicle died."""

FIRST_S = DIED_S + BEFORE_S
"""The earliest report that certainly came after the vehicle's last heartbeat."""


def test_a_gateway_that_was_cut_off_names_an_older_heartbeat_and_is_believed(replica: Replica) -> None:
    removal = word(heard=OUTDATED, reported_s=FIRST_S)
    effects = replica.told("gateway", Removals(removals=(removal,)), LATER_S)
    (freed,) = facts(effects, PlacesFreed)
    assert set(freed.places) == {HERE, ELSEWHERE}


def test_so_is_one_that_has_begun_since_and_names_none(replica: Replica) -> None:
    assert replica.remove(heard=(0, 0), reported_s=FIRST_S) == []
    assert replica.holder(HERE) == ""


def test_it_is_not_while_a_bad_link_explains_the_silence(replica: Replica) -> None:
    now_s = DIED_S + GONE_S - 0.1
    assert replica.remove(now_s, heard=OUTDATED, reported_s=FIRST_S) == [IS_HEARD]
    assert replica.holder(HERE) == "A"


@pytest.mark.parametrize("after_s", [0.1, 30.0, 1000.0])
def test_it_is_not_when_the_vehicle_was_heard_after_the_report_however_long_it_is_silent_then(
    replica: Replica, after_s: float
) -> None:
    replica.told("A", beat(seq=8), DIED_S + after_s)
    for silent_s in (GONE_S + 0.1, 10_000.0):
        now_s = DIED_S + after_s + silent_s
        assert replica.remove(now_s, heard=OUTDATED, reported_s=FIRST_S, signed_s=now_s) == [HEARD_SINCE]
    assert replica.holder(HERE) == "A"
    assert replica.remove(now_s, heard=OUTDATED, reported_s=now_s, signed_s=now_s, number=2) == []


def test_a_request_after_the_report_is_a_sign_of_life_too(replica: Replica) -> None:
    replica.told("A", request(HERE, ELSEWHERE, seq=2), FIRST_S)
    now_s = FIRST_S + GONE_S + 1.0
    assert replica.remove(now_s, heard=OUTDATED, reported_s=FIRST_S, signed_s=now_s) == [HEARD_SINCE]


def test_nobody_but_people_says_when_a_report_was_made(replica: Replica) -> None:
    outdated = word(heard=OUTDATED, reported_s=DIED_S)
    assert outdated.reported is not UNSET
    # Another report of this vehicle, the same one of another vehicle, a forged one, and one that was altered.
    for one in (
        word(2, reported_s=FIRST_S),
        word(atv="B", reported_s=FIRST_S),
        word(key=FORGER, reported_s=FIRST_S),
        replace(outdated, reported=replace(outdated.reported, at_s=FIRST_S)),
    ):
        removal = replace(outdated, reported=one.reported)
        replica.told("gateway", Removals(removals=(removal,)), LATER_S)
        assert replica.holder(HERE) == "A"


@pytest.mark.parametrize("behind_s", [10.0, 60.0, 3600.0])
def test_a_replica_whose_clock_is_behind_takes_no_word_after_the_report_for_one_before(
    replica: Replica, behind_s: float
) -> None:
    """By its own clock the vehicle was heard before the time that the report names."""
    reported_s = DIED_S - 1.0 + behind_s
    now_s = DIED_S + GONE_S + 1.0
    for later_s in (0.0, 1000.0):
        how = {"reported_s": reported_s, "signed_s": now_s + later_s + behind_s}
        assert replica.remove(now_s + later_s, heard=OUTDATED, **how) == [HEARD_SINCE]
    assert replica.holder(HERE) == "A"
    how = {"reported_s": FIRST_S + behind_s, "signed_s": now_s + behind_s}
    assert replica.remove(now_s, heard=OUTDATED, **how) == []


@pytest.mark.parametrize("older", [(1, 0), (1, 7), (0, 2**40)], ids=["first", "named", "earlier-life"])
@pytest.mark.parametrize("reported_s", [None, DIED_S + 0.5], ids=["untimed", "timed"])
def test_an_older_heartbeat_does_not_make_a_report_count_that_a_later_one_has_refuted(
    replica: Replica, older: tuple[int, int], reported_s: float | None
) -> None:
    """It came late, or a thief of the vehicle's certificate has sent it."""
    life, seq = older
    replica.told("A", beat(seq=8), DIED_S + 1.0)
    replica.told("A", beat(life=life, seq=seq), DIED_S + 2.0)
    for silent_s in (GONE_S + 0.1, 10_000.0):
        now_s = DIED_S + 2.0 + silent_s
        assert replica.remove(now_s, reported_s=reported_s, signed_s=now_s) == [HEARD_SINCE]
    assert replica.holder(HERE) == "A"


@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 9), st.booleans()), min_size=1, max_size=9))
def test_whatever_a_thief_sends_and_in_which_order_lowers_nothing_that_was_heard(
    beats: list[tuple[int, int, bool]],
) -> None:
    """Of any life, with any number, shortened for radio or whole."""
    neighbours = Neighbours()
    for at, (life, seq, whole) in enumerate(beats, 1):
        said = beat(life=life, seq=seq)
        neighbours.on_vehicle(said if whole else replace(said, floor=UNSET), float(at))
        last = neighbours.last("A")
        assert last is not None
        assert last.said == max((life, seq) for life, seq, _ in beats[:at])
        assert last.at_s == at


def test_a_vehicle_that_counts_from_one_again_without_its_journal_can_be_carried_away_all_the_same(
    replica: Replica,
) -> None:
    """Its time tells that its newest word came before the report."""
    replica.told("A", beat(life=5, seq=900), DIED_S + 1.0)
    replica.told("A", beat(life=1, seq=3), DIED_S + 2.0)
    now_s = DIED_S + 2.0 + GONE_S + 0.1
    assert replica.remove(now_s, heard=(1, 3), reported_s=DIED_S + 2.0 + BEFORE_S) == []
    assert replica.holder(HERE) == ""


def test_what_came_before_the_report_does_not_bring_the_vehicle_back(replica: Replica) -> None:
    assert replica.remove(heard=OUTDATED, reported_s=FIRST_S) == []
    replica.told("A", beat(seq=7), LATER_S + 1.0)
    how = {"heard": OUTDATED, "reported_s": LATER_S + 10.0, "signed_s": LATER_S + 100.0}
    assert replica.remove(LATER_S + 100.0, number=2, node=HERE, **how) == []
    assert replica.holder(HERE) == "A"
    replica.told("A", beat(seq=8), LATER_S + 110.0)
    assert replica.remove(LATER_S + 1000.0, number=2, node=HERE, **how) == [HEARD_SINCE]


def test_a_report_without_its_time_is_judged_by_the_named_heartbeat_alone(replica: Replica) -> None:
    """So it comes from a gateway of the last version."""
    assert replica.remove(LATER_S + 1000.0, heard=OUTDATED) == [HEARD_SINCE]
    assert replica.holder(HERE) == "A"
    assert replica.remove(LATER_S + 1000.0, heard=(1, 7)) == []
    assert replica.holder(HERE) == ""


def test_a_thief_of_a_certificate_makes_no_report_count_of_a_vehicle_that_lives(replica: Replica) -> None:
    """It has spoken of the far future in the vehicle's name, so that the vehicle's own heartbeats are no news any more."""
    far = 2**50
    replica.told("A", beat(life=far), DIED_S + 0.5)
    assert replica.remove(heard=OUTDATED, reported_s=FIRST_S + 0.5) == []
    back_s = LATER_S + 100.0
    replica.told("A", beat(life=2, seq=1, removal=1), back_s)
    how = {"heard": (far, 7), "reported_s": back_s + 1.0, "signed_s": back_s + 1.0}
    assert replica.remove(back_s + 1.0, number=2, **how) == [IS_HEARD]


def test_nor_does_it_keep_a_vehicle_off_the_floor(replica: Replica) -> None:
    replica.told("A", beat(life=2**50), DIED_S + 0.5)
    assert replica.remove(heard=OUTDATED, reported_s=FIRST_S + 0.5) == []
    back_s = LATER_S + 100.0
    replica.told("A", request(removal=1, life=2, groups=((HERE,),)), back_s)
    for seq in range(7):
        replica.told("A", beat(life=2, seq=seq, removal=1), back_s + seq)
    assert replica.holder(HERE) == "A"
    # When it has died, a report of that is accepted all the same.
    dead_s = back_s + 10.0 + GONE_S
    how = {"number": 2, "heard": (2, 6), "reported_s": dead_s, "signed_s": dead_s}
    assert replica.remove(dead_s, **how) == []
    assert replica.holder(HERE) == ""


@pytest.mark.parametrize("heard_later", [False, True])
def test_a_copy_lets_its_leader_free_nothing_of_a_vehicle_that_it_has_heard_after_the_report(
    replica: Replica, monkeypatch: pytest.MonkeyPatch, heard_later: bool
) -> None:
    """Whatever a lying leader has heard itself."""
    let: list[str] = []
    monkeypatch.setattr(Copies, "on_carried", lambda _self, atv: let.append(atv))
    if heard_later:
        replica.told("A", beat(seq=8), FIRST_S + 1.0)
    now_s = FIRST_S + GONE_S + 2.0
    replica.remove(now_s, heard=OUTDATED, reported_s=FIRST_S, signed_s=now_s)
    assert let == ([] if heard_later else ["A"])


def test_the_time_of_an_earlier_publication_does_not_count_with_a_later_grant(replica: Replica) -> None:
    """Together they would hide that the replica's clock is a minute behind: by that clock the vehicle spoke before the report."""
    reported_s, now_s = DIED_S - 1.0 + 60.0, DIED_S + GONE_S + 1.0
    how = {"heard": OUTDATED, "reported_s": reported_s}
    first = word(signed_s=reported_s, until_s=reported_s + 60.0, **how)
    later = word(signed_s=now_s + 60.0, until_s=now_s + 120.0, **how)
    mixed = replace(later, reported=first.reported)
    effects = replica.told("gateway", Removals(removals=(mixed,)), now_s)
    assert [effect.reason for effect in effects if isinstance(effect, Ignore)] == [HEARD_SINCE]
    assert replica.holder(HERE) == "A"


def test_a_report_was_made_before_it_was_signed_whatever_it_says(replica: Replica) -> None:
    how = {"heard": OUTDATED, "reported_s": LATER_S + 1000.0}
    assert replica.remove(signed_s=FIRST_S - 0.1, **how) == [HEARD_SINCE]
    assert replica.remove(signed_s=FIRST_S, **how) == []


def test_nor_of_one_that_still_asks_for_places(replica: Replica) -> None:
    replica.told("A", request(HERE, seq=2), LATER_S - 1.0)
    assert replica.remove() == [IS_HEARD]


def test_what_it_has_said_long_before_is_no_sign_that_it_lives(replica: Replica) -> None:
    old = request(HERE, ELSEWHERE, seq=1)
    replica.told("A", old, LATER_S - 1.0)
    assert replica.remove() == []


def test_a_replica_that_has_just_begun_to_listen_believes_nothing() -> None:
    assert Replica(now_s=LATER_S - 1.0).remove() == [TOO_EARLY]


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
    replica: Replica, how: dict[str, Any], why: str
) -> None:
    assert replica.remove(**how) == [why]
    assert replica.holder(HERE) == "A"


def test_the_area_where_it_was_heard_last_is_enough_for_all_that_it_held(replica: Replica) -> None:
    assert replica.remove(areas=(AREA,)) == []
    assert replica.holder(ELSEWHERE) == ""


def test_a_stale_word_frees_nothing_that_was_granted_since(replica: Replica) -> None:
    replica.remove()
    replica.told("A", request(removal=1, life=2, groups=((HERE,),)), LATER_S + 10.0)
    replica.told("A", beat(life=2, seq=1, removal=1), LATER_S + 10.0)
    assert replica.holder(HERE) == "A"
    for number in (0, 1):
        replica.remove(LATER_S + 1000.0, number=number)
        assert replica.holder(HERE) == "A"


def test_who_comes_back_with_a_removal_that_this_table_has_not_heard_of_holds_nothing_of_before(
    replica: Replica,
) -> None:
    replica.told("A", request(removal=5, life=2, groups=((HERE,),)), LATER_S)
    replica.told("A", beat(life=2, seq=1, removal=5), LATER_S)
    assert (replica.holder(HERE), replica.holder(ELSEWHERE)) == ("A", "")


def test_one_that_stands_there_and_was_only_deaf_is_told_that_nothing_is_its_own(replica: Replica) -> None:
    replica.remove()
    replica.comes("B", HERE, now_s=LATER_S + 1.0)
    (told,) = answers(replica.told("A", beat(seq=8), LATER_S + 2.0))
    assert (told.removal, told.grants) == (1, ())
    (told,) = answers(replica.told("A", request(HERE, ELSEWHERE, seq=2), LATER_S + 2.0))
    assert (told.removal, told.grants) == (1, ())
    assert (replica.holder(HERE), replica.holder(ELSEWHERE)) == ("B", "")
    (told,) = answers(replica.told("A", request(seq=3, removal=1, groups=((HERE,),)), LATER_S + 3.0))
    assert (told.by, told.at, told.grants) == ("B", HERE, ())


def test_one_that_has_started_again_and_does_not_know_its_removal_any_more_is_told(replica: Replica) -> None:
    replica.remove()
    replica.told("A", request(removal=1, life=2, groups=((HERE,),)), LATER_S + 1.0)
    (told,) = answers(replica.told("A", request(life=3, groups=((HERE,),)), LATER_S + 2.0))
    assert (told.life, told.removal) == (3, 1)


def test_the_place_to_which_it_comes_back_is_kept_for_it(replica: Replica) -> None:
    replica.remove()
    effects = replica.told("gateway", Removals(removals=(word(2, node=ELSEWHERE),)), LATER_S + 1.0)
    assert facts(effects, PlaceKept) == [PlaceKept(atv="A", number=2, place=ELSEWHERE)]
    replica.told("B", request(groups=((ELSEWHERE,),)), LATER_S + 2.0)
    replica.told("B", beat(atv="B"), LATER_S + 2.0)
    assert replica.holder(ELSEWHERE) == "A"
    (told,) = answers(replica.told("A", request(life=2, groups=((ELSEWHERE,),)), LATER_S + 3.0))
    assert (told.removal, [line.place for line in told.grants]) == (2, [ELSEWHERE])


def test_a_place_that_another_one_holds_is_not_kept_before_it_is_free(replica: Replica) -> None:
    replica.remove()
    replica.comes("B", HERE, now_s=LATER_S + 1.0)
    word_of = Removals(removals=(word(2, node=HERE),))
    assert facts(replica.told("gateway", word_of, LATER_S + 2.0), PlaceKept) == []
    given_back = replica.told("B", request(seq=2, seen=replica.table.version), LATER_S + 3.0)
    assert facts(given_back, PlaceKept) == [PlaceKept(atv="A", number=2, place=HERE)]


def test_one_that_is_carried_away_once_more_leaves_the_place_that_was_kept(replica: Replica) -> None:
    replica.remove()
    replica.remove(LATER_S + 1.0, number=2, node=HERE)
    replica.remove(LATER_S + 2.0, number=3)
    assert replica.holder(HERE) == ""


def test_the_next_life_of_a_replica_knows_who_was_carried_away(replica: Replica) -> None:
    replica.remove()
    (commit,) = replica.reservations.commits()
    assert isinstance(commit.note, TableMemory)
    again = Replica({commit.name: commit.note}, LATER_S)
    again.told("A", request(HERE, seq=9), LATER_S + 1.0)
    assert again.holder(HERE) == ""


def test_a_carried_vehicle_keeps_no_recovery_poll_waiting() -> None:
    replica = Replica({"nothing": TableMemory(0, 0, 0)})
    asked = [effect.message for effect in replica.out if isinstance(effect, Send)]
    epochs = {message.epoch for message in asked if isinstance(message, HoldsAsked)}
    (epoch,) = epochs
    tables = replica.reservations.tables
    assert tables is not None
    for atv in PLANT.fleet:
        if atv != "ATV1":
            replica.told(atv, request(epoch=epoch), 90.0)
    assert not tables.districts[DISTRICT].leads
    assert replica.reservations.awaited(90.0) is UNSET
    assert replica.reservations.awaited(90.0 + QUIET_S) == ("ATV1",)
    assert replica.remove(atv="ATV1") == []
    assert tables.districts[DISTRICT].leads
    assert replica.reservations.awaited(LATER_S) is UNSET
    (told,) = answers(replica.told("ATV1", request(HERE, epoch=epoch), LATER_S + 1.0))
    assert (told.removal, told.grants) == (1, ())


def test_of_vehicles_that_have_had_no_time_to_tell_nobody_is_awaited() -> None:
    replica = Replica({"nothing": TableMemory(0, 0, 0)})
    assert replica.reservations.awaited(POLL_S - 0.1) is UNSET
    assert replica.reservations.awaited(POLL_S) == tuple(sorted(PLANT.fleet))[:AWAITED_MAX]


def test_a_request_that_was_overtaken_gives_nothing_back(replica: Replica) -> None:
    """It was said before the vehicle knew that the place where it stands is its own."""
    replica.told("A", request(HERE, seq=3, seen=2), 101.0)
    replica.told("A", request(seq=2, seen=2, groups=((HERE,),)), 102.0)
    replica.told("B", request(groups=((HERE,),)), 103.0)
    replica.told("B", beat(atv="B"), 103.0)
    assert replica.holder(HERE) == "A"


def listened_to(replica: Replica, before: int) -> list[tuple[type, str]]:
    return [
        (type(effect), effect.key.rsplit("/", 1)[1])
        for effect in replica.out[before:]
        if isinstance(effect, Subscribe | Unsubscribe)
    ]


def test_a_replica_listens_to_those_that_its_table_is_about_and_to_nobody_else() -> None:
    replica = Replica()
    assert listened_to(replica, 0) == [(Subscribe, "removals")]
    replica.told("A", request(groups=((HERE,),)), 99.0)
    assert listened_to(replica, 0) == [(Subscribe, "A")]
    replica.told("A", beat(), 99.5)
    replica.told("A", request(HERE, seq=2, groups=((ELSEWHERE,),)), 100.0)
    assert listened_to(replica, 0) == []
    replica.told("A", request(seq=3, seen=replica.table.version), 101.0)
    assert listened_to(replica, 0) == [(Unsubscribe, "A")]
    replica.told("gateway", Removals(removals=(word(),)), LATER_S)
    assert listened_to(replica, 0) == [(Subscribe, "A")]


def test_whoever_is_in_a_table_and_was_never_heard_is_silent_after_a_while() -> None:
    replica = Replica()
    replica.told("ATV1", request(groups=((HERE,),)), 99.0)
    for now_s, why in ((100.0, Blocked.WAIT), (200.0, Blocked.SILENT)):
        told = replica.told("ATV2", request(seq=int(now_s), groups=((HERE,),)), now_s)
        assert [answer.blocked for answer in answers(told)] == [why]


def test_a_replica_tells_who_holds_something_in_its_district() -> None:
    replica = Replica()
    replica.comes("A", HERE, now_s=DIED_S)
    (district,) = replica.reservations.tables.districts.values()  # type: ignore[union-attr]
    words = []
    for now_s in (101.0, 101.2, 102.0, 104.1, 200.0):
        replica.out.clear()
        district.tick(now_s)
        words += [(now_s, e.message) for e in replica.out if isinstance(e, Publish)]
    assert [(at_s, [(v.atv, v.holds, v.silent) for v in told.vehicles]) for at_s, told in words] == [
        (101.0, [("A", (HERE,), False)]),
        (104.1, [("A", (HERE,), False)]),
        (200.0, [("A", (HERE,), True)]),
    ]
    assert [told.number for _, told in words] == [1, 2, 3]


# --- people are told why -------------------------------------------------------------------------


def told_why(replica: Replica, now_s: float, **how: Any) -> list[RemovalRefusal]:
    """The reasons that people are told when this report comes."""
    effects = replica.told("gateway", Removals(removals=(word(**how),)), now_s)
    refused = facts(effects, RemovalRefused)
    assert all((each.atv, each.number) == (how.get("atv", "A"), how.get("number", 1)) for each in refused)
    return [each.reason for each in refused]


def test_every_objection_is_told_by_a_word_of_the_list() -> None:
    assert set(REFUSALS.values()) == set(RemovalRefusal)


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ({"key": FORGER}, NOT_TRUSTED),
        ({"until_s": LATER_S - 1.0}, EXPIRED),
        ({"areas": ("nowhere",)}, NOT_THERE),
        ({"node": "nowhere"}, NO_PLACE),
        ({"heard": OUTDATED}, HEARD_SINCE),
    ],
)
def test_people_are_told_once_why_a_report_is_refused_and_once_more_of_the_next_report(
    replica: Replica, how: dict[str, Any], why: str
) -> None:
    assert told_why(replica, LATER_S, **how) == [REFUSALS[why]]
    assert [told_why(replica, LATER_S + 2.0 * count, **how) for count in range(1, 50)] == [[]] * 49
    assert told_why(replica, LATER_S + 100.0, number=2, **how) == [REFUSALS[why]]
    assert replica.holder(HERE) == "A"


def test_another_reason_for_the_same_report_is_told_too(replica: Replica) -> None:
    assert told_why(replica, LATER_S, until_s=LATER_S - 1.0) == [RemovalRefusal.EXPIRED]
    assert told_why(replica, LATER_S + 1.0, areas=()) == [RemovalRefusal.NOT_THERE]


def test_of_the_silence_that_every_report_waits_for_nobody_is_told_anything(replica: Replica) -> None:
    """Neither by one that has heard the vehicle, nor by one that has begun to listen."""
    (commit,) = replica.reservations.commits()
    assert isinstance(commit.note, TableMemory)
    just_begun = Replica({commit.name: commit.note}, DIED_S + 1.0)
    for now_s in range(int(DIED_S) + 1, int(LATER_S)):
        assert told_why(replica, float(now_s)) == []
        assert told_why(just_begun, float(now_s)) == []
    assert told_why(replica, LATER_S) == []
    assert (replica.holder(HERE), replica.holder(ELSEWHERE)) == ("", "")


def test_that_a_vehicle_goes_on_being_heard_is_told_when_it_has_lasted(replica: Replica) -> None:
    told: list[tuple[int, RemovalRefusal]] = []
    for second in range(1, 200):
        now_s = DIED_S + second
        replica.told("A", beat(seq=7 + second), now_s)
        told += [(second, why) for why in told_why(replica, now_s)]
    assert told == [(int(LISTEN_S) + 2, RemovalRefusal.IS_HEARD)]


def test_a_vehicle_that_is_back_is_no_refusal_of_the_report_that_was_believed(replica: Replica) -> None:
    """The gateway hears it a moment later than the replica."""
    told_why(replica, LATER_S - 2.0)
    assert replica.remove(LATER_S) == []
    replica.told("A", request(removal=1, life=2, groups=((HERE,),)), LATER_S + 100.0)
    replica.told("A", beat(life=2, seq=1, removal=1), LATER_S + 100.0)
    assert replica.holder(HERE) == "A"
    assert told_why(replica, LATER_S + 101.0) == []


def test_whoever_repeats_an_earlier_report_has_nothing_told(replica: Replica) -> None:
    how = {"until_s": LATER_S - 1.0}
    assert told_why(replica, LATER_S, number=2, **how) == [RemovalRefusal.EXPIRED]
    assert told_why(replica, LATER_S + 1.0, number=1, **how) == []
    assert told_why(replica, LATER_S + 2.0, number=2, **how) == []


def test_who_invents_reports_fills_no_history_and_hides_no_report_of_people(replica: Replica) -> None:
    """One a minute is told of a vehicle that holds places here, and none of invented names."""
    told = [
        why
        for count in range(100)
        for why in told_why(replica, LATER_S + count / 10.0, number=2**50 + count, key=FORGER)
    ]
    assert told == [RemovalRefusal.NOT_TRUSTED]
    for count in range(100):
        assert told_why(replica, LATER_S + 10.0, atv=f"X{count}", node=HERE, key=FORGER) == []
    assert told_why(replica, LATER_S + 11.0, areas=()) == [RemovalRefusal.NOT_THERE]
    assert told_why(replica, LATER_S + TOLD_EVERY_S, key=FORGER) == [RemovalRefusal.NOT_TRUSTED]


def test_what_keeps_a_recovery_poll_waiting_is_told_too() -> None:
    """The table is lost: nobody knows yet what the vehicle holds."""
    replica = Replica({"nothing": TableMemory(0, 0, 0)})
    assert told_why(replica, LATER_S, atv="ATV1", areas=()) == [RemovalRefusal.NOT_THERE]


def test_a_replica_without_a_place_of_the_vehicle_tells_nothing_but_where_it_is_put_back() -> None:
    replica = Replica()
    how = {"until_s": LATER_S - 1.0}
    assert told_why(replica, LATER_S, **how) == []
    assert told_why(replica, LATER_S, number=2, node=HERE, **how) == [RemovalRefusal.EXPIRED]
