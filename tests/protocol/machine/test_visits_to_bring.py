"""Vehicles that may put a load down at a dock whose body does not count (`transports.visits`).

A dock that makes itself safe stays open until the vehicle at it has left, whatever becomes of its transport meanwhile. The load is
booked in once: on the word of its vehicle, or by what that does when it leaves.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from defaults import PLANT
from dock_parts import blind_dock
from effects import instructed, listening, sent
from m7 import NO_HOUSINGS, docked, handover, hiring, supplied_by, unloading
from msgspec.structs import replace
from next_life import next_life
from rigs import BlindRig, MachineRig
from seals import FOR_EVER_S, seal
from spoken import production, rhb

from dray.adapters.security.signing import is_signed
from dray.body import Book, CloseDock, DockReady, OpenDock
from dray.memory import DepartureMemory
from dray.messages import (
    Docked,
    DockOpened,
    Grant,
    HandoverAccepted,
    Phase,
    Reason,
    Removal,
    Removals,
    Resigned,
    Role,
    StockAsked,
    Superseded,
)
from dray.messages.floor.removal import removed_words
from dray.messages.keys import Keys
from dray.protocol.runtime.events import Effect
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.removal_authorisation import LISTEN_S
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.transports.visit import UNHEARD_S

DOCK, CART = "m7", "ATV2"
GIVES_BACK = Resigned(task="M7-1", epoch=1, role=Role.PRIMARY, reason=Reason.PROBLEM)
SHUT = [CloseDock(vehicle=CART)]
BROUGHT = [Book(CART, "housing", 24, task="M7-1", epoch=1)]
LOAD = DepartureMemory(CART, "M7-1", 1, "housing", 24)


def given_back(rig: MachineRig | None = None) -> MachineRig:
    """ATV2 has given its transport back while it unloads."""
    rig = unloading(rig)
    effects = rig.on_message(CART, GIVES_BACK)
    assert sent(effects, Superseded, to=CART)
    assert instructed(effects, CloseDock) == []
    return rig


def beats(
    rig: MachineRig,
    phase: Phase | None,
    *,
    node: str = DOCK,
    aboard: bool = False,
    task: str = "M7-1",
    before: int = 0,
) -> list[Effect]:
    """ATV2 tells what it does; `before`: so many heartbeats ago."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s) - before, rig.now_s, task=task, coordinator="M7")
    assert beat.task is not None
    doing = None if phase is None else replace(beat.task, phase=phase, item="housing", quantity=24)
    load = ("housing", 24) if aboard else ("", 0)
    return rig.on_message(CART, replace(beat, task=doing, node=node, load=load[0], load_quantity=load[1]))


def test_a_vehicle_that_goes_away_with_its_load_has_the_dock_until_it_has_left() -> None:
    rig = given_back()
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), CloseDock) == []
    assert instructed(beats(rig, Phase.RETURNING, aboard=True), CloseDock) == []
    effects = beats(rig, Phase.RETURNING, node="c1", aboard=True)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_what_a_superseded_vehicle_has_put_down_all_the_same_is_booked() -> None:
    rig = given_back()
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), Book) == []
    effects = beats(rig, None)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, BROUGHT)
    assert instructed(beats(rig, None), CloseDock) == []


def test_a_vehicle_that_names_another_task_has_ended_this_one() -> None:
    rig = given_back()
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), CloseDock) == []
    # It loads the same for another one.
    effects = beats(rig, Phase.LOADING, task="M8-1", aboard=True)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, BROUGHT)


def test_a_load_that_somebody_takes_off_a_vehicle_on_its_way_back_was_not_put_down_here() -> None:
    rig = given_back()
    effects = beats(rig, Phase.RETURNING, node="c1")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_a_heartbeat_of_before_tells_nothing() -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    assert instructed(beats(rig, Phase.CARRYING, node="c1", aboard=True, before=5), CloseDock) == []


def test_a_silent_vehicle_keeps_the_dock_until_it_is_heard_elsewhere() -> None:
    rig = given_back()
    assert instructed(rig.run(rig.now_s + 3_600.0), CloseDock) == []
    assert instructed(beats(rig, None, node="c1", aboard=True), CloseDock) == SHUT


@pytest.mark.parametrize(
    ("phase", "task", "node", "aboard", "booked"),
    [
        (None, "M7-1", DOCK, False, BROUGHT),
        (None, "M7-1", DOCK, True, []),
        (None, "M7-1", "c1", False, []),
        (Phase.APPROACHING, "M8-1", DOCK, False, []),
    ],
)
def test_after_a_silence_only_who_stands_there_with_no_task_and_no_load_has_surely_put_it_down_here(
    phase: Phase | None, task: str, node: str, *, aboard: bool, booked: list[Book]
) -> None:
    # It has lost its memory, and has never left.
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    effects = beats(rig, phase, task=task, node=node, aboard=aboard)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, booked)


def test_a_load_is_booked_when_its_vehicle_says_that_it_is_down_though_it_was_not_heard_for_a_while() -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    effects = rig.on_message(CART, handover())
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, BROUGHT)
    assert sent(effects, Superseded, to=CART)
    # Said again, and told by its heartbeat, it is booked no more.
    assert instructed(rig.on_message(CART, handover()) + beats(rig, None), Book) == []


def test_no_more_is_booked_than_its_vehicle_was_given() -> None:
    life = Life()
    _, visits = blind_dock(DOCK, life)
    visits.restore([LOAD])
    visits.on_put_down(CART, "M7-1", 2, 24)
    visits.on_put_down(CART, "M8-1", 1, 24)
    assert instructed(life.effects, Book) == []
    visits.on_put_down(CART, "M7-1", 1, 240)
    assert instructed(life.effects, Book) == BROUGHT


def test_where_the_dock_opens_at_once_a_drop_after_the_transport_was_given_back_is_booked() -> None:
    rig = hiring(BlindRig("M7", NO_HOUSINGS))
    assert sent(rig.on_message(CART, docked()), DockOpened)
    assert instructed(rig.on_message(CART, GIVES_BACK), CloseDock) == SHUT
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), Book) == []
    assert instructed(beats(rig, None), Book) == BROUGHT


def test_a_dock_that_was_never_opened_is_shut_at_once() -> None:
    rig = hiring(BlindRig("M7", NO_HOUSINGS), answers=True)
    rig.on_message(CART, docked())
    assert instructed(rig.on_message(CART, GIVES_BACK), CloseDock) == SHUT


def test_a_dock_that_ends_a_transfer_without_effect_is_shut_at_once() -> None:
    rig = supplied_by(CART)
    rig.on_message(CART, docked())
    assert instructed(rig.on_message(CART, GIVES_BACK), CloseDock) == SHUT


def test_who_loaded_here_once_and_gives_a_later_transport_back_far_away_has_brought_nothing() -> None:
    rig = BlindRig("M7", {**NO_HOUSINGS, "housing": 6})
    rig.answers = True
    rig.start()
    rig.on_message("M8", StockAsked("M8-1", 1, "housing", 6))
    rig.on_message(CART, Docked("M8-1", 1, "M7", "housing", 6))
    assert sent(rig.report(DockReady(vehicle=CART)), DockOpened)
    rig.take_goal("G1", production(quantity=24))
    rig.hire("M7-1", CART)
    # It may be inside still, for what it was let in for.
    assert instructed(rig.on_message(CART, GIVES_BACK), CloseDock) == []
    assert instructed(beats(rig, None, node="c1"), Book) == []


def test_what_was_booked_of_an_earlier_transport_of_its_carrier_is_not_the_load_of_this_one() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.agent._flow.bookings.say(DepartureMemory(CART, "M7-0", 1, "housing", 24))
    rig.hire("M7-1", CART)
    rig.stocked("housing", 24, CART)
    task = rig.agent._flow.tasks.get("M7-1")
    assert task is not None
    assert (task.contract.receipt.counted, task.is_counted) == (0, False)
    effects = rig.on_message(CART, handover())
    assert (instructed(effects, Book), len(sent(effects, HandoverAccepted, to=CART))) == (BROUGHT, 1)


def test_a_vehicle_that_is_back_with_the_load_for_which_it_was_waited_is_not_let_in_yet() -> None:
    _, visits = blind_dock(DOCK, Life())
    visits.restore([LOAD])
    visits.take_back(LOAD, 0.0)
    assert [each.let_in for each in visits.memories()] == [False]
    visits.let_in(LOAD)
    visits.take_back(LOAD, 1.0)
    assert [each.let_in for each in visits.memories()] == [True]


# --- a vehicle whose agent has lost its memory there ---


def test_a_vehicle_that_lost_its_memory_and_brings_the_found_load_back_has_put_nothing_down() -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    assert instructed(beats(rig, Phase.RETURNING, task="ATV2-found-7", aboard=True), CloseDock) == []
    effects = beats(rig, Phase.RETURNING, task="ATV2-found-7", node="c1", aboard=True)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


@pytest.mark.parametrize(("node", "silence_s", "booked"), [(DOCK, 0.0, BROUGHT), ("c1", 2 * UNHEARD_S, [])])
def test_what_the_body_of_a_vehicle_without_memory_puts_down_before_it_drives_off_is_booked(
    node: str, silence_s: float, booked: list[Book]
) -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    # Its body still unloads for its earlier life.
    assert instructed(beats(rig, Phase.RETURNING, task="ATV2-found-7", aboard=True), CloseDock) == []
    rig.run(rig.now_s + silence_s)
    effects = beats(rig, Phase.RETURNING, task="ATV2-found-7", node=node)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, booked)


@pytest.mark.parametrize("load", ["", "housing"], ids=["nothing on board", "such a load from elsewhere"])
@pytest.mark.parametrize("task", ["", "M8-1"])
def test_a_vehicle_that_left_empty_after_it_had_lost_its_memory_here_has_put_all_down(
    load: str, task: str
) -> None:
    # The place was down meanwhile.
    life = Life()
    _, visits = blind_dock(DOCK, life)
    visits.restore([LOAD])
    beat = replace(rhb(CART, 1, 0.0, task=task), load=load, load_quantity=24 if load else 0)
    visits.on_vehicle(replace(beat, left_empty=DOCK), 0.0)
    assert (instructed(life.effects, CloseDock), instructed(life.effects, Book)) == (SHUT, BROUGHT)


# --- a vehicle that was carried away ---


def test_a_vehicle_that_was_carried_away_has_left() -> None:
    life = Life()
    _, visits = blind_dock(DOCK, life)
    visits.restore([LOAD])
    visits.on_carried_away("ATV7")
    assert instructed(life.effects, CloseDock) == []
    visits.on_carried_away(CART)
    assert (instructed(life.effects, CloseDock), instructed(life.effects, Book)) == (SHUT, [])
    assert listening(life.effects) == set()


def with_books_elsewhere() -> TrafficMap:
    """Right of way, and only M4 keeps books."""
    traffic = TrafficMap(PLANT, is_signed)
    traffic.places = Places(PLANT, replicas=("M4",))
    return traffic


def carried_away(*, everywhere: bool = True, forged: bool = False) -> Removals:
    """A person has carried ATV2 away."""
    grant = Grant("mara", FOR_EVER_S, b"", everywhere=everywhere)
    removal = Removal(CART, number=1, life=1, seq=10_000, grant=grant)
    signature = seal(b"" if forged else removed_words(removal))
    return Removals((replace(removal, grant=replace(grant, signature=signature)),))


@pytest.mark.parametrize("traffic", [None, with_books_elsewhere()], ids=["no right of way", "no books here"])
def test_a_dock_without_books_hears_that_a_dead_vehicle_was_carried_away(traffic: TrafficMap | None) -> None:
    rig = given_back(BlindRig("M7", NO_HOUSINGS, traffic=traffic))
    assert Keys(PLANT.id).removals in listening(rig.all)
    # It is listened to from the first word on: it may be alive.
    assert instructed(rig.on_message("GATEWAY", carried_away()), CloseDock) == []
    rig.run(rig.now_s + LISTEN_S + 1.0)
    assert instructed(rig.on_message("GATEWAY", carried_away(forged=True)), CloseDock) == []
    assert instructed(rig.on_message("GATEWAY", carried_away(everywhere=False)), CloseDock) == []
    effects = rig.on_message("GATEWAY", carried_away())
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_a_dock_without_books_does_not_believe_that_a_vehicle_was_carried_away_which_it_hears() -> None:
    rig = given_back()
    rig.on_message("GATEWAY", carried_away())
    rig.run(rig.now_s + LISTEN_S + 1.0)
    beats(rig, Phase.UNLOADING, aboard=True)
    assert instructed(rig.on_message("GATEWAY", carried_away()), CloseDock) == []


def test_a_dock_that_opens_at_once_and_keeps_no_books_hears_nobodys_removals() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.start()
    assert Keys(PLANT.id).removals not in listening(rig.all)


# --- the next life of the machine's agent ---


def test_the_next_life_waits_for_it_and_books_what_it_put_down() -> None:
    rig = next_life(given_back(), opened=(CART,))
    assert instructed(rig.all, CloseDock) == []
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), CloseDock) == []
    effects = beats(rig, None)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, BROUGHT)


def test_who_carries_goes_on_unloading_over_a_restart_of_the_machines_agent() -> None:
    rig = next_life(unloading(), opened=(CART,))
    assert instructed(rig.all, CloseDock) == []
    assert instructed(rig.on_message(CART, handover()), Book) == BROUGHT


def told_by_heartbeat(rig: MachineRig) -> list[Effect]:
    return beats(rig, Phase.HANDING_OVER)


def told_by_handover(rig: MachineRig) -> list[Effect]:
    return rig.on_message(CART, handover())


def ended_there(rig: MachineRig) -> list[Effect]:
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), CloseDock) == []
    return beats(rig, None)


def ended_elsewhere(rig: MachineRig) -> list[Effect]:
    return beats(rig, None, node="c1")


@pytest.mark.parametrize(
    ("tells", "booked"),
    [(told_by_heartbeat, BROUGHT), (told_by_handover, BROUGHT), (ended_there, []), (ended_elsewhere, [])],
)
def test_a_load_for_which_an_earlier_life_may_have_opened_the_dock_is_booked_in_on_its_carriers_word(
    tells: Callable[[MachineRig], list[Effect]], booked: list[Book]
) -> None:
    rig = next_life(unloading(), opened=(CART,))
    effects = rig.on_message(CART, GIVES_BACK)
    assert sent(effects, Superseded, to=CART)
    assert instructed(effects, CloseDock) == []
    effects = tells(rig)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, booked)
    # Its report counts also once it has gone, and once.
    assert instructed(told_by_handover(rig), Book) == ([] if booked else BROUGHT)
    assert instructed(told_by_handover(rig), Book) == []


# --- a life without notes, whose body remembers what it has let in ---


def without_notes(item: str = "housing") -> MachineRig:
    """M7's agent has lost its notes; its body remembers that ATV2 was let in."""
    return next_life(unloading(), opened=(CART,), let_in=OpenDock(CART, item, 24), memory={})


def test_a_life_without_notes_shuts_a_dock_that_it_does_not_know_of_once_its_vehicle_has_left() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.answers, rig.opened = True, (CART,)
    assert instructed(rig.start(), CloseDock) == []
    effects = beats(rig, None, node="c1")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_what_the_body_let_a_vehicle_bring_is_booked_when_it_reports_that_to_a_life_without_notes() -> None:
    rig = without_notes()
    assert instructed(beats(rig, None, node="c1"), Book) == []
    effects = rig.on_message(CART, handover())
    assert instructed(effects, Book) == BROUGHT
    assert sent(effects, Superseded, to=CART)
    rig.stocked("housing", 24, CART)
    assert instructed(rig.on_message(CART, handover()), Book) == []
    assert instructed(rig.on_message(CART, handover("M7-2")), Book) == []


def test_a_vehicle_that_reports_before_a_life_without_notes_has_heard_where_it_is_reports_again() -> None:
    rig = without_notes()
    effects = rig.on_message(CART, handover())
    assert (instructed(effects, Book), sent(effects, Superseded)) == ([], [])
    assert instructed(beats(rig, Phase.APPROACHING, node="c1", task="M8-1"), CloseDock) == SHUT
    assert instructed(rig.on_message(CART, handover()), Book) == BROUGHT


def test_what_a_vehicle_hands_over_at_the_dock_of_a_life_without_notes_is_booked_once() -> None:
    rig = without_notes()
    assert instructed(beats(rig, Phase.HANDING_OVER), Book) == BROUGHT
    rig.stocked("housing", 24, CART)
    assert instructed(rig.on_message(CART, handover()), Book) == []


def recovered(rig: MachineRig) -> None:
    """ATV3 tells that it carries the same task for M7, as the carrier after ATV2."""
    beat = rhb("ATV3", 1, rig.now_s, task="M7-1", coordinator="M7")
    assert beat.task is not None
    task = replace(beat.task, epoch=2, phase=Phase.APPROACHING, item="housing", quantity=24, due_s=900.0)
    rig.on_message("ATV3", replace(beat, task=task))
    assert rig.agent._flow.tasks.get("M7-1") is not None


@pytest.mark.parametrize("ends", [False, True])
def test_what_a_vehicle_reports_for_an_earlier_epoch_of_a_recovered_task_is_booked(*, ends: bool) -> None:
    rig = without_notes()
    recovered(rig)
    beats(rig, Phase.HANDING_OVER, node="c1")
    if ends:
        task = rig.agent._flow.tasks.get("M7-1")
        assert task is not None
        rig.agent._flow.cancel(task)
    assert instructed(rig.on_message(CART, handover()), Book) == BROUGHT


def test_what_a_vehicle_reports_for_the_known_epoch_of_a_recovered_task_is_not_of_an_earlier_life() -> None:
    rig = without_notes()
    recovered(rig)
    beats(rig, None, node="c1")
    assert instructed(rig.on_message(CART, handover(epoch=2)), Book) == []


def left_empty(rig: MachineRig, *, where: str = DOCK) -> list[Effect]:
    """ATV2 is heard elsewhere, and says where it has lost its memory and what it has left with: nothing."""
    rig.run(rig.now_s + 1.0)
    beat = rhb(CART, 1000 + int(rig.now_s), rig.now_s)
    return rig.on_message(CART, replace(beat, node="c1", left_empty=where))


@pytest.mark.parametrize("stands", [False, True])
def test_what_the_body_let_a_vehicle_bring_that_has_lost_its_memory_is_booked_once_it_has_left_empty(
    *, stands: bool
) -> None:
    rig = without_notes()
    if stands:
        # It may tell of its load yet.
        assert instructed(beats(rig, None), CloseDock) == []
    effects = left_empty(rig)
    brought = [Book(CART, "housing", 24, task="", epoch=2)]
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == (brought, SHUT)
    assert instructed(left_empty(rig), Book) == []


def test_who_has_lost_its_memory_elsewhere_has_not_put_down_what_the_body_let_it_bring() -> None:
    assert instructed(left_empty(without_notes(), where="c9"), Book) == []


@pytest.mark.parametrize("heard", [True, False])
def test_who_stood_there_empty_and_comes_for_the_next_load_has_put_down_what_the_body_let_it_bring(
    *, heard: bool
) -> None:
    rig = without_notes()
    if heard:
        beats(rig, None)
    rig.on_message("S1", StockAsked("S1-1", 1, "seal-kit", 1))
    effects = rig.on_message(CART, Docked("S1-1", 1, "M7", "seal-kit", 1))
    assert instructed(effects, Book) == ([Book(CART, "housing", 24, task="", epoch=2)] if heard else [])


def test_who_has_not_lost_its_memory_and_tells_nothing_has_put_nothing_down() -> None:
    rig = without_notes()
    beats(rig, None)
    effects = beats(rig, None, node="c1")
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([], SHUT)


@pytest.mark.parametrize(("item", "vehicle"), [("pump-p3", CART), ("unknown", CART), ("housing", "ATV3")])
def test_nothing_else_is_booked_in_on_a_report_to_a_life_without_notes(item: str, vehicle: str) -> None:
    rig = without_notes(item)
    beats(rig, None, node="c1")
    assert instructed(rig.on_message(vehicle, handover()), Book) == []


def test_who_has_brought_another_load_since_reports_nothing_of_a_life_before_the_notes_were_lost() -> None:
    rig = without_notes()
    beats(rig, None, node="c1")
    rig.stocked("housing", 12, CART)
    assert instructed(rig.on_message(CART, handover()), Book) == []


def test_a_life_after_one_without_notes_books_what_is_reported_to_it() -> None:
    first = without_notes()
    beats(first, None, node="c1")
    assert instructed(next_life(first).on_message(CART, handover()), Book) == BROUGHT


@pytest.mark.parametrize(
    ("opened", "phase", "node", "counts", "booked"),
    [
        ((CART,), Phase.HANDING_OVER, DOCK, False, BROUGHT),
        ((), Phase.HANDING_OVER, DOCK, False, []),
        ((CART,), Phase.CARRYING, DOCK, False, []),
        ((CART,), Phase.HANDING_OVER, "c1", False, []),
        ((CART,), Phase.HANDING_OVER, DOCK, True, []),
    ],
    ids=["put-down", "not-let-in", "not-put-down", "elsewhere", "counts"],
)
def test_what_came_through_the_open_dock_while_the_notes_were_lost_is_booked_in_once(
    opened: tuple[str, ...], phase: Phase, node: str, *, counts: bool, booked: list[Book]
) -> None:
    rig = (MachineRig if counts else BlindRig)("M7", NO_HOUSINGS, incarnation=2)
    rig.answers, rig.opened = True, opened
    rig.start()
    assert instructed(beats(rig, phase, node=node), Book) == booked
    assert instructed(beats(rig, phase, node=node), Book) == []
