"""What people say at a machine ends in the right count, or in a refusal with a name: twice, late, too large, negative, of another place."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from people_rig import BILL, CYCLE_S, FULL, ITEM, KIND, PRODUCT, PeopleRig

from dray.adapters.people.words import LOADS_KEPT, WORDS_KEPT, Visit
from dray.adapters.people.workcell import DAMAGED, PIECES_MAX
from dray.body import (
    Book,
    CloseDock,
    CycleDone,
    CycleFailed,
    OpenDock,
    Repaired,
    ResetFault,
    StartCycle,
    StockChanged,
)
from dray.messages import BillLine, CommandRefusal, MachineCommandKind, UnconfirmedLoad

REFUSED = CommandRefusal
ATV = "ATV3"


def brought(rig: PeopleRig, pieces: int = 12, item: str = ITEM) -> None:
    """A vehicle is let in, and says what it has put down."""
    rig.body.instruct(OpenDock(ATV, item, pieces))
    rig.book(ATV, item, pieces)


def left(rig: PeopleRig) -> None:
    """A vehicle was not wanted any more, and has left."""
    rig.body.instruct(CloseDock(ATV))
    rig.body.instruct(CloseDock(ATV))


# --- pieces ---


def test_a_piece_uses_its_material_and_lies_in_the_goods() -> None:
    rig = PeopleRig()
    rig.start()
    assert rig.state.stock[ITEM] == FULL[ITEM] - BILL[ITEM]
    assert rig.says(KIND.MADE) == (None, "")
    assert rig.heard() == [CycleDone(PRODUCT, rig.state.seq)]
    assert (rig.state.cycling, rig.state.stock[PRODUCT], rig.state.stock[ITEM]) == ("", 1, 20 - BILL[ITEM])


def test_pieces_that_nobody_has_asked_for_count_and_use_their_material() -> None:
    rig = PeopleRig()
    rig.start()
    rig.now_s += CYCLE_S
    assert rig.says(KIND.MADE, 3) == (None, "")
    assert [report for report in rig.heard() if isinstance(report, CycleDone)] == [
        CycleDone(PRODUCT, rig.state.seq - back) for back in (2, 1, 0)
    ]
    assert (rig.state.stock[PRODUCT], rig.state.stock[ITEM]) == (3, 20 - 3 * BILL[ITEM])


def test_a_bad_piece_uses_its_material_and_lies_nowhere() -> None:
    rig = PeopleRig()
    rig.start()
    assert rig.says(KIND.SCRAPPED) == (None, "")
    assert rig.heard() == [CycleDone(PRODUCT, rig.state.seq, bad=True)]
    assert (rig.state.stock[PRODUCT], rig.state.stock[ITEM]) == (0, 20 - BILL[ITEM])


def test_more_pieces_than_can_have_been_made_are_asked_for_once() -> None:
    rig = PeopleRig()
    assert rig.says(KIND.MADE, 5) == (REFUSED.UNLIKELY, "2")
    assert rig.heard() == []
    assert rig.says(KIND.MADE, 5, sure=True) == (None, "")
    assert rig.state.stock[PRODUCT] == 5
    rig.now_s += 2 * CYCLE_S
    assert rig.says(KIND.MADE, 5) == (None, "")


@pytest.mark.parametrize("pieces", [0, -1, PIECES_MAX + 1])
def test_no_pieces_negative_ones_and_too_many_in_one_word_are_refused_even_when_sure(pieces: int) -> None:
    rig = PeopleRig()
    assert rig.says(KIND.MADE, pieces, sure=True) == (REFUSED.QUANTITY_OUT_OF_RANGE, "")
    assert rig.state.stock[PRODUCT] == 0


def test_a_cycle_without_its_material_fails() -> None:
    rig = PeopleRig({})
    rig.start()
    [failed] = rig.heard()
    assert isinstance(failed, CycleFailed)
    assert failed.reason.startswith("missing ")


# --- loads ---


def test_a_load_is_booked_as_its_vehicle_says_and_confirmed_without_another_change() -> None:
    rig = PeopleRig()
    brought(rig)
    assert rig.heard() == [StockChanged(ITEM, 12, rig.state.seq, ATV)]
    assert rig.state.loads == (UnconfirmedLoad(ATV, ITEM, 12),)
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (None, "")
    assert (rig.heard(), rig.state.loads, rig.state.stock[ITEM]) == ([], (), 32)


def test_a_load_is_corrected_by_the_difference() -> None:
    rig = PeopleRig()
    brought(rig)
    rig.heard()
    assert rig.says(KIND.ARRIVED, 10, ITEM, vehicle=ATV) == (None, "")
    assert rig.heard() == [StockChanged(ITEM, -2, rig.state.seq, counted=True)]
    assert rig.state.stock[ITEM] == 30


def test_goods_that_a_vehicle_has_taken_are_corrected_the_other_way() -> None:
    rig = PeopleRig({**FULL, PRODUCT: 10})
    rig.body.instruct(OpenDock(ATV, PRODUCT, 8))
    rig.book(ATV, PRODUCT, -8)
    assert rig.state.loads == (UnconfirmedLoad(ATV, PRODUCT, 8, goes=True),)
    rig.heard()
    assert rig.says(KIND.TAKEN, 6, PRODUCT, vehicle=ATV) == (None, "")
    assert rig.heard() == [StockChanged(PRODUCT, 2, rig.state.seq, counted=True)]
    assert rig.state.stock[PRODUCT] == 4


def test_a_second_person_who_confirms_the_same_load_is_told_that_there_is_none() -> None:
    rig = PeopleRig()
    brought(rig)
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (None, "")
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (REFUSED.NO_LOAD, "")
    assert rig.state.stock[ITEM] == 32


def test_a_load_of_a_vehicle_that_was_not_let_in_is_none() -> None:
    rig = PeopleRig()
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (REFUSED.NO_LOAD, "")
    assert rig.state.stock[ITEM] == FULL[ITEM]


def test_a_vehicle_that_was_let_in_and_has_left_without_a_word_has_no_load() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    left(rig)
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (REFUSED.NO_LOAD, "")
    assert rig.state.stock[ITEM] == FULL[ITEM]
    assert rig.kept is not None
    assert rig.kept.visits == ()


def test_what_people_say_of_a_vehicle_at_the_dock_counts_for_its_own_word_over_lives() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    assert rig.says(KIND.ARRIVED, 11, ITEM) == (None, "")
    assert rig.state.stock[ITEM] == 20
    rig.begin()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.heard()
    rig.book(ATV, ITEM, 12)
    assert rig.heard() == [StockChanged(ITEM, 11, rig.state.seq, ATV)]
    assert (rig.state.loads, rig.state.stock[ITEM]) == ((), 31)


@pytest.mark.parametrize("vehicle", ["", ATV])
def test_a_load_that_is_put_down_though_its_transport_was_taken_over_counts_once(vehicle: str) -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(CloseDock(ATV))
    rig.begin()
    assert rig.state.opened == ()
    # The word comes before its vehicle's.
    assert rig.says(KIND.ARRIVED, 11, ITEM, vehicle=vehicle) == (None, "")
    assert rig.heard() == [StockChanged(ITEM, 11, rig.state.seq)]
    rig.book(ATV, ITEM, 12)
    assert rig.heard() == [StockChanged(ITEM, 0, rig.state.seq, ATV)]
    assert (rig.state.loads, rig.state.stock[ITEM]) == ((), 31)


def test_a_word_that_was_said_before_the_transport_was_taken_over_counts_for_the_load() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    assert rig.says(KIND.ARRIVED, 11, ITEM) == (None, "")
    rig.body.instruct(CloseDock(ATV))
    rig.book(ATV, ITEM, 12)
    assert (rig.state.loads, rig.state.stock[ITEM]) == ((), 31)


def test_a_vehicle_that_has_left_with_its_load_keeps_nobody_from_saying_what_comes_by_hand() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.ARRIVED, 4, ITEM) == (None, "")
    assert rig.says(KIND.ARRIVED, 12, ITEM) == (None, "")
    assert rig.state.stock[ITEM] == 36
    # What it brings later is another load.
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.book(ATV, ITEM, 12)
    assert rig.state.stock[ITEM] == 48


def test_more_than_a_vehicle_had_that_is_not_wanted_any_more_was_brought_by_hand() -> None:
    rig = PeopleRig({ITEM: 0})
    rig.body.instruct(OpenDock(ATV, ITEM, 2))
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.ARRIVED, 10, ITEM) == (None, "")
    rig.book(ATV, ITEM, 2)
    assert rig.state.stock[ITEM] == 12


def test_a_word_of_a_load_that_is_not_wanted_any_more_is_doubted_as_one_by_hand() -> None:
    rig = PeopleRig({ITEM: 10_000})
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (REFUSED.UNLIKELY, "0")
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV, sure=True) == (None, "")
    rig = PeopleRig({ITEM: 3})
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.TAKEN, 12, ITEM, vehicle=ATV) == (REFUSED.UNLIKELY, "3")
    assert rig.state.stock[ITEM] == 3


def test_nobody_counts_what_a_vehicle_that_is_not_wanted_any_more_may_still_put_down() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.STOCK_IS, 32, ITEM, sure=True) == (REFUSED.DOCK_OPEN, "")
    rig.begin()
    assert rig.says(KIND.STOCK_IS, 32, ITEM, sure=True) == (REFUSED.DOCK_OPEN, "")
    rig.book(ATV, ITEM, 12)
    assert rig.says(KIND.STOCK_IS, 32, ITEM) == (None, "")
    assert rig.state.stock[ITEM] == 32


def test_what_a_vehicle_has_left_with_keeps_nobody_from_counting() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    left(rig)
    assert rig.says(KIND.STOCK_IS, 20, ITEM) == (None, "")


def test_a_count_has_the_load_of_a_vehicle_of_which_people_have_said_the_wrong_way_too() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.TAKEN, 12, ITEM, vehicle=ATV) == (None, "")
    assert rig.says(KIND.STOCK_IS, 32, ITEM, sure=True) == (None, "")
    rig.book(ATV, ITEM, 12)
    assert rig.state.stock[ITEM] == 32


def test_a_count_has_what_was_said_of_a_load_that_its_vehicle_tells_of_later() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    assert rig.says(KIND.ARRIVED, 12, ITEM) == (None, "")
    rig.body.instruct(CloseDock(ATV))
    assert rig.says(KIND.STOCK_IS, 32, ITEM, sure=True) == (None, "")
    rig.book(ATV, ITEM, 12)
    assert rig.state.stock[ITEM] == 32


def test_the_dock_is_told_to_be_open_for_whom_it_was_opened_so_that_the_next_life_can_shut_it() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.begin()
    assert rig.state.opened == (ATV,)


def test_a_word_that_an_older_version_has_kept_goes_where_its_vehicle_says() -> None:
    rig = PeopleRig({**FULL, PRODUCT: 10})
    rig.body.instruct(OpenDock(ATV, PRODUCT, 8))
    assert rig.says(KIND.TAKEN, 7, PRODUCT) == (None, "")
    assert rig.kept is not None
    [visit] = msgspec.to_builtins(rig.kept.visits)
    del visit["goes"]
    rig.kept = replace(rig.kept, visits=msgspec.convert([visit], tuple[Visit, ...]))
    rig.begin()
    rig.book(ATV, PRODUCT, -8)
    assert rig.state.stock[PRODUCT] == 3


def test_a_load_that_an_agent_that_was_killed_says_again_is_answered_and_not_booked_again() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    rig.book(ATV, ITEM, 12, "M1-1")
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (None, "")
    first = rig.heard()
    rig.begin()
    rig.book(ATV, ITEM, 12, "M1-1")
    assert rig.heard() == first
    assert (rig.state.loads, rig.state.stock[ITEM]) == ((), 32)


def test_what_comes_by_hand_while_a_load_waits_for_a_word_is_more() -> None:
    rig = PeopleRig()
    brought(rig)
    assert rig.says(KIND.ARRIVED, 12, ITEM) == (None, "")
    assert rig.state.stock[ITEM] == 44
    assert rig.state.loads == (UnconfirmedLoad(ATV, ITEM, 12),)


def test_what_is_taken_by_hand_while_a_vehicle_brings_more_is_not_its_load() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 10))
    assert rig.says(KIND.TAKEN, 6, ITEM) == (None, "")
    rig.book(ATV, ITEM, 10)
    assert rig.state.stock[ITEM] == 24


def test_a_product_that_an_order_has_taught_is_known_to_the_next_life() -> None:
    rig = PeopleRig()
    rig.body.instruct(StartCycle(product="taught", bill=(BillLine(ITEM, 2),), cycle_s=30.0))
    rig.begin()
    assert rig.state.cycling == "taught"
    assert rig.says(KIND.MADE, 1) == (None, "")
    assert (rig.state.cycling, rig.state.stock["taught"], rig.state.stock[ITEM]) == ("", 1, 18)


def test_a_number_far_from_the_load_is_asked_once() -> None:
    rig = PeopleRig()
    brought(rig)
    assert rig.says(KIND.ARRIVED, 120, ITEM, vehicle=ATV) == (REFUSED.UNLIKELY, "12")
    assert rig.state.loads
    assert rig.says(KIND.ARRIVED, 0, ITEM, vehicle=ATV, sure=True) == (None, "")
    assert (rig.state.loads, rig.state.stock[ITEM]) == ((), 20)


def test_by_hand_things_come_and_go_within_what_fits_and_what_lies_there() -> None:
    rig = PeopleRig()
    assert rig.says(KIND.ARRIVED, 3, ITEM) == (None, "")
    assert rig.says(KIND.TAKEN, 4, ITEM) == (None, "")
    assert rig.state.stock[ITEM] == 19
    assert rig.says(KIND.TAKEN, 30, ITEM) == (REFUSED.UNLIKELY, "19")
    assert rig.says(KIND.TAKEN, 30, ITEM, sure=True) == (None, "")
    assert rig.state.stock[ITEM] == 0
    assert rig.says(KIND.ARRIVED, 100_000, ITEM)[0] is REFUSED.UNLIKELY
    assert rig.says(KIND.ARRIVED, 0, ITEM, sure=True) == (REFUSED.QUANTITY_OUT_OF_RANGE, "")


@pytest.mark.parametrize("kind", [KIND.ARRIVED, KIND.TAKEN, KIND.STOCK_IS, KIND.MADE])
def test_what_belongs_to_another_station_is_not_handled_here(kind: MachineCommandKind) -> None:
    rig = PeopleRig()
    before = rig.state
    assert rig.says(kind, 1, "anvil", sure=True) == (REFUSED.NOT_HANDLED, "")
    assert rig.state == before


@pytest.mark.parametrize("kind", [KIND.ARRIVED, KIND.TAKEN, KIND.STOCK_IS])
def test_a_negative_number_is_refused(kind: MachineCommandKind) -> None:
    rig = PeopleRig()
    assert rig.says(kind, -1, ITEM, sure=True) == (REFUSED.QUANTITY_OUT_OF_RANGE, "")
    assert rig.state.stock[ITEM] == 20


def test_loads_that_nobody_confirms_are_bounded() -> None:
    rig = PeopleRig()
    for _ in range(LOADS_KEPT + 5):
        brought(rig, 1)
    assert len(rig.state.loads) == LOADS_KEPT


# --- counting ---


def test_a_count_puts_the_stock_right_and_settles_loads_that_wait() -> None:
    rig = PeopleRig()
    brought(rig)
    rig.heard()
    assert rig.says(KIND.STOCK_IS, 30, ITEM) == (None, "")
    assert rig.heard() == [StockChanged(ITEM, -2, rig.state.seq, counted=True)]
    assert rig.state.loads == ()
    assert rig.says(KIND.ARRIVED, 12, ITEM, vehicle=ATV) == (REFUSED.NO_LOAD, "")


def test_nobody_counts_what_is_just_being_unloaded() -> None:
    rig = PeopleRig()
    rig.body.instruct(OpenDock(ATV, ITEM, 12))
    assert rig.says(KIND.STOCK_IS, 32, ITEM) == (REFUSED.DOCK_OPEN, "")
    rig.book(ATV, ITEM, 12)
    assert rig.says(KIND.STOCK_IS, 32, ITEM) == (None, "")
    assert rig.state.stock[ITEM] == 32


def test_a_count_that_changes_nothing_reports_nothing() -> None:
    rig = PeopleRig()
    assert rig.says(KIND.STOCK_IS, 20, ITEM) == (None, "")
    assert rig.heard() == []


# --- lives ---


@pytest.mark.parametrize(
    ("kind", "pieces", "item"),
    [(KIND.MADE, 1, ""), (KIND.SCRAPPED, 1, ""), (KIND.ARRIVED, 3, ITEM), (KIND.TAKEN, 3, ITEM)],
)
def test_a_word_that_comes_twice_counts_once_also_in_the_next_life(
    kind: MachineCommandKind, pieces: int, item: str
) -> None:
    rig = PeopleRig()
    rig.says(kind, pieces, item, key="maria/a")
    after = rig.state
    assert rig.says(kind, pieces, item, key="maria/a") == (None, "")
    assert rig.state == after
    rig.begin()
    rig.heard()
    assert rig.says(kind, pieces, item, key="maria/a") == (None, "")
    assert (rig.state, rig.heard()) == (after, [])


def test_a_refusal_is_remembered_as_well() -> None:
    rig = PeopleRig()
    assert rig.says(KIND.MADE, 5, key="maria/a") == (REFUSED.UNLIKELY, "2")
    rig.now_s += 10 * CYCLE_S
    assert rig.says(KIND.MADE, 5, key="maria/a") == (REFUSED.UNLIKELY, "2")


def test_words_that_are_kept_are_bounded() -> None:
    rig = PeopleRig()
    for _ in range(WORDS_KEPT + 10):
        rig.says(KIND.STOCK_IS, 20, ITEM)
    assert rig.kept is not None
    assert len(rig.kept.answered) == WORDS_KEPT


def test_a_damaged_memory_is_a_problem_until_somebody_has_counted_and_says_so() -> None:
    rig = PeopleRig()
    rig.kept = DAMAGED
    rig.begin()
    assert (rig.state.broken, rig.state.resettable) == (DAMAGED.doubt, True)
    assert rig.says(KIND.STOCK_IS, 20, ITEM, sure=True) == (None, "")
    rig.body.instruct(ResetFault())
    assert (rig.state.broken, rig.heard()[-1]) == ("", Repaired())


WORDS = st.tuples(
    st.sampled_from([KIND.MADE, KIND.SCRAPPED, KIND.ARRIVED, KIND.TAKEN, KIND.STOCK_IS]),
    st.integers(-2, 40),
    st.sampled_from(["", ITEM, PRODUCT, "anvil"]),
    st.sampled_from(["", ATV, "ATV9"]),
    st.booleans(),
)
BOOKS = st.builds(
    lambda load, task: Book(ATV, *load, task=task, epoch=1),
    st.sampled_from([(ITEM, 12), (PRODUCT, -2)]),
    st.sampled_from(["M1-1", "M1-2", "M1-3"]),
)
DOCK = st.sampled_from([OpenDock(ATV, ITEM, 12), CloseDock(ATV)]) | BOOKS


@given(st.lists(WORDS | DOCK | st.just("life") | st.just("start"), max_size=40))
def test_whatever_is_said_nothing_is_negative_and_reports_explain_the_stock(story: list[object]) -> None:
    rig = PeopleRig()
    used = dict(rig.state.stock)
    seqs = [rig.state.seq]
    for step in story:
        if step == "life":
            rig.begin()
        elif step == "start":
            rig.start()
        elif isinstance(step, tuple):
            kind, pieces, item, vehicle, sure = step
            rig.says(kind, pieces, item, vehicle=vehicle, sure=sure)
        else:
            rig.body.instruct(step)  # type: ignore[arg-type]
        for report in rig.heard():
            if isinstance(report, CycleDone | StockChanged) and report.seq <= seqs[-1]:
                assert isinstance(step, Book)  # It was said before.
            elif isinstance(report, CycleDone):
                used[PRODUCT] += not report.bad
                seqs.append(report.seq)
            elif isinstance(report, StockChanged):
                used[report.item] = max(0, used[report.item] + report.change)
                seqs.append(report.seq)
        assert min(rig.state.stock.values()) >= 0
        assert rig.state.stock[PRODUCT] == used[PRODUCT]
        assert rig.kept is not None
        assert (rig.kept.stock, rig.kept.seq) == (rig.state.stock, rig.state.seq)
    assert seqs == list(range(seqs[0], seqs[0] + len(seqs)))


def test_all_that_is_reported_is_on_the_disk() -> None:
    rig = PeopleRig()
    rig.start()
    rig.says(KIND.MADE, 2)
    brought(rig)
    for report, kept in zip(rig.reports, rig.told[-len(rig.reports) :], strict=True):
        assert kept is not None
        if isinstance(report, CycleDone | StockChanged):
            assert kept.seq >= report.seq
        else:
            assert any(each.key == getattr(report, "key", "") for each in kept.answered)
