"""A dock that makes itself safe stays open until the vehicle at it has left, whatever becomes of its transport meanwhile."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import pytest
from defaults import PLANT
from dock_parts import dock_parts
from effects import committed, instructed, listening, sent
from m7 import NO_HOUSINGS, docked, handover, hiring, supplied_by, unloading
from msgspec.structs import replace
from rigs import BlindRig, MachineRig
from seals import FOR_EVER_S, seal
from spoken import production, rhb

from dray.adapters.security.signing import is_signed
from dray.body import Book, CloseDock, DockReady, OpenDock, StockChanged
from dray.memory import DepartureMemory, MachineMemory, visits_of
from dray.messages import (
    Docked,
    DockHeld,
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
    StockFreed,
    Superseded,
)
from dray.messages.floor.removal import removed_words
from dray.messages.keys import Keys
from dray.plant.file.file import shipped_plant
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.events import Effect
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.removal_authorisation import LISTEN_S
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.dock_door import Door
from dray.protocol.transports.transports import RECOVERY_WAIT_S
from dray.protocol.transports.visits import UNHEARD_S, Visits

DOCK = "m7"
GIVES_BACK = Resigned(task="M7-1", epoch=1, role=Role.PRIMARY, reason=Reason.PROBLEM)
SHUT = [CloseDock(vehicle="ATV2")]
BROUGHT = [Book("ATV2", "housing", 24, task="M7-1", epoch=1)]


def given_back(rig: MachineRig | None = None) -> MachineRig:
    """ATV2 has given its transport back while it unloads."""
    rig = unloading(rig)
    effects = rig.on_message("ATV2", GIVES_BACK)
    assert sent(effects, Superseded, to="ATV2")
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
    beat = rhb("ATV2", 1000 + int(rig.now_s) - before, rig.now_s, task=task, coordinator="M7")
    assert beat.task is not None
    doing = None if phase is None else replace(beat.task, phase=phase, item="housing", quantity=24)
    load = ("housing", 24) if aboard else ("", 0)
    return rig.on_message("ATV2", replace(beat, task=doing, node=node, load=load[0], load_quantity=load[1]))


def alone(life: Life) -> tuple[Door, Visits]:
    """Of a dock, without an agent."""
    door, visits = dock_parts(DOCK, HeartbeatSubscriptions(Keys("dray").atv_heartbeat, life), life)
    visits.counts = False
    return door, visits


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


def test_a_vehicle_that_lost_its_memory_and_brings_the_found_load_back_has_taken_it() -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", -24)])
    beat = rhb("ATV2", 1, 0.0, task="M7-1", coordinator="M7")
    assert beat.task is not None
    beat = replace(beat, node=DOCK, task=replace(beat.task, phase=Phase.LOADING))
    departures.on_vehicle(beat, 0.0)
    found = replace(
        beat,
        incarnation=2,
        load="shaft",
        load_quantity=24,
        task=replace(beat.task, task="ATV2-found-7", phase=Phase.RETURNING),
    )
    departures.on_vehicle(found, 1.0)
    assert instructed(life.effects, CloseDock) == []
    departures.on_vehicle(replace(found, seq=2, node="c1"), 2.0)
    assert instructed(life.effects, Book) == [Book("ATV2", "shaft", -24, task="M7-1", epoch=1)]


def test_what_a_vehicle_may_have_put_down_elsewhere_is_not_booked_in() -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    effects = beats(rig, Phase.APPROACHING, task="M8-1")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


@pytest.mark.parametrize(
    ("node", "aboard", "booked"), [(DOCK, False, BROUGHT), (DOCK, True, []), ("c1", False, [])]
)
def test_a_vehicle_that_stands_there_without_a_task_after_a_silence_has_lost_its_memory_and_never_left(
    node: str, *, aboard: bool, booked: list[Book]
) -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    effects = beats(rig, None, node=node, aboard=aboard)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, booked)


@pytest.mark.parametrize(("quantity", "is_booked"), [(0, False), (24, True)])
def test_what_it_was_to_take_and_has_not_on_board_is_still_there(quantity: int, *, is_booked: bool) -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", -24)])
    load = "shaft" if quantity else ""
    departures.on_vehicle(replace(rhb("ATV2", 1, 0.0), node=DOCK, load=load, load_quantity=quantity), 0.0)
    assert bool(instructed(life.effects, Book)) is is_booked


def test_a_load_that_somebody_takes_off_a_vehicle_on_its_way_back_was_not_put_down_here() -> None:
    rig = given_back()
    effects = beats(rig, Phase.RETURNING, node="c1")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_a_heartbeat_of_before_tells_nothing() -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    assert instructed(beats(rig, Phase.CARRYING, node="c1", aboard=True, before=5), CloseDock) == []


def test_what_a_vehicle_may_have_taken_while_it_was_not_heard_is_booked_out() -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", -24)])
    departures.on_vehicle(rhb("ATV2", 1, 0.0), 0.0)
    assert instructed(life.effects, Book) == [Book("ATV2", "shaft", -24, task="M7-1", epoch=1)]


TAKEN = [Book("ATV2", "shaft", -24, task="M7-1", epoch=1)]


def loads(departures: Visits, *, life: int, at_s: float, names: bool = False) -> None:
    """ATV2 loads 24 shafts at the dock; only a life that remembers it names the task."""
    beat = rhb("ATV2", int(at_s) + 1, at_s, task="M7-1" if names else "", coordinator="M7")
    doing = None if beat.task is None else replace(beat.task, phase=Phase.LOADING)
    departures.on_vehicle(replace(beat, node=DOCK, incarnation=life, task=doing), at_s)


def leaves(departures: Visits, *, life: int, at_s: float, aboard: bool) -> None:
    """ATV2 drives off without the task."""
    beat = rhb("ATV2", int(at_s) + 1, at_s, task="ATV2-found-7" if aboard else "")
    doing = None if beat.task is None else replace(beat.task, phase=Phase.RETURNING)
    beat = replace(beat, load="shaft" if aboard else "", load_quantity=24 if aboard else 0)
    for node in (DOCK, "c1") if aboard else ("c1",):
        departures.on_vehicle(replace(beat, node=node, incarnation=life, task=doing), at_s)
        beat = replace(beat, seq=beat.seq + 1)


@pytest.mark.parametrize("is_restarted", [False, True], ids=["this life", "the next life"])
@pytest.mark.parametrize("lives", [(2,), (2, 3)], ids=["one loss", "two losses"])
@pytest.mark.parametrize(("aboard", "booked"), [(True, TAKEN), (False, [])])
def test_the_body_of_a_vehicle_that_lost_its_memory_may_go_on_loading(
    lives: tuple[int, ...], *, aboard: bool, booked: list[Book], is_restarted: bool
) -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", -24)])
    if not is_restarted:
        loads(departures, life=1, at_s=0.0, names=True)
    for each in lives:
        loads(departures, life=each, at_s=1.0)
        loads(departures, life=each, at_s=6.0)
    assert instructed(life.effects, CloseDock) == []
    leaves(departures, life=lives[-1], at_s=11.0, aboard=aboard)
    assert (instructed(life.effects, CloseDock), instructed(life.effects, Book)) == (SHUT, booked)


def test_a_vehicle_that_has_ended_its_task_at_the_dock_does_not_load_there_any_more() -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", -24)])
    loads(departures, life=1, at_s=0.0, names=True)
    loads(departures, life=1, at_s=1.0)
    assert (instructed(life.effects, CloseDock), instructed(life.effects, Book)) == (SHUT, [])


@pytest.mark.parametrize("load", ["", "shaft"], ids=["nothing on board", "such a load from elsewhere"])
@pytest.mark.parametrize(("change", "is_booked"), [(-24, False), (24, True)], ids=["to take", "to bring"])
@pytest.mark.parametrize("names_another", [False, True])
def test_a_vehicle_that_left_empty_after_it_had_lost_its_memory_here_has_taken_nothing_and_put_down_all(
    load: str, change: int, *, is_booked: bool, names_another: bool
) -> None:
    # The place was down meanwhile.
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", change)])
    beat = rhb("ATV2", 1, 0.0, task="M8-1" if names_another else "")
    beat = replace(beat, load=load, load_quantity=24 if load else 0, left_empty=DOCK)
    departures.on_vehicle(beat, 0.0)
    assert instructed(life.effects, CloseDock) == SHUT
    assert bool(instructed(life.effects, Book)) is is_booked


def test_what_a_vehicle_did_at_another_dock_after_it_had_lost_its_memory_tells_nothing() -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "shaft", -24)])
    departures.on_vehicle(replace(rhb("ATV2", 1, 0.0), left_empty="m8"), 0.0)
    assert instructed(life.effects, Book) == [Book("ATV2", "shaft", -24, task="M7-1", epoch=1)]


def test_a_vehicle_that_asks_for_the_dock_for_something_else_is_done_though_it_has_to_wait() -> None:
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 6}, plant=shipped_plant("levels"))
    rig.answers = True
    rig.start()
    rig.on_message("PRESS1", StockAsked("PRESS1-1", 1, "shaft", 6))
    rig.on_message("ATV2", Docked("PRESS1-1", 1, "LATHE1", "shaft", 6))
    rig.report(DockReady(vehicle="ATV2"))
    assert instructed(rig.on_message("PRESS1", StockFreed("PRESS1-1")), CloseDock) == []
    rig.on_message("PRESS2", StockAsked("PRESS2-1", 1, "shaft", 6))
    effects = rig.on_message("ATV2", Docked("PRESS3-1", 1, "LATHE1", "shaft", 6))
    assert sent(effects, DockHeld, to="ATV2")
    assert instructed(effects, CloseDock) == SHUT


def test_where_the_dock_opens_at_once_a_drop_after_the_transport_was_given_back_is_booked() -> None:
    rig = hiring(BlindRig("M7", NO_HOUSINGS))
    assert sent(rig.on_message("ATV2", docked()), DockOpened)
    assert instructed(rig.on_message("ATV2", GIVES_BACK), CloseDock) == SHUT
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), Book) == []
    assert instructed(beats(rig, None), Book) == BROUGHT


def test_a_silent_vehicle_keeps_the_dock_until_it_is_heard_elsewhere() -> None:
    rig = given_back()
    assert instructed(rig.run(rig.now_s + 3_600.0), CloseDock) == []
    assert instructed(beats(rig, None, node="c1", aboard=True), CloseDock) == SHUT


def test_a_vehicle_that_was_carried_away_has_left() -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "housing", 24)])
    departures.on_carried_away("ATV7")
    assert instructed(life.effects, CloseDock) == []
    departures.on_carried_away("ATV2")
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
    removal = Removal("ATV2", number=1, life=1, seq=10_000, grant=grant)
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


def test_the_next_life_waits_for_it_and_books_what_it_put_down() -> None:
    first = given_back()
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.answers, rig.opened, rig.memory = True, ("ATV2",), committed(first.all)
    assert instructed(rig.start(), CloseDock) == []
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), CloseDock) == []
    effects = beats(rig, None)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, BROUGHT)


def test_a_life_without_notes_shuts_a_dock_that_it_does_not_know_of_once_its_vehicle_has_left() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.answers, rig.opened = True, ("ATV2",)
    assert instructed(rig.start(), CloseDock) == []
    effects = beats(rig, None, node="c1")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def without_notes(item: str = "housing") -> MachineRig:
    """M7's agent has lost its notes; its body remembers that ATV2 was let in."""
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.answers, rig.opened, rig.let_in = True, ("ATV2",), OpenDock("ATV2", item, 24)
    rig.start()
    return rig


def test_what_the_body_let_a_vehicle_bring_is_booked_when_it_reports_that_to_a_life_without_notes() -> None:
    rig = without_notes()
    assert instructed(beats(rig, None, node="c1"), Book) == []
    effects = rig.on_message("ATV2", handover())
    assert instructed(effects, Book) == BROUGHT
    assert sent(effects, Superseded, to="ATV2")
    rig.stocked("housing", 24, "ATV2")
    assert instructed(rig.on_message("ATV2", handover()), Book) == []
    assert instructed(rig.on_message("ATV2", handover("M7-2")), Book) == []


def test_a_vehicle_that_reports_before_a_life_without_notes_has_heard_where_it_is_reports_again() -> None:
    rig = without_notes()
    effects = rig.on_message("ATV2", handover())
    assert (instructed(effects, Book), sent(effects, Superseded)) == ([], [])
    assert instructed(beats(rig, Phase.APPROACHING, node="c1", task="M8-1"), CloseDock) == SHUT
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT


def test_what_a_vehicle_hands_over_at_the_dock_of_a_life_without_notes_is_booked_once() -> None:
    rig = without_notes()
    assert instructed(beats(rig, Phase.HANDING_OVER), Book) == BROUGHT
    rig.stocked("housing", 24, "ATV2")
    assert instructed(rig.on_message("ATV2", handover()), Book) == []


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
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT


def test_what_a_vehicle_reports_for_the_known_epoch_of_a_recovered_task_is_not_of_an_earlier_life() -> None:
    rig = without_notes()
    recovered(rig)
    beats(rig, None, node="c1")
    assert instructed(rig.on_message("ATV2", handover(epoch=2)), Book) == []


def left_empty(rig: MachineRig, **said: str) -> list[Effect]:
    """ATV2 is heard elsewhere, and says where it has lost its memory and what it has left with: nothing."""
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV2", 1000 + int(rig.now_s), rig.now_s)
    return rig.on_message("ATV2", replace(beat, task=None, node="c1", left_empty=said.get("where", DOCK)))


@pytest.mark.parametrize("stands", [False, True])
def test_what_the_body_let_a_vehicle_bring_that_has_lost_its_memory_is_booked_once_it_has_left_empty(
    *, stands: bool
) -> None:
    rig = without_notes()
    if stands:
        # It may tell of its load yet.
        assert instructed(beats(rig, None), CloseDock) == []
    effects = left_empty(rig)
    brought = [Book("ATV2", "housing", 24, task="", epoch=2)]
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == (brought, SHUT)
    assert instructed(left_empty(rig), Book) == []


@pytest.mark.parametrize("heard", [True, False])
def test_who_stood_there_empty_and_comes_for_the_next_load_has_put_down_what_the_body_let_it_bring(
    *, heard: bool
) -> None:
    rig = without_notes()
    if heard:
        beats(rig, None)
    rig.on_message("S1", StockAsked("S1-1", 1, "seal-kit", 1))
    effects = rig.on_message("ATV2", Docked("S1-1", 1, "M7", "seal-kit", 1))
    assert instructed(effects, Book) == ([Book("ATV2", "housing", 24, task="", epoch=2)] if heard else [])


def test_who_has_lost_its_memory_elsewhere_has_not_put_down_what_the_body_let_it_bring() -> None:
    assert instructed(left_empty(without_notes(), where="c9"), Book) == []


def test_who_has_not_lost_its_memory_and_tells_nothing_has_put_nothing_down() -> None:
    rig = without_notes()
    beats(rig, None)
    effects = beats(rig, None, node="c1")
    assert (instructed(effects, Book), instructed(effects, CloseDock)) == ([], SHUT)


@pytest.mark.parametrize(("item", "vehicle"), [("pump-p3", "ATV2"), ("unknown", "ATV2"), ("housing", "ATV3")])
def test_nothing_else_is_booked_in_on_a_report_to_a_life_without_notes(item: str, vehicle: str) -> None:
    rig = without_notes(item)
    beats(rig, None, node="c1")
    assert instructed(rig.on_message(vehicle, handover()), Book) == []


def test_who_has_brought_another_load_since_reports_nothing_of_a_life_before_the_notes_were_lost() -> None:
    rig = without_notes()
    beats(rig, None, node="c1")
    rig.stocked("housing", 12, "ATV2")
    assert instructed(rig.on_message("ATV2", handover()), Book) == []


def test_a_life_after_one_without_notes_books_what_is_reported_to_it() -> None:
    first = without_notes()
    beats(first, None, node="c1")
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=3)
    rig.answers, rig.memory, rig.now_s = True, committed(first.all), first.now_s
    rig.start()
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT


def test_who_carries_goes_on_unloading_over_a_restart_of_the_machines_agent() -> None:
    first = unloading()
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.answers, rig.opened, rig.memory = True, ("ATV2",), committed(first.all)
    assert instructed(rig.start(), CloseDock) == []
    assert instructed(rig.on_message("ATV2", handover()), Book) == BROUGHT


def test_a_dock_that_was_never_opened_is_shut_at_once() -> None:
    rig = hiring(BlindRig("M7", NO_HOUSINGS), answers=True)
    rig.on_message("ATV2", docked())
    assert instructed(rig.on_message("ATV2", GIVES_BACK), CloseDock) == SHUT


def test_a_dock_that_ends_a_transfer_without_effect_is_shut_at_once() -> None:
    rig = supplied_by("ATV2")
    rig.on_message("ATV2", docked())
    assert instructed(rig.on_message("ATV2", GIVES_BACK), CloseDock) == SHUT


def test_a_load_that_is_given_back_while_it_is_taken_leaves_the_dock_open_until_its_vehicle_has_left() -> (
    None
):
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=shipped_plant("levels"))
    rig.answers = True
    rig.start()
    rig.on_message("PRESS1", StockAsked("PRESS1-1", 1, "shaft", 6))
    rig.on_message("ATV2", Docked("PRESS1-1", 1, "LATHE1", "shaft", 6))
    rig.report(DockReady(vehicle="ATV2"))
    assert instructed(rig.on_message("PRESS1", StockFreed("PRESS1-1")), CloseDock) == []
    beat = rhb("ATV2", 1000, rig.now_s, task="PRESS1-1", coordinator="PRESS1")
    assert beat.task is not None
    beat = replace(beat, node=shipped_plant("levels").node_of("LATHE1"))
    loads = replace(beat, task=replace(beat.task, phase=Phase.LOADING))
    assert instructed(rig.on_message("ATV2", loads), CloseDock) == []
    leaves = replace(beat, seq=1001, node="far", task=replace(beat.task, phase=Phase.RETURNING))
    assert instructed(rig.on_message("ATV2", leaves), CloseDock) == SHUT


def test_who_loaded_here_once_and_gives_a_later_transport_back_far_away_has_brought_nothing() -> None:
    rig = BlindRig("M7", {**NO_HOUSINGS, "housing": 6})
    rig.answers = True
    rig.start()
    rig.on_message("M8", StockAsked("M8-1", 1, "housing", 6))
    rig.on_message("ATV2", Docked("M8-1", 1, "M7", "housing", 6))
    assert sent(rig.report(DockReady(vehicle="ATV2")), DockOpened)
    rig.take_goal("G1", production(quantity=24))
    rig.hire("M7-1", "ATV2")
    # It may be inside still, for what it was let in for.
    assert instructed(rig.on_message("ATV2", GIVES_BACK), CloseDock) == []
    assert instructed(beats(rig, None, node="c1"), Book) == []


def test_who_was_let_in_by_an_earlier_life_is_not_booked_in_for_what_this_one_does_not_know() -> None:
    first = unloading()
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.answers, rig.opened, rig.memory = True, ("ATV2",), committed(first.all)
    rig.start()
    assert instructed(rig.on_message("ATV2", GIVES_BACK), CloseDock) == []
    assert instructed(beats(rig, Phase.UNLOADING, aboard=True), CloseDock) == []
    effects = beats(rig, None)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, [])


def test_who_has_loaded_is_inside_no_more_once_that_is_booked() -> None:
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=shipped_plant("levels"))
    rig.answers = True
    rig.start()
    rig.on_message("PRESS1", StockAsked("PRESS1-1", 1, "shaft", 6))
    rig.on_message("ATV2", Docked("PRESS1-1", 1, "LATHE1", "shaft", 6))
    rig.report(DockReady(vehicle="ATV2"))
    assert instructed(beats(rig, Phase.CARRYING, aboard=True, task="PRESS1-1"), Book)
    rig.stocked("shaft", -6, "ATV2")
    # Its next load here is given back before the dock was made ready for it: nobody waits for it to leave.
    rig.on_message("PRESS1", StockAsked("PRESS1-2", 1, "shaft", 6))
    rig.on_message("ATV2", Docked("PRESS1-2", 1, "LATHE1", "shaft", 6))
    assert instructed(rig.on_message("PRESS1", StockFreed("PRESS1-2")), CloseDock) == SHUT


@pytest.mark.parametrize("change", [24, -24])
def test_where_the_dock_opens_at_once_the_next_life_books_what_is_taken_in_doubt_and_nothing_in(
    change: int,
) -> None:
    life = Life()
    door, departures = alone(life)
    door.visits.answers, door.visits.counts = False, False
    departures.restore_opened(("ATV2",))
    door.shut("ATV2", "M7-1", DepartureMemory("ATV2", "M7-1", 1, "housing", change))
    assert instructed(life.effects, CloseDock) == SHUT
    # It names the task no more, and has such a load on board.
    departures.on_vehicle(rhb("ATV2", 1, 0.0), 0.0)
    taken = [Book("ATV2", "housing", change, task="M7-1", epoch=1)]
    assert instructed(life.effects, Book) == (taken if change < 0 else [])
    assert instructed(life.effects, CloseDock) == 2 * SHUT


@pytest.mark.parametrize(("is_heard", "told"), [(True, SHUT), (False, [])])
def test_where_the_dock_opens_at_once_a_body_hears_once_more_when_who_was_to_load_has_left_without(
    is_heard: bool, told: list[CloseDock]
) -> None:
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=shipped_plant("levels"))
    rig.start()
    rig.on_message("PRESS1", StockAsked("PRESS1-1", 1, "shaft", 6))
    rig.on_message("ATV2", Docked("PRESS1-1", 1, "LATHE1", "shaft", 6))
    assert instructed(rig.on_message("PRESS1", StockFreed("PRESS1-1")), CloseDock) == SHUT
    rig.run(rig.now_s + (1.0 if is_heard else 2 * UNHEARD_S))
    effects = beats(rig, None, node="c1")
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (told, [])


def test_who_is_not_wanted_after_it_has_left_without_its_load_is_told_to_have_left() -> None:
    rig = BlindRig("LATHE1", {"bar": 60, "shaft": 12}, plant=shipped_plant("levels"))
    rig.start()
    rig.on_message("PRESS1", StockAsked("PRESS1-1", 1, "shaft", 6))
    rig.on_message("ATV2", Docked("PRESS1-1", 1, "LATHE1", "shaft", 6))
    assert instructed(beats(rig, None, node="c1"), CloseDock) == []
    assert instructed(rig.on_message("PRESS1", StockFreed("PRESS1-1")), CloseDock) == SHUT
    assert instructed(beats(rig, None, node="c1"), CloseDock) == SHUT


def test_a_vehicle_that_is_back_with_the_load_for_which_it_was_waited_is_not_let_in_yet() -> None:
    life = Life()
    _, departures = alone(life)
    load = DepartureMemory("ATV2", "M7-1", 1, "housing", 24)
    departures.restore([load])
    departures.take_back(load, 0.0)
    assert [each.let_in for each in departures.memories()] == [False]
    departures.let_in(load)
    departures.take_back(load, 1.0)
    assert [each.let_in for each in departures.memories()] == [True]


def test_what_was_booked_of_an_earlier_transport_of_its_carrier_is_not_the_load_of_this_one() -> None:
    rig = BlindRig("M7", NO_HOUSINGS)
    rig.start()
    rig.take_goal("G1", production(quantity=24))
    rig.agent._flow.bookings.say(DepartureMemory("ATV2", "M7-0", 1, "housing", 24))
    rig.hire("M7-1", "ATV2")
    rig.stocked("housing", 24, "ATV2")
    task = rig.agent._flow.tasks.get("M7-1")
    assert task is not None
    assert (task.contract.receipt.counted, task.is_counted) == (0, False)
    effects = rig.on_message("ATV2", handover())
    assert (instructed(effects, Book), len(sent(effects, HandoverAccepted, to="ATV2"))) == (BROUGHT, 1)


def test_a_word_that_is_said_again_before_its_answer_is_told_once() -> None:
    life = Life()
    bookings = Bookings(life)
    load = DepartureMemory("ATV2", "M7-1", 1, "housing", 24)
    bookings.say(load)
    bookings.say(load)
    assert instructed(life.effects, Book) == BROUGHT


def test_what_was_put_down_is_told_again_by_the_next_life_until_the_body_has_answered() -> None:
    first = given_back()
    beats(first, Phase.UNLOADING, aboard=True)
    assert instructed(beats(first, None), Book) == BROUGHT
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.memory = committed(first.all)
    assert instructed(rig.start(), Book) == BROUGHT
    rig.stocked("housing", 24, "ATV2")
    third = BlindRig("M7", NO_HOUSINGS, incarnation=3)
    third.memory = committed(rig.all)
    assert instructed(third.start(), Book) == []


def test_a_load_is_booked_when_its_vehicle_says_that_it_is_down_though_it_was_not_heard_for_a_while() -> None:
    rig = given_back()
    beats(rig, Phase.UNLOADING, aboard=True)
    rig.run(rig.now_s + 2 * UNHEARD_S)
    effects = rig.on_message("ATV2", handover())
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, BROUGHT)
    assert sent(effects, Superseded, to="ATV2")
    # Said again, and told by its heartbeat, it is booked no more.
    assert instructed(rig.on_message("ATV2", handover()) + beats(rig, None), Book) == []


def test_no_more_is_booked_than_its_vehicle_was_given() -> None:
    life = Life()
    _, departures = alone(life)
    departures.restore([DepartureMemory("ATV2", "M7-1", 1, "housing", 24)])
    departures.on_put_down("ATV2", "M7-1", 2, 24)
    departures.on_put_down("ATV2", "M8-1", 1, 24)
    assert instructed(life.effects, Book) == []
    departures.on_put_down("ATV2", "M7-1", 1, 240)
    assert instructed(life.effects, Book) == BROUGHT


def test_what_a_carrier_has_handed_over_is_told_again_by_the_next_life_until_the_body_has_answered() -> None:
    first = unloading()
    assert instructed(first.on_message("ATV2", handover()), Book) == BROUGHT
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.answers, rig.memory = True, committed(first.all)
    assert instructed(rig.start(), Book) == BROUGHT


def test_a_body_that_has_answered_one_word_of_a_vehicle_has_not_answered_the_next() -> None:
    life = Life()
    bookings = Bookings(life)
    loads = [
        DepartureMemory("ATV2", f"M7-{number}", 1, "housing", change) for number, change in ((1, 24), (2, -6))
    ]
    for load in loads:
        bookings.say(load)
    bookings.on_stock_changed(StockChanged("housing", 24, 1, "ATV2"))
    assert bookings.memories() == (loads[1],)
    bookings.on_stock_changed(StockChanged("housing", -6, 2, "ATV2"))
    assert bookings.memories() == ()


@pytest.mark.parametrize(
    ("opened", "phase", "node", "counts", "booked"),
    [
        (("ATV2",), Phase.HANDING_OVER, DOCK, False, BROUGHT),
        ((), Phase.HANDING_OVER, DOCK, False, []),
        (("ATV2",), Phase.CARRYING, DOCK, False, []),
        (("ATV2",), Phase.HANDING_OVER, "c1", False, []),
        (("ATV2",), Phase.HANDING_OVER, DOCK, True, []),
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


@pytest.mark.parametrize(
    ("coordinator", "item", "phase", "node", "opened", "listens", "booked"),
    [
        ("M7", "pump-p3", Phase.CARRYING, DOCK, ("ATV2",), True, True),
        ("M7", "pump-p3", Phase.CARRYING, DOCK, ("ATV2",), False, True),
        ("S1", "pump-p3", Phase.CARRYING, DOCK, ("ATV2",), True, True),
        ("M7", "housing", Phase.CARRYING, DOCK, ("ATV2",), True, False),
        ("S1", "seal-kit", Phase.CARRYING, DOCK, ("ATV2",), True, False),
        ("S1", "pump-p3", Phase.UNLOADING, DOCK, ("ATV2",), True, False),
        ("M7", "pump-p3", Phase.CARRYING, "c1", ("ATV2",), True, False),
        ("M7", "pump-p3", Phase.CARRYING, DOCK, (), True, False),
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


def told_by_heartbeat(rig: MachineRig) -> list[Effect]:
    return beats(rig, Phase.HANDING_OVER)


def told_by_handover(rig: MachineRig) -> list[Effect]:
    return rig.on_message("ATV2", handover())


def told_nothing(rig: MachineRig) -> list[Effect]:
    return beats(rig, None, node="c1")


@pytest.mark.parametrize(
    ("tells", "booked"), [(told_by_heartbeat, BROUGHT), (told_by_handover, BROUGHT), (told_nothing, [])]
)
def test_a_load_for_which_an_earlier_life_may_have_opened_the_dock_is_booked_in_on_its_carriers_word(
    tells: Callable[[MachineRig], list[Effect]], booked: list[Book]
) -> None:
    before = unloading()
    rig = BlindRig("M7", NO_HOUSINGS, incarnation=2)
    rig.memory, rig.now_s, rig.answers, rig.opened = committed(before.all), before.now_s, True, ("ATV2",)
    rig.start()
    assert sent(rig.on_message("ATV2", GIVES_BACK), Superseded, to="ATV2")
    effects = tells(rig)
    assert (instructed(effects, CloseDock), instructed(effects, Book)) == (SHUT, booked)
    # Its report counts also once it has gone, and once.
    assert instructed(told_by_handover(rig), Book) == ([] if booked else BROUGHT)
    assert instructed(told_by_handover(rig), Book) == []


def test_what_an_older_version_has_noted_of_loads_to_take_and_of_vehicles_that_leave_is_read() -> None:
    taken = {"task": "P-1", "epoch": 1, "item": "shaft", "quantity": 6, "coordinator": "P", "vehicle": "ATV1"}
    written = {
        "kind": "machine",
        "let_in": [
            taken | {"opened": 2},
            taken | {"vehicle": "ATV2", "opened": 3, "ended": True, "gone": True},
        ],
        "leaving": [
            {"vehicle": "ATV1"},
            {"vehicle": "ATV3", "task": "M7-1", "epoch": 1, "item": "housing", "change": 24},
            {"vehicle": "ATV2", "task": "M7-2", "epoch": 1, "item": "housing", "change": 24, "gone": True},
        ],
    }
    note = msgspec.convert(written, MachineMemory)
    assert visits_of(note) == (
        DepartureMemory("ATV1", "P-1", 2, "shaft", -6, coordinator="P"),
        DepartureMemory(
            "ATV2", "P-1", 3, "shaft", -6, gone=True, permitted=True, coordinator="P", ended=True
        ),
        DepartureMemory("ATV3", "M7-1", 1, "housing", 24),
        DepartureMemory("ATV2", "M7-2", 1, "housing", 24, gone=True),
    )
    again = msgspec.convert(msgspec.to_builtins(MachineMemory(visits=visits_of(note))), MachineMemory)
    assert visits_of(again) == visits_of(note)
