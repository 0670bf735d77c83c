"""A secondary's watches: it guards, and reserves nothing (protocol, step 4)."""

from __future__ import annotations

import msgspec
import pytest
from defaults import KEYS
from effects import facts, listening, sent
from spoken import award, rhb

from dray.messages import Award, Reason, Release, Resigned, Role
from dray.messages.fact import ContractEnded, ContractTaken, PrimarySuspected
from dray.protocol.liveness.failure_detector import FailureDetector, HeartbeatSubscriptions
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.takeover.standby import OVER_AFTER_S, Standby

BOUND_S = bound_s(WORKING_INTERVAL_S)


def watch(task: str = "M8-1", primary: str = "ATV2", epoch: int = 1, number: int = 1) -> Award:
    return award(task=task, role=Role.SECONDARY, primary=primary, epoch=epoch, number=number)


class StandbyRig:
    """The watches of ATV1, and the time."""

    def __init__(self) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.now_s = 0.0
        self.following = HeartbeatSubscriptions(KEYS.atv_heartbeat, self.life)
        self.standby = Standby(self.following, self.life)

    def watch(self, order: Award) -> None:
        self.standby.watch(order, "M8", self.now_s)

    def hears(self, seq: int, at_s: float, atv: str = "ATV2", task: str = "M8-1") -> None:
        self.now_s = at_s
        self.standby.on_heartbeat(rhb(atv, seq, at_s, task=task), at_s)

    def run(self, until_s: float) -> None:
        while self.life.timers.next_s <= until_s:
            self.now_s = self.life.timers.next_s
            for _, task in self.life.timers.due(self.now_s):  # type: ignore[misc]
                self.standby.failed(task, self.now_s)
        self.now_s = until_s

    @property
    def suspicions(self) -> list[PrimarySuspected]:
        return facts(self.life.effects, PrimarySuspected)

    @property
    def ended(self) -> list[tuple[str, str]]:
        return [(fact.task, fact.reason) for fact in facts(self.life.effects, ContractEnded)]


def test_a_watch_listens_to_the_primary_and_is_told_in_the_heartbeat() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    assert listening(rig.out) == {KEYS.atv_heartbeat("ATV2")}
    [brief] = rig.standby.briefs()
    assert (brief.task, brief.role, brief.coordinator, brief.phase) == ("M8-1", Role.SECONDARY, "M8", None)
    [taken] = facts(rig.out, ContractTaken)
    assert taken.role is Role.SECONDARY


def test_a_primary_that_is_silent_beyond_the_bound_is_suspected_once() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.run(BOUND_S - 0.001)
    assert rig.suspicions == []
    rig.run(60.0)
    [suspected] = rig.suspicions
    assert suspected.primary == "ATV2"
    assert suspected.silent_s == pytest.approx(BOUND_S)


def test_a_primary_that_beats_is_never_suspected() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    for second in range(1, 100):
        rig.run(float(second))
        rig.hears(second, float(second))
    assert rig.suspicions == []


def test_a_suspect_that_speaks_up_may_be_suspected_again() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.run(10.0)
    rig.hears(1, 10.0)
    rig.run(30.0)
    assert len(rig.suspicions) == 2
    assert rig.suspicions[1].silent_s == pytest.approx(BOUND_S)


def test_time_in_which_the_vehicle_itself_was_held_up_is_no_silence_of_its_primary() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.hears(1, 1.0)
    rig.following.arrivals.deaf_s += 10.0
    rig.run(1.0 + BOUND_S + 9.9)
    assert rig.suspicions == []
    rig.run(1.0 + BOUND_S + 10.1)
    assert len(rig.suspicions) == 1


def test_a_primary_that_was_heard_since_then_is_suspected_as_soon_as_ever() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.following.arrivals.deaf_s += 10.0
    rig.hears(1, 11.0)
    rig.run(11.0 + BOUND_S + 0.1)
    assert len(rig.suspicions) == 1


def test_an_old_heartbeat_is_no_sign_of_life() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.hears(7, 1.0)
    rig.hears(6, 3.0)
    rig.hears(7, 4.0)
    rig.run(5.0)
    assert len(rig.suspicions) == 1


def test_a_heartbeat_of_an_earlier_life_is_no_sign_of_life() -> None:
    detector = FailureDetector("ATV2", WORKING_INTERVAL_S, 0.0)
    detector.on_heartbeat(msgspec.structs.replace(rhb("ATV2", 1, 1.0, task="T"), incarnation=2), 1.0)
    detector.on_heartbeat(rhb("ATV2", 99, 3.0, task="T"), 3.0)
    assert detector.heard_s == 1.0


def test_the_bound_follows_what_the_primary_says_of_itself() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.hears(1, 1.0, task="")
    rig.run(15.0)
    assert rig.suspicions == []
    rig.run(17.0)
    assert len(rig.suspicions) == 1


def test_an_ended_watch_is_silent_and_forgotten() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.standby.unwatch("M8-1", "the task has ended")
    rig.standby.unwatch("M8-1", "the task has ended")
    assert listening(rig.out) == set()
    assert rig.life.timers.next_s == NEVER_S
    assert rig.ended == [("M8-1", "the task has ended")]
    assert "M8-1" not in rig.standby
    assert rig.standby.failed("M8-1", 100.0) is None
    assert rig.suspicions == []


@pytest.mark.parametrize(
    ("number", "let_go"),
    [(1, False), (2, True), (3, False)],
)
def test_a_watch_is_released_by_the_number_of_the_award_that_has_asked_for_it(
    number: int, let_go: bool
) -> None:
    rig = StandbyRig()
    rig.watch(watch(epoch=2, number=2))
    release = Release(task="M8-1", epoch=2, role=Role.SECONDARY, reason=Reason.TASK_ENDED, number=number)
    assert rig.standby.release(release) is let_go
    assert ("M8-1" in rig.standby) is not let_go


def test_a_release_of_what_is_not_watched_is_noticed_and_changes_nothing() -> None:
    rig = StandbyRig()
    release = Release(task="M8-1", epoch=1, role=Role.SECONDARY, reason=Reason.TASK_ENDED)
    assert not rig.standby.release(release)
    assert rig.out == []


def test_all_watches_are_given_back_to_their_coordinator() -> None:
    rig = StandbyRig()
    rig.watch(watch("M8-1", "ATV2"))
    rig.watch(watch("M8-2", "ATV3"))
    rig.standby.resign(Reason.HAS_WORK)
    resigned = sent(rig.out, Resigned, to="M8")
    assert [(message.task, message.role) for message in resigned] == [
        ("M8-1", Role.SECONDARY),
        ("M8-2", Role.SECONDARY),
    ]
    assert len(rig.standby) == 0
    assert listening(rig.out) == set()
    rig.standby.resign("again")
    assert len(sent(rig.out, Resigned)) == 2


def test_one_primary_may_be_watched_for_two_tasks_and_is_heard_until_both_are_over() -> None:
    rig = StandbyRig()
    rig.watch(watch("M8-1", "ATV2"))
    rig.watch(watch("M8-2", "ATV2"))
    rig.standby.unwatch("M8-1", "the task has ended")
    assert listening(rig.out) == {KEYS.atv_heartbeat("ATV2")}
    rig.standby.unwatch("M8-2", "the task has ended")
    assert listening(rig.out) == set()


def test_a_newer_epoch_of_a_task_replaces_the_older_one() -> None:
    rig = StandbyRig()
    rig.watch(watch(epoch=1, primary="ATV2"))
    rig.watch(watch(epoch=2, primary="ATV3"))
    assert len(rig.standby) == 1
    assert rig.standby.holds("M8-1", 2)
    assert not rig.standby.holds("M8-1", 1)
    assert listening(rig.out) == {KEYS.atv_heartbeat("ATV3")}
    assert rig.ended == [("M8-1", "renewed")]


def test_a_watch_whose_release_was_lost_ends_when_the_primary_does_other_work() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    rig.hears(1, 1.0)
    for second in range(2, 2 + int(OVER_AFTER_S) + 2):
        rig.hears(second, float(second), task="M3-4")
    assert rig.ended == [("M8-1", "over")]


def test_a_primary_that_names_the_task_again_stays_watched() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    for second in range(1, 60):
        rig.hears(second, float(second), task="M8-1" if second % 10 == 0 else "")
    assert rig.ended == []


def test_heartbeats_of_others_mean_nothing() -> None:
    rig = StandbyRig()
    rig.watch(watch())
    for second in range(1, 60):
        rig.hears(second, float(second), atv="ATV9")
    rig.run(60.0)
    assert len(rig.suspicions) == 1
    assert rig.ended == []
