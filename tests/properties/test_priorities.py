"""Priorities become times, and by those times nothing that waits is passed for ever."""

from __future__ import annotations

from credulous import Credulous
from defaults import PLANT
from hypothesis import given
from hypothesis import strategies as st
from spoken import production, transport

from dray.messages import Role
from dray.priorities import ORDER_WITHIN_S, TRANSPORT_WITHIN_S, Priority, order_wanted_s
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.auction_rules import PATIENCE_S, AuctionRules
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.machine.production import Goal, GoalBook
from dray.protocol.runtime.life import Life
from dray.protocol.transports.transports import most_urgent, stands_back

PLENTY = {"housing": 10_000, "impeller": 10_000, "seal-kit": 10_000, "shaft": 10_000, "bearing": 10_000}
HOURS_S = st.floats(min_value=0.0, max_value=200_000.0)
DUE_IN_S = st.none() | st.floats(min_value=1.0, max_value=100_000.0)


@given(released_s=HOURS_S, due_in_s=DUE_IN_S)
def test_the_more_urgent_is_never_wanted_later_and_nothing_before_its_release(
    released_s: float, due_in_s: float | None
) -> None:
    due_s = None if due_in_s is None else released_s + due_in_s
    wanted_s = [order_wanted_s(priority, released_s, due_s) for priority in reversed(Priority)]
    assert wanted_s == sorted(wanted_s)
    assert min(wanted_s) >= released_s


@given(released_s=HOURS_S, due_in_s=DUE_IN_S, speed=st.floats(min_value=0.5, max_value=50.0))
def test_a_priority_counts_in_the_plants_time_however_fast_that_goes(
    released_s: float, due_in_s: float | None, speed: float
) -> None:
    due_s = None if due_in_s is None else released_s + due_in_s
    urgent_s = order_wanted_s(Priority.URGENT, released_s, due_s, speed)
    assert urgent_s <= released_s + ORDER_WITHIN_S[Priority.URGENT] / speed


@given(
    first=st.sampled_from(list(Priority)),
    later=st.lists(
        st.tuples(st.floats(min_value=0.0, max_value=900.0), st.sampled_from(list(Priority)), DUE_IN_S),
        min_size=1,
        max_size=60,
    ),
)
def test_what_came_after_the_wanted_time_of_a_goal_is_never_made_before_it(
    first: Priority, later: list[tuple[float, Priority, float | None]]
) -> None:
    """A machine that is never idle and gets ever more: the first goal is begun by its wanted time and what was there then."""
    goals, now_s, came_s = GoalBook("M8", PLANT), 0.0, {"FIRST": 0.0}
    wanted_s = order_wanted_s(first, 0.0, 1800.0)
    goals.add(_goal("FIRST", wanted_s))
    for number, (gap_s, priority, due_in_s) in enumerate(later):
        now_s += gap_s
        due_s = None if due_in_s is None else now_s + due_in_s
        came_s[f"G{number}"] = now_s
        goals.add(_goal(f"G{number}", order_wanted_s(priority, now_s, due_s)))
        _work(goals, came_s, wanted_s)
    while _work(goals, came_s, wanted_s):
        pass
    assert not goals.unfinished


def _work(goals: GoalBook, came_s: dict[str, float], wanted_s: float) -> bool:
    """Make one piece; False when there is nothing to make."""
    made = goals.next_to_make(PLENTY)
    if made is None:
        return False
    waits = goals.get("FIRST")
    if waits is not None and waits.to_make > 0:
        assert made is waits or came_s[made.id] <= wanted_s
    made.made += 1
    return True


def _goal(name: str, deadline_s: float) -> Goal:
    goal = Goal(name, production(quantity=2), deadline_s)
    goal.confirmed = True
    return goal


@given(
    first=st.sampled_from(list(Priority)),
    later=st.lists(
        st.tuples(st.floats(min_value=0.0, max_value=120.0), st.sampled_from(list(Priority))),
        min_size=1,
        max_size=60,
    ),
    each=st.integers(min_value=1, max_value=10),
)
def test_five_minutes_after_it_was_given_out_a_transport_is_passed_by_none_that_was_called_later(
    first: Priority, later: list[tuple[float, Priority]], each: int
) -> None:
    """Vehicles that are never idle, and ever more calls: each time one is free it is offered what is most urgent."""
    now_s, came_s = 0.0, {"FIRST": 0.0}
    waiting = {"FIRST": _waiting("FIRST", first, 0.0)}
    for number, (gap_s, priority) in enumerate(later):
        now_s += gap_s
        name = f"T{number}"
        came_s[name], waiting[name] = now_s, _waiting(name, priority, now_s)
        if number % each == 0:
            _carry(waiting, came_s)
    while waiting:
        _carry(waiting, came_s)


def _carry(waiting: dict[str, OpenTask], came_s: dict[str, float]) -> None:
    """A vehicle is free, and takes what it is offered first."""
    chosen = most_urgent(waiting.values(), "ATV1", ("tote", "pallet"))
    assert chosen is not None
    assert not stands_back(chosen, waiting.values())
    if "FIRST" in waiting:
        assert chosen.id == "FIRST" or came_s[chosen.id] <= PATIENCE_S
    del waiting[chosen.id]


def _waiting(name: str, priority: Priority, now_s: float) -> OpenTask:
    """A transport for which all vehicles were busy."""
    work = transport()
    terms = Terms(name, 1, Role.PRIMARY, work, now_s + TRANSPORT_WITHIN_S[priority])
    place = Place(x_m=0.0, y_m=0.0, reach_m=100.0)
    auction = Auction("M8", terms, place, lambda _radius_m: ("k",), AuctionRules(), Life(), Credulous())
    auction.stand_behind(now_s)
    return OpenTask(name, work, auction, now_s)
