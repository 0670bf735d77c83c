"""A committed transport, as its carrier lives it: approach, load, carry, unload, hand over.

    APPROACHING -> LOADING -> CARRYING -> UNLOADING -> HANDING_OVER -> ended
         |            |           |            |
         +-- ended    +-----------+------------+--> RETURNING -> ended      (superseded, withdrawn)

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

import msgspec

from dray.body import Drop, Pick
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
from dray.messages.fact import PhaseEntered
from dray.plant import Plant
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.runtime.events import NEVER_S, Effect, Ignore, Record, Send
from dray.protocol.runtime.retransmission import ASK_AGAIN_S, Retransmitter
from dray.protocol.runtime.timers import Timers
from dray.protocol.vehicle.driving import Driver

ASK = "ask"
"""The alarm for whatever the job waits for: an answer, or another try."""

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

HANDED_OVER = "handed_over"


class TransportJob:
    """One transport of one vehicle.

    Args:
        atv: the vehicle.
        contract: what it is bound to.
        plant, vehicle_type: for ways and handling times.
        driver: the vehicle's place on the lanes.
        timers: the vehicle's alarms; this class uses `ASK` and ``(CLAIM_TASK, task)``.
        out: where effects go.

    Attributes:
        phase: how far it has come.
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
        self.phase = contract.phase
        self.due_s = contract.promised_s
        self.ended = ""
        self._plant = plant
        self._type = plant.vehicle_types[vehicle_type]
        self._routes = plant.routes(vehicle_type)
        self._driver = driver
        self._timers = timers
        self._out = out
        self._action = 0
        """The order number of the running pick or drop; 0 for none."""
        self._loaded = False
        self._cancelled = contract.cancelled
        """Why it is to end as soon as the running manoeuvre is over."""
        self._short = ""
        """The storage that had none of the load, which is why it was given back."""
        self._stands_s = NEVER_S
        """Since when it waits at its source."""
        self._given_back = ""
        """Why the coordinator is asked to let another one carry it; empty while it is carried."""
        self._may_be_dropping = False
        """An earlier life had come to the unloading: its drop may still be under way."""
        self._station = contract.source
        self._asked = 0
        """Questions since the last answer."""
        self._failed = 0
        """Manoeuvres that failed at this station."""
        self._full: set[str] = set()
        """Stations that did not take the load back. Only ever asked for membership."""
        self._claim = Retransmitter(CLAIM_TASK, timers, out)
        """What is said until the coordinator has confirmed a takeover, over all lives of the vehicle."""
        self.number = contract.number
        """Of the award that binds it; 0 for a takeover."""

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
            cancelled=self._cancelled,
            number=self.number,
            claim=self._contract.claim if self.task in self._claim else None,
        )

    @property
    def is_void(self) -> bool:
        """Whether it is over but for the load, which is on its way back."""
        return bool(self._cancelled)

    @property
    def is_given_back(self) -> bool:
        """Whether it ends as soon as the coordinator has answered."""
        return bool(self._given_back)

    @property
    def slack_s(self) -> float:
        """How much later than now expected it may be done."""
        return self._contract.deadline_s - self.due_s

    # --- what happens ---

    def begin(self, now_s: float) -> None:
        """Set off for the source."""
        self._enter(Phase.APPROACHING, self.source)
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
        self._loaded = load == self.work.item
        self._may_be_dropping = self.phase is Phase.UNLOADING
        if not self._cancelled:
            self._say_taken(now_s)
        if self._cancelled:
            self._give_up(now_s)
        elif self._loaded:
            self._carry(now_s)
        elif self.phase in (Phase.UNLOADING, Phase.HANDING_OVER):
            self._hand_over(now_s)
        elif self.phase in (Phase.CARRYING, Phase.RETURNING):
            self._miss_load(now_s)
        else:
            self.begin(now_s)

    def arrived(self, now_s: float) -> None:
        """The vehicle stands where it was sent."""
        if self._given_back:
            return
        if self.phase is Phase.APPROACHING:
            self._enter(Phase.LOADING, self.source)
            self._stands_s = now_s
            self._ask_for_dock(now_s)
        elif self.phase is Phase.CARRYING:
            self._enter(Phase.UNLOADING, self.work.destination)
            self._ask_to_unload(now_s)
        elif self.phase is Phase.RETURNING:
            self._drop()

    def way_refused(self, now_s: float) -> None:
        """The vehicle could not take the way: try again from where it is then."""
        self._timers.set(ASK, now_s + RETRY_S)

    def action_done(self, order: int, now_s: float) -> None:
        """A pick or drop has ended well."""
        if order != self._action:
            return
        self._action, self._failed = 0, 0
        if self.phase is Phase.LOADING:
            self._loaded = True
            if self._cancelled:
                self._return(now_s)
            else:
                self._carry(now_s)
        elif self.phase is Phase.UNLOADING:
            self._loaded = False
            if self._cancelled:
                self._end(self._cancelled)
            else:
                self._hand_over(now_s)
        elif self.phase is Phase.RETURNING:
            self._loaded = False
            self._end(self._cancelled)

    def action_failed(self, order: int, reason: str, now_s: float) -> None:
        """A pick or drop ended without effect."""
        if order != self._action:
            return
        self._action = 0
        self._failed += 1
        if self._cancelled and self.phase is not Phase.RETURNING:
            self._give_up(now_s)
        elif self._failed < TRIES:
            self._timers.set(ASK, now_s + RETRY_S)
        elif self.phase is Phase.RETURNING:
            self._full.add(self._station)
            self._return(now_s)
        elif self.phase is Phase.UNLOADING and self._is_gated:
            self.resign(f"refused: {reason}", now_s)
        else:
            self._timers.set(ASK, now_s + RETRY_S)

    def on_answer(self, message: Message, now_s: float) -> None:
        """Take an answer of the coordinator; what is late or doubled changes nothing."""
        if isinstance(message, Superseded) and not 0 < message.epoch < self.epoch:
            self.cancel(self._given_back or "superseded", now_s)
        elif isinstance(message, Withdrawn):
            self.cancel(self._given_back or "withdrawn", now_s)
        elif isinstance(message, Confirmed) and self.task in self._claim:
            self._claim.settle(self.task)
        elif isinstance(message, HandoverAccepted) and self.phase is Phase.HANDING_OVER:
            self._end(HANDED_OVER)
        elif isinstance(message, DockHeld) and self._waits_at(message.station):
            self._wait(message, now_s)
        elif isinstance(message, DockOpened) and self._waits_at(message.station):
            self._timers.clear(ASK)
            self._transfer()
        else:
            self._out.append(Ignore("an answer that nothing waits for any more"))
            return
        self._asked = 0

    def cancel(self, reason: str, now_s: float) -> None:
        """The contract is void: end, and take the load back if there is one."""
        if self._cancelled or self.ended:
            return
        self._cancelled = reason
        self._timers.clear(ASK)
        if not self._action:
            self._give_up(now_s)

    def resign(self, reason: str, now_s: float) -> None:
        """Give the contract back to its coordinator, and end it."""
        if not self._cancelled and not self.ended:
            resigned = Resigned(task=self.task, epoch=self.epoch, role=Role.PRIMARY, reason=reason)
            self._out.append(Send(self.coordinator, resigned))
        self.cancel(reason, now_s)

    def give_back(self, reason: str, now_s: float) -> None:
        """Stand, and ask the coordinator to let another one carry it.

        Harmless when the load is on board, or a manoeuvre runs: that nobody else can finish.
        """
        is_on_its_way = self.phase is Phase.APPROACHING or self.phase is Phase.LOADING
        if self._given_back or self._cancelled or self._action or not is_on_its_way:
            return
        self._given_back, self._asked = reason, 0
        if self._driver.way:
            self._driver.go(self._driver.next_node, now_s)
        self._say_given_back(now_s)

    def claim_again(self, now_s: float) -> None:
        """The coordinator has not confirmed the takeover yet."""
        self._claim.wake(self.task, now_s)

    def wake(self, load: str, now_s: float) -> None:
        """No answer has come, or a failed manoeuvre is due again.

        Args:
            load: what is on board now: an action of an earlier life may have ended, or a person has
                taken the load off.
            now_s: the present time.
        """
        if self._asked >= GIVE_UP_AFTER:
            self._be_left_alone(now_s)
        elif load and load != self.work.item:
            # An earlier life has picked it up; whoever carries this task must be empty.
            self.resign(f"{load} is on board", now_s)
        elif bool(load) != self._loaded:
            self._loaded, self._given_back = bool(load), ""
            if self._loaded:
                self._carry(now_s)
            else:
                self._miss_load(now_s)
        elif self._given_back:
            self._say_given_back(now_s)
        elif self.phase is Phase.LOADING:
            self._ask_for_dock(now_s)
        elif self.phase is Phase.UNLOADING:
            self._ask_to_unload(now_s)
        elif self.phase is Phase.HANDING_OVER:
            self._say_handover(now_s)
        else:
            self._drive(self._station, now_s)

    # --- how it is done ---

    @property
    def _is_gated(self) -> bool:
        """Whether a gate decides about the load, and not the coordinator."""
        return self.work.destination in self._plant.delivery_warehouses

    def _say_taken(self, now_s: float) -> None:
        """Say how this contract was made."""
        if self._contract.claim is not None:
            self._claim.say(self.task, self.coordinator, self._contract.claim, now_s)
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

    def _enter(self, phase: Phase, station: str) -> None:
        self.phase, self._station, self._failed = phase, station, 0
        fact = PhaseEntered(task=self.task, epoch=self.epoch, phase=phase, station=station)
        self._out.append(Record(fact))

    def _drive(self, station: str, now_s: float) -> None:
        away = self._driver.go(self._dock(station), now_s)
        arrives_s = self._driver.arrives_s if away else now_s
        if self.phase is Phase.APPROACHING:
            self.due_s = arrives_s + self._from_here_s()
        elif self.phase is Phase.CARRYING:
            self.due_s = arrives_s + self._type.unload_s
        if not away:
            self.arrived(now_s)

    def _from_here_s(self) -> float:
        """How long the rest takes, from the source with nothing on board."""
        loaded_s = self._routes.duration_s(self._dock(self.source), self._dock(self.work.destination))
        return self._type.load_s + loaded_s + self._type.unload_s

    def _dock(self, place: str) -> str:
        return dock_of(self._plant, self.work, place)

    def _carry(self, now_s: float) -> None:
        self._enter(Phase.CARRYING, self.work.destination)
        self._drive(self.work.destination, now_s)

    def _hand_over(self, now_s: float) -> None:
        self._enter(Phase.HANDING_OVER, self.work.destination)
        self._say_handover(now_s)

    def _ask_to_unload(self, now_s: float) -> None:
        if self._is_gated:
            self._drop()
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
        self._asked += 1
        self._out.append(Send(whom, question))
        self._timers.set(ASK, now_s + ASK_AGAIN_S)

    def _say_given_back(self, now_s: float) -> None:
        resigned = Resigned(
            task=self.task,
            epoch=self.epoch,
            role=Role.PRIMARY,
            reason=self._given_back,
            short=self._short,
        )
        self._ask(self.coordinator, resigned, now_s)

    def _wait(self, held: DockHeld, now_s: float) -> None:
        """Ask again later; at a storage, as long as its promise can be kept and a moment longer."""
        fetches = self.phase is Phase.LOADING and self.source != self.coordinator
        kept = now_s + self._from_here_s() <= self.promised_s
        if fetches and not kept and now_s >= self._stands_s + WAITS_AT_LEAST_S:
            self._short = self.source
            self.give_back(held.reason, now_s)
        else:
            self._timers.set(ASK, now_s + HELD_ASK_AGAIN_S)

    def _waits_at(self, station: str) -> bool:
        asking = self.phase is Phase.LOADING or self.phase is Phase.UNLOADING
        return asking and station == self._station and not self._action and not self._given_back

    def _transfer(self) -> None:
        if self.phase is Phase.LOADING:
            self._pick()
        else:
            self._drop()

    def _pick(self) -> None:
        self._action = self._driver.next_order()
        self._driver.act(
            Pick(
                order=self._action,
                station=self.source,
                item=self.work.item,
                quantity=self.work.quantity,
            )
        )

    def _drop(self) -> None:
        self._action = self._driver.next_order()
        goal = self.work.goal if self.phase is Phase.UNLOADING else ""
        self._driver.act(Drop(order=self._action, station=self._station, goal=goal))

    def _be_left_alone(self, now_s: float) -> None:
        """The coordinator answers nothing any more: its transports end with it (paper, case 1)."""
        self._asked = 0
        if self.phase is Phase.HANDING_OVER:
            self._end("handed over to a silent machine")
        elif self.phase is Phase.LOADING and self.source != self.coordinator and not self._given_back:
            self._short = self.source
            self.give_back(f"{self.source} does not answer", now_s)
        else:
            self.resign("its machine is silent", now_s)

    def _miss_load(self, now_s: float) -> None:
        """The load is gone: put down at last for an earlier life, or taken off by a person."""
        if self._cancelled:
            self._end(self._cancelled)
        elif self._may_be_dropping and self.phase is Phase.UNLOADING:
            self._hand_over(now_s)
        elif self.work.goal:
            self.resign("its load was taken off", now_s)
        else:
            self.begin(now_s)

    def _give_up(self, now_s: float) -> None:
        if self._loaded:
            self._return(now_s)
        else:
            self._end(self._cancelled)

    def _return(self, now_s: float) -> None:
        """Bring the load to a storage that keeps it; goods are set aside at the delivery warehouse."""
        refuges = self._plant.storages_of(self.work.item) if self._is_material else (self.work.destination,)
        roomy = [refuge for refuge in refuges if refuge not in self._full]
        if not roomy:
            self._full.clear()
        here = self._driver.next_node
        nearest = min(
            roomy or refuges, key=lambda each: self._routes.duration_s(here, self._plant.node_of(each))
        )
        self._enter(Phase.RETURNING, nearest)
        self._drive(nearest, now_s)

    @property
    def _is_material(self) -> bool:
        return self.work.item in self._plant.materials

    def _end(self, reason: str) -> None:
        self.ended = reason
        self._timers.clear(ASK)
        self._claim.settle(self.task)
