"""The primaries of a coordinator's tasks: whether they live, and the consequences of a failure.

A failed primary is replaced by its secondary within TAKEOVER_TIMEOUT_S; otherwise its task is announced anew.
Either way the epoch rises. The epoch is the fence: there is one carrier, even if another believes to be it.

    ASSIGNED --failed, with a secondary--> SUSPECTED --TakenOver--> ASSIGNED to another, epoch + 1
       |  ^                                  |  |
       |  +------- heard again --------------+  +-- nobody takes over --> announced anew, epoch + 1
       +-- failed, and was silent already when the secondary began --> that one is asked, epoch + 1
       +-- failed without a secondary, restarted without it --> announced anew, epoch + 1
       +-- given back, no progress --> the secondary is asked, epoch + 1; else announced anew
       +-- no progress at a dock, like the carrier before it --> held

A carrier that lives without progress has failed too (`progress`). Its secondary does not see that, so it is asked.
Where two carriers in a row stand at one dock in vain, or one alone time after time, the task is held (`dock_failures`).

Finished goods that have left their machine exist only once, and so does a thing without master data. No other
vehicle can carry them, so their task waits for its carrier or for a person's decision (`left_aboard`). A load that
was counted in the buffer is delivered, even if its carrier fails before it reports that.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, cast

from msgspec import UNSET

from dray.messages import THING, AtvHeartbeat, Phase, Reason, TakenOver, Transport
from dray.messages.fact import CarrierChanged, PrimarySuspected
from dray.messages.heartbeat import GOODS_ABOARD
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.contract_net.trust.dock_failures import Fault
from dray.protocol.liveness.failure_detector import (
    UNNAMED_S,
    FailureDetector,
    HeartbeatSubscriptions,
)
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.takeover.left_aboard import LeftAboard
from dray.protocol.takeover.secondaries import Secondaries

TAKEOVER_TIMEOUT_S = 2.0
"""Time for a secondary to take over after its primary has failed (s), beside the delay of one message. Both detectors hear
the same heartbeats, within each other's lateness."""

PRIMARY_SILENCE = "primary silence"


class Remedies(Protocol):
    """A coordinator's remedies for a task without a carrier, and what it knows of the task's load."""

    def is_missing(self, task: OpenTask) -> bool:
        """Whether the coordinator's own sensors no longer see its load, although no vehicle has fetched it."""
        ...

    def source_answers(self, task: OpenTask, now_s: float) -> bool:
        """Whether the station that has its load lives."""
        ...

    def reopen(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Announce it anew, with a higher epoch."""
        ...

    def pass_on(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Ask its secondary to carry it, with a higher epoch."""
        ...

    def hold(self, task: OpenTask, now_s: float, *, fails_at: str) -> None:
        """Release its carrier; no vehicle carries it before a person has looked at the place where carriers fail."""
        ...

    def wait(self, task: OpenTask, trouble: Reason, now_s: float) -> None:
        """Report in the heartbeat why it does not progress."""
        ...

    def give_up(self, task: OpenTask, now_s: float) -> None:
        """Withdraw it: its goods are lost."""
        ...

    def conclude(self, task: OpenTask, now_s: float) -> None:
        """Close it as delivered: its load was counted, although no handover was received."""
        ...


class Failover:
    """The watch over the primaries of one coordinator.

    Args:
        tasks: the coordinator's open tasks, by id.
        secondaries: the tasks' secondaries.
        subscriptions: the coordinator's heartbeat subscriptions.
        life: the agent's life; alarms are named ``(PRIMARY_SILENCE, task)``.
        remedies: the coordinator.
        assessor: the expected progress and the ratings of carriers.

    Attributes:
        aboard: goods that were left on board.
        alarms: handlers of this class's alarms, called with (task, now_s).
    """

    def __init__(
        self,
        tasks: Mapping[str, OpenTask],
        secondaries: Secondaries,
        subscriptions: HeartbeatSubscriptions,
        life: Life,
        remedies: Remedies,
        assessor: Assessor,
    ) -> None:
        self._tasks = tasks
        self._secondaries = secondaries
        self._subscriptions = subscriptions
        self._life = life
        self._remedies = remedies
        self._assessor = assessor
        self.aboard = LeftAboard(tasks, life, remedies)
        self.alarms = {PRIMARY_SILENCE: self._check, **self.aboard.alarms}

    def follow(self, task: OpenTask, interval_s: float, now_s: float) -> None:
        """A task has a primary, which is expected to beat every `interval_s`."""
        task.clear_trouble()
        self._subscriptions.follow(task.primary)
        task.contract.detector = FailureDetector(
            task.primary, interval_s, now_s, self._subscriptions.arrivals
        )
        self._life.alarm((PRIMARY_SILENCE, task.id), task.contract.detector.fails_at_s)
        # The progress under an earlier life's contract is unknown.
        promised_s = task.contract.promised_s if task.witnessed else self._assessor.latest_s(task.work, now_s)
        task.contract.progress = self._assessor.progress(promised_s, now_s)

    def leave(self, task: OpenTask) -> None:
        """A task has ended, or its primary was replaced."""
        if task.contract.detector is not None:
            self._subscriptions.unfollow(task.contract.detector.subject)
        self._life.cancel((PRIMARY_SILENCE, task.id))
        task.clear_trouble()

    def note_loaded(self, task: OpenTask) -> None:
        """The goods or thing are on board. The secondary keeps watching: it is asked first if a person hands them over."""
        if not task.is_loaded and not task.is_counted:
            task.states.enter(TaskState.IN_TRANSIT)
            self.aboard.forget(task)
            self._secondaries.seek_no_more(task)
            self._life.commit()

    def on_heartbeat(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Handle a heartbeat of the primary, which may have lost its contract."""
        detector = task.contract.detector
        if detector is None or not detector.on_heartbeat(heartbeat, now_s):
            return
        self._trust(task)
        task.trouble = Reason.PROBLEM if heartbeat.problem else None
        task.detail = heartbeat.problem
        self._life.alarm((PRIMARY_SILENCE, task.id), detector.fails_at_s)
        brief = heartbeat.task
        if brief is not None and brief.task == task.id and brief.epoch == task.epoch:
            task.contract.unnamed_s = NEVER_S
            if task.exists_once and brief.phase in GOODS_ABOARD and self._may_have_left(task):
                self.note_loaded(task)
            self._look_at_progress(task, heartbeat, now_s)
            if not detector.failure(now_s) and not self._is_stuck(task):
                self.aboard.goes_on(task)
        elif task.contract.unnamed_s == NEVER_S:
            task.contract.unnamed_s = now_s
        elif task.contract.forgotten_aboard:
            if heartbeat.load == THING:
                self.aboard.note_place(task, heartbeat.node)
        elif now_s - task.contract.unnamed_s > UNNAMED_S:
            self.replace(task, Reason.FORGOTTEN, now_s)

    def objection(self, task: OpenTask, sender: str, message: TakenOver, now_s: float) -> Reason | None:
        """Why a takeover is refused; None if it is right."""
        if sender != task.secondary:
            return Reason.ANOTHER_WATCHES
        if message.primary != task.primary:
            return Reason.ANOTHER_CARRIES
        if task.is_counted:
            return Reason.LOAD_DOWN
        if task.is_loaded:
            return Reason.LOAD_ABOARD
        detector = task.contract.detector
        if detector is not None and detector.heard_lately(now_s) and not detector.failure(now_s):
            return Reason.IS_HEARD
        return None

    def replace(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Replace the primary when no secondary has taken over."""
        if task.is_counted:
            self._remedies.conclude(task, now_s)
            return
        self.blame(task, reason, now_s)
        if not task.is_loaded:
            self._remedies.reopen(task, reason, now_s)
        else:
            self._wait_for_goods(task, reason, now_s)

    def note_given_back(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """The primary has given a task back without need."""
        self._assessor.reliability.note_given_back(task.primary, task.id, reason, now_s)

    def note_short(self, task: OpenTask, place: str, reason: Reason, now_s: float) -> None:
        """The primary has given a task back because it gets no load at a place that has promised it."""
        is_held = reason is Reason.DOCK_HELD
        if not is_held or self._note_dock_failure(task, place, reason, now_s) is not Fault.PLACE:
            self.note_given_back(task, reason, now_s)

    def give_back(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """The primary lives and gives a task back: it can be relieved."""
        if task.is_counted or task.is_loaded:
            self.replace(task, reason, now_s)
        else:
            if not self._assessor.is_floor_restricted:
                self.note_given_back(task, reason, now_s)
            self._remedies.pass_on(task, reason, now_s)

    def blame(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Note once that the primary has dropped its contract."""
        if task.contract.progress is not None and not task.contract.progress.blamed:
            task.contract.progress.blamed = True
            self._assessor.reliability.note_dropped(task.primary, task.id, reason, now_s)

    def note_change(self, task: OpenTask, replaced: str, reason: Reason, silent_s: float) -> None:
        """Record that a task has another carrier, or none for now."""
        changed = CarrierChanged(
            task=task.id,
            epoch=task.epoch,
            replaced=replaced,
            carrier=task.primary,
            reason=reason,
            silent_s=silent_s,
        )
        self._life.record(changed)

    def silent_s(self, task: OpenTask, now_s: float) -> float:
        """How long the primary has been silent (s)."""
        return max(0.0, now_s - task.contract.detector.heard_s) if task.contract.detector is not None else 0.0

    # --- internals ---

    def _check(self, task_id: str, now_s: float) -> None:
        task = self._tasks.get(task_id)
        detector = task.contract.detector if task is not None else None
        if task is None or detector is None:
            return
        failure = detector.failure(now_s)
        if not failure:
            self._trust(task)
            self._life.alarm((PRIMARY_SILENCE, task.id), detector.fails_at_s)
            return
        self._note_suspicion(task, now_s)
        standby = task.standby.detector
        if task.state is not TaskState.ASSIGNED or standby is None:
            self.replace(task, failure, now_s)
        elif detector.heard_s < standby.begun_s:
            # The secondary has never heard the primary, and so allows it more time than this coordinator.
            self.blame(task, failure, now_s)
            self._remedies.pass_on(task, failure, now_s)
        else:
            task.states.enter(TaskState.SUSPECTED)
            self._life.alarm((PRIMARY_SILENCE, task.id), now_s + TAKEOVER_TIMEOUT_S + detector.delay_s)

    def _trust(self, task: OpenTask) -> None:
        """The primary is heard again: it keeps its task."""
        if task.state is TaskState.SUSPECTED:
            task.states.enter(TaskState.ASSIGNED)

    def _may_have_left(self, task: OpenTask) -> bool:
        """Whether a reported load may be on board: this coordinator was down or misses it, or it was elsewhere."""
        elsewhere = task.is_thing or bool(cast(Transport, task.work).handed_at)
        return elsewhere or not task.witnessed or self._remedies.is_missing(task)

    def _is_stuck(self, task: OpenTask) -> bool:
        """Whether its carrier makes no progress."""
        return task.contract.progress is not None and task.contract.progress.failed_s < NEVER_S

    def _look_at_progress(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> None:
        progress, brief = task.contract.progress, heartbeat.task
        if progress is None or brief is None:
            return
        held = task.contract.held_s < NEVER_S or self._assessor.is_floor_restricted
        held = held or (heartbeat.floor is not UNSET and heartbeat.floor.waits)
        if brief.phase is Phase.LOADING and progress.stands_long(brief.phase, now_s):
            held = held or not self._remedies.source_answers(task, now_s)
        failure = progress.on_heartbeat(heartbeat, brief.phase, held, now_s)
        if not failure:
            return
        if task.is_counted:
            self._remedies.conclude(task, now_s)
            return
        place = self._stands_in_vain_at(task, heartbeat, now_s) if failure is Reason.STALLED else ""
        fault = self._note_dock_failure(task, place, failure, now_s) if place else Fault.CARRIER
        if fault is not Fault.PLACE:
            self.blame(task, failure, now_s)
        progress.blamed = True
        if task.is_loaded:
            self.aboard.strand(task, now_s)
            task.trouble, task.detail = failure, ""
        elif fault is not Fault.CARRIER:
            self._remedies.hold(task, now_s, fails_at=place)
        else:
            self._remedies.pass_on(task, failure, now_s)

    def _stands_in_vain_at(self, task: OpenTask, heartbeat: AtvHeartbeat, now_s: float) -> str:
        """The place that the primary, which has stalled, says something of; empty for none."""
        progress, brief, work = task.contract.progress, heartbeat.task, cast(Transport, task.work)
        if progress is None or progress.blamed or brief is None:
            return ""
        if brief.phase is Phase.LOADING and self._remedies.source_answers(task, now_s):
            place = task.contract.source
        elif brief.phase is Phase.UNLOADING:
            place = work.destination
        else:
            return ""
        return place if self._assessor.stands_in_vain(work, place, heartbeat) else ""

    def _note_dock_failure(self, task: OpenTask, place: str, reason: Reason, now_s: float) -> Fault:
        """Note that the primary stood at a place in vain. Returns who is at fault."""
        return self._assessor.note_dock_failure(place, task.work_item, reason, task.primary, task.id, now_s)

    def _note_suspicion(self, task: OpenTask, now_s: float) -> None:
        if task.state is TaskState.SUSPECTED or task.trouble:
            return  # It is recorded already.
        suspected = PrimarySuspected(
            task=task.id, epoch=task.epoch, primary=task.primary, silent_s=self.silent_s(task, now_s)
        )
        self._life.record(suspected)

    def _wait_for_goods(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        detector = cast(FailureDetector, task.contract.detector)
        last = detector.last
        if task.is_thing and reason is Reason.FORGOTTEN and last is not None and last.load == THING:
            # A person takes it off, even if its carrier reports otherwise later.
            task.contract.forgotten_aboard = True
        if task.contract.forgotten_aboard or detector.failure(now_s):
            self.aboard.strand(task, now_s)
            self._remedies.wait(task, reason, now_s)
        elif task.is_of_goods or cast(Transport, task.work).handed_at:
            self._remedies.give_up(task, now_s)
        else:
            # Its carrier lives without the thing: search where it was.
            self.aboard.forget(task)
            self._remedies.reopen(task, reason, now_s)
