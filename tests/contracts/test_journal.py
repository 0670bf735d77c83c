"""The conformance suite of `dray.ports.Journal`: every journal runs all of it.

A new journal is one more `Case`: how to begin an agent's first life with it, and how to begin the next.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Protocol

import pytest
from makings import making

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.memory import (
    WHOLE,
    AtvMemory,
    CommandMemory,
    Contract,
    EndedOrder,
    GateGoal,
    GateMemory,
    GateOrder,
    GoalBooked,
    GoalMemory,
    MachineMemory,
    Note,
    OrderMemory,
    ReturnedOrder,
    ShutWord,
    StrategistMemory,
    TaskMemory,
)
from dray.messages import Brought, CommandRefusal, Event, OrderItem, Phase, Transport
from dray.messages.fact import OrderFulfilled
from dray.messages.gate import GoalOf
from dray.ports import Journal
from dray_sim.factory.journal import HeldJournal

KEPT = 10
"""Events that the journals of these tests hold."""


class Case(Protocol):
    """One implementation of the port."""

    def first_life(self) -> Journal: ...

    def next_life(self, journal: Journal) -> Journal:
        """The journal as the agent finds it after a restart."""
        ...

    def lose(self, journal: Journal) -> None:
        """What was written is gone."""
        ...


class Held:
    def first_life(self) -> Journal:
        return HeldJournal(events_kept=KEPT)

    def next_life(self, journal: Journal) -> Journal:
        assert isinstance(journal, HeldJournal)
        journal.begin_life()
        return journal

    def lose(self, journal: Journal) -> None:
        assert isinstance(journal, HeldJournal)
        journal.lose("a disk has failed")


class OnDisk:
    """In one file; a life ends as a killed process does, without closing anything."""

    def __init__(self, file: Path, stack: ExitStack) -> None:
        self._file, self._stack = file, stack

    def first_life(self) -> Journal:
        return self._stack.enter_context(closing(SqliteJournal(self._file, events_kept=KEPT)))

    def next_life(self, journal: Journal) -> Journal:
        return self.first_life()

    def lose(self, journal: Journal) -> None:
        for end in ("", "-wal", "-shm"):
            self._file.with_name(self._file.name + end).unlink(missing_ok=True)


@pytest.fixture(params=["held", "SQLite"])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Case]:
    with ExitStack() as stack:
        yield Held() if request.param == "held" else OnDisk(tmp_path / "journal.db", stack)


def event(life: int, number: int) -> Event:
    return Event("M1", life, number, float(number), OrderFulfilled(order=f"{life}.{number}"))


def write(journal: Journal, numbers: range) -> list[Event]:
    written = [event(journal.incarnation, number) for number in numbers]
    for one in written:
        journal.write([one], {})
    return written


FETCH = Transport(item="steel", quantity=4, sources=("S1", "S2"), destination="M1", ability="tote")
MAKE = making("P1", 4, "O-1")

CONTRACT = Contract(
    task="M1-7",
    epoch=3,
    work=FETCH,
    coordinator="M1",
    source="S2",
    promised_s=17.5,
    deadline_s=99.0,
    phase=Phase.CARRYING,
    cancelled="withdrawn",
)
GOAL = GoalMemory(
    goal="O-1-1.1",
    work=MAKE,
    strategist="strategist",
    deadline_s=99.0,
    made=3,
    delivered=2,
    lost_in_transit=1,
    epoch=2,
)
TASK = TaskMemory(
    task="M1-7",
    epoch=3,
    work=FETCH,
    deadline_s=99.0,
    opened_s=1.5,
    primary="ATV1",
    source="S2",
    promised_s=12.0,
)
BOOKED = GoalBooked(goal="O-1-1.1", work=MAKE, deadline_s=99.0, machine="M1")
GOALS = StrategistMemory(goal_count=7)
ORDER = OrderMemory(order="O-1", items=(OrderItem("P1", 4),), due_s=99.0, goals=(BOOKED,))

NOTES: list[Note] = [
    AtvMemory(),
    AtvMemory(contract=CONTRACT, acknowledged=True, speed_frac=0.25),
    AtvMemory(stopped_itself=True, stop_cause="its name is used by another"),
    AtvMemory(
        answered=(
            CommandMemory(command="C1", person="person:p", valid_until_s=9.5, refused=CommandRefusal.EXPIRED),
        )
    ),
    MachineMemory(goals=(GOAL,), tasks=(TASK,), task_count=7),
    StrategistMemory(goal_count=5),
    ORDER,
    EndedOrder(fulfilled=True),
    ReturnedOrder(order="O-1", release=2, outstanding=(4, 0)),
    ShutWord(order="O-1", epoch=2, over=1),
    GateMemory(since=3),
    GateGoal("O-1-1.1", "strategist", 4, 2, 7, 3, 2, GoalOf("O-1", 0, "M1", 2), (Brought("ATV1", 3),)),
    GateOrder("O-1", "strategist", 2, arrived=(3, 0), lost_by="strategist2"),
]


def test_lives_are_counted_from_one(case: Case) -> None:
    journal = case.first_life()
    assert journal.incarnation == 1
    journal = case.next_life(journal)
    assert journal.incarnation == 2
    assert case.next_life(journal).incarnation == 3


def test_an_agent_that_never_wrote_a_memory_remembers_nothing(case: Case) -> None:
    journal = case.first_life()
    write(journal, range(1, 3))
    assert journal.memory == {}
    assert case.next_life(journal).memory == {}


@pytest.mark.parametrize("note", NOTES, ids=lambda note: type(note).__name__)
def test_every_kind_of_note_outlives_the_process(case: Case, note: Note) -> None:
    journal = case.first_life()
    journal.write([], {"O-1": note})
    assert journal.memory == {"O-1": note}
    again = case.next_life(journal)
    assert again.memory == {"O-1": note}
    assert case.next_life(again).memory == {"O-1": note}


def test_events_without_a_memory_leave_the_one_that_is_there(case: Case) -> None:
    journal = case.first_life()
    written = [event(1, number) for number in (1, 2, 3)]
    journal.write(written, {WHOLE: AtvMemory(speed_frac=0.5)})
    journal.write([event(1, 4)], {})
    journal = case.next_life(journal)
    assert journal.memory == {WHOLE: AtvMemory(speed_frac=0.5)}
    assert journal.events(1, 1, 9) == [*written, event(1, 4)]


def test_a_note_is_replaced_or_forgotten_and_all_others_stay(case: Case) -> None:
    journal = case.first_life()
    journal.write([], {"A": AtvMemory(), "B": GOALS, "C": EndedOrder()})
    journal.write([], {"B": ORDER})
    journal.write([event(1, 1)], {"A": None, "never written": None, "D": EndedOrder(fulfilled=True)})
    journal = case.next_life(journal)
    assert journal.memory == {"B": ORDER, "C": EndedOrder(), "D": EndedOrder(fulfilled=True)}


def test_notes_come_in_the_order_in_which_they_were_first_written(case: Case) -> None:
    journal = case.first_life()
    for number in range(20):
        journal.write([], {f"O{number % 7}": StrategistMemory(goal_count=number)})
    journal.write([], {"O3": None})
    journal.write([], {"O3": EndedOrder(), "O1": EndedOrder()})
    assert list(case.next_life(journal).memory) == ["O0", "O1", "O2", "O4", "O5", "O6", "O3"]


def test_events_are_found_by_life_and_number_both_ends_included(case: Case) -> None:
    journal = case.first_life()
    first = write(journal, range(1, 4))
    journal = case.next_life(journal)
    second = write(journal, range(1, 6))
    assert journal.events(1, 1, 3) == first
    assert journal.events(2, 2, 4) == second[1:4]
    assert journal.events(2, 4, 100) == second[3:]
    assert journal.events(2, 4, 3) == journal.events(2, 6, 9) == journal.events(3, 1, 9) == []


def test_a_journal_tells_which_numbers_of_a_life_it_keeps(case: Case) -> None:
    journal = case.first_life()
    assert journal.kept(1) == (1, 0)
    write(journal, range(1, 4))
    assert journal.kept(1) == (1, 3)
    journal = case.next_life(journal)
    assert (journal.kept(1), journal.kept(2)) == ((1, 3), (1, 0))


def test_a_journal_tells_which_earlier_lives_it_keeps(case: Case) -> None:
    journal = case.first_life()
    write(journal, range(1, 4))
    journal = case.next_life(case.next_life(journal))
    write(journal, range(1, 3))
    journal = case.next_life(journal)
    write(journal, range(1, 2))
    assert journal.earlier(4, 10) == [(1, 1, 3), (3, 1, 2)]
    assert journal.earlier(4, 1) == journal.earlier(4, 10)[1:]
    assert journal.earlier(1, 10) == []


def test_a_journal_that_was_lost_says_so_until_it_is_told_and_lives_are_counted_on(case: Case) -> None:
    journal = case.next_life(case.first_life())
    assert journal.lost == ""
    journal.write([event(2, 1)], {WHOLE: AtvMemory(speed_frac=0.5)})
    case.lose(journal)
    journal = case.next_life(journal)
    assert (journal.incarnation, journal.memory, journal.kept(2)) == (3, {}, (1, 0))
    assert journal.lost
    journal = case.next_life(journal)
    assert journal.incarnation == 4
    assert journal.lost, "the life before has told nobody"
    journal.write([], {WHOLE: AtvMemory()})
    assert journal.lost
    journal.write([event(4, 1)], {})
    assert journal.lost == case.next_life(journal).lost == ""


def test_old_events_are_dropped_the_oldest_first_over_all_lives(case: Case) -> None:
    journal = case.first_life()
    write(journal, range(1, 9))
    journal = case.next_life(journal)
    written = write(journal, range(1, 7))
    assert journal.kept(1) == (5, 8)
    assert [one.number for one in journal.events(1, 1, 100)] == [5, 6, 7, 8]
    assert journal.events(2, 1, 100) == written
    write(journal, range(7, 7 + KEPT))
    assert (journal.kept(1), journal.kept(2)) == ((1, 0), (7, 6 + KEPT))
