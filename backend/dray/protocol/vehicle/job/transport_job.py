"""A contracted transport of its carrier: approach, load, carry, unload, hand over. Its states are in `job_state`.

The carrier asks at every dock first. The coordinator opens its own dock only to the present epoch, a storage's
station only to the vehicle with the reservation. At a storage without the load the carrier waits while it can keep
its promise. Then it gives the task back. A delivery warehouse's gate fences finished goods instead: it knows what
each goal may still bring. A coordinator that does not answer `job_messages.GIVE_UP_AFTER` questions has failed, and
the load goes back.

After a takeover the carrier drives before its coordinator has confirmed. A carrier that gives a task back before
loading stands until its coordinator has superseded it: until then it is bound.

Its moves are in `job_moves`, its messages in `job_messages`.
"""

from __future__ import annotations

from math import inf
from typing import Any, cast

import msgspec

from dray.errors import NoWay
from dray.memory import Contract
from dray.messages import (
    THING,
    Brief,
    Confirmed,
    DockHeld,
    DockOpened,
    HandoverAccepted,
    Message,
    Phase,
    Reason,
    Role,
    Superseded,
    Withdrawn,
)
from dray.messages.fact import PhaseEntered
from dray.plant import Plant
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.wait import SHUT_OUT_S
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.job.job_messages import JobMessages
from dray.protocol.vehicle.job.job_moves import JobMoves
from dray.protocol.vehicle.job.job_state import LOADED, MANOEUVRES, VOID, JobState, JobStates
from dray.protocol.vehicle.people.assistance import Waiting

WAITS_AT_LEAST_S = 15.0
"""Minimum wait at a storage without the load, even past its promise (s): the station may have restarted. Shorter than its
coordinator's time-out for standing still (`progress.STALL_S`)."""

ASKS_AGAIN_S = 300.0
"""Time after which a load that was only available behind a silent vehicle is given back (s): other places may have it by
then."""

REFUGE_HELD_S = 60.0
"""Time after which a storage that has not taken a load back is given up (s): as long as a dock may take to get ready."""

TRIES = 3
"""Maximum manoeuvres at one place before another one is sought."""


class TransportJob:
    """One transport of one vehicle: its events, and its next step.

    Args:
        contract: its contract.
        plant, vehicle_type: for ways and handling times.
        driver: the vehicle's place on the lanes.

    Attributes:
        due_s: the expected handover (plant clock).
        ended: why it is over; None while it lasts.
        detail: the reason in the words of the agent or device that held it up; empty for none.
        is_untold: whether it is over while its load is down at its destination, and its coordinator has not answered that.
        number: number of the binding award; 0 for a takeover.
    """

    def __init__(
        self, contract: Contract, plant: Plant, vehicle_type: str, driver: Driver, life: Life
    ) -> None:
        self._contract = contract
        self.task = contract.task
        self.epoch = contract.epoch
        self.work = contract.work
        self.coordinator = contract.coordinator
        self.source = contract.source
        self.promised_s = contract.promised_s
        self.due_s = contract.promised_s
        self.ended: Reason | None = None
        self.detail = ""
        self.is_untold = False
        self.number = contract.number
        self._life = life
        self._states = JobStates(contract.phase)
        self._moves = JobMoves(contract, plant, vehicle_type, driver, life)
        self._messages = JobMessages(contract, life)
        self._station = contract.source
        """The station where it drives to or stands."""
        self._cut_off = False
        """Whether closures leave no way to its station: it waits elsewhere."""
        self._was_shut_out = self._moves.is_shut_out_of(contract.source)
        """Whether an obstacle blocked the source when the contract was made: no other source had the load then."""
        self._short = ""
        """The storage that lacked the load or cannot be reached, if the task was given back for that."""
        self._void = contract.cancelled
        """Why the contract is void; None while it binds."""
        self._stands_s = NEVER_S
        """Since when it waits at its source, or where it returns its load."""
        self._given_back: Reason | None = None
        """Why the coordinator was asked for another carrier."""
        self._may_be_dropping = False
        """Whether an earlier life was unloading, or would have brought its load back: its drop may still be under way."""
        self._pick_over_s = -NEVER_S
        """When an earlier life's pick is over at the latest (plant clock)."""
        self._failed = 0
        """Failed manoeuvres at this station."""
        self._refused = contract.refused
        """How often the gate has refused the load, over all lives of the vehicle."""

    @property
    def state(self) -> JobState:
        """Its state."""
        return self._states.now

    @property
    def phase(self) -> Phase:
        """The phase that other agents see."""
        return self._states.phase

    @property
    def is_void(self) -> bool:
        """Whether the contract is void, even if the load is still on its way back."""
        return self.state in VOID

    @property
    def is_given_back(self) -> bool:
        """Whether it ends with the coordinator's answer."""
        return self.state is JobState.GIVING_BACK

    @property
    def slack_s(self) -> float:
        """How much later than expected it may be done (s)."""
        return self._contract.deadline_s - self.due_s

    def answers_at(self, station: str) -> str:
        """The agent that opens a place's dock; the coordinator if people hand the load over there."""
        return self.coordinator if station == self.work.handed_at else station

    def is_meant_by(self, message: Any) -> bool:
        """Whether a coordinator's message is about this contract; a Superseded carries another epoch."""
        return self.task == message.task and (type(message) is Superseded or message.epoch == self.epoch)

    def brief(self) -> Brief:
        """Its entry in the vehicle's heartbeat."""
        return Brief(
            task=self.task,
            epoch=self.epoch,
            role=Role.PRIMARY,
            coordinator=self.coordinator,
            phase=self.phase,
            item=self.work.item,
            quantity=self.work.quantity,
            due_s=self.due_s,
        )

    def memory(self) -> Contract:
        """Its record for the vehicle's next life."""
        return msgspec.structs.replace(
            self._contract,
            phase=self.phase,
            cancelled=self._void,
            number=self.number,
            refused=self._refused,
            claim=self._contract.claim if self._messages.is_claiming else None,
        )

    # --- events ---

    def set_off(self, now_s: float) -> None:
        """Set off for the source."""
        self._enter(JobState.APPROACHING, self.source)
        self._drive(self.source, now_s)

    def take_over(self, now_s: float) -> None:
        """Set off in place of a failed vehicle, and repeat the takeover until the coordinator has confirmed it."""
        self._messages.tell_bound(self.number, now_s)
        self.set_off(now_s)

    def resume(self, load: str, now_s: float) -> None:
        """Continue after a restart, according to the load on board.

        The acceptance is repeated: a coordinator that has another carrier says so now, and not at the end of a long
        way.
        """
        loaded = load == self.work.item
        self._may_be_dropping = self.phase in (Phase.UNLOADING, Phase.RETURNING)
        if self.phase is Phase.LOADING and self._moves.stands_at(self.source):
            self._pick_over_s = now_s + self._moves.loading_s()
        if not self._void:
            self._messages.tell_bound(self.number, now_s)
        if self._void and loaded:
            self._return(now_s)
        elif self._void and self._may_be_dropping:
            self._end_void()
        elif self._void:
            self._leave_empty(self._void, now_s)
        elif loaded:
            self._carry(now_s)
        elif self.phase in (Phase.UNLOADING, Phase.HANDING_OVER):
            self._hand_over(now_s)
        elif self.phase in (Phase.CARRYING, Phase.RETURNING):
            self._miss_load(now_s)
        else:
            self.set_off(now_s)

    def arrived(self, now_s: float) -> None:
        """The vehicle has arrived."""
        match self.state:
            case _ if self._cut_off:
                pass
            case JobState.APPROACHING:
                self._enter(JobState.AT_SOURCE, self.source)
                self._stands_s = now_s
                self._moves.expect_to_load(now_s, docked=True)
                self._ask_for_dock(now_s)
            case JobState.CARRYING:
                self._enter(JobState.AT_DESTINATION, self.work.destination)
                self._moves.expect_to_unload(now_s, docked=True)
                self._ask_to_unload(now_s)
            case JobState.RETURNING if self._moves.has_station(self._station):
                self._states.enter(JobState.AT_REFUGE)
                self._stands_s = now_s
                self._ask_to_put_back(now_s)
            case JobState.RETURNING:
                self._drop(JobState.PUTTING_BACK)

    def floor_changed(self, now_s: float) -> None:
        """Closures have changed: take open ways. A vehicle at a dock finishes there first."""
        if self.state in (JobState.APPROACHING, JobState.CARRYING, JobState.RETURNING):
            self._drive_on(now_s)
        elif self.is_given_back:
            self._moves.halt(now_s)

    def shut_out(self, by: str, waited_s: float, now_s: float) -> None:
        """A silent vehicle blocks every way: fetch the load elsewhere or by another vehicle, or bring it elsewhere.

        The job waits if no other vehicle or place is possible.

        Args:
            by: the silent vehicle.
            waited_s: how long the vehicle has waited for it.
            now_s: the present time.
        """
        waits_s = ASKS_AGAIN_S if self._was_shut_out else 0.0
        if self.state is JobState.APPROACHING and waited_s >= waits_s:
            if self._moves.can_fetch_elsewhere():
                self._short = self.source
                self.give_back(Reason.WAY_BLOCKED, now_s, by)
            elif waited_s >= SHUT_OUT_S and self._moves.is_shut_in(now_s):
                self.give_back(Reason.WAY_BLOCKED, now_s, by)
        elif self.state is JobState.RETURNING and (refuge := self._moves.refuge()) != self._station:
            self._station = refuge
            self._drive(refuge, now_s)

    def waiting(self, now_s: float) -> Waiting:
        """The consequences for the task while the vehicle cannot go on."""
        loaded = self.state in LOADED
        relief_s = 0.0
        if loaded:
            try:
                relief_s = self._moves.from_source_s() - max(0.0, self.due_s - now_s)
            except NoWay:
                relief_s = inf
        once = loaded and (bool(self.work.goal) or self.work.item == THING)
        return Waiting(self.task, self.slack_s, relief_s, irreplaceable=once or self.is_void)

    def way_refused(self, now_s: float) -> None:
        """The vehicle could not take the way: try again later from its position."""
        if not self._messages.is_asking:
            self._moves.try_later(now_s)

    def action_done(self, order: int, now_s: float) -> None:
        """A pick or drop has succeeded."""
        if not self._is_under_way(order):
            return
        match self.state:
            case JobState.PICKING:
                self._carry(now_s)
            case JobState.DROPPING:
                self._hand_over(now_s)
            case JobState.VOID_PICKING:
                self._return(now_s)
            case JobState.VOID_DROPPING:
                self.is_untold = not self._moves.is_gated
                self._end(cast(Reason, self._void))
            case _:
                self._end(cast(Reason, self._void))

    def action_failed(self, order: int, reason: str, now_s: float) -> None:
        """A pick or drop has failed without effect."""
        if not self._is_under_way(order):
            return
        self._failed += 1
        match self.state:
            case JobState.PICKING:
                self._states.enter(JobState.AT_SOURCE)
                self._moves.try_later(now_s)
            case JobState.DROPPING:
                self._states.enter(JobState.AT_DESTINATION)
                self._refused += self._moves.is_gated
                if self._refused >= TRIES:
                    self.resign(Reason.GATE_REFUSED, now_s, reason)
                else:
                    self._moves.try_later(now_s)
            case JobState.VOID_PICKING:
                self._end(cast(Reason, self._void))
            case JobState.VOID_DROPPING:
                self._return(now_s)
            case _ if self._failed < TRIES:
                self._states.enter(JobState.RETURNING)
                self._moves.try_later(now_s)
            case _:
                self._return_elsewhere(now_s)

    def on_answer(self, message: Message, now_s: float) -> None:
        """Handle the coordinator's answer; late and doubled ones are ignored."""
        if isinstance(message, Superseded) and not 0 < message.epoch < self.epoch:
            if self.state is JobState.AT_REFUGE:
                return  # A late message of the coordinator, or of an agent that takes nothing back: no answer to the question.
            self.cancel(self._given_back or Reason.SUPERSEDED, now_s)
        elif isinstance(message, Withdrawn):
            self.cancel(self._given_back or Reason.WITHDRAWN, now_s)
        elif isinstance(message, Confirmed) and self._messages.is_claiming:
            self._messages.claim_confirmed()
        elif isinstance(message, HandoverAccepted) and self.state is JobState.HANDING_OVER:
            self._end(Reason.HANDED_OVER)
        elif isinstance(message, DockHeld) and self._waits_at(message.station):
            self._wait(message, now_s)
        elif isinstance(message, DockOpened) and self._waits_at(message.station):
            self._messages.answered()
            self._transfer()
        else:
            self._life.ignore("an answer for which the transport does not wait")
            return
        self._messages.heard()

    def cancel(self, reason: Reason, now_s: float) -> None:
        """The contract is void: end, and return the load if there is one."""
        if self.is_void:
            return
        self._void = reason
        self._stop_waiting()
        if self.state is JobState.PICKING:
            self._states.enter(JobState.VOID_PICKING)
        elif self.state is JobState.DROPPING:
            self._states.enter(JobState.VOID_DROPPING)
        elif self.state in LOADED:
            self._return(now_s)
        else:
            # A release answers no handover.
            self.is_untold = self.state is JobState.HANDING_OVER and reason is Reason.RELEASED
            self._leave_empty(reason, now_s)

    def resign(self, reason: Reason, now_s: float, detail: str = "") -> None:
        """Give the contract back to its coordinator, and end it; `detail` tells people more."""
        if not self.is_void:
            self.detail = detail
            self._messages.resign(reason, detail)
        self.cancel(reason, now_s)

    def give_back(self, reason: Reason, now_s: float, detail: str = "") -> None:
        """Stand, and ask the coordinator for another carrier; `detail` tells people more.

        Ignored with the load on board or during a manoeuvre, which no other vehicle can finish.
        """
        if self.state not in (JobState.APPROACHING, JobState.AT_SOURCE):
            return
        self._states.enter(JobState.GIVING_BACK)
        self._given_back, self.detail = reason, detail
        self._moves.halt(now_s)
        self._ask_for_relief(now_s)

    def claim_again(self, now_s: float) -> None:
        """Repeat the unconfirmed takeover."""
        self._messages.claim_again(now_s)

    def misses_load(self, load: str) -> bool:
        """Whether the load of a void contract is gone: a drop of an earlier life has ended. `load` is on board."""
        return self.state is JobState.RETURNING and not load and self._may_be_dropping

    def wake(self, load: str, now_s: float) -> None:
        """Handle a missing answer, or repeat a failed way or manoeuvre.

        Args:
            load: the item on board: an earlier life's action may have ended, or a person may have taken the load
                off.
            now_s: the present time.
        """
        if self.state is JobState.VOID_AT_SOURCE:
            self._await_pick(load, now_s)
        elif self.misses_load(load):
            self._end_void()
        elif self._messages.is_unanswered:
            self._be_left_alone(now_s)
        elif load and load != self.work.item:
            # An earlier life has picked it up; the carrier of this task must be empty.
            self.resign(Reason.OTHER_LOAD, now_s, load)
        elif load and self.state not in LOADED:
            self._given_back, self.detail = None, ""
            self._carry(now_s)
        elif not load and self.state in LOADED:
            self._miss_load(now_s)
        else:
            self._go_on(now_s)

    # --- internals ---

    def _drive(self, station: str, now_s: float) -> None:
        """Drive to a station; it has arrived if it stands there already."""
        self._cut_off = False
        try:
            there_s = self._moves.drive(station, now_s)
            arrives_s = now_s if there_s is None else there_s
            if self.state is JobState.APPROACHING:
                self.due_s = arrives_s + self._moves.from_source_s()
                self._moves.expect_to_load(arrives_s)
                self._moves.expect_to_unload(self.due_s - self._moves.unloading_s())
            elif self.state is JobState.CARRYING:
                self.due_s = arrives_s + self._moves.unloading_s()
                self._moves.expect_to_unload(arrives_s)
        except NoWay:
            self._wait_for_way(now_s)
            return
        if there_s is None:
            self.arrived(now_s)

    def _drive_on(self, now_s: float) -> None:
        """Drive to its station, or to another refuge if that was closed."""
        if self._cut_off and self.state is JobState.RETURNING:
            self._station = self._moves.refuge()
        self._drive(self._station, now_s)

    def _wait_for_way(self, now_s: float) -> None:
        """Closures leave no way: seek another carrier, or wait with the load on board."""
        self._cut_off = True
        if self.state is JobState.APPROACHING:
            self.give_back(Reason.CLOSED, now_s)
        else:
            self._moves.halt(now_s)
            self._moves.try_later(now_s)

    def _keeps_promise(self, now_s: float) -> bool:
        """Whether it would be in time if it were loaded now."""
        try:
            return now_s + self._moves.from_source_s() <= self.promised_s
        except NoWay:
            return False

    def _go_on(self, now_s: float) -> None:
        """Repeat the pending step of the present state."""
        match self.state:
            case JobState.GIVING_BACK:
                self._ask_for_relief(now_s)
            case JobState.AT_SOURCE:
                self._ask_for_dock(now_s)
            case JobState.AT_DESTINATION:
                self._ask_to_unload(now_s)
            case JobState.AT_REFUGE:
                self._ask_to_put_back(now_s)
            case JobState.HANDING_OVER:
                self._ask_for_handover(now_s)
            case _:
                self._drive_on(now_s)

    def _is_under_way(self, order: int) -> bool:
        """Whether the job waits for this pick or drop."""
        return self._moves.is_newest(order) and self.state in MANOEUVRES

    def _enter(self, state: JobState, station: str) -> None:
        """Begin a phase that other agents see."""
        self._states.enter(state)
        self._messages.answered()
        self._station, self._failed = station, 0
        fact = PhaseEntered(task=self.task, epoch=self.epoch, phase=self.phase, station=station)
        self._life.record(fact)

    def _carry(self, now_s: float) -> None:
        self._pick_over_s = -NEVER_S
        self._moves.leave(self.source, now_s)
        self._enter(JobState.CARRYING, self.work.destination)
        self._drive(self.work.destination, now_s)

    def _hand_over(self, now_s: float) -> None:
        self._moves.leave(self.work.destination, now_s)
        self._enter(JobState.HANDING_OVER, self.work.destination)
        self._ask_for_handover(now_s)

    def _ask_to_unload(self, now_s: float) -> None:
        if self._moves.is_gated:
            self._drop(JobState.DROPPING)
        else:
            self._ask_for_dock(now_s)

    def _ask_for_dock(self, now_s: float) -> None:
        self._moves.try_no_more()
        self._messages.ask_for_dock(self._station, now_s)

    def _ask_to_put_back(self, now_s: float) -> None:
        self._moves.try_no_more()
        self._messages.ask_to_put_back(self._station, now_s)

    def _ask_for_handover(self, now_s: float) -> None:
        self._moves.try_no_more()
        self._messages.ask_for_handover(now_s)

    def _ask_for_relief(self, now_s: float) -> None:
        self._moves.try_no_more()
        self._messages.ask_for_relief(cast(Reason, self._given_back), self.detail, self._short, now_s)

    def _stop_waiting(self) -> None:
        self._messages.answered()
        self._moves.try_no_more()

    def _wait(self, held: DockHeld, now_s: float) -> None:
        """Ask again later; at a storage only while its promise can be kept, and a moment longer."""
        fetches = self.state is JobState.AT_SOURCE and self.source not in (
            self.coordinator,
            self.work.handed_at,
        )
        if self.state is JobState.AT_REFUGE and now_s >= self._stands_s + REFUGE_HELD_S:
            self._return_elsewhere(now_s)
        elif fetches and not self._keeps_promise(now_s) and now_s >= self._stands_s + WAITS_AT_LEAST_S:
            self._short = self.source
            self.give_back(Reason.DOCK_HELD, now_s, held.reason)
        else:
            self._messages.ask_later(now_s)

    def _waits_at(self, station: str) -> bool:
        asks = self.state in (JobState.AT_SOURCE, JobState.AT_DESTINATION, JobState.AT_REFUGE)
        return asks and station == self._station

    def _transfer(self) -> None:
        if self.state is JobState.AT_SOURCE:
            self._states.enter(JobState.PICKING)
            self._moves.pick()
        elif self.state is JobState.AT_REFUGE:
            self._drop(JobState.PUTTING_BACK)
        else:
            self._drop(JobState.DROPPING)

    def _drop(self, state: JobState) -> None:
        self._states.enter(state)
        self._moves.drop(self._station, self.work.goal if state is JobState.DROPPING else "")

    def _be_left_alone(self, now_s: float) -> None:
        """The coordinator does not answer any more: its transports end with it (paper, case 1)."""
        if self.state is JobState.HANDING_OVER:
            self.is_untold = True
            self._end(Reason.NOT_CONFIRMED)
        elif self.state is JobState.AT_REFUGE:
            self._return_elsewhere(now_s)
        elif self.state is JobState.AT_SOURCE and self.source not in (self.coordinator, self.work.handed_at):
            self._short = self.source
            self.give_back(Reason.SOURCE_SILENT, now_s, self.source)
        else:
            self.resign(Reason.COORDINATOR_SILENT, now_s)

    def _miss_load(self, now_s: float) -> None:
        """The load is gone: an earlier life has put it down, or a person has taken it off."""
        if self.is_void:
            self._end_void()
        elif self._may_be_dropping and self.state is JobState.AT_DESTINATION:
            self._hand_over(now_s)
        elif self.work.goal or self.work.item == THING:
            # It exists once: its coordinator decides where to look for it.
            self._messages.resign(Reason.LOAD_GONE)
            self._end(Reason.LOAD_GONE)
        else:
            self.set_off(now_s)

    def _leave_empty(self, reason: Reason, now_s: float) -> None:
        """End, unless an earlier life's pick may still bring the load: the source counts on its vehicle to say so."""
        if now_s < self._pick_over_s:
            self._states.enter(JobState.VOID_AT_SOURCE)
            self._moves.try_later(now_s)
        else:
            self._end(reason)

    def _await_pick(self, load: str, now_s: float) -> None:
        """Wait for the end of an earlier life's pick."""
        if load == self.work.item:
            self._return(now_s)
        elif load or now_s >= self._pick_over_s:
            self._end(cast(Reason, self._void))
        else:
            self._moves.try_later(now_s)

    def _return(self, now_s: float) -> None:
        """Bring the load to a storage."""
        refuge = self._moves.refuge()
        if self.phase is Phase.RETURNING and refuge == self._station:
            # There is no other refuge: try again, without a new phase.
            self._states.enter(JobState.RETURNING)
            self._messages.answered()
            self._failed = 0
        else:
            self._enter(JobState.RETURNING, refuge)
        self._drive(refuge, now_s)

    def _return_elsewhere(self, now_s: float) -> None:
        """This place does not take the load: try another."""
        self._moves.note_full(self._station)
        self._return(now_s)

    def _end_void(self) -> None:
        """End a void contract whose load is gone: what an earlier life was unloading at the destination is down there."""
        stands = self._may_be_dropping and self._moves.stands_at(self.work.destination)
        self.is_untold = stands and not self._moves.is_gated
        self._end(cast(Reason, self._void))

    def _end(self, reason: Reason) -> None:
        self._states.enter(JobState.ENDED)
        self.ended = reason
        self._moves.try_no_more()
        self._messages.stop()
