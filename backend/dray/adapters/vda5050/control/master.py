"""The master of one vehicle: it turns its agent's wishes into orders, and the vehicle's messages into reports.

Pure: `handle(event, now_s)` returns effects, to be carried out in order: a memory is stored before the order that it is about
is sent. `Work` has the agent's wishes, `Orders` the vehicle's present order, `VehicleView` its messages. No order is sent during a
problem, or while the vehicle is held.
"""

from __future__ import annotations

from dray.adapters.vda5050.control.criticals import Criticals
from dray.adapters.vda5050.control.factsheet import differences
from dray.adapters.vda5050.control.hold import Holding
from dray.adapters.vda5050.control.instant import ASK_STATE, InstantActions
from dray.adapters.vda5050.control.names import Names
from dray.adapters.vda5050.control.on_board import OnBoard
from dray.adapters.vda5050.control.order_state import OrderState
from dray.adapters.vda5050.control.orders import Orders
from dray.adapters.vda5050.control.problems import absence, complaint, is_attended, problem
from dray.adapters.vda5050.control.steady import Steady
from dray.adapters.vda5050.control.vehicle_order import Kind, restored
from dray.adapters.vda5050.control.view import NEVER_S, REORDERED_S, VehicleView
from dray.adapters.vda5050.control.watch import Watch
from dray.adapters.vda5050.control.whereabouts import Stand
from dray.adapters.vda5050.control.work import Work
from dray.adapters.vda5050.events import (
    Cancel,
    Effect,
    Event,
    Heard,
    Instructed,
    Linked,
    Memory,
    Note,
    OrderMemory,
    Remember,
    Tell,
    Unlinked,
    Woke,
    kind_of,
)
from dray.adapters.vda5050.profile import Profile
from dray.body import (
    Charge,
    Drive,
    Drop,
    Hold,
    LimitSpeed,
    Pick,
    ProblemCleared,
    ProblemRaised,
    ReleaseWay,
    Unhold,
    VehicleInstruction,
    VehicleState,
)
from dray.messages import BodyWait, Pose
from dray.messages.problem import NOTHING_KNOWN, ProblemKind
from dray.plant import Plant
from dray.plant.model import VehicleType

LOOK_S, REST_S = 0.5, 2.0
"""Seconds between two ticks: with an order, and without one."""

HINDERED_S = 60.0
"""Seconds without accepting an order after which a vehicle has a problem, though nothing else is wrong."""

NOTED_S = 60.0
"""A wait longer than this is logged."""

FAILED_S = 60.0
"""Duration of a problem after a failure of our own; a success with the next event of its kind ends it earlier."""

FOREIGN_MAX = 20
"""Maximum logged types of others' actions."""

ASK_FACTSHEET = "factsheetRequest"


class MasterControl:
    """The master of one vehicle.

    Args:
        agent: its id in the plant.
        plant: roads and stations.
        vehicle_type: its type in the plant.
        profile: its type's profile.
        life: higher than any life before, so that ids of orders are unique.
        memory: the last life's memory.

    Attributes:
        wake_at_s: when `Woke` is due.
        view: the vehicle's messages.
        is_linked: whether the broker is connected.
    """

    def __init__(
        self,
        agent: str,
        plant: Plant,
        vehicle_type: VehicleType,
        profile: Profile,
        *,
        life: int,
        memory: Memory | None = None,
    ) -> None:
        memory = memory or Memory()
        self.wake_at_s = 0.0
        self._plant, self._type, self._profile = plant, vehicle_type, profile
        self._out: list[Effect] = []
        self.view = view = VehicleView(profile, agent, vehicle_type, Names(plant, profile))
        self._instant = InstantActions(agent, life, profile, self._out)
        self._criticals = Criticals(view, profile)
        self._holding = Holding(profile, view, self._instant)
        self._load = OnBoard(profile, memory.load, memory.quantity, memory.doubt)
        self._work = Work(
            plant, vehicle_type, profile, view, self._instant, self._load, self._holding, self._out
        )
        self._orders = self._work.orders = Orders(
            agent, life, profile, view, self._instant, self._out, self._work, self._remember
        )
        self._earlier = memory.order
        """The last life's order, until the first state."""
        self._recognises = True
        """Whether the vehicle's order is still to be recognised, by the first state."""
        self._remembered = memory
        self.is_linked = False
        self._unlinked: tuple[str, float] | None = None
        """The reason and time of the loss of the broker."""
        self._is_attended = False
        """Whether people operate it."""
        self._watch = Watch(plant, vehicle_type, profile, view)
        self._steady = Steady()
        self._hindrance, self._hindered_s = "", 0.0
        """The reason why the vehicle takes no order, and its begin."""
        self._waits: tuple[str, str] | None = None
        self._waits_s, self._has_noted_wait = 0.0, False
        """The begin of the present wait, and whether it is logged."""
        self._foreign: set[str] = set()
        """Actions of others that were logged."""
        self._problem: ProblemRaised | None = None
        """The problem as last reported."""
        self._failed: tuple[str, float] | None = None
        """The kind of event whose handling failed, and the last time; None without a recent failure."""

    @property
    def is_known(self) -> bool:
        """Whether the vehicle's position is known: before that it has no state."""
        return self._work.stand is not None

    @property
    def why_unknown(self) -> str:
        """The missing information, for people."""
        if self._unlinked is not None:
            return f"the broker is away: {self._unlinked[0]}"
        if not self.is_linked:
            return "the broker has not answered yet"
        if self.view.heard_s == NEVER_S:
            odd = ", ".join(f"{count} times {reason}" for reason, count in self.view.odd.items())
            return "the vehicle has not said anything yet" + (f" that can be used: {odd}" if odd else "")
        found = self._find_problem(self.view.heard_s)
        return found.reason if found is not None else "the vehicle has not said where it is"

    @property
    def wait(self) -> BodyWait | None:
        """What it waits for, since when, and what would end the wait; None without a wait."""
        if self._waits is None:
            return None
        what, until = self._waits
        return BodyWait(what=what, since_s=self._waits_s, until=until)

    def waits_for(self, now_s: float) -> str:
        """The same in one line; empty without a wait."""
        wait = self.wait
        return (
            ""
            if wait is None
            else f"waits for {now_s - wait.since_s:.0f} s: {wait.what} (until {wait.until})"
        )

    def _what_it_waits_for(self) -> tuple[str, str] | None:
        """What it waits for, and what would end the wait."""
        order, way = self._orders.present, self._work.way
        if self._problem is not None:
            return self._problem.reason, "that is gone"
        if not self.is_known:
            return self.why_unknown, "it says so"
        if self._holding.held:
            return "its agent holds it", "its agent lets it go on"
        if self._hindrance:
            return self._hindrance, "it stands and has nothing left to do"
        if order is None and self._work.wants_order and self.view.is_charging:
            return "it charges", f"it does not, or {self._profile.stop_charging} has ended"
        if order is None:
            is_short = way is not None and not self._work.wants_order
            return ("no more of its way is released", "its agent releases more") if is_short else None
        match order.now:
            case OrderState.OFFERED:
                return f"it does not show order {order.id}", f"it does, for {self._profile.silent_s:g} s"
            case OrderState.REFUSED:
                return f"it has refused order {order.id}: {order.reason}", "it is tried again"
            case OrderState.CANCELLING:
                return f"order {order.id} is cancelled", "cancelOrder has ended, or it has nothing left to do"
        if order.action is not None:
            return f"its action {order.action.type}", "that is FINISHED or FAILED"
        return f"it drives to {order.nodes[min(order.passed + 1, order.end)]}", "it is there"

    def _note_waits(self, now_s: float) -> None:
        """Log a long wait, once."""
        waits = self._what_it_waits_for()
        if waits != self._waits:
            self._waits, self._waits_s, self._has_noted_wait = waits, now_s, False
        elif waits and not self._has_noted_wait and now_s - self._waits_s >= NOTED_S:
            self._has_noted_wait = True
            self._out.append(Note(self.waits_for(now_s)))

    def _note_foreign(self) -> None:
        """Log others' actions that do not end, once each."""
        if self.view.is_foreign:
            return
        for action in self.view.foreign_actions:
            name = action.action_type or action.action_id or ""
            if name not in self._foreign and len(self._foreign) < FOREIGN_MAX:
                self._foreign.add(name)
                words = f"an action of somebody else is {action.action_status}: {name}; no order waits for it"
                self._out.append(Note(words))

    @property
    def needs_node_twice(self) -> bool:
        """Whether an action succeeded only with its node listed twice, or the profile says so."""
        return self._work.steps.twice

    @property
    def cancelled(self) -> int:
        """The number of orders that the vehicle has ended by our cancellation."""
        return self._orders.cancelled

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Handle an event; returns the effects in order."""
        match event:
            case Heard(topic, data):
                self._hear(topic, data, now_s)
            case Instructed(instruction):
                self._obey(instruction, now_s)
            case Cancel():
                self._orders.cancel(now_s)
            case Linked():
                self.is_linked, self._unlinked = True, None
                self._instant.say(ASK_STATE, now_s)
                if self.view.factsheet is None:
                    self._instant.say(ASK_FACTSHEET, now_s)
            case Unlinked(reason):
                self.is_linked, self._unlinked = False, self._unlinked or (reason, now_s)
            case Woke():
                pass
        if self.is_linked:
            self._ask_when_in_doubt(now_s)
            self._instant.tick(now_s)
            self._instant.clear(self.view.state, now_s)
            self._orders.tick(now_s)
            if (error := self._criticals.look(self._orders.running, now_s)) is not None:
                self._orders.fail(error, now_s)
            self._holding.tick(now_s)
        self._tell_problem(now_s)
        if self.is_linked and self.is_known and not self._problem and not self._holding.held:
            self._work.go_on(now_s)
        self._work.watch_charge(now_s)
        self._remember()
        self._note_waits(now_s)
        if self._failed is not None and self._failed[0] == kind_of(event):
            self._failed = None
        self.wake_at_s = now_s + (LOOK_S if self._work.is_busy else REST_S)
        return self._effects()

    def fail(self, event: Event, now_s: float) -> list[Effect]:
        """Effects after `handle` has raised: those decided by then, and a problem."""
        self._failed = kind_of(event), now_s
        self._tell(self._failure(now_s), now_s)
        self.wake_at_s = now_s + REST_S
        return self._effects()

    def _effects(self) -> list[Effect]:
        effects = self._out[:]
        self._out.clear()
        return effects

    def sense(self) -> VehicleState:
        """The vehicle's state, as reported.

        Raises:
            ProtocolViolation: its position is unknown; our own bug.
        """
        node, ahead = self._work.between()
        spot, view = self._plant.nodes[node], self.view
        gap_m = self._work.gap_m(ahead) if ahead != node else 0.0
        return VehicleState(
            pose=view.pose or Pose(x_m=spot.x_m, y_m=spot.y_m, heading_rad=0.0),
            node=node,
            next_node=ahead,
            next_node_s=gap_m / (view.speed_mps or self._type.max_speed_mps),
            speed_mps=view.speed_mps if view.is_driving else 0.0,
            battery_frac=view.battery_frac,
            load=self._load.item,
            load_quantity=self._load.quantity,
            held=self._holding.held,
            charging=view.is_charging,
            problem=self._problem.reason if self._problem else "",
            about_problem=self._problem.problem if self._problem else NOTHING_KNOWN,
            battery_reckoned=bool(view.battery.unknown),
            wait=self.wait,
            base_end=self._work.base_end,
        )

    # --- what its agent wants --------------------------------------------------------------------

    def _obey(self, instruction: VehicleInstruction, now_s: float) -> None:
        match instruction:
            case Drive():
                self._work.drive(instruction, now_s)
            case ReleaseWay(number, released):
                if self._work.way is not None:
                    self._work.way.release(number, released)
            case Pick() | Drop() | Charge():
                self._work.act(instruction, now_s)
            case Hold():
                self._holding.hold(now_s)
                if not self._profile.pause:
                    self._orders.cancel(now_s)
            case Unhold():
                self._holding.go_on(now_s)
            case LimitSpeed(speed_frac):
                self._work.speed_frac = min(speed_frac, 1.0)

    # --- what the vehicle says -------------------------------------------------------------------

    def _hear(self, topic: str, data: bytes, now_s: float) -> None:
        sheet, was_known = self.view.factsheet, self.is_known
        state = self.view.take(topic, data, now_s)
        if self.view.factsheet is not None and self.view.factsheet is not sheet:
            self._out += (Note(text) for text in differences(self.view.factsheet, self._type, self._profile))
        self._out += (Note(text) for text in self.view.doubts.to_tell())
        if topic == "connection" and not self.view.away:
            self._instant.say(ASK_STATE, now_s)
        if state is None:
            return
        self._recognise(now_s)
        self._instant.on_state(state)
        self._note_foreign()
        self._orders.on_state(now_s)
        self._work.locate()
        if not was_known and self.is_known:
            self._holding.held = state.paused is True
        self._attend()
        order = self._orders.present
        is_handling = order is not None and order.kind in (Kind.PICK, Kind.DROP)
        self._load.on_state(state, is_handling=is_handling, now_s=now_s)
        if self._load.flickers:
            words = "what is on board changed for a moment, and no action of ours was under way"
            self.view.doubts.note("a load that comes and goes", words)

    def _recognise(self, now_s: float) -> None:
        """Continue the last life's order: it is never given again under another id.

        An order to drive that was not shown may still come. It is waited for, and not sent again: nobody may want it any more.
        """
        memory, self._earlier = self._earlier, None
        if not self._recognises:
            return
        self._recognises = False
        if (shown := self._shown_base(memory)) is not None:
            memory = shown
        if memory is None or not all(node in self._plant.nodes for node in memory.nodes):
            return
        order = restored(memory, self._work.steps)
        if order.is_shown(self.view.state):
            self._work.stand = Stand(memory.nodes[0])
            self._orders.recognise(order, now_s)
        elif order.task is not None and not isinstance(order.task, Charge):
            if memory.is_shown or self.view.state.loads:
                self._work.lose_track(order)  # The vehicle has forgotten it meanwhile.
            else:
                self._orders.recognise(order, now_s)  # Perhaps it never arrived: send it again, unchanged.
        elif order.task is None and not memory.is_shown and self._work.is_at_begin_of(order):
            self._work.stand = Stand(memory.nodes[0])
            self._orders.recognise(order, now_s)

    def _shown_base(self, memory: OrderMemory | None) -> OrderMemory | None:
        """What the vehicle may still drive over, if this is no order that the last life has noted; None for nothing.

        The journal is lost, or the order was taken for refused, and came late.
        """
        state, view = self.view.state, self.view
        if memory is not None and (state.order_id == memory.id or memory.kind != Kind.STEP):
            return None
        if not view.shows_ours:
            return None
        # Some never clear their nodes: those before the last one are driven.
        past = state.last_node_sequence_id or 0
        left = sorted(
            (each.sequence_id or 0, each.node_id or "") for each in state.node_states or () if each.released
        )
        ahead = (view.names.ours(node, view.map_id) or "" for number, node in left if number > past)
        nodes = (state.last_node_id or "", *ahead)
        if len(nodes) < 2:
            return None
        update = state.order_update_id or 0
        return OrderMemory(state.order_id or "", update, 0, Kind.STEP.value, nodes, is_shown=True)

    def _ask_when_in_doubt(self, now_s: float) -> None:
        """Request a state after a doubtful one: a lower header id means an old state, or a restarted vehicle."""
        doubtful_s = self.view.doubtful_s
        if doubtful_s is not None and now_s - doubtful_s >= REORDERED_S:
            self.view.doubtful_s = None
            self._instant.say(ASK_STATE, now_s)

    def _attend(self) -> None:
        if is_attended(self.view.state):
            self._is_attended = True
        elif self._is_attended:
            self._is_attended = False
            self._load.was_attended(self.view.state)

    # --- problems, and what the next life must know ----------------------------------------------

    def _find_problem(self, now_s: float) -> ProblemRaised | None:
        """The first of its present problems."""
        view, load = self.view, self._load
        found = self._failure(now_s) or absence(view, self._profile, self._unlinked, now_s)
        if found is not None or view.heard_s == NEVER_S:
            return found
        if found := complaint(view.state, self._profile, critical=self._criticals.is_told(now_s)):
            return found
        if not view.is_on_map:
            known = [name for name in view.names.frames if name] or [view.map_id]
            return problem(f"it is on a map that is not {' or '.join(known)}", ProblemKind.LOST_POSITION)
        if self._work.lacks_place:
            where = f": ({view.pose.x_m:.1f}, {view.pose.y_m:.1f})" if view.pose else ""
            return problem(f"it stands on no lane of the plant{where}", ProblemKind.LOST_POSITION)
        if self._orders.does_not_cancel:
            return problem("it goes on with an order that was cancelled")
        if words := self._holding.problem or self._orders.overlong:
            return problem(words)
        if self._hindrance and now_s - self._hindered_s >= HINDERED_S:
            return problem(f"it takes no order: {self._hindrance}")
        if refuses := self._orders.unwilling.problem(now_s) or self._orders.undriven.problem(now_s):
            return problem(refuses, needs_person=True)
        if self._watch.problem is not None:
            return self._watch.problem
        if self._work.gains_nothing:
            return problem(self._work.gains_nothing, ProblemKind.BATTERY, needs_person=True)
        if load.doubt or load.difference:
            return problem(load.doubt or load.difference, ProblemKind.LOAD, needs_person=True)
        return None

    def _look_at_progress(self, now_s: float) -> None:
        """Check that it approaches the end of its order, if no known reason keeps it from that."""
        view, orders, way = self.view, self._orders, self._work.way
        is_here = self.is_known and view.heard_s != NEVER_S and self.is_linked
        keeps = absence(view, self._profile, self._unlinked, now_s) or complaint(
            view.state, self._profile, critical=self._criticals.is_told(now_s)
        )
        order = orders.running if is_here else None
        gap_m = None
        if order is not None and order.kind is Kind.STEP and view.pose is not None:
            gap_m = self._work.gap_m(order.nodes[min(order.passed + 1, order.end)])
        number = way.number if way is not None else 0
        may_drive = is_here and keeps is None and not self._holding.is_held(now_s)
        said = self._watch.look(order, number, gap_m, now_s, may_drive=may_drive)
        if said is not None:
            self._out.append(Tell(said))

    def _look_at_hindrance(self, now_s: float) -> None:
        wants = self._work.wants_order or self._orders.present is not None
        is_here = self.is_linked and self.view.heard_s != NEVER_S and not self._holding.held
        found = self._orders.hindrance(now_s) if wants and is_here else ""
        if not found or not self._hindrance:
            self._hindered_s = now_s
        self._hindrance = found

    def _tell_problem(self, now_s: float) -> None:
        self._look_at_progress(now_s)
        self._look_at_hindrance(now_s)
        self._tell(self._find_problem(now_s), now_s)

    def _tell(self, found: ProblemRaised | None, now_s: float) -> None:
        stands = self._steady.look(found, now_s)
        if stands != self._problem:
            self._problem = stands
            self._out.append(Tell(stands or ProblemCleared()))

    def _failure(self, now_s: float) -> ProblemRaised | None:
        """The problem from our own fault; None without a recent failure."""
        if self._failed is None or now_s - self._failed[1] >= FAILED_S:
            return None
        return problem(f"our own fault, see the log: {self._failed[0]} cannot be dealt with")

    def _remember(self) -> None:
        """Store the memory, when it has changed."""
        order = self._orders.present
        memory = Memory(
            load=self._load.item,
            quantity=self._load.quantity,
            order=self._earlier if order is None else order.memory(),
            doubt=self._load.doubt,
        )
        if memory != self._remembered:
            self._remembered = memory
            self._out.append(Remember(memory))
