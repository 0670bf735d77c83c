"""A simulated vehicle that speaks VDA 5050: orders in, states out, and a body that drives.

It behaves as the text says, or as its `Misbehaviour` says instead. It drives an order up to the next node with an
action, or to the end of its base; there it does the action. Its messages go to `publish`, and messages to it come
through `on_message`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drive,
    Hold,
    NodePassed,
    ProblemCleared,
    ProblemRaised,
    Report,
    Unhold,
    WayDone,
)
from dray.plant.model import VehicleType
from dray.ports import Clock
from dray_sim.bodies.vehicle.vehicle import SimVehicle
from dray_sim.vda5050 import order as reading
from dray_sim.vda5050.misbehaviour import Misbehaviour
from dray_sim.vda5050.order import NodeAction, Order
from dray_sim.vda5050.own_map import OwnMap
from dray_sim.vda5050.words import Condition, Words

Publish = Callable[[str, bytes, bool], None]
"""Called with a topic (the last chunk), a message, and whether the broker keeps it."""

STATE_EVERY_S, DRIVING_EVERY_S, INSTANT_KEPT = 30.0, 1.0, 20
REACHABLE_M = 2.0
"""Largest distance between the vehicle and the beginning of an order (m)."""


class Vda5050Vehicle:
    """One vehicle.

    Args:
        body: drives, picks and drops.
        kind: of its type.
        charger_at: the charger at a node; empty for none.
        clock: the plant's.
        publish: sends its messages.
        words: its version and name.
        corners: of its map: lanes that are not straight, by their ends.
        own_map: its own ids and frame; None where these are the plant's.

    Attributes:
        condition: its state beside its body; tests change it, and report it with `say_state`.
        order: the present one; None before the first one, and after a restart.
        done: executed actions, by id: none may be there twice.
    """

    def __init__(
        self,
        body: SimVehicle,
        kind: VehicleType,
        charger_at: Callable[[str], str],
        clock: Clock,
        publish: Publish,
        words: Words,
        corners: Mapping[tuple[str, str], tuple[str, ...]] | None = None,
        own_map: OwnMap | None = None,
    ) -> None:
        self._own_map = own_map
        self._body, self._kind, self._charger_at, self._corners = body, kind, charger_at, corners or {}
        self._clock, self._publish, self.words = clock, publish, words
        self.quirks: Misbehaviour = words.quirks
        self.condition = Condition(last_node="" if self.quirks.no_last_node else body.sense().node)
        self.order: Order | None = None
        self.done: list[str] = []
        self._action: NodeAction | None = None
        self._drive = 0
        """The number of the newest instruction to its body."""
        self._way: list[int] = []
        """Index in the order, for each node of the present drive."""
        self._passed_m = 0.0
        """Distance driven when it was last at a node of its map."""
        self._spoken_s = float("-inf")
        self._asked = not self.quirks.silent_until_asked
        self._ready_s = float("-inf")
        self._ignored = {
            "order": self.quirks.ignores_first_orders,
            "instantActions": self.quirks.ignores_instant_actions,
        }
        self._refused_ids: set[str] = set()
        self._accepted_ids = 0
        self._doomed = self._was_moving = False
        self._life = 0
        body.attach(self._on_report)
        self.introduce()
        self._tick(0)

    # --- what it says ----------------------------------------------------------------------------

    def introduce(self) -> None:
        """Announce its connection, its factsheet and its state: the broker keeps the first two."""
        now_s = self._clock.now_s()
        word = "OFFLINE" if self.quirks.says_offline else "ONLINE"
        self._publish_json("connection", self.words.connection(word, now_s), retain=True)
        self.say_factsheet()
        self.say_state()

    def say_state(self) -> None:
        """Say how it is, now."""
        if not self._asked:
            return
        now_s = self._clock.now_s()
        self._spoken_s = now_s
        order = None if self.quirks.forgets_finished_order and self._is_idle else self.order
        body = self._body.sense()
        is_at_node = body.next_node == body.node
        self.condition.past_m = 0.0 if is_at_node else self._body.odometer().metres_m - self._passed_m
        said = self.words.state(body, order, self.condition, now_s)
        for _ in range(2 if self.quirks.doubles_states else 1):
            self._publish_json("state", said)

    def say_factsheet(self) -> None:
        """Publish its factsheet."""
        self._publish_json("factsheet", self.words.factsheet(self._kind, self._clock.now_s()), retain=True)

    def _publish_json(self, topic: str, said: dict[str, Any], *, retain: bool = False) -> None:
        if self._own_map is not None:
            said = self._own_map.told(said)
        self._publish(topic, json.dumps(said).encode(), retain)

    def _tick(self, life: int) -> None:
        """Speak from time to time, more often while it drives."""
        if life != self._life:
            return
        now_s, body = self._clock.now_s(), self._body.sense()
        is_moving = body.speed_mps > 0.0
        has_stopped, self._was_moving = self._was_moving and not is_moving, is_moving
        if has_stopped:
            self.say_state()
        if now_s - self._spoken_s >= (DRIVING_EVERY_S if is_moving else STATE_EVERY_S):
            if not (is_moving and self.quirks.tells_ends_only):
                self.say_state()
        if is_moving and self.quirks.no_pose_in_state:
            self._publish_json("visualization", self.words.visualization(body, now_s))
        self._clock.call_at(now_s + DRIVING_EVERY_S, partial(self._tick, life))

    # --- what happens to it ----------------------------------------------------------------------

    def restart(self) -> None:
        """Lose the power and come back: it stands where it is, and has forgotten its order."""
        self._life += 1
        self._body.power_off()
        self._body.power_on()
        self.order, self._action, self._way = None, None, []
        self.condition = Condition(last_node="" if self.quirks.no_last_node else self.condition.last_node)
        self.words.numbers = {}
        self.introduce()
        self._tick(self._life)

    # --- what is said to it ----------------------------------------------------------------------

    def on_message(self, topic: str, data: bytes) -> None:
        """An order or instant actions."""
        if self._ignored.get(topic, 0):
            self._ignored[topic] -= 1
            return
        said = reading.read_message(data)
        if self._own_map is not None and said:
            said = self._own_map.heard(topic, said) or {}
        if topic == "order" and said:
            self._on_order(reading.read_order(said))
        elif topic == "instantActions":
            for action in reading.read_actions(said):
                if all(action.id != known.id for known in self.condition.instant):
                    del self.condition.instant[: -INSTANT_KEPT + 1]
                    self.condition.instant.append(action)
                    self._on_instant(action)

    @property
    def _is_idle(self) -> bool:
        return self.order is None or self.order.is_over

    def _on_order(self, order: Order) -> None:
        now = self.order
        if self._is_refused_silently(order.id):
            return
        if now is not None and now.id == order.id:
            if order.update > now.update:
                self._on_update(now, order)
            return
        if not self._is_idle or self._clock.now_s() < self._ready_s:
            self._refuse(order, "OTHER_ORDER_ACTIVE", "another order is active")
        elif order.points[0].gap_m(self._body.sense().pose) > REACHABLE_M:
            self._refuse(order, "START_NODE_OUT_OF_RANGE", "the first node is out of range")
        else:
            self._accept(order)

    def _is_refused_silently(self, id_: str) -> bool:
        if not self.quirks.refuses_every_second or (self.order is not None and self.order.id == id_):
            return False
        if id_ not in self._refused_ids:
            self._accepted_ids += 1
            if self._accepted_ids % 2:
                self._refused_ids.add(id_)
        return id_ in self._refused_ids

    def _accept(self, order: Order) -> None:
        self._forget_errors()
        if self._doomed:
            self._doomed = False
            order.give_up()
        before = self.condition.last_node
        self.order = order
        first = order.points[0]
        order.reached = 0
        self.condition.last_node, self.condition.last_sequence = first.id, first.sequence
        self.say_state()
        # Its actions may wait for a node that never comes.
        waits = self.quirks.no_action_at_last_node and first.actions and before == first.id
        if not (waits and len(order.points) == 1):
            self._proceed()

    def _on_update(self, now: Order, update: Order) -> None:
        stitch, base_end = update.points[0], now.base_end
        last = now.points[base_end]
        if now.cancelled or (stitch.id, stitch.sequence) != (last.id, last.sequence):
            text = "the update does not begin with the last node of the base"
            self._refuse(update, "OUTDATED_ORDER_UPDATE", text, "orderUpdateError")
            return
        now.update = update.update
        if self.quirks.loses_updates:
            self.say_state()
            return
        kept = [edge for edge in now.edges if edge[1] < last.sequence]
        now.points = now.points[: base_end + 1] + update.points[1:]
        now.edges = kept + update.edges
        now.actions += [action for point in update.points[1:] for action in point.actions]
        self.say_state()
        self._proceed()

    def _refuse(self, order: Order, kind: str, text: str, old: str = "orderError") -> None:
        named = {"orderId": order.id, "orderUpdateId": str(order.update)}
        self.condition.errors.append((kind if self.words.version == "3.0" else old, "WARNING", text, named))
        self.say_state()

    def _lose_way(self, reason: str) -> None:
        """End the order: its way does not continue from where the vehicle stands."""
        order, self._way = self.order, []
        if order is None or order.is_over:
            return
        order.give_up()
        self._refuse(order, "NO_ROUTE_TO_TARGET", reason, "noRouteError")

    def _forget_errors(self) -> None:
        if not self.quirks.lingering_warnings:
            self.condition.errors = [error for error in self.condition.errors if error[1] != "WARNING"]

    # --- instant actions -------------------------------------------------------------------------

    def _on_instant(self, action: NodeAction) -> None:
        action.status = "FINISHED"
        match action.type:
            case "stateRequest":
                self._asked = True
            case "factsheetRequest":
                self.say_factsheet()
            case "startPause":
                if not self.quirks.ignores_pause:
                    self._body.instruct(Hold())
            case "stopPause":
                self._body.instruct(Unhold())
            case "stopCharging":
                node = self._body.sense().node
                self._instruct_drive((node,), 1, [])
            case "cancelOrder":
                self._on_cancel(action)
            case "clearInstantActions" if self.words.version == "3.0":
                ended = ("FINISHED", "FAILED")
                going = [one for one in self.condition.instant if one.status not in ended]
                self.condition.instant = [*going, action]
            case _:
                action.status, action.result = "FAILED", f"no instant action {action.type}"
        self.say_state()

    def _on_cancel(self, action: NodeAction) -> None:
        if self._is_idle and not self._body.sense().charging:
            self._doomed = self.quirks.idle_cancel_kills_next
            action.status = "FAILED"
            kind = "NO_ORDER_TO_CANCEL" if self.words.version == "3.0" else "noOrderToCancel"
            self.condition.errors.append((kind, "WARNING", "no order to cancel", {"actionId": action.id}))
            return
        action.status = "RUNNING"
        self._body.power_off()  # It stands at once and loses its order.
        self._body.power_on()
        self._action = None
        self._clock.call_at(self._clock.now_s() + self.quirks.cancel_s, partial(self._finish_cancel, action))

    def _finish_cancel(self, action: NodeAction) -> None:
        if self.order is not None:
            self.order.give_up()
        self._way = []
        action.status = "FINISHED"
        self.say_state()

    # --- driving and acting ----------------------------------------------------------------------

    def _proceed(self) -> None:
        """Do the next action, or drive on."""
        order = self.order
        if order is None or order.cancelled or self._action is not None:
            return
        here = order.points[order.reached]
        action = next((one for one in here.actions if one.status == "WAITING"), None)
        if action is not None:
            self._begin(action)
            return
        ahead = list(order.ahead)
        if len(ahead) < 2:
            self._finish_if_over()
            return
        body = self._body.sense()
        if body.next_node != order.points[order.reached].id:
            ahead = ahead[1:]  # It is on a lane, and finishes that first.
        if order.points[ahead[0]].id == order.points[order.reached].id and len(ahead) > 1:
            twin = order.points[ahead[1]].id == order.points[ahead[0]].id
            if twin:
                self._reach(ahead[1])
                self._proceed()
                return
        nodes, indexes = reading.over_corners(order, ahead, body.next_node, self._corners)
        self._instruct_drive(nodes, len(nodes), indexes)

    def _instruct_drive(self, nodes: tuple[str, ...], released: int, indexes: list[int]) -> None:
        self._drive += 1
        self._way = indexes
        self._body.instruct(Drive(order=self._drive, nodes=nodes, released=released))

    def _begin(self, action: NodeAction) -> None:
        self._drive += 1
        self._action, action.status = action, "RUNNING"
        instruction = reading.instruction_of(action, self._drive, self._charger_at(self._body.sense().node))
        if instruction is None:
            self._end_action("FAILED", f"no action {action.type}")
        else:
            self._body.instruct(instruction)
        if isinstance(instruction, Charge):
            self._clock.call_at(self._clock.now_s() + 0.5, partial(self._plugged, action))
        self.say_state()

    def _look_again(self, action: NodeAction | None) -> None:
        if action is not None and self._action is action:
            self._begin(action)

    def _plugged(self, action: NodeAction) -> None:
        if self._action is action and self._body.sense().charging:
            self._end_action("FINISHED", "")

    def _end_action(self, status: str, result: str) -> None:
        action, self._action = self._action, None
        if action is None:
            return
        action.status, action.result = status, result
        if status == "FINISHED":
            self.done.append(action.id)
        self._finish_if_over()
        self.say_state()
        self._proceed()

    def _reach(self, index: int) -> None:
        order = self.order
        if order is None or index <= order.reached:
            return
        order.reached = index
        self.condition.last_node = order.points[index].id
        self.condition.last_sequence = order.points[index].sequence

    def _finish_if_over(self) -> None:
        if self.order is not None and self.order.is_over:
            self._ready_s = self._clock.now_s() + self.quirks.busy_after_s

    def _on_report(self, report: Report) -> None:
        match report:
            case NodePassed(number, _, index) if number == self._drive and index < len(self._way):
                if self._way[index] >= 0:  # No corner.
                    self._passed_m = self._body.odometer().metres_m
                self._reach(self._way[index])
                if not self.quirks.tells_ends_only:
                    self.say_state()
            case WayDone(number) if number == self._drive and self._way:
                self._finish_if_over()
                self.say_state()
                self._proceed()
            case ActionDone(number) if number == self._drive:
                self._end_action("FINISHED", "")
            case ActionFailed(number, reason) if number == self._drive and self._action is None:
                self._lose_way(reason)
            case ActionFailed(number, reason) if number == self._drive:
                if reading.waits_for_person(self._action, reason):
                    self._clock.call_at(self._clock.now_s() + 1.0, partial(self._look_again, self._action))
                else:
                    self._end_action("FAILED", reason)
            case ProblemRaised(reason):
                self.condition.errors.append(("hardware", "FATAL", reason, {}))
                self.say_state()
            case ProblemCleared():
                self.condition.errors = [error for error in self.condition.errors if error[1] != "FATAL"]
                self.say_state()
