"""How far an order has come, from facts in any order."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import pytest
from history import accepted, contracted, delivered, made, same_clock, tell
from hypothesis import given
from hypothesis import strategies as st

from dray.messages import Event
from dray.messages.base import COUNT_MAX
from dray.messages.fact import GoalLost, GoalWithdrawn
from dray.messages.history import LIVES_TOLD
from dray.messages.overtaken import OVERTAKES_S
from dray.store.orders.progress import (
    Goal,
    OrderStatus,
    Progress,
    delivered_after,
    goal_of,
    life_with,
    merge,
    note,
    progress,
    status_after,
)


def reached(
    events: Sequence[Event], *quantities: int, life: int = 0, arrived: tuple[int, ...] = ()
) -> Progress:
    goals: dict[str, Goal] = {}
    for event in events:
        if goal := goal_of(event):
            note(goals.setdefault(goal, Goal(goal)), event, same_clock)
    return progress(quantities, goals.values(), life, arrived or (0,) * len(quantities))


@pytest.mark.parametrize(
    ("facts", "status", "counts"),
    [
        ([], OrderStatus.RELEASED, (0, 0)),
        ([accepted("G1")], OrderStatus.RELEASED, (0, 0)),
        ([contracted("G1", 0, 4)], OrderStatus.IN_PRODUCTION, (0, 0)),
        ([contracted("G1", 0, 4), made("G1", 3)], OrderStatus.IN_PRODUCTION, (3, 0)),
        ([contracted("G1", 0, 4), made("G1", 4)], OrderStatus.IN_DELIVERY, (4, 0)),
        ([contracted("G1", 0, 4), made("G1", 3), delivered("G1", 0, 2)], OrderStatus.IN_DELIVERY, (3, 2)),
        ([contracted("G1", 0, 4), delivered("G1", 0, 4)], OrderStatus.DELIVERED, (4, 4)),
    ],
)
def test_the_status_of_an_order_follows_its_goals(
    facts: list[object], status: OrderStatus, counts: tuple[int, int]
) -> None:
    result = reached(tell("somebody", *facts), 4)  # type: ignore[arg-type]
    assert (result.status, result.made, result.delivered) == (status, counts[:1], counts[1:])


def test_an_order_is_delivered_when_its_last_piece_arrived() -> None:
    events = [
        *tell("M1", delivered("G1", 0, 2), delivered("G1", 0, 4), at_s=10.0),
        *tell("M2", delivered("G2", 1, 1), at_s=5.0),
    ]
    assert reached(events, 4, 1).delivered_at_s == 12.0
    assert reached(events[:2], 4, 1).delivered_at_s is None


def test_an_item_that_two_goals_make_needs_both() -> None:
    one = tell("M1", delivered("G1", 0, 2))
    assert reached(one, 4).status is OrderStatus.IN_DELIVERY
    both = one + tell("M2", delivered("G2", 0, 2))
    assert reached(both, 4).status is OrderStatus.DELIVERED


def test_what_a_lost_life_made_is_gone_and_what_it_delivered_stays() -> None:
    first = tell("strategist", contracted("G1", 0, 4)) + tell("M1", made("G1", 3), delivered("G1", 0, 2))
    again = tell("strategist", contracted("Gr2", 0, 2), life=2)
    assert reached(first, 4).made == (3,)
    assert reached(first + again, 4, life=2).made == (2,)
    done = again + tell("M1", made("Gr2", 2), delivered("Gr2", 0, 2), life=2)
    assert reached(first + done, 4, life=2).status is OrderStatus.DELIVERED


HELD_BY_TWO = [
    # The first holder has lived often, the second never before.
    *tell(
        "strategist",
        contracted("G1", 0, 4, held=1),
        contracted("G2", 0, 4, held=1),
        first=90,
        life=7,
        at_s=0.0,
    ),
    *tell("M1", made("G1", 3), made("G2", 3)),
    *tell(
        "strategist2", GoalLost("G1", "M1", arrived=1, successor="G3", held=2), contracted("G3", 0, 3, held=2)
    ),
]


@given(st.permutations(HELD_BY_TWO))
def test_what_the_next_holder_of_an_order_tells_counts_however_often_others_have_lived(
    events: list[Event],
) -> None:
    """The second one goes on with G2, and has lost G1."""
    result = reached(events, 8, life=7)
    assert (result.status, result.made, result.delivered) == (OrderStatus.IN_DELIVERY, (4,), (1,))


def test_an_acceptance_by_one_of_several_makes_no_goal_of_another_unknown() -> None:
    [alone] = tell("strategist", accepted("G1"), life=3)
    [shared] = tell("strategist2", accepted("G1", held=1), life=3)
    assert (life_with(alone), life_with(shared)) == (3, 0)


TOLD_OF_A_GOAL = [
    *tell("strategist", contracted("G1", 0, 4)),
    *tell("M1", made("G1", 2), made("G1", 3), delivered("G1", 0, 2), at_s=50.0),
    *tell("strategist", GoalLost(goal="G1", machine="M1", arrived=3, successor=""), life=2, at_s=90.0),
]


@given(st.lists(st.sampled_from(TOLD_OF_A_GOAL)), st.lists(st.sampled_from(TOLD_OF_A_GOAL)))
def test_what_two_know_of_a_goal_is_what_one_knows_who_was_told_all(
    here: list[Event], there: list[Event]
) -> None:
    mine, theirs, whole = Goal("G1"), Goal("G1"), Goal("G1")
    for goal, told in ((mine, here), (theirs, there), (whole, [*here, *there])):
        for event in told:
            note(goal, event, same_clock)
    merge(mine, theirs)
    for life in (0, 1, 2):
        assert progress((4,), [mine], life, (0,)) == progress((4,), [whole], life, (0,))


@pytest.mark.parametrize(
    ("held", "life", "number"),
    [(0, COUNT_MAX, 1), (0, 1, COUNT_MAX), (COUNT_MAX, 1, 1)],
    ids=["a life", "a number", "an epoch"],
)
def test_what_a_thief_tells_of_the_far_future_does_not_decide_for_ever_what_is_shown_of_a_goal(
    held: int, life: int, number: int
) -> None:
    """It has a strategist's certificate. What it has told may come once more, as what SQL has of it."""
    own = Event("strategist", 1, 1, 5.0, contracted("G1", 0, 4))
    stolen = Event("strategist", life, number, 10.0, GoalLost("G1", "M1", 0, "", held=held))
    perhaps_late = Event("strategist", 1, 2, 10.0 + OVERTAKES_S, contracted("G1", 0, 6))
    later = Event("strategist", 1, 3, 10.1 + OVERTAKES_S, contracted("G1", 0, 8))

    def known(*events: Event) -> Goal:
        goal = Goal("G1")
        for event in events:
            note(goal, event, same_clock)
        return goal

    assert known(own, stolen, perhaps_late).over
    merged = known(own, stolen)
    merge(merged, known(later))
    merge(merged, known(own, stolen))
    for goal in (known(own, stolen, later), known(later, stolen, own), merged):
        assert not goal.over
        assert goal.quantity == 8


def test_a_goal_whose_newest_fact_has_no_time_goes_by_numbers_alone() -> None:
    """As SQL has it from before these times were kept."""
    goal = Goal("G1", machine="M1", quantity=4, incarnation=2, number=7)
    for event in tell("strategist", contracted("G1", 0, 9), life=2, first=6, at_s=1000.0):
        note(goal, event, same_clock)
    assert goal.quantity == 4


def test_more_than_was_ordered_counts_as_what_was_ordered() -> None:
    result = reached(tell("M1", delivered("G1", 0, 9)), 4)
    assert (result.made, result.delivered) == ((4,), (4,))


def test_an_item_that_the_order_does_not_have_counts_nothing() -> None:
    assert reached(tell("M1", delivered("G1", 1, 4)), 4).delivered == (0,)


def test_what_a_failed_machine_made_is_gone_and_what_had_arrived_stays() -> None:
    first = tell("strategist", contracted("G1", 0, 4)) + tell("M1", made("G1", 3), delivered("G1", 0, 1))
    lost = tell("strategist", GoalLost("G1", "M1", arrived=2, successor="G2"), first=2)
    alone = reached(first + lost, 4)
    assert (alone.status, alone.made, alone.delivered) == (OrderStatus.IN_DELIVERY, (2,), (2,))
    rest = tell("strategist", contracted("G2", 0, 2), first=3) + tell("M2", delivered("G2", 0, 2))
    assert reached(first + lost + rest, 4).status is OrderStatus.DELIVERED


def test_an_order_whose_only_machine_failed_is_not_in_production() -> None:
    lost = tell("strategist", GoalLost("G1", "M1", arrived=0, successor="G2"), first=2)
    result = reached(tell("strategist", contracted("G1", 0, 4)) + tell("M1", made("G1", 3)) + lost, 4)
    assert (result.status, result.made) == (OrderStatus.RELEASED, (0,))


def test_an_order_that_had_arrived_when_its_machine_was_lost_is_delivered() -> None:
    told = tell(
        "strategist", contracted("G1", 0, 4), GoalLost("G1", "M1", arrived=4, successor=""), at_s=50.0
    )
    result = reached(told, 4)
    assert (result.status, result.delivered_at_s) == (OrderStatus.DELIVERED, told[-1].at_s)


def test_of_an_order_that_was_taken_back_only_what_had_arrived_counts() -> None:
    first = tell("strategist", contracted("G1", 0, 4)) + tell("M1", made("G1", 3), delivered("G1", 0, 1))
    back = tell("strategist", GoalWithdrawn("G1", "M1", arrived=2), first=2)
    resting = reached(first + back, 4)
    assert (resting.made, resting.delivered) == ((2,), (2,))
    again = tell("strategist", contracted("G2", 0, 2), first=3) + tell("M1", made("G2", 1))
    assert reached(first + back + again, 4).made == (3,)
    done = again + tell("M1", delivered("G2", 0, 2), first=9)
    assert reached(first + back + done, 4).status is OrderStatus.DELIVERED


def test_a_goal_that_was_withdrawn_has_lost_nothing() -> None:
    told = tell("strategist", contracted("G1", 0, 4), GoalWithdrawn("G1", "M1", arrived=0))
    goal = Goal("G1")
    for event in told:
        note(goal, event, same_clock)
    assert (goal.over, goal.lost) == (True, False)


def test_what_is_known_to_have_arrived_counts_before_its_facts_do() -> None:
    assert reached([], 4, 1, arrived=(3, 0)).delivered == (3, 0)
    told = tell("M1", delivered("G1", 0, 2))
    assert reached(told, 4, arrived=(3,)).delivered == (3,)
    assert reached(told, 4, arrived=(1,)).delivered == (2,)
    assert reached([], 4, arrived=(4,)) == Progress(OrderStatus.DELIVERED, (4,), (4,), None)


@pytest.mark.parametrize(
    ("status", "goals_say", "after"),
    [
        (OrderStatus.RELEASED, OrderStatus.IN_DELIVERY, OrderStatus.IN_DELIVERY),
        (OrderStatus.STORED, OrderStatus.IN_DELIVERY, OrderStatus.STORED),
        (OrderStatus.STORED, OrderStatus.DELIVERED, OrderStatus.DELIVERED),
        (OrderStatus.CANCELLED, OrderStatus.DELIVERED, OrderStatus.CANCELLED),
    ],
)
def test_a_stored_order_stays_stored_unless_all_of_it_arrives(
    status: OrderStatus, goals_say: OrderStatus, after: OrderStatus
) -> None:
    assert status_after(status, goals_say) is after


@pytest.mark.parametrize(
    ("status", "known_s", "reached_s", "delivered_s"),
    [
        (OrderStatus.DELIVERED, None, 9.0, 9.0),
        (OrderStatus.DELIVERED, 20.0, None, 20.0),
        (OrderStatus.DELIVERED, 20.0, 9.0, 9.0),
        (OrderStatus.CANCELLED, None, 9.0, None),
    ],
)
def test_facts_know_best_when_an_order_was_delivered(
    status: OrderStatus, known_s: float | None, reached_s: float | None, delivered_s: float | None
) -> None:
    assert delivered_after(status, known_s, reached_s) == delivered_s


FACTS = [
    *tell(
        "M1",
        contracted("G1", 0, 4),
        made("G1", 1),
        made("G1", 4),
        delivered("G1", 0, 2),
        delivered("G1", 0, 4),
    ),
    *tell("M1", GoalLost("G1", "M1", arrived=3, successor="G2"), contracted("G2", 0, 1), first=6, at_s=105.0),
    *tell("M1", GoalWithdrawn("G2", "M1", arrived=0), first=8, at_s=107.0),
]


@given(st.lists(st.sampled_from(FACTS), min_size=1), st.randoms(use_true_random=False))
def test_the_order_and_the_doubling_of_facts_change_nothing(events: list[Event], chance: object) -> None:
    shuffled = [*events, *events]
    chance.shuffle(shuffled)  # type: ignore[attr-defined]
    assert reached(shuffled, 4) == reached(events, 4)


@st.composite
def facts_by_set_clocks(draw: st.DrawFn) -> list[Event]:
    """One strategist's facts about G1, in the order in which it told them; its clock was set, forth or back, before any of them."""
    events, told = (
        [],
        draw(st.lists(st.tuples(st.integers(0, 1), st.floats(0.0, 1e4)), min_size=1, max_size=5)),
    )
    life, number = 1, 0
    for restarts, at_s in told:
        life, number = life + restarts, 1 if restarts else number + 1
        events.append(Event("strategist", life, number, at_s, contracted("G1", 0, len(events) + 1)))
    return events


@given(facts_by_set_clocks(), st.data())
def test_a_clock_that_was_set_makes_no_fact_of_a_goal_old(events: list[Event], data: st.DataObject) -> None:
    """In any order, and however two records of it share the facts."""
    shuffled = data.draw(st.permutations(events))
    cut = data.draw(st.integers(0, len(shuffled)))
    here, there = Goal("G1"), Goal("G1")
    for goal, told in ((here, shuffled[:cut]), (there, shuffled[cut:])):
        for event in told:
            note(goal, event, same_clock)
    both, other_way = msgspec.structs.replace(here), msgspec.structs.replace(there)
    merge(both, there)
    merge(other_way, here)
    assert both == other_way
    assert both.quantity == len(events)


@given(st.data(), st.lists(st.floats(0.0, 200.0), min_size=1, max_size=4), st.floats(0.0, 200.0))
def test_what_a_thief_tells_of_a_goal_weighs_the_same_in_any_order(
    data: st.DataObject, times_s: list[float], stolen_s: float
) -> None:
    own = [
        Event("strategist", 1, number, at_s, contracted("G1", 0, number))
        for number, at_s in enumerate(sorted(times_s), 1)
    ]
    stolen = Event("strategist", COUNT_MAX, 1, stolen_s, GoalLost("G1", "M1", 0, ""))
    goal = Goal("G1")
    for event in data.draw(st.permutations([*own, stolen])):
        note(goal, event, same_clock)
    assert goal.over is (max(times_s) - stolen_s <= OVERTAKES_S)


def test_a_goal_is_lost_although_its_strategist_began_again_with_a_clock_an_hour_slow() -> None:
    before = tell("strategist", contracted("G1", 0, 4), at_s=5000.0)
    after = tell("strategist", GoalLost("G1", "M1", 0, ""), life=2, at_s=1400.0)
    assert reached([*before, *after], 4).status is OrderStatus.RELEASED


def test_an_acceptance_of_the_far_future_makes_no_goal_unknown() -> None:
    """A thief of the strategist's certificate has told it. A life with goals of its own is at most some lives later."""
    events = [*tell("strategist", contracted("G1", 0, 4), life=3), *tell("M1", made("G1", 3))]
    for life, status, count in [
        (3 + LIVES_TOLD, OrderStatus.RELEASED, 0),
        (4 + LIVES_TOLD, OrderStatus.IN_PRODUCTION, 3),
        (COUNT_MAX, OrderStatus.IN_PRODUCTION, 3),
    ]:
        result = reached(events, 4, life=life)
        assert (result.status, result.made) == (status, (count,))
    without_contract = reached(tell("M1", made("G1", 3)), 4, life=COUNT_MAX)
    assert without_contract.status is OrderStatus.RELEASED
