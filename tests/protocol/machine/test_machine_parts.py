"""A machine and parts: those that it makes wait for whoever needs them, those that it uses come from wherever they lie."""

from __future__ import annotations

from effects import instructed, published, sent
from m7 import outgoing
from msgspec.structs import replace
from rigs import MachineRig
from spoken import announcement

from dray.body import CycleDone, OpenDock, StartCycle
from dray.memory import WHOLE, MachineMemory
from dray.messages import (
    Bid,
    Docked,
    GoalClosed,
    Production,
    StockAsked,
    StockReserved,
    StockShort,
    TaskAnnounced,
    TransportAnswered,
    TransportCancelled,
    TransportOrdered,
    TransportState,
)
from dray.messages.fact import BidRefused, PieceMade, PieceScrapped, SparePieceMade
from dray.plant import Plant
from dray.plant.file.file import shipped_plant
from dray.protocol.runtime.events import Commit, Record
from dray.protocol.strategist.definitions import definition_of

PLANT = shipped_plant("levels")


def goal(product: str, quantity: int, part_of: str = "") -> Production:
    return Production(product, quantity, "O1", 0, definition_of(PLANT.products[product]), part_of=part_of)


def lathe(quantity: int = 12) -> MachineRig:
    """A lathe with all the steel that it needs, and a goal of shafts for gearboxes."""
    rig = MachineRig("LATHE1", {"bar": 60}, plant=PLANT)
    rig.start()
    rig.take_goal("G1", goal("shaft", quantity, "gearbox"))
    return rig


def asked(rig: MachineRig, quantity: int, task: str = "PRESS1-1") -> list[object]:
    effects = rig.on_message("PRESS1", StockAsked(task, 1, "shaft", quantity))
    return [type(message) for message in sent(effects, StockReserved) + sent(effects, StockShort)]


def test_parts_are_not_sent_to_the_delivery_warehouse() -> None:
    rig = lathe()
    rig.cycles(12)
    assert outgoing(rig.all) == []
    assert [e.fact.made for e in rig.all if isinstance(e, Record) and isinstance(e.fact, PieceMade)][-1] == 12


def test_made_parts_are_set_aside_for_whoever_asks_and_fetched_once() -> None:
    rig = lathe()
    rig.cycles(5)
    assert asked(rig, 6) == [StockShort]
    effects = rig.cycle()
    assert [message.quantity for message in sent(effects, StockReserved)] == [6]
    assert asked(rig, 1, "PRESS2-1") == [StockShort]
    rig.on_message("CART1", Docked("PRESS1-1", 1, "LATHE1", "shaft", 6))
    assert [(dock.item, dock.quantity) for dock in instructed(rig.all, OpenDock)] == [("shaft", 6)]
    rig.stocked("shaft", -6, "CART1")
    assert asked(rig, 1, "PRESS2-1") == [StockShort]
    rig.run(rig.now_s + 11.0)
    [level] = [each for each in rig.reported_stock()[1] if each.item == "shaft"]
    assert (level.level, level.spare) == (0, 0)


def test_a_part_that_is_made_here_is_told_of_once() -> None:
    rig = MachineRig("LATHE1", {"bar": 60, "shaft": 5}, plant=PLANT)
    rig.start()
    rig.run(rig.now_s + 1.0)
    buffers, goods = rig.reported_stock()
    assert [each.item for each in buffers] == ["bar"]
    assert [(each.item, each.level) for each in goods] == [("shaft", 5)]


def test_parts_that_are_set_aside_serve_no_customers_goal() -> None:
    rig = lathe()
    rig.cycles(6)
    assert asked(rig, 6) == [StockReserved]
    rig.take_goal("G2", goal("shaft", 6), deadline_s=1.0)
    assert "G2" not in [
        e.fact.goal for e in rig.all if isinstance(e, Record) and isinstance(e.fact, PieceMade)
    ]


def test_a_goal_of_parts_takes_no_pieces_that_lie_there() -> None:
    rig = MachineRig("LATHE1", {"bar": 60, "shaft": 12}, plant=PLANT)
    rig.start()
    [bid] = sent(
        rig.on_message(
            "STRATEGIST", announcement(task="G1", coordinator="STRATEGIST", work=goal("shaft", 12, "gearbox"))
        ),
        Bid,
    )
    assert bid.cost.total_s == 12 * 30.0


def test_what_nobody_has_asked_for_goes_to_a_storage_when_no_more_is_made() -> None:
    rig = lathe()
    rig.cycles(11)
    assert sent(rig.all, TransportOrdered) == []
    rig.cycle()
    [order] = sent(rig.all, TransportOrdered)
    assert (order.source, order.item, order.quantity) == ("LATHE1", "shaft", 12)


def test_what_others_wait_for_stays() -> None:
    rig = lathe()
    rig.cycles(6)
    assert asked(rig, 12) == [StockShort]
    rig.cycles(6)
    assert sent(rig.all, TransportOrdered) == []


def test_a_part_that_nobody_fetches_leaves_room_for_the_others_of_its_machine() -> None:
    """What uses both may lack just the other one, and fetches no more of this one then."""
    rig = MachineRig("LATHE2", {"bar": 60, "blank": 60}, plant=PLANT)
    rig.start()
    rig.take_goal("G1", goal("shaft", 48, "gearbox"), deadline_s=1000.0)
    rig.take_goal("G2", goal("gear", 32, "gearbox"), deadline_s=2000.0)
    rig.cycles(36)
    made = [cycle.product for cycle in instructed(rig.all, StartCycle)]
    assert made == ["shaft"] * 20 + ["gear"] * 16
    rig.stocked("gear", -16, "CART1")
    assert [cycle.product for cycle in instructed(rig.all, StartCycle)][36:] == ["gear"]


def test_a_storage_that_fetches_nothing_is_let_go_and_the_next_one_asked() -> None:
    rig = lathe()
    rig.cycles(12)
    [order] = sent(rig.all, TransportOrdered)
    first = next(e.to for e in rig.all if getattr(e, "message", None) == order)
    rig.run(rig.now_s + 331.0)
    assert [message.transport for message in sent(rig.all, TransportCancelled)][:1] == [order.transport]
    rig.on_message(first, TransportAnswered(order.transport, TransportState.CANCELLED))
    rig.run(rig.now_s + 1.0)
    rig.on_message("STRATEGIST", GoalClosed("G1"))
    last = [(e.to, e.message) for e in rig.all if isinstance(getattr(e, "message", None), TransportOrdered)][
        -1
    ]
    assert last[0] != first
    assert last[1].transport != order.transport


def test_a_machine_of_which_nobody_wants_anything_asks_the_next_storage_by_itself() -> None:
    rig = lathe()
    rig.cycles(12)
    [order] = sent(rig.all, TransportOrdered)
    first = next(e.to for e in rig.all if getattr(e, "message", None) == order)
    rig.on_message("STRATEGIST", GoalClosed("G1"))
    rig.run(rig.now_s + 331.0)
    rig.on_message(first, TransportAnswered(order.transport, TransportState.CANCELLED))
    before = len(sent(rig.all, TransportOrdered))
    rig.run(rig.now_s + 25.0)
    assert len(sent(rig.all, TransportOrdered)) == before, "not at once: a storage may refuse at once"
    rig.run(rig.now_s + 10.0)
    assert sent(rig.all, TransportOrdered)[-1].transport != order.transport


def test_what_is_left_when_a_storage_has_fetched_something_is_put_away_too() -> None:
    rig = lathe()
    rig.cycles(12)
    [order] = sent(rig.all, TransportOrdered)
    first = next(e.to for e in rig.all if getattr(e, "message", None) == order)
    rig.on_message("STRATEGIST", GoalClosed("G1"))
    rig.on_message(first, TransportAnswered(order.transport, TransportState.DELIVERED))
    rig.run(rig.now_s + 35.0)
    assert sent(rig.all, TransportOrdered)[-1].transport != order.transport


def test_the_next_life_goes_on_with_what_it_has_asked_storages_for() -> None:
    rig = lathe()
    rig.cycles(12)
    [order] = sent(rig.all, TransportOrdered)
    notes = [e.note for e in rig.all if isinstance(e, Commit) and isinstance(e.note, MachineMemory)]
    again = MachineRig("LATHE1", {"bar": 48, "shaft": 12}, plant=PLANT, incarnation=2)
    again.memory = {WHOLE: notes[-1]}
    again.start()
    assert order in sent(again.all, TransportOrdered)


def test_a_user_asks_storages_and_makers_and_for_no_more_than_it_needs() -> None:
    rig = MachineRig("PRESS1", {"gear": 48, "bearing": 120}, plant=PLANT, stations_answer=False)
    rig.start()
    rig.take_goal("G1", goal("gear-set", 3, "gearbox"))
    requests = [
        (e.to, e.message.quantity) for e in rig.all if isinstance(getattr(e, "message", None), StockAsked)
    ]
    assert set(requests) == {("PARTS", 3), ("SETS", 3), ("LATHE1", 3), ("LATHE2", 3)}


def test_a_user_that_has_waited_takes_what_there_is() -> None:
    rig = MachineRig("PRESS1", {"gear": 48, "bearing": 120}, plant=PLANT, stations_answer=False)
    rig.start()
    rig.take_goal("G1", goal("gear-set", 3, "gearbox"))
    for _ in range(4):
        task = sent(rig.all, StockAsked)[0].task
        for place, free in (("PARTS", 2), ("SETS", 0), ("LATHE1", 0), ("LATHE2", 0)):
            rig.on_message(place, StockShort(task, 1, "shaft", free))
        rig.run(rig.now_s + 10.0)
    assert sent(rig.all, StockAsked)[-1].quantity == 2


def test_a_user_takes_no_less_while_others_of_that_part_wait_for_a_carrier() -> None:
    rig = MachineRig("PRESS1", {"gear": 48, "bearing": 120}, plant=PLANT, stations_answer=False)
    rig.start()
    rig.take_goal("G1", goal("gear-set", 60, "gearbox"))

    def wait_for_shafts() -> StockAsked:
        """Half a minute in which nobody has more than one. Returns what is asked for then."""
        for _ in range(4):
            [task] = {need.task for need in sent(rig.all, StockAsked) if need.task not in announced}
            for place, free in (("PARTS", 1), ("SETS", 0), ("LATHE1", 0), ("LATHE2", 0)):
                rig.on_message(place, StockShort(task, 1, "shaft", free))
            rig.run(rig.now_s + 10.0)
        return sent(rig.all, StockAsked)[-1]

    announced: set[str] = set()
    first = wait_for_shafts()
    assert first.quantity == 1
    announced.add(first.task)
    rig.on_message("PARTS", StockReserved(first.task, 1, "shaft", 1))
    rig.stocked("gear", 1)
    assert {each.task for each in published(rig.all, TaskAnnounced)} == announced
    lot = sent(rig.all, StockAsked)[-1].quantity
    second = wait_for_shafts()
    assert (second.task != first.task, second.quantity) == (True, lot)
    assert lot > 1
    rig.hire(first.task, "CART1")
    assert wait_for_shafts().quantity == 1


def test_parts_that_no_goal_takes_any_more_go_back_to_a_storage() -> None:
    rig = MachineRig("PRESS1", {"gear": 48, "bearing": 120, "shaft": 5}, plant=PLANT)
    rig.start()
    rig.run(1.0)
    assert {(order.item, order.quantity) for order in sent(rig.all, TransportOrdered)} >= {("shaft", 5)}


def test_what_the_running_cycle_has_taken_is_not_kept_from_others_once_more() -> None:
    rig = MachineRig("PRESS1", {"gear": 2, "bearing": 2, "shaft": 2}, plant=PLANT)
    rig.start()
    rig.take_goal("G1", goal("gear-set", 1, "gearbox"))
    assert instructed(rig.all, StartCycle)
    effects = rig.on_message("SETS", StockAsked("T-1", 1, "shaft", 1))
    assert (len(sent(effects, StockReserved)), sent(effects, StockShort)) == (1, [])
    effects = rig.on_message("CART1", Docked("T-1", 1, "PRESS1", "shaft", 1))
    assert sent(effects, StockShort) == []
    assert [(dock.item, dock.quantity) for dock in instructed(effects, OpenDock)] == [("shaft", 1)]


def test_a_bad_piece_is_told_and_made_again() -> None:
    rig = lathe(2)
    rig.seq += 1
    rig._cycles += 1
    effects = rig.report(CycleDone("shaft", rig.seq, bad=True))
    assert [e.fact for e in effects if isinstance(e, Record) and isinstance(e.fact, PieceScrapped)] == [
        PieceScrapped("shaft", "G1")
    ]
    rig.cycles(2)
    assert len(instructed(rig.all, StartCycle)) == 3
    assert rig.stock["bar"] == 57


def test_every_good_piece_is_told_once_and_what_lay_there_is_told_as_such() -> None:
    rig = lathe(2)
    rig.take_goal("G2", goal("shaft", 3))
    rig.on_message("STRATEGIST", GoalClosed("G1"))
    rig.on_message("STRATEGIST", GoalClosed("G2"))
    rig.cycle()
    told = [effect.fact for effect in rig.all if isinstance(effect, Record)]
    assert [fact for fact in told if isinstance(fact, SparePieceMade)] == [SparePieceMade("shaft")]
    rig.take_goal("G3", goal("shaft", 3))
    last = [e.fact for e in rig.all if isinstance(e, Record) and isinstance(e.fact, PieceMade)]
    assert last == [PieceMade("G3", "shaft", 1, from_stock=True)]
    rig.cycle()
    last = [e.fact for e in rig.all if isinstance(e, Record) and isinstance(e.fact, PieceMade)]
    assert last[-1] == PieceMade("G3", "shaft", 2)


def test_a_machine_refuses_to_use_what_it_makes() -> None:
    machines = tuple(
        replace(each, makes=(*each.makes, *PLANT.file.machines[5].makes)) if each.id == "LATHE1" else each
        for each in PLANT.file.machines
    )
    rig = MachineRig("LATHE1", plant=Plant(replace(PLANT.file, machines=machines)))
    rig.start()
    rig.on_message(
        "STRATEGIST", announcement(task="G1", coordinator="STRATEGIST", work=goal("gear-set", 6, "gearbox"))
    )
    refused = [e.fact.detail for e in rig.all if isinstance(e, Record) and isinstance(e.fact, BidRefused)]
    assert refused == ["makes shaft itself"]
