"""Vehicles that may take a load from a dock whose body does not count (`transports.visits`).

The load is booked out once: when its vehicle has it, or in doubt.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from dock_parts import blind_dock
from effects import instructed, listening, sent
from lathe1 import CART, LEVELS, SIX_SHAFTS, TASK, at_the_dock, before_a_shut_dock, lathe, opens
from m7 import NO_HOUSINGS
from msgspec.structs import replace
from next_life import next_life
from rigs import BlindRig, MachineRig
from spoken import rhb

from dray.body import Book, CloseDock, DockReady, OpenDock
from dray.memory import DepartureMemory
from dray.messages import (
    Docked,
    DockHeld,
    DockOpened,
    Phase,
    StockAsked,
    StockFreed,
    StockReserved,
    StockShort,
)
from dray.messages.keys import Keys
from dray.protocol.runtime.events import Effect, Instruct
from dray.protocol.runtime.life import Life
from dray.protocol.transports.transports import RECOVERY_WAIT_S
from dray.protocol.transports.visit import UNHEARD_S
from dray.protocol.transports.visits import Visits

DOCK = LEVELS.node_of("LATHE1")
OUT = Book(CART, "shaft", -6, task=TASK, epoch=1)
SHUT = [CloseDock(vehicle=CART)]


def beats(
    rig: MachineRig, phase: Phase, *, task: str = TASK, epoch: int = 1, aboard: str = "", node: str = ""
) -> list[Effect]:
    """The cart tells what it does."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s, task=task, coordinator="PRESS1")
    assert beat.task is not None
    beat = replace(beat, load=aboard, load_quantity=6 if aboard else 0, node=node or beat.node)
    return rig.on_message(CART, replace(beat, task=replace(beat.task, phase=phase, epoch=epoch)))


def stands_there(
    rig: MachineRig, *, aboard: str = "", node: str = DOCK, left_empty: str = ""
) -> list[Effect]:
    """The cart tells that it has no task."""
    rig.run(rig.now_s + 1.0)
    beat = replace(rhb(CART, 1000 + int(rig.now_s), rig.now_s), node=node, left_empty=left_empty)
    return rig.on_message(CART, replace(beat, load=aboard, load_quantity=6 if aboard else 0))


def works_elsewhere(
    rig: MachineRig, *, aboard: str = "shaft", node: str = "elsewhere", left_empty: str = ""
) -> list[Effect]:
    """The cart tells that it works for another press."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s, task="PRESS2-7", coordinator="PRESS2")
    beat = replace(beat, node=node, left_empty=left_empty)
    return rig.on_message(CART, replace(beat, load=aboard, load_quantity=6 if aboard else 0))


def lies_there(rig: MachineRig) -> tuple[int, int | None]:
    """Shafts, and how many of them are spare, by its heartbeat."""
    rig.run(rig.now_s + 11.0)
    [level] = [each for each in rig.reported_stock()[1] if each.item == "shaft"]
    return level.level, level.spare


def test_a_load_is_booked_out_once_its_vehicle_has_it() -> None:
    rig = at_the_dock()
    assert instructed(beats(rig, Phase.LOADING), Book) == []
    assert instructed(beats(rig, Phase.CARRYING), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    assert instructed(beats(rig, Phase.UNLOADING), Book) == []
    assert lies_there(rig) == (6, 6)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 6)), StockReserved)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-2", 1, "shaft", 1)), StockShort)


def test_the_vehicle_is_listened_to_from_the_dock_until_it_has_told() -> None:
    rig, key = at_the_dock(), Keys(LEVELS.id).atv_heartbeat(CART)
    assert key in listening(rig.all)
    beats(rig, Phase.CARRYING)
    assert key not in listening(rig.all)


def test_a_vehicle_that_leaves_without_the_load_has_taken_nothing() -> None:
    rig = at_the_dock()
    beats(rig, Phase.APPROACHING, task="PRESS2-7")
    assert instructed(beats(rig, Phase.CARRYING), Book) == []
    assert lies_there(rig) == (12, 12)


@pytest.mark.parametrize(("aboard", "booked"), [("shaft", [OUT]), ("bar", [])])
def test_a_vehicle_that_leaves_for_another_task_with_such_a_load_on_board_has_taken_it(
    aboard: str, booked: list[Book]
) -> None:
    assert instructed(beats(at_the_dock(), Phase.APPROACHING, task="PRESS2-7", aboard=aboard), Book) == booked


def test_another_epoch_of_its_task_is_another_load() -> None:
    assert instructed(beats(at_the_dock(), Phase.CARRYING, epoch=2), Book) == []


def test_a_load_that_was_given_back_while_it_was_taken_is_booked_out_all_the_same() -> None:
    rig = at_the_dock()
    rig.on_message("PRESS1", StockFreed(TASK))
    assert instructed(beats(rig, Phase.RETURNING), Book) == [OUT]


def test_a_life_that_begins_while_a_vehicle_loads_books_its_load_out() -> None:
    rig = next_life(at_the_dock())
    assert instructed(beats(rig, Phase.CARRYING), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    assert lies_there(rig) == (6, 6)


def test_what_was_booked_before_a_kill_and_is_told_again_takes_nothing_twice() -> None:
    first = at_the_dock()
    # It was killed after its body had booked: the stock tells of it, its own notes do not.
    first.seq, first.stock["shaft"] = 1, 6
    rig = next_life(first)
    beats(rig, Phase.CARRYING)
    rig.seq, rig.stock["shaft"] = 0, 12
    rig.stocked("shaft", -6, CART)  # The body answers as it did before, with the number of then.
    assert lies_there(rig) == (6, 6)


def test_a_body_that_counts_is_told_nothing() -> None:
    assert instructed(beats(at_the_dock(lathe(MachineRig)), Phase.CARRYING), Book) == []


def test_a_vehicle_that_comes_for_a_second_load_unheard_has_taken_the_first() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    effects = rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4))
    told = [effect.instruction for effect in effects if isinstance(effect, Instruct)]
    assert told == [OUT, OpenDock(CART, "shaft", 4)]  # A body shuts its dock when it books.
    second = Book(CART, "shaft", -4, task="PRESS2-1", epoch=1)
    assert instructed(beats(rig, Phase.CARRYING, task="PRESS2-1"), Book) == [second]


def test_a_vehicle_that_was_heard_at_the_dock_and_asks_for_another_load_has_not_taken_the_first() -> None:
    rig = at_the_dock()
    beats(rig, Phase.LOADING)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    assert instructed(rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4)), Book) == []


def test_a_dock_that_takes_time_to_open_is_not_shut_between_two_loads_of_which_the_first_was_not_taken() -> (
    None
):
    rig = before_a_shut_dock()
    opens(rig)
    beats(rig, Phase.LOADING)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    effects = rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4))
    told = [effect.instruction for effect in effects if isinstance(effect, Instruct)]
    assert told == [OpenDock(CART, "shaft", 4)]


@pytest.mark.parametrize("silent_s", [0.0, 60.0], ids=["heard", "not heard"])
@pytest.mark.parametrize("is_given_back", [False, True])
def test_a_vehicle_that_stands_there_without_a_task_may_still_be_loading(
    silent_s: float, *, is_given_back: bool
) -> None:
    rig = at_the_dock()
    if is_given_back:
        rig.on_message("PRESS1", StockFreed(TASK))
    rig.run(rig.now_s + silent_s)
    assert instructed(stands_there(rig), Book) == []
    assert instructed(stands_there(rig, aboard="shaft"), Book) == [OUT]


def test_a_vehicle_that_has_stood_there_without_a_task_and_leaves_empty_has_taken_nothing() -> None:
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    stands_there(rig)
    effects = stands_there(rig, node="elsewhere")
    assert (instructed(effects, Book), sent(effects, StockReserved)) == ([], [])
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == []


@pytest.mark.parametrize(("is_heard", "told"), [(True, SHUT), (False, [])])
def test_a_body_hears_once_more_when_a_vehicle_whose_load_was_given_back_has_left_without(
    is_heard: bool, told: list[CloseDock]
) -> None:
    rig = at_the_dock()
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK)), CloseDock) == SHUT
    rig.run(rig.now_s + (1.0 if is_heard else 2 * UNHEARD_S))
    effects = stands_there(rig, node="elsewhere")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (told, [])


def test_who_is_not_wanted_after_it_has_left_without_its_load_is_told_to_have_left() -> None:
    rig = at_the_dock()
    assert instructed(stands_there(rig, node="elsewhere"), CloseDock) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK)), CloseDock) == SHUT
    assert instructed(stands_there(rig, node="elsewhere"), CloseDock) == SHUT


# --- at a dock that opens later ---


@pytest.mark.parametrize("aboard", ["", "shaft"])
def test_a_vehicle_that_ends_its_task_before_the_dock_opens_takes_nothing(aboard: str) -> None:
    rig = before_a_shut_dock()
    stands_there(rig)
    opens(rig)
    stands_there(rig)
    rig.run(rig.now_s + 60.0)
    effects = stands_there(rig, aboard=aboard, node="elsewhere")
    assert (instructed(effects, Book), sent(effects, StockReserved)) == ([], [])
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == []


def test_the_next_life_knows_that_a_vehicle_has_ended_its_task_before_the_dock_opened() -> None:
    first = before_a_shut_dock()
    stands_there(first)
    rig = next_life(first, opened=(CART,))
    rig.run(rig.now_s + 60.0)
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 4)), StockReserved)
    effects = rig.on_message(CART, Docked("PRESS2-1", 1, "LATHE1", "shaft", 4))
    assert (instructed(effects, Book), len(instructed(effects, OpenDock))) == ([], 1)


def test_the_dock_is_shut_for_a_vehicle_that_was_let_in_and_is_elsewhere_for_another_task() -> None:
    rig = before_a_shut_dock()
    opens(rig)
    beats(rig, Phase.LOADING)
    late = replace(rhb(CART, 1, rig.now_s), node="elsewhere")
    assert instructed(rig.on_message(CART, late), CloseDock) == []
    effects = stands_there(rig, node="elsewhere")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_the_dock_does_not_open_for_a_vehicle_that_has_waited_for_it_and_is_elsewhere() -> None:
    rig = before_a_shut_dock()
    stands_there(rig)
    assert instructed(stands_there(rig, node="elsewhere"), CloseDock) == SHUT
    assert sent(rig.report(DockReady(vehicle=CART)), DockOpened) == []


def test_the_dock_stays_open_for_a_load_that_is_given_back_while_it_is_taken_until_its_vehicle_has_left() -> (
    None
):
    rig = before_a_shut_dock()
    opens(rig)
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK)), CloseDock) == []
    assert instructed(beats(rig, Phase.LOADING, node=DOCK), CloseDock) == []
    assert instructed(beats(rig, Phase.RETURNING, node="elsewhere"), CloseDock) == SHUT


def test_a_vehicle_that_asks_for_the_dock_for_something_else_is_done_though_it_has_to_wait() -> None:
    rig = before_a_shut_dock()
    opens(rig)
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK)), CloseDock) == []
    rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 12))
    effects = rig.on_message(CART, Docked("PRESS3-1", 1, "LATHE1", "shaft", 6))
    assert sent(effects, DockHeld, to=CART)
    assert instructed(effects, CloseDock) == SHUT


def test_who_has_loaded_is_inside_no_more_once_that_is_booked() -> None:
    rig = before_a_shut_dock()
    opens(rig)
    assert instructed(beats(rig, Phase.CARRYING, node=DOCK, aboard="shaft"), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    # Its next load here is given back before the dock was made ready for it: nobody waits for it to leave.
    rig.on_message("PRESS1", StockAsked("PRESS1-2", 1, "shaft", 6))
    rig.on_message(CART, Docked("PRESS1-2", 1, "LATHE1", "shaft", 6))
    assert instructed(rig.on_message("PRESS1", StockFreed("PRESS1-2")), CloseDock) == SHUT


def test_a_vehicle_whose_heartbeat_from_elsewhere_has_come_late_asks_again_and_is_let_in() -> None:
    rig = before_a_shut_dock()
    late = replace(rhb(CART, 1, rig.now_s), node="elsewhere")
    assert instructed(rig.on_message(CART, late), CloseDock) == SHUT
    assert instructed(rig.on_message(CART, SIX_SHAFTS), OpenDock)
    opens(rig)


@pytest.mark.parametrize("asks", [False, True])
def test_a_vehicle_that_asks_or_names_its_task_again_may_load_after_all(*, asks: bool) -> None:
    rig = before_a_shut_dock()
    stands_there(rig)  # A heartbeat of before, which has come late.
    if asks:
        rig.on_message(CART, SIX_SHAFTS)
    else:
        beats(rig, Phase.LOADING)
    opens(rig)
    rig.run(rig.now_s + 60.0)
    assert sent(stands_there(rig, node="elsewhere"), StockReserved, to="PRESS1")


@pytest.mark.parametrize("life", ["this", "the next", "the next without notes"])
def test_a_vehicle_that_was_let_in_and_asks_again_may_load_still_when_it_has_no_task_any_more(
    life: str,
) -> None:
    rig = before_a_shut_dock()
    opens(rig)
    if life != "this":
        rig = next_life(rig, opened=(CART,), memory={} if "without notes" in life else None)
    # Its body loads while its agent is started again, and is released before the dock is ready once more.
    rig.on_message("PRESS1", StockAsked(TASK, 1, "shaft", 6))
    assert instructed(rig.on_message(CART, SIX_SHAFTS), OpenDock)
    stands_there(rig)
    rig.run(rig.now_s + 60.0)
    assert instructed(stands_there(rig, aboard="shaft", node="elsewhere"), Book) == [OUT]


def test_what_a_vehicle_has_on_board_before_the_dock_opens_is_not_from_here() -> None:
    rig = before_a_shut_dock()
    assert instructed(stands_there(rig, aboard="shaft"), Book) == []
    opens(rig)
    # It stands here still, and has such a load: in doubt it is booked out.
    assert instructed(stands_there(rig, aboard="shaft"), Book) == [OUT]


# --- a vehicle whose agent has lost its memory there, and whose body goes on ---


def leaving(life: Life) -> Visits:
    """The cart was let in for six shafts, and its permission has ended."""
    _, visits = blind_dock(DOCK, life)
    visits.restore([DepartureMemory(CART, TASK, 1, "shaft", -6)])
    return visits


def loads(visits: Visits, *, life: int, at_s: float, names: bool = False) -> None:
    """The cart loads at the dock; only a life that remembers it names the task."""
    beat = rhb(CART, int(at_s) + 1, at_s, task=TASK if names else "", coordinator="PRESS1")
    doing = None if beat.task is None else replace(beat.task, phase=Phase.LOADING)
    visits.on_vehicle(replace(beat, node=DOCK, incarnation=life, task=doing), at_s)


def goes(visits: Visits, *, life: int, at_s: float, aboard: bool, node: str = "elsewhere") -> None:
    """The cart goes away without the task; it brings back what it has found on board."""
    beat = rhb(CART, int(at_s) + 1, at_s, task=f"{CART}-found-7" if aboard else "")
    doing = None if beat.task is None else replace(beat.task, phase=Phase.RETURNING)
    beat = replace(beat, load="shaft" if aboard else "", load_quantity=6 if aboard else 0)
    visits.on_vehicle(replace(beat, node=node, incarnation=life, task=doing), at_s)


@pytest.mark.parametrize("is_restarted", [False, True], ids=["this life", "the next life"])
@pytest.mark.parametrize("lives", [(2,), (2, 3)], ids=["one loss", "two losses"])
@pytest.mark.parametrize(("aboard", "booked"), [(True, [OUT]), (False, [])])
def test_the_body_of_a_vehicle_that_lost_its_memory_may_go_on_loading(
    lives: tuple[int, ...], *, aboard: bool, booked: list[Book], is_restarted: bool
) -> None:
    life = Life()
    visits = leaving(life)
    if not is_restarted:
        loads(visits, life=1, at_s=0.0, names=True)
    for each in lives:
        loads(visits, life=each, at_s=1.0)
        loads(visits, life=each, at_s=6.0)
    if aboard:
        goes(visits, life=lives[-1], at_s=11.0, aboard=True, node=DOCK)
    assert instructed(life.effects, CloseDock) == []
    goes(visits, life=lives[-1], at_s=12.0, aboard=aboard)
    assert (instructed(life.effects, CloseDock), instructed(life.effects, Book)) == (SHUT, booked)


def test_a_vehicle_that_lost_its_memory_and_brings_the_found_load_back_at_once_has_taken_it() -> None:
    life = Life()
    visits = leaving(life)
    loads(visits, life=1, at_s=0.0, names=True)
    goes(visits, life=2, at_s=1.0, aboard=True, node=DOCK)
    assert instructed(life.effects, CloseDock) == []
    goes(visits, life=2, at_s=2.0, aboard=True)
    assert instructed(life.effects, Book) == [OUT]


def test_a_vehicle_that_has_ended_its_task_at_the_dock_does_not_load_there_any_more() -> None:
    life = Life()
    visits = leaving(life)
    loads(visits, life=1, at_s=0.0, names=True)
    loads(visits, life=1, at_s=1.0)
    assert (instructed(life.effects, CloseDock), instructed(life.effects, Book)) == (SHUT, [])


@pytest.mark.parametrize("aboard", ["", "shaft"])
@pytest.mark.parametrize("tells", [stands_there, works_elsewhere])
def test_a_vehicle_that_left_empty_after_it_had_lost_its_memory_here_has_not_fetched_its_load(
    tells: Callable[..., list[Effect]], aboard: str
) -> None:
    rig = next_life(at_the_dock())
    effects = tells(rig, node="elsewhere", aboard=aboard, left_empty=DOCK)
    assert (instructed(effects, Book), sent(effects, StockReserved)) == ([], [])
    assert instructed(works_elsewhere(rig), Book) == []
    assert lies_there(rig)[0] == 12


def test_a_vehicle_that_says_so_after_its_coordinator_was_asked_has_not_fetched_its_load() -> None:
    rig = after_a_trip()
    assert instructed(works_elsewhere(rig, aboard="", left_empty=DOCK), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == []


# --- a life without notes, whose body remembers what it has let in ---


def without_notes(item: str = "shaft", *, before: MachineRig | None = None) -> MachineRig:
    """The lathe's agent has lost its notes while the cart was let in."""
    if before is None:
        before = lathe()
        before.answers = True
    return next_life(before, opened=(CART,), let_in=OpenDock(CART, item, 6), memory={})


UNNOTED = Book(CART, "shaft", -6, task="", epoch=2)


def test_in_doubt_a_life_without_notes_books_out_what_its_body_has_let_a_vehicle_take() -> None:
    rig = without_notes()
    assert instructed(stands_there(rig, node="elsewhere"), Book) == [UNNOTED]
    rig.stocked("shaft", -6, CART)
    assert lies_there(rig) == (6, 6)


def test_a_life_without_notes_books_out_what_the_vehicle_leaves_with() -> None:
    rig = without_notes()
    assert instructed(beats(rig, Phase.LOADING, node=DOCK), Book) == []
    assert instructed(beats(rig, Phase.LOADING, node=DOCK), Book) == []
    assert instructed(beats(rig, Phase.CARRYING, node=DOCK, aboard="shaft"), Book) == [UNNOTED]


def test_what_leaves_with_its_task_s_name_is_booked_out_once_though_the_body_remembers_it() -> None:
    rig = without_notes()
    beat = rhb(CART, 1000, rig.now_s, task=TASK, coordinator="PRESS1")
    assert beat.task is not None
    carries = replace(beat.task, phase=Phase.CARRYING, item="shaft", quantity=6)
    beat = replace(beat, task=carries, node=DOCK, load="shaft", load_quantity=6)
    assert instructed(rig.on_message(CART, beat), Book) == [UNNOTED]
    assert instructed(rig.on_message(CART, replace(beat, seq=1001)), Book) == []
    rig.stocked("shaft", -6, CART)
    assert instructed(rig.on_message(CART, replace(beat, seq=1002)), Book) == []


def test_a_life_without_notes_books_nothing_out_for_a_vehicle_that_it_saw_leave_without() -> None:
    rig = without_notes()
    stands_there(rig)
    assert instructed(stands_there(rig, node="elsewhere"), Book) == []
    assert instructed(stands_there(rig, node="elsewhere", aboard="shaft"), Book) == []


def test_a_life_without_notes_knows_that_a_vehicle_without_memory_has_left_empty() -> None:
    assert instructed(works_elsewhere(without_notes(), left_empty=DOCK), Book) == []


def test_a_life_without_notes_books_no_material_out_that_a_vehicle_may_have_brought() -> None:
    assert instructed(stands_there(without_notes("bar"), node="elsewhere"), Book) == []


def test_who_asks_a_life_without_notes_again_has_not_taken_its_load() -> None:
    rig = without_notes()
    rig.on_message("PRESS1", StockAsked(TASK, 1, "shaft", 6))
    assert instructed(rig.on_message(CART, SIX_SHAFTS), Book) == []


def test_the_life_after_one_without_notes_goes_on_with_what_that_followed() -> None:
    first = without_notes()
    stands_there(first)
    rig = next_life(first, opened=(CART,), let_in=first.let_in)
    assert lies_there(rig) == (12, 12)
    assert instructed(stands_there(rig, node="elsewhere"), Book) == [UNNOTED]


@pytest.mark.parametrize(
    ("coordinator", "item", "phase", "node", "opened", "listens", "booked"),
    [
        ("M7", "pump-p3", Phase.CARRYING, "m7", ("ATV2",), True, True),
        ("M7", "pump-p3", Phase.CARRYING, "m7", ("ATV2",), False, True),
        ("S1", "pump-p3", Phase.CARRYING, "m7", ("ATV2",), True, True),
        ("M7", "housing", Phase.CARRYING, "m7", ("ATV2",), True, False),
        ("S1", "seal-kit", Phase.CARRYING, "m7", ("ATV2",), True, False),
        ("S1", "pump-p3", Phase.UNLOADING, "m7", ("ATV2",), True, False),
        ("M7", "pump-p3", Phase.CARRYING, "c1", ("ATV2",), True, False),
        ("M7", "pump-p3", Phase.CARRYING, "m7", (), True, False),
    ],
    ids=[
        "goods",
        "later",
        "another-s",
        "comes",
        "more-than-there",
        "brings",
        "elsewhere",
        "not-let-in",
    ],
)
def test_what_left_through_the_open_dock_while_the_notes_were_lost_is_booked_out_once(
    coordinator: str,
    item: str,
    phase: Phase,
    node: str,
    opened: tuple[str, ...],
    *,
    listens: bool,
    booked: bool,
) -> None:
    rig = BlindRig("M7", NO_HOUSINGS | {"pump-p3": 8, "housing": 8, "seal-kit": 0}, incarnation=2)
    rig.answers, rig.opened = True, opened
    rig.start()
    rig.run(rig.now_s + (0.0 if listens else 2 * RECOVERY_WAIT_S))
    beat = rhb("ATV2", 1000, rig.now_s, task="M7-1", coordinator=coordinator)
    assert beat.task is not None
    carries = replace(beat.task, phase=phase, item=item, quantity=8)
    beat = replace(beat, task=carries, node=node, load=item, load_quantity=8)
    out = [Book("ATV2", item, -8, task="M7-1", epoch=1)] if booked else []
    assert instructed(rig.on_message("ATV2", beat), Book) == out
    assert instructed(rig.on_message("ATV2", replace(beat, seq=1001)), Book) == []


# --- after a time in which the vehicle was not heard ---


def after_a_trip() -> MachineRig:
    """The lathe's agent was down while the cart has loaded; it works at something else by now."""
    rig = next_life(at_the_dock())
    effects = beats(rig, Phase.APPROACHING, task="PRESS2-7")
    assert sent(effects, StockReserved, to="PRESS1") == [StockReserved(TASK, 1, "shaft", 6)]
    assert instructed(effects, Book) == []
    return rig


def after_a_silence() -> MachineRig:
    """The lathe's agent has not heard the cart for a while; it works at something else by now."""
    rig = at_the_dock()
    rig.run(rig.now_s + 60.0)
    assert sent(works_elsewhere(rig, aboard=""), StockReserved, to="PRESS1")
    return rig


@pytest.mark.parametrize("unheard", [after_a_trip, after_a_silence])
def test_a_load_that_its_coordinator_knows_to_be_fetched_is_booked_out(
    unheard: Callable[[], MachineRig],
) -> None:
    rig = unheard()
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == [OUT]
    rig.stocked("shaft", -6, CART)
    assert lies_there(rig) == (6, 6)


def test_a_load_that_was_not_fetched_while_the_agent_was_down_lies_there_still() -> None:
    rig = after_a_trip()
    assert instructed(rig.on_message("PRESS2", StockFreed(TASK, fetched=True)), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK)), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == []
    assert lies_there(rig)[0] == 12


def test_a_load_of_an_earlier_epoch_is_booked_out_while_its_task_goes_on_and_keeps_what_was_promised() -> (
    None
):
    rig = after_a_trip()
    assert sent(rig.on_message("PRESS1", StockAsked(TASK, 2, "shaft", 6)), StockReserved)
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True, epoch=2)), Book) == []
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True, epoch=1)), Book) == [OUT]
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 7)), StockShort)


def test_a_load_that_an_earlier_carrier_has_not_fetched_stays_promised_to_its_task() -> None:
    rig = after_a_trip()
    assert sent(rig.on_message("PRESS1", StockAsked(TASK, 2, "shaft", 6)), StockReserved)
    for _ in range(2):
        assert instructed(rig.on_message("PRESS1", StockFreed(TASK, epoch=1)), Book) == []
    assert sent(rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 7)), StockShort)


def test_the_coordinator_is_asked_until_it_answers_and_no_oftener_than_it_needs() -> None:
    rig = after_a_trip()
    asked = [
        each
        for _ in range(25)
        for each in sent(beats(rig, Phase.APPROACHING, task="PRESS2-7"), StockReserved)
    ]
    assert len(asked) == 2


def test_what_a_vehicle_has_on_board_after_it_was_heard_elsewhere_without_is_not_from_here() -> None:
    rig = after_a_silence()
    assert instructed(works_elsewhere(rig), Book) == []
    # It passes by, and stands here without a task: its body has not gone on loading.
    assert instructed(stands_there(rig, aboard="shaft"), Book) == []
    # Neither does the next life take it for that.
    second = next_life(rig)
    effects = works_elsewhere(second)
    assert (instructed(effects, Book), len(sent(effects, StockReserved, to="PRESS1"))) == ([], 1)
    assert instructed(second.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == [OUT]


def test_a_vehicle_that_was_heard_elsewhere_and_names_the_task_with_its_load_has_fetched_it() -> None:
    assert instructed(beats(after_a_silence(), Phase.CARRYING), Book) == [OUT]


def test_a_vehicle_that_was_heard_elsewhere_and_is_let_in_again_may_take_a_load() -> None:
    rig = after_a_silence()
    rig.on_message(CART, SIX_SHAFTS)
    assert instructed(rig.on_message("PRESS1", StockFreed(TASK, fetched=True)), Book) == []  # A late answer.
    assert instructed(stands_there(rig, aboard="shaft"), Book) == [OUT]


@pytest.mark.parametrize("left_empty", ["", "m8"], ids=["nothing told", "told of another dock"])
def test_where_nobody_can_be_asked_a_load_is_booked_out_in_doubt(left_empty: str) -> None:
    life = Life()
    leaving(life).on_vehicle(replace(rhb(CART, 1, 0.0), left_empty=left_empty), 0.0)
    assert instructed(life.effects, Book) == [OUT]


@pytest.mark.parametrize("change", [6, -6])
def test_where_the_dock_opens_at_once_the_next_life_books_what_is_taken_in_doubt_and_nothing_in(
    change: int,
) -> None:
    life = Life()
    door, visits = blind_dock(DOCK, life)
    visits.restore_opened((CART,))
    door.shut(CART, TASK, DepartureMemory(CART, TASK, 1, "shaft", change))
    assert instructed(life.effects, CloseDock) == SHUT
    # It names the task no more.
    visits.on_vehicle(rhb(CART, 1, 0.0), 0.0)
    assert instructed(life.effects, Book) == ([OUT] if change < 0 else [])
    assert instructed(life.effects, CloseDock) == 2 * SHUT
