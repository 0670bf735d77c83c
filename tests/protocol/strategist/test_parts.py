"""Orders become goals on all levels: what is lacking, net of what lies somewhere and of what is in work."""

from __future__ import annotations

from bureau import announced, contract, reborn
from effects import instructed, published, sent
from msgspec.structs import replace
from rigs import StrategistRig
from spoken import goal_bid, mhb

from dray.body import Admit
from dray.messages import (
    Award,
    BufferLevel,
    GoalBrief,
    GoalClosed,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    Production,
    StationHeartbeat,
    StockLevel,
    TaskAnnounced,
    Withdrawn,
)
from dray.messages.fact import GoalContracted, GoalWithdrawn, OrderFulfilled
from dray.messages.gate import OrderHeld
from dray.plant.file.file import shipped_plant
from dray.protocol.runtime.events import Effect, Record
from dray.protocol.strategist.order_holding import TURN_S
from dray.protocol.strategist.part_planning import PLAN_EVERY_S, SETTLE_S

PLANT = shipped_plant("levels")
SETTLED_S = SETTLE_S + 2 * PLAN_EVERY_S


def bureau(quantity: int = 4, product: str = "gearbox") -> StrategistRig:
    """A strategist of the gear works that has just been given an order of four gearboxes."""
    rig = StrategistRig(plant=PLANT)
    rig.start()
    order(rig, "O1", quantity, product)
    return rig


def order(rig: StrategistRig, name: str, quantity: int, product: str = "gearbox") -> list[Effect]:
    return rig.on_message("gateway", OrderReleased(name, (OrderItem(product, quantity),), 7200.0))


def store(rig: StrategistRig, seq: int = 1, **pieces: int) -> None:
    """The gear set store tells what lies there; names with _ for -."""
    stocks = tuple(StockLevel(item.replace("_", "-"), level, 100) for item, level in pieces.items())
    rig.on_message("SETS", StationHeartbeat("SETS", 1, seq, rig.now_s, stocks))


def put_up(effects: list[Effect]) -> list[tuple[str, int]]:
    return [(product, quantity) for _, product, quantity in announced(effects)]


def goal_of(rig: StrategistRig, product: str) -> str:
    return next(goal for goal, of, _ in announced(rig.all) if of == product)


def brief(goal: str, product: str, quantity: int, made: int) -> GoalBrief:
    return GoalBrief(goal, product, quantity, made, made)


def test_what_is_lacking_is_put_up_in_whole_containers_level_by_level() -> None:
    rig = bureau()
    assert put_up(rig.all) == [("gearbox", 4)]
    assert put_up(rig.run(SETTLED_S)) == [("gear-set", 6)]
    assert put_up(rig.run(rig.now_s + SETTLED_S)) == [("shaft", 12), ("gear", 16)]
    assert put_up(rig.run(rig.now_s + 10 * SETTLED_S)) == []


def test_what_lies_somewhere_is_not_made() -> None:
    rig = bureau()
    store(rig, gear_set=4)
    assert put_up(rig.run(SETTLED_S)) == []
    store(rig, 2, gear_set=3)
    assert put_up(rig.run(rig.now_s + SETTLED_S)) == [("gear-set", 6)]


def test_what_was_not_heard_of_for_a_minute_does_not_count() -> None:
    rig = bureau()
    store(rig, gear_set=4)
    assert put_up(rig.run(50.0)) == []
    assert put_up(rig.run(60.0 + SETTLED_S)) == [("gear-set", 6)]


def test_what_is_lacking_for_a_moment_is_not_made() -> None:
    rig = bureau()
    rig.run(10.0)
    store(rig, gear_set=4)  # It was being carried.
    assert put_up(rig.run(10.0 + SETTLED_S)) == []


def test_two_orders_share_what_is_over_in_a_container() -> None:
    rig = bureau(2)
    order(rig, "O2", 3)
    assert put_up(rig.run(SETTLED_S)) == [("gear-set", 6)]
    assert put_up(rig.run(rig.now_s + SETTLED_S)) == [("shaft", 12), ("gear", 16)]


def test_parts_are_due_before_what_needs_them() -> None:
    rig = bureau()
    rig.run(3 * SETTLED_S)
    due_s = {
        message.work.product: message.deadline_s
        for message in published(rig.all, TaskAnnounced)
        if isinstance(message.work, Production)
    }
    assert due_s["gear"] < due_s["gear-set"] < due_s["gearbox"]
    assert due_s["gear-set"] == due_s["gearbox"] - 4 * 60.0 - 300.0


def test_a_goal_of_parts_ends_with_the_making_and_has_no_gate() -> None:
    rig = bureau()
    rig.run(SETTLED_S)
    goal = goal_of(rig, "gear-set")
    effects = contract(rig, goal, "PRESS1")
    assert goal not in [admit.goal for admit in instructed(effects, Admit)]
    [taken] = [e.fact for e in effects if isinstance(e, Record) and isinstance(e.fact, GoalContracted)]
    assert (taken.product, taken.part_of) == ("gear-set", "gearbox")
    assert not sent(rig.on_message("PRESS1", mhb("PRESS1", brief(goal, "gear-set", 6, 5), seq=2)), GoalClosed)
    assert sent(rig.on_message("PRESS1", mhb("PRESS1", brief(goal, "gear-set", 6, 6), seq=3)), GoalClosed)


def test_a_part_that_is_in_a_cycle_is_not_lacking() -> None:
    rig = bureau(1)
    contract(rig, goal_of(rig, "gearbox"), "ASSEMBLY1")
    begun = replace(brief(goal_of(rig, "gearbox"), "gearbox", 1, 0), to_begin=0)
    for seq in range(1, 30):
        rig.run(seq * 1.0)
        rig.on_message("ASSEMBLY1", mhb("ASSEMBLY1", begun, seq=seq))
    assert put_up(rig.all) == [("gearbox", 1)]


def test_a_machine_that_falls_silent_leaves_what_it_has_made_and_others_make_the_rest() -> None:
    rig = bureau()
    rig.run(SETTLED_S)
    goal = goal_of(rig, "gear-set")
    contract(rig, goal, "PRESS1")
    goods = (BufferLevel("gear-set", 2, 18, spare=2),)
    rig.on_message(
        "PRESS1", replace(mhb("PRESS1", brief(goal, "gear-set", 6, 2), seq=9), goods=goods, buffers=())
    )
    for seq in range(10, 30):
        rig.run(rig.now_s + 1.0)
        rig.on_message("PRESS2", mhb("PRESS2", seq=seq))
    assert [e.fact.goal for e in rig.all if isinstance(e, Record) and isinstance(e.fact, GoalWithdrawn)] == [
        goal
    ]
    before = len(announced(rig.all))
    rig.run(rig.now_s + SETTLED_S)
    assert ("gear-set", 6) in put_up(rig.all)[before:]


def test_a_cancelled_order_takes_its_goals_of_parts_along_and_its_pieces_serve_the_next() -> None:
    rig = bureau()
    rig.run(SETTLED_S)
    goal = goal_of(rig, "gear-set")
    contract(rig, goal, "PRESS1")
    effects = rig.on_message("gateway", OrderCancelled("O1"))
    assert goal in [message.task for message in sent(effects, Withdrawn)]
    store(rig, gear_set=4)
    order(rig, "O2", 4)
    assert put_up(rig.run(rig.now_s + SETTLED_S))[0:1] != [("gear-set", 6)]


def test_an_order_that_is_delivered_leaves_no_goal_of_parts() -> None:
    rig = bureau()
    rig.run(SETTLED_S)
    part, whole = goal_of(rig, "gear-set"), goal_of(rig, "gearbox")
    contract(rig, part, "PRESS1")
    contract(rig, whole, "ASSEMBLY1")
    effects = rig.arrive(whole, 4)
    assert [
        e.fact.order for e in effects if isinstance(e, Record) and isinstance(e.fact, OrderFulfilled)
    ] == ["O1"]
    assert part in [message.task for message in sent(effects, Withdrawn)]
    assert put_up(rig.run(rig.now_s + 3 * SETTLED_S)) == []


def test_the_next_life_goes_on_with_goals_of_parts() -> None:
    rig = bureau()
    rig.run(SETTLED_S)
    goal = goal_of(rig, "gear-set")
    contract(rig, goal, "PRESS1")
    again = reborn(rig, plant=PLANT)
    again.on_message("PRESS1", mhb("PRESS1", brief(goal, "gear-set", 6, 5), seq=1))
    assert sent(again.on_message("PRESS1", mhb("PRESS1", brief(goal, "gear-set", 6, 6), seq=2)), GoalClosed)


def test_an_order_whose_parts_nobody_makes_is_not_taken() -> None:
    machines = tuple(each for each in PLANT.file.machines if not each.id.startswith("PRESS"))
    rig = StrategistRig(plant=type(PLANT)(replace(PLANT.file, machines=machines)))
    rig.start()
    order(rig, "O1", 4)
    assert announced(rig.all) == []


def withdrawn(effects: list[Effect]) -> list[str]:
    """Goals that machines are told to leave."""
    return [message.task for message in sent(effects, Withdrawn)]


def told_withdrawn(effects: list[Effect]) -> list[str]:
    """Goals of which history is told that they are withdrawn."""
    return [e.fact.goal for e in effects if isinstance(e, Record) and isinstance(e.fact, GoalWithdrawn)]


def test_a_cancelled_order_takes_the_goals_of_both_levels_along_begun_or_not() -> None:
    rig = bureau()
    rig.run(3 * SETTLED_S)
    sets, shafts, gears = (goal_of(rig, part) for part in ("gear-set", "shaft", "gear"))
    contract(rig, sets, "PRESS1")
    contract(rig, shafts, "LATHE1")
    begun = replace(brief(shafts, "shaft", 12, 2), to_begin=9)
    rig.on_message("LATHE1", mhb("LATHE1", begun, seq=2))
    effects = rig.on_message("gateway", OrderCancelled("O1"))
    assert withdrawn(effects) == [sets, shafts]
    assert told_withdrawn(effects) == [sets, shafts]
    # Nobody has taken the gears: their auction is over.
    assert not sent(rig.on_message("MILL1", goal_bid(gears, 100.0)), Award)
    assert put_up(rig.run(rig.now_s + 3 * SETTLED_S)) == []


def served_by_the_store(*others: str) -> tuple[StrategistRig, str]:
    """O1 takes the six gear sets in the store, and so O2, due later, has six more made by PRESS1."""
    rig = StrategistRig(plant=PLANT, others=others)
    rig.start()
    for name, due_s in (("O1", 7200.0), ("O2", 9000.0)):
        rig.on_message("gateway", OrderReleased(name, (OrderItem("gearbox", 6),), due_s))
        if others:
            rig.run(rig.now_s + TURN_S)
            rig.report(OrderHeld(name, "strategist", 1))
    run_with_store(rig, 2 * SETTLED_S)
    goal = goal_of(rig, "gear-set")
    assert goal.startswith("O2")
    contract(rig, goal, "PRESS1")
    return rig, goal


def run_with_store(rig: StrategistRig, until_s: float, *briefs: GoalBrief, pieces: int = 6) -> list[Effect]:
    """Time passes, while the store tells of its gear sets and PRESS1 of its goals."""
    effects: list[Effect] = []
    while rig.now_s < until_s:
        effects += rig.run(rig.now_s + 1.0)
        store(rig, seq=100 + int(rig.now_s), gear_set=pieces)
        if briefs:
            effects += rig.on_message("PRESS1", mhb("PRESS1", *briefs, seq=100 + int(rig.now_s)))
    return effects


def test_a_goal_of_parts_that_nobody_needs_after_a_cancellation_is_withdrawn_with_those_of_the_next_level() -> (
    None
):
    rig, goal = served_by_the_store()
    idle = brief(goal, "gear-set", 6, 0)
    assert withdrawn(run_with_store(rig, rig.now_s + SETTLED_S, idle)) == []
    [gears] = [of for of, part, _ in announced(rig.all) if part == "gear"]
    cancelled = rig.on_message("gateway", OrderCancelled("O1"))
    effects = cancelled + run_with_store(rig, rig.now_s + SETTLE_S - PLAN_EVERY_S, idle)
    assert withdrawn(effects) == []
    effects = run_with_store(rig, rig.now_s + 2 * PLAN_EVERY_S, idle)
    # Its machine is told again while it names it.
    assert (set(withdrawn(effects)), told_withdrawn(effects)) == ({goal}, [goal])
    # Without it nobody needs its parts.
    run_with_store(rig, rig.now_s + SETTLED_S)
    assert not sent(rig.on_message("MILL1", goal_bid(gears, 100.0)), Award)
    assert put_up(run_with_store(rig, rig.now_s + 3 * SETTLED_S)) == []


def test_a_begun_goal_of_parts_is_made_also_where_nobody_needs_it() -> None:
    rig, goal = served_by_the_store()
    begun = replace(brief(goal, "gear-set", 6, 0), to_begin=5)
    run_with_store(rig, rig.now_s + 2.0, begun)
    rig.on_message("gateway", OrderCancelled("O1"))
    assert withdrawn(run_with_store(rig, rig.now_s + 3 * SETTLED_S, begun)) == []


def test_a_goal_of_parts_of_which_a_piece_is_needed_is_made() -> None:
    rig, goal = served_by_the_store()
    idle = brief(goal, "gear-set", 6, 0)
    rig.on_message("gateway", OrderCancelled("O1"))
    assert withdrawn(run_with_store(rig, rig.now_s + 3 * SETTLED_S, idle, pieces=5)) == []


def test_a_goal_of_parts_that_is_needed_again_within_a_moment_is_made() -> None:
    rig, goal = served_by_the_store()
    idle = brief(goal, "gear-set", 6, 0)
    rig.on_message("gateway", OrderCancelled("O1"))
    run_with_store(rig, rig.now_s + SETTLE_S - PLAN_EVERY_S, idle)
    run_with_store(rig, rig.now_s + PLAN_EVERY_S, idle, pieces=0)
    assert withdrawn(run_with_store(rig, rig.now_s + SETTLE_S - PLAN_EVERY_S, idle)) == []


def test_beside_another_strategist_whose_needs_are_unknown_no_goal_of_parts_counts_as_unneeded() -> None:
    rig, goal = served_by_the_store("strategist2")
    rig.on_message("gateway", OrderCancelled("O1"))
    idle = brief(goal, "gear-set", 6, 0)
    assert withdrawn(run_with_store(rig, rig.now_s + 3 * SETTLED_S, idle)) == []


def test_a_goal_of_parts_that_waits_for_the_auction_of_another_orders_is_put_up_when_that_order_is_taken_back() -> (
    None
):
    rig = bureau(6)
    rig.run(SETTLED_S)
    order(rig, "O2", 6)
    rig.run(rig.now_s + SETTLED_S)
    assert [of.partition("-")[0] for of, part, _ in announced(rig.all) if part == "gear-set"] == ["O1"]
    rig.on_message("gateway", OrderRevoked("O1", 1))
    rig.run(rig.now_s + PLAN_EVERY_S)
    assert [of.partition("-")[0] for of, part, _ in announced(rig.all) if part == "gear-set"] == ["O1", "O2"]
