"""A carrier has to come nearer: a liar runs out of time, and who is kept from driving does not."""

from __future__ import annotations

from msgspec.structs import replace
from spoken import rhb

from dray.messages import AtvHeartbeat, AtvStatus, HelpWanted, Phase, Pose, Reason
from dray.protocol.liveness.progress import EXCUSED_MAX_S, SLACK_MIN_S, STALL_S, Progress

PROMISED_S = 100.0


class Carrier:
    """A vehicle that beats once a second, and the progress that is expected of it."""

    def __init__(self) -> None:
        self.progress = Progress(PROMISED_S, STALL_S, 0.0)
        self.now_s = 0.0
        self.x_m = 0.0

    def beats(
        self,
        seconds: int,
        *,
        speed_mps: float = 0.0,
        phase: Phase = Phase.APPROACHING,
        held: bool = False,
        status: AtvStatus = AtvStatus.WORKING,
        help_s: float = 0.0,
        limit: float = 1.0,
    ) -> str:
        """The last verdict of so many seconds, or the first that is a failure."""
        for _ in range(seconds):
            self.now_s += 1.0
            self.x_m += speed_mps
            said: AtvHeartbeat = replace(
                rhb("ATV9", int(self.now_s), self.now_s, task="T1"),
                pose=Pose(self.x_m, 0.0, 0.0),
                status=status,
                help=HelpWanted(until_s=help_s) if help_s else None,
                speed_limit_frac=limit,
            )
            if failure := self.progress.on_heartbeat(said, phase, held, self.now_s):
                return failure
        return ""


def test_who_never_moves_has_failed_soon() -> None:
    carrier = Carrier()
    assert carrier.beats(1000) == Reason.STALLED
    assert carrier.now_s <= STALL_S + 3.0


def test_who_drives_and_keeps_its_promise_is_left_alone() -> None:
    carrier = Carrier()
    assert carrier.beats(40, speed_mps=1.0) == ""
    assert carrier.beats(20, phase=Phase.LOADING) == ""
    assert carrier.beats(30, speed_mps=1.0, phase=Phase.CARRYING) == ""
    assert carrier.progress.late_s < 0.0


def test_who_stands_behind_others_may_be_so_much_later_and_nobody_has_to_be_sooner() -> None:
    carrier = Carrier()
    carrier.progress.allow(PROMISED_S + 30.0)
    carrier.progress.allow(PROMISED_S - 30.0)
    assert carrier.beats(120, speed_mps=1.0) == ""
    assert carrier.progress.late_s == -10.0


def test_who_only_tells_of_ways_is_long_past_its_promise_in_the_end() -> None:
    carrier = Carrier()
    assert carrier.beats(1000, speed_mps=1.0) == Reason.OVERDUE
    assert carrier.now_s <= PROMISED_S + SLACK_MIN_S + 2.0


def test_phases_that_go_round_buy_no_time() -> None:
    carrier = Carrier()
    verdicts = [
        carrier.beats(20, phase=phase) for _ in range(20) for phase in (Phase.LOADING, Phase.APPROACHING)
    ]
    assert Reason.STALLED in verdicts


def test_who_waits_for_its_coordinator_is_not_to_blame() -> None:
    carrier = Carrier()
    assert carrier.beats(200, held=True) == ""
    assert carrier.progress.late_s <= 0.0 or carrier.progress.late_s < SLACK_MIN_S


def test_who_was_stopped_by_a_person_or_asks_for_help_is_not_to_blame() -> None:
    for status in (AtvStatus.STOPPED, AtvStatus.ERROR):
        carrier = Carrier()
        assert carrier.beats(600, status=status, help_s=1000.0) == ""
        assert carrier.beats(90, speed_mps=1.0) == ""


def test_who_was_told_to_drive_slowly_is_given_the_time() -> None:
    assert Carrier().beats(140, speed_mps=0.2, limit=0.5) == ""
    assert Carrier().beats(300, speed_mps=0.2, limit=0.5) == ""
    assert Carrier().beats(300, speed_mps=0.2) == Reason.OVERDUE


def test_excuses_end() -> None:
    carrier = Carrier()
    assert carrier.beats(10_000, status=AtvStatus.STOPPED, help_s=1e11) == Reason.STALLED
    assert carrier.now_s <= EXCUSED_MAX_S + STALL_S + 3.0
