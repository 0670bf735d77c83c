"""A committed transport, as its carrier lives it: approach, load, carry, unload, hand over. Its states are in `job_state`.

At every dock the carrier asks first (`Docked`): the coordinator opens its own to the present epoch alone, the station
of a storage to whom it has promised the load. At a storage that has none it waits as long as it can keep its own promise,
and gives the task back then. FinishedGoods that reach a delivery warehouse are fenced
by its gate instead, which knows what each goal may still bring. Questions and the handover are repeated
until they are answered, so a lost message costs seconds and no load; a coordinator that answers nothing
for GIVE_UP_AFTER questions has failed, and the load goes back.

Who has taken a task over from a failed vehicle says so until its coordinator has confirmed it, and drives
meanwhile. Who gives a task back that is not on board yet stands, and says so until its coordinator has
superseded it: until then it is bound.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from dray.body import Drop, Pick
from dray.errors import NoWay
from dray.memory import Contract
from dray.messages import (
    Accepted,
    Brief,
    Confirmed,
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Phase,
    Resigned,
    Role,
    Superseded,
    Withdrawn,
)
from dray.messages.fact import HANDED_OVER, PhaseEntered
from dray.plant import Plant
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.runtime.events import NEVER_S, Effect, Ignore, Record, Send
from dray.protocol.runtime.retransmission import Retransmitter
from dray.protocol.runtime.timers import Timers
from dray.protocol.vehicle.driving import Driver, limited_s
from dray.protocol.vehicle.job_state import LOADED, MANOEUVRES, VOID, JobState, JobStates

ASK = "ask"
"""The alarm for asking again: for the dock, for the acceptance of a handover, to be relieved of the task."""

RETRY = "retry"
"""The alarm for another try of a way or a manoeuvre, which is no message."""

CLAIM_TASK = "claim task"
"""The alarm for saying again that a task was taken over."""

GIVE_UP_AFTER = 10
"""Questions without an answer: half a minute, longer than a machine's software needs to start again."""

HELD_ASK_AGAIN_S = 5.0
"""A dock that is held has no room yet: asking often would not make any."""

WAITS_AT_LEAST_S = 15.0
"""At a storage that has nothing, beyond what its promise allows: the station may have been started again a moment ago.
Shorter than what its coordinator takes for standing still (`progress.STALL_S`)."""

RETRY_S = 5.0
"""After a failed manoeuvre."""

TRIES = 3
"""Manoeuvres at one place before another one is looked for."""

GONE = "its load was taken off"


class TransportJob:
    """One transport of one vehicle.

    Args:
        atv: the vehicle.
        contract: what it is bound to.
        plant, vehicle_type: for ways and handling times.
        driver: the vehicle's place on the lanes.
        timers: the vehicle's alarms; this class uses `RETRY`, ``(ASK, task)`` and ``(CLAIM_TASK, task)``.
        out: where effects go.

    Attributes:
        due_s: when it now expects to hand over (plant clock).
        ended: why it is over: `handed_over`, or another reason; empty while it lasts.
    """

    def __init__(
        self,
        atv: str,
        contract: Contract,
        *,
        plant: Plant,
        vehicle_type: str,
        driver: Driver,
        timers: Timers,
        out: list[Effect],
    ) -> None:
        self._atv = atv
        self._contract = contract
        self.task = contract.task
        self.epoch = contract.epoch
        self.work = contract.work
        self.coordinator = contract.coordinator
        self.source = contract.source
        self.promised_s = contract.promised_s
        self.due_s = contract.promised_s
        self.ended = ""
        self._plant = plant
        self._type = plant.vehicle_types[vehicle_type]
        self._routes = plant.routes(vehicle_type)
        self._driver = driver
        self._timers = timers
        self._out = out
        self._states = JobStates(contract.phase)
        self._order = 0
        """The number of the newest pick or drop."""
        self._void = contract.cancelled
        """Why the contract is void; empty while it binds."""
        self._short = ""
        """The storage that had none of the load, which is why it was given back."""
        self._stands_s = NEVER_S
        """Since when it waits at its source."""
        self._given_back = ""
        """Why the coordinator was asked to let another one carry it."""
        self._may_be_dropping = False
        """An earlier life had come to the unloading: its drop may still be under way."""
        self._station = contract.source
        self._failed = 0
        """Manoeuvres that failed at this station."""
        self._refused = contract.refused
        """How often the gate has not let the load in, over all lives of the vehicle."""
        self._full: set[str] = set()
        """Stations that did not take the load back. Only ever asked for membership."""
        self._question = Retransmitter(ASK, timers, out, most=GIVE_UP_AFTER)
        """What the job waits for an answer to: its dock, its handover, or that it is given back."""
        self._claim = Retransmitter(CLAIM_TASK, timers, out)
        """What is said until the coordinator has confirmed a takeover, over all lives of the vehicle."""
        self.number = contract.number
        """Of the award that binds it; 0 for a takeover."""

    @property
    def state(self) -> JobState:
        """How far it has come."""
        return self._states.now

    @property
    def phase(self) -> Phase:
        """The same, as others hear it."""
        return self._states.phase

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
            claim=self._contract.claim if self.task in self._claim else None,
        )

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

    # --- what happens ---

    def begin(self, now_s: float) -> None:
        """Set off for the source."""
        self._enter(JobState.APPROACHING, self.source)
        self._drive(self.source, now_s)

    def take_over(self, now_s: float) -> None:
        """Set off in the place of a failed vehicle, and tell the coordinator until it has heard."""
        self._say_taken(now_s)
        self.begin(now_s)

    def resume(self, load: str, now_s: float) -> None:
        """Go on after a restart, from what the vehicle has on board.

        The coordinator is told again that the contract was accepted: if it has moved on, it says so now,
        and not at the end of a long way.
        """
        loaded = load == self.work.item
        self._may_be_dropping = self.phase is Phase.UNLOADING
        if not self._void:
            self._say_taken(now_s)
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
            self.begin(now_s)

    def arrived(self, now_s: float) -> None:
        """The vehicle stands where it was sent."""
        match self.state:
            case JobState.APPROACHING:
                self._enter(JobState.AT_SOURCE, self.source)
                self._stands_s = now_s
                self._ask_for_dock(now_s)
            case JobState.CARRYING:
                self._enter(JobState.AT_DESTINATION, self.work.destination)
                self._ask_to_unload(now_s)
            case JobState.RETURNING:
                self._drop(JobState.PUTTING_BACK)

    def way_refused(self, now_s: float) -> None:
        """The vehicle could not take the way: try again from where it is then."""
        if self.task not in self._question:
            self._timers.set(RETRY, now_s + RETRY_S)

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
                self._end(self._void)

    def action_failed(self, order: int, reason: str, now_s: float) -> None:
        """A pick or drop ended without effect."""
        if not self._is_under_way(order):
            return
        self._failed += 1
        match self.state:
            case JobState.PICKING:
                self._states.enter(JobState.AT_SOURCE)
                self._timers.set(RETRY, now_s + RETRY_S)
            case JobState.DROPPING:
                self._states.enter(JobState.AT_DESTINATION)
                self._refused += self._is_gated
                if self._refused >= TRIES:
                    self.resign(f"refused: {reason}", now_s)
                else:
                    self._timers.set(RETRY, now_s + RETRY_S)
            case JobState.VOID_PICKING:
                self._end(self._void)
            case JobState.VOID_DROPPING:
                self._return(now_s)
            case _ if self._failed < TRIES:
                self._states.enter(JobState.RETURNING)
                self._timers.set(RETRY, now_s + RETRY_S)
            case _:
                self._full.add(self._station)
                self._return(now_s)

    def on_answer(self, message: Message, now_s: float) -> None:
        """Take an answer of the coordinator; what is late or doubled changes nothing."""
        if isinstance(message, Superseded) and not 0 < message.epoch < self.epoch:
            self.cancel(self._given_back or "superseded", now_s)
        elif isinstance(message, Withdrawn):
            self.cancel(self._given_back or "withdrawn", now_s)
        elif isinstance(message, Confirmed) and self.task in self._claim:
            self._claim.settle(self.task)
        elif isinstance(message, HandoverAccepted) and self.state is JobState.HANDING_OVER:
            self._end(HANDED_OVER)
        elif isinstance(message, DockHeld) and self._waits_at(message.station):
            self._wait(message, now_s)
        elif isinstance(message, DockOpened) and self._waits_at(message.station):
            self._question.settle(self.task)
            self._transfer()
        else:
            self._out.append(Ignore("an answer that nothing waits for any more"))
            return
        self._question.count_anew(self.task)

    def cancel(self, reason: str, now_s: float) -> None:
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

    def resign(self, reason: str, now_s: float) -> None:
        """Give the contract back to its coordinator, and end it."""
        if not self.is_void:
            self._say_resigned(reason)
        self.cancel(reason, now_s)

    def give_back(self, reason: str, now_s: float) -> None:
        """Stand, and ask the coordinator to let another one carry it.

        Harmless when the load is on board, or a manoeuvre runs: that nobody else can finish.
        """
        if self.state not in (JobState.APPROACHING, JobState.AT_SOURCE):
            return
        self._states.enter(JobState.GIVING_BACK)
        self._given_back = reason
        if self._driver.way:
            self._driver.go(self._driver.next_node, now_s)
        self._say_given_back(now_s)

    def claim_again(self, now_s: float) -> None:
        """The coordinator has not confirmed the takeover yet."""
        self._claim.wake(self.task, now_s)

    def wake(self, load: str, now_s: float) -> None:
        """No answer has come, or a failed way or manoeuvre is due again.

        Args:
            load: what is on board now: an action of an earlier life may have ended, or a person has
                taken the load off.
            now_s: the present time.
        """
        if self._question.is_exhausted(self.task):
            self._be_left_alone(now_s)
        elif load and load != self.work.item:
            # An earlier life has picked it up; whoever carries this task must be empty.
            self.resign(f"{load} is on board", now_s)
        elif load and self.state not in LOADED:
            self._given_back = ""
            self._carry(now_s)
        elif not load and self.state in LOADED:
            self._miss_load(now_s)
        else:
            self._go_on(now_s)

    # --- how it is done ---

    def _go_on(self, now_s: float) -> None:
        """Do again what the present state waits for."""
        match self.state:
            case JobState.GIVING_BACK:
                self._say_given_back(now_s)
            case JobState.AT_SOURCE:
                self._ask_for_dock(now_s)
            case JobState.AT_DESTINATION:
                self._ask_to_unload(now_s)
            case JobState.HANDING_OVER:
                self._say_handover(now_s)
            case _:
                self._drive(self._station, now_s)

    def _is_under_way(self, order: int) -> bool:
        """Whether this pick or drop is what the job waits for."""
        return order == self._order and self.state in MANOEUVRES

    @property
    def _is_gated(self) -> bool:
        """Whether a gate decides about the load, and not the coordinator."""
        return self.work.destination in self._plant.delivery_warehouses

    def _say_taken(self, now_s: float) -> None:
        """Say how this contract was made."""
        if self._contract.claim is not None:
            self._claim.say(self.task, Send(self.coordinator, self._contract.claim), now_s)
            return
        accepted = Accepted(
            task=self.task,
            epoch=self.epoch,
            role=Role.PRIMARY,
            finish_s=self.promised_s,
            number=self.number,
            at_s=now_s,
        )
        self._out.append(Send(self.coordinator, accepted))

    def _enter(self, state: JobState, station: str) -> None:
        """Begin a phase that others hear of."""
        self._states.enter(state)
        self._question.settle(self.task)
        self._station, self._failed = station, 0
        fact = PhaseEntered(task=self.task, epoch=self.epoch, phase=self.phase, station=station)
        self._out.append(Record(fact))

    def _drive(self, station: str, now_s: float) -> None:
        away = self._driver.go(self._dock(station), now_s)
        arrives_s = self._driver.arrives_s if away else now_s
        if self.state is JobState.APPROACHING:
            self.due_s = arrives_s + self._from_here_s()
        elif self.state is JobState.CARRYING:
            self.due_s = arrives_s + self._type.unload_s
        if not away:
            self.arrived(now_s)

    def _from_here_s(self) -> float:
        """How long the rest takes, from the source with nothing on board."""
        loaded_s = self._routes.duration_s(self._dock(self.source), self._dock(self.work.destination))
        return self._type.load_s + limited_s(loaded_s, self._driver.speed_frac) + self._type.unload_s

    def _dock(self, place: str) -> str:
        return dock_of(self._plant, self.work, place)

    def _carry(self, now_s: float) -> None:
        self._enter(JobState.CARRYING, self.work.destination)
        self._drive(self.work.destination, now_s)

    def _hand_over(self, now_s: float) -> None:
        self._enter(JobState.HANDING_OVER, self.work.destination)
        self._say_handover(now_s)

    def _ask_to_unload(self, now_s: float) -> None:
        if self._is_gated:
            self._drop(JobState.DROPPING)
        else:
            self._ask_for_dock(now_s)

    def _ask_for_dock(self, now_s: float) -> None:
        asked = Docked(task=self.task, epoch=self.epoch, station=self._station)
        if self._station != self.coordinator:
            # A storage may have lost its notes, and has no other word of the task.
            asked = msgspec.structs.replace(asked, item=self.work.item, quantity=self.work.quantity)
        # A machine and the station of a storage have the name of the place.
        self._ask(self._station, asked, now_s)

    def _say_handover(self, now_s: float) -> None:
        handover = Handover(task=self.task, epoch=self.epoch, quantity=self.work.quantity)
        self._ask(self.coordinator, handover, now_s)

    def _ask(self, whom: str, question: Message, now_s: float) -> None:
        self._timers.clear(RETRY)
        self._question.say(self.task, Send(whom, question), now_s)

    def _stop_waiting(self) -> None:
        self._question.settle(self.task)
        self._timers.clear(RETRY)

    def _say_given_back(self, now_s: float) -> None:
        resigned = self._resigned(self._given_back)
        self._ask(self.coordinator, msgspec.structs.replace(resigned, short=self._short), now_s)

    def _say_resigned(self, reason: str) -> None:
        self._out.append(Send(self.coordinator, self._resigned(reason)))

    def _resigned(self, reason: str) -> Resigned:
        return Resigned(task=self.task, epoch=self.epoch, role=Role.PRIMARY, reason=reason)

    def _wait(self, held: DockHeld, now_s: float) -> None:
        """Ask again later; at a storage, as long as its promise can be kept and a moment longer."""
        fetches = self.state is JobState.AT_SOURCE and self.source != self.coordinator
        kept = now_s + self._from_here_s() <= self.promised_s
        if fetches and not kept and now_s >= self._stands_s + WAITS_AT_LEAST_S:
            self._short = self.source
            self.give_back(held.reason, now_s)
        else:
            self._question.defer(self.task, now_s + HELD_ASK_AGAIN_S)

    def _waits_at(self, station: str) -> bool:
        asks = self.state in (JobState.AT_SOURCE, JobState.AT_DESTINATION)
        return asks and station == self._station

    def _transfer(self) -> None:
        if self.state is JobState.AT_SOURCE:
            self._pick()
        else:
            self._drop(JobState.DROPPING)

    def _pick(self) -> None:
        self._states.enter(JobState.PICKING)
        self._order = self._driver.next_order()
        self._driver.act(
            Pick(
                order=self._order,
                station=self.source,
                item=self.work.item,
                quantity=self.work.quantity,
            )
        )

    def _drop(self, state: JobState) -> None:
        self._states.enter(state)
        self._order = self._driver.next_order()
        goal = self.work.goal if state is JobState.DROPPING else ""
        self._driver.act(Drop(order=self._order, station=self._station, goal=goal))

    def _be_left_alone(self, now_s: float) -> None:
        """The coordinator answers nothing any more: its transports end with it (paper, case 1)."""
        if self.state is JobState.HANDING_OVER:
            self._end("handed over to a silent machine")
        elif self.state is JobState.AT_SOURCE and self.source != self.coordinator:
            self._short = self.source
            self.give_back(f"{self.source} does not answer", now_s)
        else:
            self.resign("its machine is silent", now_s)

    def _miss_load(self, now_s: float) -> None:
        """The load is gone: put down at last for an earlier life, or taken off by a person."""
        if self.is_void:
            self._end(self._void)
        elif self._may_be_dropping and self.state is JobState.AT_DESTINATION:
            self._hand_over(now_s)
        elif self.work.goal:
            self._say_resigned(GONE)
            self._end(GONE)
        else:
            self.begin(now_s)

    def _return(self, now_s: float) -> None:
        """Bring the load to a storage that keeps it; goods are set aside at the delivery warehouse.

        Where every storage is full, and stays so since nobody can fetch with this vehicle's load in the way, material goes back
        to where it came from, a source warehouse.
        """
        is_material = self.work.item in self._plant.materials
        storages = self._plant.storages_of(self.work.item) if is_material else (self.work.destination,)
        here = self._driver.next_node
        for refuges in (storages, self._plant.source_warehouses if is_material else ()):
            try:
                refuge, _ = self._routes.nearest(here, self._not_full(refuges))
                break
            except NoWay:
                continue
        else:
            self._full.clear()
            refuge, _ = self._routes.nearest(here, storages)
        self._enter(JobState.RETURNING, refuge)
        self._drive(refuge, now_s)

    def _not_full(self, places: Iterable[str]) -> tuple[str, ...]:
        return tuple(place for place in places if place not in self._full)

    def _end(self, reason: str) -> None:
        self._states.enter(JobState.ENDED)
        self.ended = reason
        self._stop_waiting()
        self._claim.settle(self.task)
