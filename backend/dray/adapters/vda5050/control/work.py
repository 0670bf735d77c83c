"""An agent's wishes, carried out as orders: one way or one task at a time.

The agent's way (`Way`) and task (`Task`) are the wishes; the vehicle's order (`Orders.present`) carries them out. `go_on` sends what is
possible: an idle vehicle gets its next step, a running one more base where its profile allows updates. A base cannot be
withdrawn, so it is kept short. A new way begins at the end of the vehicle's lane, as `dray.body.Drive` requires.
"""

from __future__ import annotations

from itertools import takewhile

from dray.adapters.vda5050.control.charge_watch import ChargeWatch
from dray.adapters.vda5050.control.hold import Holding
from dray.adapters.vda5050.control.instant import InstantActions
from dray.adapters.vda5050.control.on_board import OnBoard
from dray.adapters.vda5050.control.order_state import OrderState
from dray.adapters.vda5050.control.orders import (
    CANCELLED,
    FORGOTTEN,
    NEVER_CAME,
    STOPPED_SHORT,
    VANISHED,
    Orders,
)
from dray.adapters.vda5050.control.problems import kind_of
from dray.adapters.vda5050.control.refusals import is_about_order
from dray.adapters.vda5050.control.steps import Steps
from dray.adapters.vda5050.control.vehicle_order import ONLY_WAITS, Kind, Task, VehicleOrder
from dray.adapters.vda5050.control.view import VehicleView
from dray.adapters.vda5050.control.way import Way, objection
from dray.adapters.vda5050.control.whereabouts import PAST_M, Stand, Whereabouts
from dray.adapters.vda5050.events import Effect, Tell
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import OVER
from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drive,
    Drop,
    NodePassed,
    Pick,
    Report,
    WayBlocked,
    WayDone,
)
from dray.errors import ProtocolViolation
from dray.messages.problem import ProblemKind
from dray.plant import Plant
from dray.plant.model import VehicleType

FAILURES_MAX = 3
"""Maximum consecutive orders that ended early without progress of the way."""


class Work:
    """The wishes for one vehicle. `Orders` tells it what becomes of its orders.

    Args:
        plant: roads and stations.
        vehicle_type: its type in the plant.
        profile: its type's profile.
        view: the vehicle's messages.
        instant: its instant actions.
        load: the load on board.
        holding: whether it is held.
        out: receives the effects.

    Attributes:
        orders: its orders; set by the code that connects these objects.
        stand: its position, unless a step of ours gives it; None while unknown.
        lacks_place: whether it is at no place of the plant.
        way, task: its agent's wish; at most one of them.
        speed_frac: the limit that people have set.
        gains_nothing: the problem of a vehicle at a charger whose level does not rise; empty for none.
    """

    orders: Orders

    def __init__(
        self,
        plant: Plant,
        vehicle_type: VehicleType,
        profile: Profile,
        view: VehicleView,
        instant: InstantActions,
        load: OnBoard,
        holding: Holding,
        out: list[Effect],
    ) -> None:
        self._plant, self._profile, self._view = plant, profile, view
        self._kind = vehicle_type.id
        self._instant, self._load, self._holding, self._out = instant, load, holding, out
        self._whereabouts = Whereabouts(plant, profile)
        self.steps = Steps(plant, vehicle_type, profile, view)
        self.stand: Stand | None = None
        self.lacks_place = False
        self.way: Way | None = None
        self.task: Task | None = None
        self.speed_frac = 1.0
        self._left = ""
        """A node that it failed to set off from: it counts as left, however near it is."""
        self._charged_s: float | None = None
        """Since when it charges for our task."""
        self._charge_watch = ChargeWatch(vehicle_type)
        self.gains_nothing = ""

    @property
    def is_busy(self) -> bool:
        """Whether its agent waits for something."""
        return self.orders.present is not None or self.way is not None or self.task is not None

    def between(self) -> tuple[str, str]:
        """The last passed node, and the possible start of a new way.

        Raises:
            ProtocolViolation: its position is unknown.
        """
        order, stand = self.orders.present, self.stand
        if stand is None:
            raise ProtocolViolation("nothing is known of the vehicle yet: wait until it has said where it is")
        if order is None or order.kind is not Kind.STEP:
            return stand.node, stand.ahead or stand.node
        nodes = order.nodes
        return nodes[order.passed], nodes[min(order.passed + 1, order.end)]

    @property
    def base_end(self) -> str:
        """The last node that the vehicle may drive to: of its order, which may be of another way, or of its way; empty when it is there."""
        order, way = self.orders.present, self.way
        if order is not None and order.kind is Kind.STEP and order.passed < order.end:
            place = order.places[order.end]
            if way is None or place is None or place[0] != way.number:
                return order.nodes[order.end]
        return way.base_end if way is not None else ""

    def is_at_begin_of(self, order: VehicleOrder) -> bool:
        """Whether the vehicle is where an order to drive begins: anywhere else it would not take it."""
        start, ahead = order.nodes[0], order.nodes[min(1, order.end)]
        said = self._view.state.last_node_id or ""
        found = self._whereabouts.find(self._view.pose, said, order.nodes)
        if found is None:
            return False
        is_there = found.node == start and found.ahead in ("", ahead)
        return is_there or (said == start and self.gap_m(start) <= self._profile.first_deviation_m)

    def gap_m(self, node: str) -> float:
        """The vehicle's distance to a node; 0 while unknown."""
        return self._whereabouts.gap_m(self._view.pose, node)

    @property
    def wants_order(self) -> bool:
        """Whether there is more to order, once the vehicle takes it."""
        way = self.way
        wants_step = way is not None and way.passed < way.drivable - 1
        return wants_step or (self.task is not None and self._charged_s is None)

    # --- what its agent wants --------------------------------------------------------------------

    def drive(self, drive: Drive, now_s: float) -> None:
        node, ahead = self.between()
        self.way = None
        if reason := objection(drive, ahead, self._plant, self._kind):
            self._fail(drive.order, reason)
            return
        self._end_task("a new way was given", now_s)
        way = self.way = Way(drive, self.steps.corners)
        self.steps.place(way, self.orders.present)
        if ahead != node:
            return
        self._begin(way)

    def act(self, task: Task, now_s: float) -> None:
        if isinstance(self.task, Charge):
            self._end_task("", now_s)
        if reason := self._why_not(task):
            self._fail(task.order, reason)
            return
        self.task = task
        order = self.orders.present
        if order is not None and order.task is not None:
            order.number = task.order  # An earlier life's equal task.

    def _why_not(self, task: Task) -> str:
        """Why a task cannot be begun; empty when it can."""
        node, ahead = self.between()
        place = task.charger if isinstance(task, Charge) else task.station
        if self.way is not None:
            return "the way is not finished"
        if self.task is not None:
            return "busy with another action"
        by_hand = isinstance(task, Pick) and place in self._plant.nodes
        if place not in self._plant.places and not by_hand:
            return f"no station {place}"
        if ahead != node or (self._plant.node_of(place) if place in self._plant.places else place) != node:
            return f"not at {place}"
        order = self.orders.present
        if order is not None and order.task is not None and not _is_same(order.task, task):
            return "busy with another action"
        if isinstance(task, Pick) and self._load.item:
            return f"{self._load.item} is on board"
        return "nothing on board" if isinstance(task, Drop) and not self._load.item else ""

    def _end_task(self, reason: str, now_s: float) -> None:
        """End the present task by a new way or task: a charge succeeds, a pick or drop fails."""
        task, self._charged_s = self.task, None
        order = self.orders.present
        if order is not None and order.action is not None:
            self.orders.cancel(now_s)
        if task is None:
            return
        if isinstance(task, Charge) or order is None or order.action is None:
            self.task = None
            if not isinstance(task, Charge):
                self._fail(task.order, reason)

    # --- where it is -----------------------------------------------------------------------------

    def locate(self) -> None:
        """Find its position when no order gives it."""
        order = self.orders.present
        if order is not None and order.kind is Kind.STEP:
            return
        course = self.way.nodes if self.way is not None else ()
        found = self._find(self._view.state.last_node_id or "", course)
        self.lacks_place = found is None
        if found is None or found == self.stand:
            return
        before, self.stand = self.stand, found
        way = self.way
        if way is not None and before is not None and way.passed >= 0 and found.node != before.node:
            self._lose_way(way, f"it was moved from {before.node} to {found.node}")

    def _find(self, said: str, course: tuple[str, ...]) -> Stand | None:
        state = self._view.state
        past_m = self._view.driven_m or 0.0 if said == state.last_node_id else 0.0
        least_m, course = (PAST_M, course) if said != self._left else (0.0, ())
        return self._whereabouts.find(self._view.pose, said, course, is_past=past_m > least_m)

    # --- what becomes of an order (`Owner`) ------------------------------------------------------

    def on_passed(self, order: VehicleOrder, index: int, now_s: float) -> None:
        """A node of the base was passed."""
        self.stand, self._left = Stand(order.nodes[index]), ""
        way, place = self.way, order.places[index]
        if way is not None and place is not None and place[0] == way.number:
            self._reach(way, place[1])

    def on_over(self, order: VehicleOrder, now_s: float) -> None:
        """The order has ended, in any way."""
        done = order.now is OrderState.DONE
        if order.kind is Kind.STEP:
            self._end_step(order, done, now_s)
        elif done:
            self._end_action(order, now_s)
        else:
            self._miss_action(order)

    def _end_step(self, order: VehicleOrder, done: bool, now_s: float) -> None:
        node = order.nodes[order.passed]
        if not (done or order.passed or order.reason in (CANCELLED, STOPPED_SHORT, NEVER_CAME)):
            self._left = node
        found = self._find(node, order.nodes[order.passed :])
        if found is not None and not done:
            self._pass_corners(order, found, now_s)
        self.stand = Stand(node) if done or found is None else found
        way = self.way
        if way is None:
            return
        if (done or order.reason == CANCELLED) and way.passed == way.last:
            if node == way.nodes[-1]:
                self._finish_way(way)
            else:
                self._lose_way(way, f"it was bound for {node} already")
        elif done or order.reason == CANCELLED:
            way.failures = 0
        else:
            way.failures += 1
            self._tell_blocked(way, order, found)
            # An interrupted way continues from the present position; a repeatedly refused one does not.
            if order.reason != STOPPED_SHORT or way.failures >= FAILURES_MAX:
                self._lose_way(way, order.reason)

    def _tell_blocked(self, way: Way, order: VehicleOrder, found: Stand | None) -> None:
        """Report a blocked lane after an error has ended an order: other vehicles avoid it, and its agent takes another way, if any.

        The error lasts until the next order is accepted, so its end does not show that the lane is free: agents forget it after a
        while, or when a vehicle drives there.
        """
        error, first = order.ended_by, order.passed + 1
        if error is None or is_about_order(error) or first > order.end:
            return
        if kind_of(error, self._profile) is not ProblemKind.WAY_BLOCKED:
            return
        named = (index for index in range(first, order.end + 1) if error.names(order.nodes[index]))
        end = next(named, first)
        start, goal = order.nodes[end - 1], order.nodes[end]
        entered = found is not None and found != Stand(order.nodes[order.passed])
        self._tell(WayBlocked(order=way.number, start=start, end=goal, entered=entered and end == first))

    def _pass_corners(self, order: VehicleOrder, found: Stand, now_s: float) -> None:
        """Pass the corners of a lane that was left half way: the vehicle has not reported them."""
        ahead = list(takewhile(lambda node: node in self.steps.corners, order.nodes[order.passed + 1 :]))
        if found.node in ahead:
            for _ in range(ahead.index(found.node) + 1):
                order.passed += 1
                self.on_passed(order, order.passed, now_s)

    def _end_action(self, order: VehicleOrder, now_s: float) -> None:
        task = order.task
        if isinstance(task, Pick):
            self._load.picked(task.item, task.quantity)
        elif isinstance(task, Drop):
            self._load.dropped()
        if isinstance(task, Charge):
            if self.task is not None:
                self._charged_s = now_s  # The battery level shows when the charge is over.
            return
        self.task = None
        self._tell(ActionDone(order=order.number))

    def _miss_action(self, order: VehicleOrder) -> None:
        if (
            order.reason == ONLY_WAITS
            and not order.is_twice
            and self.task is not None
            and not order.is_unwanted
        ):
            self.steps.twice = True  # Retry with its node listed twice.
            return
        self.steps.twice = self._profile.action_node_twice
        had_begun = order.reason in (FORGOTTEN, VANISHED)
        if had_begun and order.kind in (Kind.PICK, Kind.DROP):
            item = self._load.item
            self.lose_track(order)
            if self._load.doubt == "" and (self._load.item != item):
                self.task = None
                self._tell(ActionDone(order=order.number))
                return
        self.task = None
        if order.kind is not Kind.CHARGE or not order.is_unwanted:
            self._fail(order.number, order.reason or CANCELLED)

    def lose_track(self, order: VehicleOrder) -> None:
        """The end of a pick or drop was not seen: ask for the load on board instead of assuming it."""
        task = order.task
        item, quantity = (
            (task.item, task.quantity) if isinstance(task, Pick) else (self._load.item, self._load.quantity)
        )
        self._load.lose_track(order.kind.value, item, quantity, self._view.state)

    # --- going on --------------------------------------------------------------------------------

    def go_on(self, now_s: float) -> None:
        """Send the next order, if possible; there is no problem, and the vehicle is not held."""
        if self.orders.present is not None:
            self._grow(self.orders.present, now_s)
            return
        if self.way is not None and self.way.passed < 0 and self.stand == Stand(self.way.nodes[0]):
            self._begin(self.way)
        way = self.way
        if not self.wants_order or not self.orders.is_ready(now_s) or self._is_still_charging(now_s):
            return
        if way is not None:
            self._step(way, now_s)
        elif self.task is not None and self.stand is not None:
            self.orders.offer(self.steps.action(self.task, self.stand.node), now_s)

    def _step(self, way: Way, now_s: float) -> None:
        if self.stand is None:
            return
        step = self.steps.next(way, self.stand, self.speed_frac)
        if isinstance(step, str):
            self._lose_way(way, step)
        else:
            self.orders.offer(step, now_s)

    def _grow(self, order: VehicleOrder, now_s: float) -> None:
        """Give a running order more base, or another horizon."""
        if order.now is not OrderState.RUNNING or order.kind is not Kind.STEP or order.is_unwanted:
            return
        more = self.steps.more(order, self.way, self.speed_frac)
        if more is not None:
            self.orders.extend(more.stops, more.places, more.speeds_mps, more.beyond, now_s)

    def _is_still_charging(self, now_s: float) -> bool:
        """Whether it charges, and must be told to stop that first."""
        stop = self._profile.stop_charging
        if not self._view.is_charging or not stop or isinstance(self.task, Charge):
            if stop:
                self._instant.forget(stop)
            return False
        if not self._instant.is_open(stop):
            self._instant.say(stop, now_s)
        return self._instant.status(stop) not in OVER and not self._instant.is_given_up(stop)

    def watch_charge(self, now_s: float) -> None:
        """End a charge when the battery is full, and check that its level rises."""
        task, battery = self.task, self._view.battery
        order = self.orders.running
        begun = self._charged_s is not None or (order is not None and order.kind is Kind.CHARGE)
        is_watched = isinstance(task, Charge) and begun and not battery.unknown
        self.gains_nothing = self._charge_watch.look(battery.frac if is_watched else None, now_s)
        self._view.battery.is_plugged = isinstance(task, Charge) and self._charged_s is not None
        if isinstance(task, Charge) and (self._charged_s is not None or self._view.is_charging):
            if self._view.battery_frac * 100.0 >= self._profile.full_percent:
                self.task = self._charged_s = None
                self._tell(ActionDone(order=task.order))

    def _begin(self, way: Way) -> None:
        """The vehicle stands at the first node of its way."""
        self._reach(way, 0)
        if way.last == 0:
            self._finish_way(way)

    def _reach(self, way: Way, index: int) -> None:
        way.passed, way.failures = index, 0
        node = way.nodes[index]
        self._tell(NodePassed(order=way.number, node=node, index=index, battery_frac=self._view.battery_frac))

    def _finish_way(self, way: Way) -> None:
        self.way = None
        self._tell(WayDone(order=way.number, node=way.nodes[-1]))

    def _lose_way(self, way: Way, reason: str) -> None:
        self.way = None
        self._fail(way.number, reason)

    def _fail(self, number: int, reason: str) -> None:
        self._tell(ActionFailed(order=number, reason=reason))

    def _tell(self, report: Report) -> None:
        self._out.append(Tell(report))


def _is_same(one: Task, other: Task) -> bool:
    """Whether two instructions have the same content."""
    match one, other:
        case (Pick(), Pick()):
            return (one.station, one.item, one.quantity) == (other.station, other.item, other.quantity)
        case (Drop(), Drop()):
            return (one.station, one.goal) == (other.station, other.goal)
        case (Charge(), Charge()):
            return one.charger == other.charger
    return False
