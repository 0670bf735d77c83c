"""A machine's goals: what it has promised, how far it is, and what that takes."""

from __future__ import annotations

import pytest
from defaults import PLANT
from spoken import production

from dray.protocol.machine.production import PASSED_FRAC, Goal, GoalBook

PLENTY = {"housing": 72, "impeller": 90, "seal-kit": 120, "shaft": 120, "bearing": 120}


def goal(name: str, *, deadline_s: float = 100.0, product: str = "pump-p3", quantity: int = 24) -> Goal:
    """A goal that the strategist has confirmed."""
    made = Goal(name, production(product=product, quantity=quantity), deadline_s)
    made.confirmed = True
    return made


def book(*goals: Goal, machine: str = "M8") -> GoalBook:
    """The goals of M8, which makes pumps in 50 s and gear units G2 in 54 s."""
    made = GoalBook(machine, PLANT)
    for each in goals:
        made.add(each)
    return made


def test_goals_stand_in_the_order_of_their_deadlines_and_then_of_their_names() -> None:
    goals = book(goal("C", deadline_s=50.0), goal("B", deadline_s=100.0), goal("A", deadline_s=100.0))
    assert [each.id for each in goals] == ["C", "A", "B"]


def test_the_most_urgent_goal_with_material_for_its_next_piece_is_made() -> None:
    goals = book(goal("GEAR", deadline_s=10.0, product="gear-unit-g2"), goal("PUMP", deadline_s=20.0))
    assert goals.next_to_make(PLENTY) is goals.get("GEAR")
    assert goals.next_to_make(PLENTY | {"shaft": 0}) is goals.get("PUMP")
    assert goals.next_to_make({}) is None


def test_one_bearing_is_not_enough_for_a_piece_that_takes_two() -> None:
    goals = book(goal("GEAR", product="gear-unit-g2"))
    assert goals.next_to_make(PLENTY | {"bearing": 1}) is None
    assert goals.next_to_make(PLENTY | {"bearing": 2}) is not None


def test_a_goal_that_is_made_is_not_made_again() -> None:
    done = goal("A")
    done.made = 24
    goals = book(done, goal("B"))
    assert goals.next_to_make(PLENTY) is goals.get("B")


def test_a_goal_that_is_made_has_no_part_in_the_running_cycle() -> None:
    done = goal("A")
    done.made = 24
    goals = book(done, goal("B"))
    assert goals.need("housing", "") == 24
    assert goals.need("housing", "pump-p3") == 23


def test_the_need_is_over_all_goals_without_what_is_made_or_running() -> None:
    half = goal("A")
    half.made = 20
    goals = book(half, goal("B"), goal("GEAR", product="gear-unit-g2", quantity=10))
    assert goals.need("housing", "") == 4 + 24 + 10
    assert goals.need("bearing", "") == 2 * 10
    assert goals.need("impeller", "pump-p3") == 4 + 24 - 1
    assert goals.need("shaft", "pump-p3") == 10


def test_the_last_running_piece_needs_nothing_more() -> None:
    last = goal("A", quantity=1)
    goals = book(last)
    assert goals.need("housing", "") == 1
    assert goals.need("housing", "pump-p3") == 0


def test_the_use_is_that_of_the_hungriest_goal_that_is_still_made() -> None:
    goals = book(goal("PUMP"), goal("GEAR", product="gear-unit-g2"))
    assert goals.use_per_s("bearing") == pytest.approx(2 / 54)
    assert goals.use_per_s("housing") == pytest.approx(1 / 50)
    assert book().use_per_s("housing") == 0.0


def test_a_quote_is_the_queue_and_the_cycles() -> None:
    cost = book(goal("A", quantity=10)).quote(production(quantity=24), PLENTY, lead_time_s=90.0)
    assert cost.queue_s == 10 * 50.0
    assert cost.making_s == 24 * 50.0
    assert cost.material_s == 0.0
    assert cost.total_s == cost.queue_s + cost.material_s + cost.making_s


def test_what_is_wanted_later_is_no_queue_and_a_price_for_making_it_wait() -> None:
    later = book(goal("A", quantity=10, deadline_s=900.0))
    cost = later.quote(production(quantity=24), PLENTY, lead_time_s=90.0, deadline_s=100.0)
    assert (cost.queue_s, cost.passed_s) == (0.0, PASSED_FRAC * 10 * 50.0)
    assert cost.takes_s == 24 * 50.0
    assert cost.total_s == cost.takes_s + cost.passed_s
    assert later.quote(production(quantity=24), PLENTY, 90.0, deadline_s=900.0).queue_s == 10 * 50.0


def test_missing_material_is_waited_for_only_as_far_as_the_queue_does_not_cover_it() -> None:
    work = production(quantity=24)
    assert book().quote(work, {}, lead_time_s=90.0).material_s == 90.0
    assert book(goal("A", quantity=1)).quote(work, {}, lead_time_s=90.0).material_s == 40.0
    assert book(goal("A", quantity=10)).quote(work, {}, lead_time_s=90.0).material_s == 0.0


def test_what_is_made_already_is_not_queued_for() -> None:
    half = goal("A", quantity=10)
    half.made = 9
    assert book(half).quote(production(), PLENTY, 90.0).queue_s == 50.0


def test_the_heartbeat_tells_of_every_goal_until_it_is_removed() -> None:
    goals = book(goal("A"), goal("B"))
    assert [brief.goal for brief in goals.briefs(0.0)] == ["A", "B"]
    goals.remove("A")
    goals.remove("A")
    assert [brief.goal for brief in goals.briefs(0.0)] == ["B"]
    assert len(goals) == 1


def test_a_book_is_unfinished_while_anything_is_to_be_made() -> None:
    one = goal("A", quantity=1)
    goals = book(one)
    assert goals.unfinished
    one.made = 1
    assert not goals.unfinished
    assert one.ready == 1
    assert one.to_make == 0


def test_a_goal_that_is_not_confirmed_is_queued_for_and_not_begun() -> None:
    waiting = goal("A", quantity=10)
    waiting.confirmed = False
    goals = book(waiting)
    assert goals.next_to_make(PLENTY) is None
    assert goals.need("housing", "") == 0
    assert goals.use_per_s("housing") == 0.0
    assert not goals.unfinished
    assert goals.quote(production(), PLENTY, 90.0).queue_s == 10 * 50.0
    assert [brief.goal for brief in goals.briefs(0.0)] == ["A"]


def test_spare_pieces_are_given_once_and_to_goals_of_their_product() -> None:
    goals = book()
    goals.add_spare("pump-p3", 3)
    goals.add_spare("pump-p3", 1)
    gears, some, more = goal("G", product="gear-unit-g2"), goal("A", quantity=3), goal("B", quantity=3)
    assert [goals.use_spare(each) for each in (gears, some, more, more)] == [0, 3, 1, 0]
    assert [each.made for each in (gears, some, more)] == [0, 3, 1]


def test_a_goal_whose_last_piece_is_being_made_takes_no_spare_one() -> None:
    last = goal("A", quantity=1)
    goals = book(last)
    goals.add_spare("pump-p3", 1)
    assert goals.use_spare(last, running=last) == 0
    assert goals.use_spare(last) == 1


def test_what_is_ready_of_a_removed_goal_is_spare_and_what_was_sent_is_not() -> None:
    half = goal("A")
    half.made, half.committed = 20, 15
    goals = book(half)
    goals.remove("A")
    assert goals.spare("pump-p3") == 5


def test_spare_pieces_make_a_quote_cheaper() -> None:
    goals = book()
    goals.add_spare("pump-p3", 20)
    cost = goals.quote(production(quantity=24), {}, lead_time_s=90.0)
    assert (cost.making_s, cost.material_s) == (4 * 50.0, 90.0)
    assert goals.quote(production(quantity=20), {}, lead_time_s=90.0).total_s == 0.0


def sent_away(made: int, *, delivered: int = 0, lost_in_transit: int = 0, on_the_way: int = 0) -> Goal:
    """A goal of 24 pieces, some of which have left the machine."""
    some = goal("A")
    some.made, some.delivered, some.lost_in_transit = made, delivered, lost_in_transit
    some.committed = delivered + lost_in_transit + on_the_way
    return some


def test_a_piece_that_was_lost_is_made_once_more() -> None:
    some = sent_away(24, delivered=14, on_the_way=10)
    assert (some.to_make, some.on_the_way) == (0, 10)
    some.lose(10)
    assert (some.to_make, some.on_the_way, some.ready) == (10, 0, 0)


def test_the_gates_count_is_believed_once_nothing_is_on_the_way() -> None:
    some = sent_away(24, delivered=4, on_the_way=10)
    assert some.note_arrived(14) == 0
    assert (some.delivered, some.on_the_way) == (4, 10)
    some.lose(10)
    assert some.note_arrived(14) == 0
    assert (some.delivered, some.lost_in_transit, some.to_make, some.ready) == (14, 0, 0, 10)


def test_pieces_that_were_believed_in_and_are_not_are_made_once_more() -> None:
    some = sent_away(24, delivered=24)
    some.note_arrived(14)
    assert (some.delivered, some.lost_in_transit, some.to_make) == (14, 10, 10)


def test_pieces_that_were_made_anew_and_are_not_needed_are_left_over() -> None:
    some = sent_away(44, delivered=4, lost_in_transit=20)
    assert some.ready == 20
    assert some.note_arrived(24) == 20
    assert (some.to_make, some.ready, some.brief(0.0, cycling=False).made) == (0, 0, 24)


def test_a_goal_comes_back_from_memory_as_it_was() -> None:
    some = sent_away(20, delivered=4, lost_in_transit=3)
    again = book().restore(some.memory())
    assert again.memory() == some.memory()
    assert (again.to_make, again.ready, again.on_the_way) == (some.to_make, some.ready, 0)
    assert again.confirmed


def test_a_goal_that_is_not_confirmed_is_remembered_as_such() -> None:
    waiting = goal("A")
    waiting.confirmed = False
    first, second = book(waiting, goal("B")).memories()
    assert [(each.goal, each.confirmed) for each in (first, second)] == [("A", False), ("B", True)]
    assert not book().restore(first).confirmed
