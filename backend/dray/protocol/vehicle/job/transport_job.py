"""A committed transport, as its carrier lives it: approach, load, carry, unload, hand over. Its states are in `job_state`.

At every dock the carrier asks first: the coordinator opens its own to the present epoch alone, the station of a storage to
whom it has promised the load. At a storage that has none it waits as long as it can keep its own promise, and gives the
task back then. Finished goods that reach a delivery warehouse are fenced by its gate instead, which knows what each goal may
still bring. A coordinator that answers nothing for `job_messages.GIVE_UP_AFTER` questions has failed, and the load goes back.

Who has taken a task over drives before its coordinator has confirmed that. Who gives a task back that is not on board yet
stands until its coordinator has superseded it: until then it is bound.

What the vehicle does for it is in `job_moves`, and what it says in `job_messages`.
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
from dray.protocol.traffic.driving.right_of_way import SHUT_OUT_S
from dray.protocol.vehicle.drivers.driver import Driver
from dray.protocol.vehicle.job.job_messages import JobMessages
from dray.protocol.vehicle.job.job_moves import JobMoves
from dray.protocol.vehicle.job.job_state import LOADED, MANOEUVRES, VOID, JobState, JobStates
from dray.protocol.vehicle.people.assistance import Waiting

WAITS_AT_LEAST_S = 15.0
"""At a storage that has nothing, beyond what its promise allows: the station may have been started again a moment ago.
Shorter than what its coordinator takes for standing still (`progress.STALL_S`)."""

ASKS_AGAIN_S = 300.0
"""Who has a contract for a load that was only to be had behind a silent vehicle gives it back after this: by then others may have it."""

REFUGE_HELD_S = 60.0
"""A storage that has not let a load back in within this does not take it: another one is looked for. As long as a dock may take to get ready."""

TRIES = 3
"""Manoeuvres at one place before another one is looked for."""


class TransportJob:
    """One transport of one vehicle: what happens to it, and what is next.

    Args:
        contract: what it is bound to.
        plant, vehicle_type: for ways and handling times.
        driver: the vehicle's place on the lanes.

    Attributes:
        due_s: when it now expects to hand over (plant clock).
        ended: why it is over; None while it lasts.
        detail: the same in the words of whoever has held it up; empty where nobody has.
        number: of the award that binds it; 0 for a takeover.
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
        self.number = contract.number
        self._life = life
        self._states = JobStates(contract.phase)
        self._moves = JobMoves(contract, plant, vehicle_type, driver, life)
        self._messages = JobMessages(contract, life)
        self._station = contract.source
        """Where it drives to, or stands."""
        self._cut_off = False
        """What is closed leaves no way to its station: it stands elsewhere, and waits."""
        self._was_shut_out = self._moves.is_shut_out_of(contract.source)
        """Something was known to be in the way to the source when the contract was made: nobody else had the load then."""
        self._short = ""
        """The storage that had none of the load, or cannot be reached, which is why it was given back."""
        self._void = contract.cancelled
        """Why the contract is void; None while it binds."""
        self._stands_s = NEVER_S
        """Since when it waits at its source, or where it brings its load back."""
        self._given_back: Reason | None = None
        """Why the coordinator was asked to let another one carry it."""
        self._may_be_dropping = False
        """An earlier life had come to the unloading: its drop may still be under way."""
        self._failed = 0
        """Manoeuvres that failed at this station."""
        self._refused = contract.refused
        """How often the gate has not let the load in, over all lives of the vehicle."""

    @property
    def state(self) -> JobState:
        """How far it has come."""
        return self._states.now

    @property
    def phase(self) -> Phase:
        """The same, as others hear it."""
        return self._states.phase

    @property
    def is_void(self) -> bool:
        """Whether it is over but for the load, which is on its way back."""
        return self.state in VOID

    @property
    def is_given_back(self) -> bool:
        """Whether it ends as soon as the coordinator has answered."""
        return self.state is JobState.GIVING_BACK

    @property
    def slack_s(self) -> float:
        """How much later than now expected it may be done."""
        return self._contract.deadline_s - self.due_s

    def answers_at(self, station: str) -> str:
        """Who says whether it may load or unload at a place where it stands: where people hand the load over, its coordinator."""
        return self.coordinator if station == self.work.handed_at else station

    def is_meant_by(self, message: Any) -> bool:
        """Whether a coordinator speaks of this contract; a Superseded speaks of another epoch."""
        return self.task == message.task and (type(message) is Superseded or message.epoch == self.epoch)

    def brief(self) -> Brief:
        """What the vehicle tells about it in its heartbeat."""
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
        """What the vehicle's next life must know of it."""
        return msgspec.structs.replace(
            self._contract,
            phase=self.phase,
            cancelled=self._void,
            number=self.number,
            refused=self._refused,
            claim=self._contract.claim if self._messages.is_claiming else None,
        )

    # --- what happens ---

    def set_off(self, now_s: float) -> None:
        """Set off for the source."""
        self._enter(JobState.APPROACHING, self.source)
        self._drive(self.source, now_s)

    def take_over(self, now_s: float) -> None:
        """Set off in the place of a failed vehicle, and tell the coordinator until it has heard."""
        self._messages.tell_bound(self.number, now_s)
        self.set_off(now_s)

    def resume(self, load: str, now_s: float) -> None:
        """Go on after a restart, from what the vehicle has on board.

        The coordinator is told again that the contract was accepted: if it has moved on, it says so now,
        and not at the end of a long way.
        """
        loaded = load == self.work.item
        self._may_be_dropping = self.phase is Phase.UNLOADING
        if not self._void:
            self._messages.tell_bound(self.number, now_s)
        if self._void and loaded:
            self._return(now_s)
        elif self._void:
            self._end(self._void)
        elif loaded:
            self._carry(now_s)
        elif self.phase in (Phase.UNLOADING, Phase.HANDING_OVER):
            self._hand_over(now_s)
        elif self.phase in (Phase.CARRYING, Phase.RETURNING):
            self._miss_load(now_s)
        else:
            self.set_off(now_s)

    def arrived(self, now_s: float) -> None:
        """The vehicle stands where it was sent."""
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
        """People have closed or opened something: go on by what is open. Whoever is at a dock finishes there first."""
        if self.state in (JobState.APPROACHING, JobState.CARRYING, JobState.RETURNING):
            self._drive_on(now_s)
        elif self.is_given_back:
            self._moves.halt(now_s)

    def shut_out(self, by: str, waited_s: float, now_s: float) -> None:
        """A silent vehicle is in its way, and none leads round: the load is fetched elsewhere or by another vehicle, or brought elsewhere.

        What nobody else can fetch, or is to be brought there, waits.

        Args:
            by: the silent vehicle.
            waited_s: how long it has been waited for.
            now_s: the present time.
        """
        waits_s = ASKS_AGAIN_S if self._was_shut_out else 0.0
        if self.state is JobState.APPROACHING:
            if waited_s >= waits_s and self._moves.can_fetch_elsewhere():
                self._short = self.source
                self.give_back(Reason.WAY_BLOCKED, now_s, by)
            elif waited_s >= SHUT_OUT_S and self._moves.is_shut_in(now_s):
                self.give_back(Reason.WAY_BLOCKED, now_s, by)
        elif self.state is JobState.RETURNING and (refuge := self._moves.refuge()) != self._station:
            self._station = refuge
            self._drive(refuge, now_s)

    def waiting(self, now_s: float) -> Waiting:
        """What it means for the task that the vehicle cannot go on."""
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
        """The vehicle could not take the way: try again from where it is then."""
        if not self._messages.is_asking:
            self._moves.try_later(now_s)

    def action_done(self, order: int, now_s: float) -> None:
        """A pick or drop has ended well."""
        if not self._is_under_way(order):
            return
        match self.state:
            case JobState.PICKING:
                self._carry(now_s)
            case JobState.DROPPING:
                self._hand_over(now_s)
            case JobState.VOID_PICKING:
                self._return(now_s)
            case _:
                self._end(cast(Reason, self._void))

    def action_failed(self, order: int, reason: str, now_s: float) -> None:
        """A pick or drop ended without effect."""
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
        """Take an answer of the coordinator; what is late or doubled changes nothing."""
        if isinstance(message, Superseded) and not 0 < message.epoch < self.epoch:
            if self.state is JobState.AT_REFUGE:
                return  # A late word of its coordinator, or one who takes nothing back: no answer to what it asks.
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
            self._life.ignore("an answer that nothing waits for any more")
            return
        self._messages.heard()

    def cancel(self, reason: Reason, now_s: float) -> None:
        """The contract is void: end, and take the load back if there is one."""
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
            self._end(reason)

    def resign(self, reason: Reason, now_s: float, detail: str = "") -> None:
        """Give the contract back to its coordinator, and end it; `detail` tells people more."""
        if not self.is_void:
            self.detail = detail
            self._messages.resign(reason, detail)
        self.cancel(reason, now_s)

    def give_back(self, reason: Reason, now_s: float, detail: str = "") -> None:
        """Stand, and ask the coordinator to let another one carry it; `detail` tells people more.

        Harmless when the load is on board, or a manoeuvre runs: that nobody else can finish.
        """
        if self.state not in (JobState.APPROACHING, JobState.AT_SOURCE):
            return
        self._states.enter(JobState.GIVING_BACK)
        self._given_back, self.detail = reason, detail
        self._moves.halt(now_s)
        self._ask_for_relief(now_s)

    def claim_again(self, now_s: float) -> None:
        """The coordinator has not confirmed the takeover yet."""
        self._messages.claim_again(now_s)

    def wake(self, load: str, now_s: float) -> None:
        """No answer has come, or a failed way or manoeuvre is due again.

        Args:
            load: what is on board now: an action of an earlier life may have ended, or a person has
                taken the load off.
            now_s: the present time.
        """
        if self._messages.is_unanswered:
            self._be_left_alone(now_s)
        elif load and load != self.work.item:
            # An earlier life has picked it up; whoever carries this task must be empty.
            self.resign(Reason.OTHER_LOAD, now_s, load)
        elif load and self.state not in LOADED:
            self._given_back, self.detail = None, ""
            self._carry(now_s)
        elif not load and self.state in LOADED:
            self._miss_load(now_s)
        else:
            self._go_on(now_s)

    # --- how it is done ---

    def _drive(self, station: str, now_s: float) -> None:
        """Drive to a station; it has arrived at once where it stands there."""
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
        """Drive to its station, or to another one that keeps the load where that was closed."""
        if self._cut_off and self.state is JobState.RETURNING:
            self._station = self._moves.refuge()
        self._drive(self._station, now_s)

    def _wait_for_way(self, now_s: float) -> None:
        """What is closed leaves no way: another one is to fetch the load, and what is on board waits with the vehicle."""
        self._cut_off = True
        if self.state is JobState.APPROACHING:
            self.give_back(Reason.CLOSED, now_s)
        else:
            self._moves.halt(now_s)
            self._moves.try_later(now_s)

    def _keeps_promise(self, now_s: float) -> bool:
        """Whether it would be done in time if it were loaded now."""
        try:
            return now_s + self._moves.from_source_s() <= self.promised_s
        except NoWay:
            return False

    def _go_on(self, now_s: float) -> None:
        """Do again what the present state waits for."""
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
        """Whether this pick or drop is what the job waits for."""
        return self._moves.is_newest(order) and self.state in MANOEUVRES

    def _enter(self, state: JobState, station: str) -> None:
        """Begin a phase that others hear of."""
        self._states.enter(state)
        self._messages.answered()
        self._station, self._failed = station, 0
        fact = PhaseEntered(task=self.task, epoch=self.epoch, phase=self.phase, station=station)
        self._life.record(fact)

    def _carry(self, now_s: float) -> None:
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
        """Ask again later; at a storage, as long as its promise can be kept and a moment longer."""
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
        """The coordinator answers nothing any more: its transports end with it (paper, case 1)."""
        if self.state is JobState.HANDING_OVER:
            self._end(Reason.NOT_CONFIRMED)
        elif self.state is JobState.AT_REFUGE:
            self._return_elsewhere(now_s)
        elif self.state is JobState.AT_SOURCE and self.source not in (self.coordinator, self.work.handed_at):
            self._short = self.source
            self.give_back(Reason.SOURCE_SILENT, now_s, self.source)
        else:
            self.resign(Reason.COORDINATOR_SILENT, now_s)

    def _miss_load(self, now_s: float) -> None:
        """The load is gone: put down at last for an earlier life, or taken off by a person."""
        if self.is_void:
            self._end(cast(Reason, self._void))
        elif self._may_be_dropping and self.state is JobState.AT_DESTINATION:
            self._hand_over(now_s)
        elif self.work.goal or self.work.item == THING:
            # It exists once: its coordinator decides where it is looked for.
            self._messages.resign(Reason.LOAD_GONE)
            self._end(Reason.LOAD_GONE)
        else:
            self.set_off(now_s)

    def _return(self, now_s: float) -> None:
        """Bring the load to where it is kept."""
        refuge = self._moves.refuge()
        if self.phase is Phase.RETURNING and refuge == self._station:
            # There is no other: it is tried again, and nothing is new to anybody.
            self._states.enter(JobState.RETURNING)
            self._messages.answered()
            self._failed = 0
        else:
            self._enter(JobState.RETURNING, refuge)
        self._drive(refuge, now_s)

    def _return_elsewhere(self, now_s: float) -> None:
        """This place does not take the load."""
        self._moves.note_full(self._station)
        self._return(now_s)

    def _end(self, reason: Reason) -> None:
        self._states.enter(JobState.ENDED)
        self.ended = reason
        self._moves.try_no_more()
        self._messages.stop()
