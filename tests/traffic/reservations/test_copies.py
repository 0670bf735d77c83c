"""Copies of a reservation table: what counts, who may write, and what a lost memory means."""

from __future__ import annotations

from random import Random

import pytest
from trio import NAMES, Trio, line

from dray.messages.floor.traffic import PlaceReservation, TableAsked, TableReplicated, TableReported
from dray.protocol.runtime.events import NEVER_S, Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.numbers import FAR, LEAP_MAX, VERSION_LEAP
from dray.protocol.traffic.reservations.copies import Copies, Kept
from dray.protocol.traffic.reservations.turns import ASK_S, DOUBT_S, SILENT_AFTER, Turns

MOST = FAR // 2 + LEAP_MAX
"""The latest epoch that is believed when one alone tells it."""


def test_what_a_majority_has_counts() -> None:
    trio = Trio()
    leader = trio.lead("M1")
    trio.cut = {"M3"}
    leader.write(1, line("A", 1))
    assert leader.counted == 0
    trio.carry()
    assert leader.counted == 1


def test_whoever_is_cut_off_makes_nothing_count() -> None:
    trio = Trio()
    leader = trio.lead("M1")
    trio.cut = {"M1"}
    leader.write(1, line("A", 1))
    trio.carry()
    assert leader.counted == 0


def test_the_next_replica_knows_all_that_has_counted() -> None:
    trio = Trio()
    trio.lead("M1").write(1, line("A", 1))
    trio.carry()
    trio.cut = {"M1"}
    successor = trio.lead("M2")
    assert successor.leads
    assert successor.kept.reservations == line("A", 1)


def test_an_outdated_replica_steps_down_when_it_hears_of_the_next_one() -> None:
    trio = Trio()
    old = trio.lead("M1")
    trio.cut = {"M1"}
    trio.lead("M2").write(1, line("B", 1))
    trio.carry()
    trio.cut = set()
    old.write(1, line("A", 1))
    trio.carry()
    assert not old.leads
    assert old.counted == 0


def test_one_that_has_lost_its_memory_promises_nothing_and_keeps_nothing() -> None:
    life = Life()
    lost = Copies("M1", "M2", NAMES, None, life)
    lost.on_replicated(
        "M1", TableReplicated(district="M1", epoch=9, version=4, reservations=line("A", 4)), silent=True
    )
    assert life.effects == []
    lost.on_asked("M1", TableAsked(district="M1", epoch=12), silent=True)
    assert lost.kept.epoch == 0


def test_one_that_has_lost_its_memory_learns_it_from_all_others() -> None:
    trio = Trio()
    leader = trio.lead("M1")
    leader.write(1, line("A", 1))
    trio.carry()
    trio.replicas["M3"] = Copies("M1", "M3", NAMES, None, trio.lives["M3"])
    trio.cut = {"M2"}
    trio.replicas["M3"].ask()
    trio.carry()
    assert trio.replicas["M3"].lost
    trio.cut = set()
    trio.replicas["M3"].ask()
    trio.carry()
    assert not trio.replicas["M3"].lost
    assert trio.replicas["M3"].kept.reservations == line("A", 1)
    assert trio.replicas["M3"].kept.epoch == leader.kept.epoch


def test_when_two_have_lost_their_memory_the_first_of_them_runs_the_recovery_poll() -> None:
    trio = Trio()
    trio.lead("M1")
    for name in ("M2", "M3"):
        trio.replicas[name] = Copies("M1", name, NAMES, None, trio.lives[name])
    for name in ("M2", "M3"):
        trio.replicas[name].ask()
    trio.carry()
    assert trio.replicas["M2"].needs_recovery_poll
    assert not trio.replicas["M3"].needs_recovery_poll
    epoch = trio.replicas["M2"].next_turn(0)
    assert epoch > trio.replicas["M1"].kept.epoch


def test_whoever_is_lost_too_takes_the_table_of_the_recovery_poll() -> None:
    trio = Trio()
    for name in NAMES:
        trio.replicas[name] = Copies("M1", name, NAMES, None, trio.lives[name])
    for name in NAMES:
        trio.replicas[name].ask()
    trio.carry()
    assert [name for name in NAMES if trio.replicas[name].needs_recovery_poll] == ["M1"]
    caller = trio.replicas["M1"]
    caller.end_recovery_poll(3)
    caller.write(1, line("A", 1))
    trio.carry()
    assert caller.counted == 1
    for name in ("M2", "M3"):
        assert not trio.replicas[name].lost
        assert (trio.replicas[name].kept.epoch, trio.replicas[name].kept.reservations) == (3, line("A", 1))


def told_of(epoch: int, *, lost: bool) -> TableReported:
    return TableReported(district="M1", epoch=epoch, lost=lost, kept_epoch=0, version=0, reservations=())


@pytest.mark.parametrize(
    "told",
    [
        {},
        {"M1": told_of(2, lost=False), "M2": told_of(0, lost=True)},
        {"M1": told_of(0, lost=True), "M2": told_of(7, lost=False)},
        {"M1": told_of(0, lost=True)},
    ],
    ids=["nobody was heard", "the writer remembers", "a later epoch", "one was not heard"],
)
def test_whoever_is_lost_takes_no_table_that_may_lack_what_it_has_promised(
    told: dict[str, TableReported],
) -> None:
    """The writer remembers of old, or somebody may lead under a later epoch by a promise that is forgotten."""
    life = Life()
    lost = Copies("M1", "M3", NAMES, None, life)
    for replica, message in told.items():
        lost.on_reported(replica, message)
    assert not lost.needs_recovery_poll
    lost.on_replicated(
        "M1", TableReplicated(district="M1", epoch=3, version=4, reservations=line("A", 4)), silent=True
    )
    assert lost.lost
    assert life.effects == []


@pytest.mark.parametrize("epoch", [3, 3 * 2**18, 3 * 2**40])
def test_a_roll_is_called_under_a_later_epoch_than_any_that_is_remembered(epoch: int) -> None:
    """M1 remembers it, and vehicles that were started again know nothing of it."""
    trio = Trio()
    remembers, caller = trio.replicas["M1"], Copies("M1", "M2", NAMES, None, trio.lives["M2"])
    remembers.kept = Kept(epoch, epoch, 4, line("A", 4))
    trio.replicas |= {"M2": caller, "M3": Copies("M1", "M3", NAMES, None, trio.lives["M3"])}
    for name in ("M2", "M3"):
        trio.replicas[name].ask()
    trio.carry()
    called = caller.next_turn(0)
    assert called > epoch
    version = caller.end_recovery_poll(called)
    caller.write(version + 1, line("A", version + 1))
    trio.carry()
    assert caller.counted == version + 1 == 5
    assert trio.replicas["M3"].kept.reservations == line("A", 5)


def test_one_that_remembers_does_not_bring_the_recovery_poll_to_the_end_of_numbers() -> None:
    caller = Copies("M1", "M1", NAMES, None, Life())
    caller.on_reported("M2", told_of(FAR, lost=False))
    caller.on_reported("M3", told_of(0, lost=True))
    assert caller.needs_recovery_poll
    assert caller.next_turn(0) < MOST
    told = TableReported(district="M1", epoch=0, lost=False, kept_epoch=0, version=FAR, reservations=())
    for _ in range(9):
        caller.on_reported("M2", told)
    assert caller.end_recovery_poll(3) < FAR // 2 + VERSION_LEAP


def test_whoever_is_lost_takes_no_table_from_the_end_of_numbers() -> None:
    """Whoever has stolen the certificate of the other one that is lost has told of that epoch before, too."""
    lost = Copies("M1", "M3", NAMES, None, Life())
    epoch = FAR - FAR % 3
    lost.on_reported("M1", told_of(epoch, lost=True))
    lost.on_reported("M2", told_of(5, lost=False))
    lost.on_replicated(
        "M1", TableReplicated(district="M1", epoch=epoch, version=4, reservations=()), silent=True
    )
    assert lost.lost
    assert lost.kept == Kept()


@pytest.mark.parametrize(
    ("one", "other", "least", "most"),
    [(FAR, 5, 5, MOST), (5, 8, 8, 8), (MOST + 7, MOST + 9, MOST + 9, MOST + 9)],
)
def test_of_two_that_remember_one_alone_does_not_bring_a_lost_one_to_the_end_of_numbers(
    one: int, other: int, least: int, most: int
) -> None:
    lost = Copies("M1", "M3", NAMES, None, Life())
    lost.on_reported("M1", told_of(one, lost=False))
    lost.on_reported("M2", told_of(other, lost=False))
    assert not lost.lost
    assert least <= lost.kept.epoch <= most


def test_one_replica_alone_is_its_own_majority() -> None:
    life = Life()
    alone = Copies("M1", "M1", ("M1",), Kept(), life)
    alone.seek()
    assert alone.leads
    alone.write(1, line("A", 1))
    assert alone.counted == 1


@pytest.mark.parametrize("seed", range(40))
def test_two_versions_never_both_count_whatever_is_lost(seed: int) -> None:
    """Replicas seek and write at random while messages are lost, late and doubled: what has counted is never forgotten."""
    random = Random(seed)
    trio = Trio()
    under_way: list[tuple[str, Send]] = []
    counted: dict[int, tuple[PlaceReservation, ...]] = {}
    written: dict[tuple[str, int, int], tuple[PlaceReservation, ...]] = {}
    for step in range(300):
        trio.cut = {name for name in NAMES if random.random() < 0.5}
        for sender, life in trio.lives.items():
            for effect in life.effects:
                assert isinstance(effect, Send)
                under_way += [(sender, effect)] * random.choice((0, 1, 1, 1, 2))
            life.effects.clear()
        move = random.random()
        name = random.choice(NAMES)
        replica = trio.replicas[name]
        if move < 0.75 and under_way:
            trio.deliver(*under_way.pop(random.randrange(len(under_way))))
        elif move < 0.82:
            replica.seek()
        elif move < 0.87:
            replica.ask()
        elif replica.leads:
            version = replica.kept.version + 1
            written[name, replica.kept.epoch, version] = line(f"V{step}", version)
            replica.write(version, line(f"V{step}", version))
        for name, replica in trio.replicas.items():
            if replica.leads and replica.counted:
                table = written.get((name, replica.kept.epoch, replica.counted))
                if table is not None:
                    assert counted.setdefault(replica.counted, table) == table


def test_a_replica_that_asks_for_promises_goes_on_with_the_one_that_lives() -> None:
    """It has not heard it for a while, and stays a replica: nothing of what is written meanwhile is refused."""
    trio = Trio()
    leader = trio.lead("M1")
    trio.replicas["M2"].seek()
    trio.carry()
    assert not trio.replicas["M2"].asks
    trio.cut = {"M3"}
    leader.write(1, line("A", 1))
    trio.carry()
    assert (leader.counted, trio.replicas["M2"].kept.reservations) == (1, line("A", 1))


def test_one_that_was_promised_to_somebody_who_died_then_is_won_back_by_a_later_epoch() -> None:
    """M3 has promised M2, which says nothing more; M1 lives, and needs M3."""
    trio = Trio()
    leader = trio.lead("M1")
    promised = leader.kept.epoch + 1
    trio.replicas["M3"].on_asked("M2", TableAsked(district="M1", epoch=promised), silent=True)
    trio.cut = {"M2"}
    leader.write(1, line("A", 1))
    trio.carry()
    assert (leader.counted, leader.is_outvoted) == (0, True)
    trio.lead("M1").write(2, line("A", 2))
    trio.carry()
    assert leader.counted == 2


# --- whether the replica before lives ---------------------------------------------------------------


def test_nobody_asks_whether_a_replica_lives_of_whom_nobody_wants_anything() -> None:
    turns = Turns("M2", ("M1", "M2", "M3"))
    assert (turns.asked(0, 0.0), turns.mine_at_s(0, 0.0)) == ((), NEVER_S)
    assert turns.mine_at_s(1, 5.0) == 5.0


def test_a_replica_that_does_not_answer_is_followed_by_the_next_one_and_one_that_does_is_not() -> None:
    turns = Turns("M3", ("M1", "M2", "M3"))
    assert turns.doubt(10.0)
    assert not turns.doubt(11.0)
    assert turns.asked(0, 10.0) == ("M1", "M2")
    assert turns.mine_at_s(0, 11.0) == 10.0 + DOUBT_S
    turns.on_replica("M2", 11.0)
    assert (turns.mine_at_s(0, 11.0), turns.asked(0, 11.0)) == (NEVER_S, ())
    assert turns.doubt(12.0)
    assert turns.mine_at_s(0, 12.0) == 12.0 + DOUBT_S
    assert turns.asked(1, 12.0) == ("M1", "M2")


def test_a_replica_is_silent_that_has_answered_none_of_four_questions() -> None:
    turns = Turns("M3", ("M1", "M2", "M3"))
    assert turns.watch(10.0)
    assert turns.asked(0, 10.0) == ("M1",)
    for question in range(SILENT_AFTER):
        assert not turns.is_silent("M1", 10.0 + question * ASK_S)
        turns.on_question("M1", 10.0 + question * ASK_S)
        turns.on_question("M1", 10.0 + question * ASK_S)
    now_s = 10.0 + SILENT_AFTER * ASK_S
    assert turns.silent(now_s) == ("M1",)
    turns.on_replica("M1", now_s)
    assert turns.silent(now_s) == ()


def test_nobody_asks_on_when_the_present_replica_has_answered() -> None:
    turns = Turns("M3", ("M1", "M2", "M3"))
    turns.watch(10.0)
    turns.on_replica("M1", 10.1)
    assert turns.asked(0, 10.5) == ()
