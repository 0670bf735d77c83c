"""The vehicle's present order: sent until it is shown, followed to its end, retried after a refusal.

There is one order at a time. Its owner is told about passed nodes, once each and in order, and about the end.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot
from typing import Protocol

from dray.adapters.vda5050.control.instant import ASK_STATE, InstantActions
from dray.adapters.vda5050.control.order_state import ACTIVE, OrderState
from dray.adapters.vda5050.control.problems import remarks
from dray.adapters.vda5050.control.refusals import (
    CRITICAL,
    FATAL,
    critical,
    kept_refusal,
    refusal,
    unsupported,
)
from dray.adapters.vda5050.control.reported_node import ReportedNode
from dray.adapters.vda5050.control.spelling import STATUS
from dray.adapters.vda5050.control.undriven_orders import UndrivenOrders
from dray.adapters.vda5050.control.unwilling import Unwilling
from dray.adapters.vda5050.control.vehicle_order import Kind, Place, Stop, VehicleOrder
from dray.adapters.vda5050.control.view import NEVER_S, VehicleView
from dray.adapters.vda5050.events import Effect, Note, Say
from dray.adapters.vda5050.profile import Profile
from dray.adapters.vda5050.wire.messages import (
    FAILED,
    FINISHED,
    OVER,
    RETRIABLE,
    WAITING,
    State,
    VehicleError,
)
from dray.adapters.vda5050.wire.orders import Action, order_body

SETTLE_S = 3.0
"""Seconds in which a vehicle clears an order after its end; afterwards it counts as idle."""

CANCELLED_S = 10.0
"""Seconds without remaining work after which a vehicle's order has ended, whatever the status of cancelOrder."""

STALE_S = 30.0
"""Timeout of an absent master's order in a vehicle that stands and shows no action."""

STRANGERS = 2
"""Consecutive states with another order after which ours counts as forgotten: one may be a late old state."""

TRYING_S = 20.0
"""Maximum time of retries since the first offer: with a silent vehicle each attempt takes `silent_s`."""

FIRST_RETRY_S = 1.0
"""Delay of the first retry, for a vehicle that becomes idle soon; doubled each time."""

CANCEL = "cancelOrder"

REFUSED_SILENTLY = "the vehicle does not take the order, and does not say why"
FORGOTTEN = "the vehicle has forgotten the order: it was restarted, or has another master"
STOPPED_SHORT = "the vehicle has ended the order before its end"
CANCELLED = "cancelled"
VANISHED = "the action is not shown any more, and nobody saw its end"
NEVER_CAME = "an order of an earlier life has not come to the vehicle"


class Owner(Protocol):
    """The receiver of an order's events."""

    def on_passed(self, order: VehicleOrder, index: int, now_s: float) -> None:
        """A node of the base was passed."""

    def on_over(self, order: VehicleOrder, now_s: float) -> None:
        """An order is `OrderState.DONE` or `ENDED`; another one may be offered."""


class Orders:
    """The orders of one vehicle.

    Args:
        agent: its id; all ids of orders begin with it.
        life: the agent's life, which makes ids unique.
        profile: the vehicle's profile.
        view: the vehicle's messages.
        instant: its instant actions.
        out: receives the effects.
        owner: receives the order's events.
        remember: called before an order is sent under a new id or updated, to store it for the next life.

    Attributes:
        present: the order that is not over; None for none.
        cancelled: number of orders ended by our cancellation.
        unwilling: whether the vehicle takes no orders at all.
        undriven: whether it takes orders, and does not drive.
    """

    def __init__(
        self,
        agent: str,
        life: int,
        profile: Profile,
        view: VehicleView,
        instant: InstantActions,
        out: list[Effect],
        owner: Owner,
        remember: Callable[[], None],
    ) -> None:
        self._prefix = f"{agent}-{life}-"
        self._profile, self._view, self._remember = profile, view, remember
        self._instant, self._out, self._owner = instant, out, owner
        self._number = 0
        self.present: VehicleOrder | None = None
        self.cancelled = 0
        self.unwilling = Unwilling()
        self.undriven = UndrivenOrders()
        self._reported_node = ReportedNode(view, profile)
        self._over_s = NEVER_S
        self._without: frozenset[str] = frozenset()
        """Optional fields that the vehicle does not support, and that its profile allows to leave out."""
        self._has_noted = False
        """Whether a stale last node was logged."""
        self._still_s: float | None = None
        """Since when the vehicle stands and shows none of our actions that is not over."""

    # --- what is wanted --------------------------------------------------------------------------

    def is_ready(self, now_s: float) -> bool:
        """Whether the vehicle would accept a new order."""
        if self.present is not None and self.present.now is not OrderState.REFUSED:
            return False
        view = self._view
        if view.is_idle:
            return True
        if view.is_driving or self._still_s is None:
            return False
        # Some never clear their states: then standing still counts.
        return now_s - self._still_s >= (STALE_S if view.is_foreign else SETTLE_S)

    def hindrance(self, now_s: float) -> str:
        """Why the vehicle takes no other order, in words; empty for no reason, or while it has one."""
        order, view = self.present, self._view
        is_due = order is None or (order.now is OrderState.REFUSED and now_s >= order.retry_s)
        if not is_due or self.is_ready(now_s):
            return ""
        whose = f" an order of somebody else: {view.state.order_id}" if view.is_foreign else ""
        if view.is_driving:
            return f"it says that it drives{whose}"
        for action in view.acting:
            name = action.action_type or action.action_id
            return f"its action {name} is {action.action_status}, of{whose or ' an earlier order'}"
        return f"it shows{whose or ' nodes of an order that is over'}"

    @property
    def overlong(self) -> str:
        """The overdue order or action in words; empty for none."""
        order = self.present
        if order is None or order.action is None or order.acts_since_s is None:
            return ""
        if order.kind is Kind.CHARGE or order.by_hand_s is not None or order.now not in ACTIVE:
            return ""
        bound_s = self._profile.acting_s
        if self._view.heard_s - order.acts_since_s < bound_s:
            return ""
        why = self._why_it_acts(order.action)
        name = order.action.type
        return (
            f"its action {name} has not ended for {bound_s:.0f} s: {why}"
            if why
            else f"its action {name} has not ended for {bound_s:.0f} s"
        )

    def _why_it_acts(self, action: Action) -> str:
        """What the vehicle reports about an action that does not end; empty for nothing."""
        shown = self._view.state.action(action.id)
        status = shown.action_status if shown is not None else None
        odd = f"its status is {status}" if status and status not in STATUS.words else ""
        said = remarks(self._view.state)
        if odd and said:
            return f"{odd}; it reports: {said}"
        return odd or (f"it reports: {said}" if said else "")

    def offer(self, order: VehicleOrder, now_s: float) -> None:
        """Send a new order; `present` is None or over."""
        self.present, order.begun_s = order, now_s
        self._offer(order, now_s)

    def recognise(self, order: VehicleOrder, now_s: float) -> None:
        """Continue an earlier life's order: it runs, or it is sent again; one to drive is only waited for."""
        self.present, order.begun_s, order.offered_s = order, now_s, now_s
        if order.is_earlier:
            order.old_errors = frozenset(
                e.key for e in self._view.state.errors or () if not e.names(order.id)
            )

    def extend(
        self,
        stops: list[Stop],
        places: list[Place],
        speeds_mps: list[float | None],
        beyond: list[Stop],
        now_s: float,
    ) -> None:
        """Release more of the present order, or change its horizon: an update that begins with the last node of the base."""
        order = self.present
        if order is None or order.now is not OrderState.RUNNING:
            return
        order.states.enter(OrderState.EXTENDING)
        order.sent_base, order.from_node = len(order.stops), order.end
        order.update += 1
        del order.speeds_mps[len(order.stops) :]
        order.stops += stops
        order.places += places
        order.speeds_mps += speeds_mps
        order.beyond = beyond
        order.offered_s = now_s
        errors = self._view.state.errors or ()
        order.old_errors |= {error.key for error in errors if error.error_level not in (FATAL, CRITICAL)}
        self._remember()
        self._say(order, now_s)

    def cancel(self, now_s: float) -> None:
        """End the present order; if the vehicle does not show it yet, cancel it later."""
        order = self.present
        if order is None:
            return
        order.is_unwanted = True
        if order.now in ACTIVE:
            self._begin_cancel(order, now_s)
        elif order.now is OrderState.REFUSED:
            self._end(order, OrderState.ENDED, CANCELLED, now_s)

    def fail(self, error: VehicleError, now_s: float) -> None:
        """End the present order by an error: the vehicle waits for the cancellation."""
        order = self.present
        if order is not None and order.now in ACTIVE:
            order.reason, order.ended_by = error.text, error
            self._begin_cancel(order, now_s)

    @property
    def running(self) -> VehicleOrder | None:
        """The present order, if the vehicle has it and it is not being cancelled."""
        order = self.present
        return order if order is not None and order.now in ACTIVE else None

    # --- what the vehicle says -------------------------------------------------------------------

    def on_state(self, now_s: float) -> None:
        """Update the order from a new state."""
        state, order = self._view.state, self.present
        if self._view.is_driving or (self._view.acting and not self._view.is_foreign):
            self._still_s = None
        elif self._still_s is None:
            self._still_s = now_s
        if order is None:
            return
        is_shown = order.is_shown(state)
        if is_shown and state.order_id in order.ids:
            order.id = state.order_id or order.id
        match order.now:
            case OrderState.OFFERED | OrderState.REFUSED if is_shown:
                order.states.enter(OrderState.RUNNING)
                self.unwilling.accepted()
                order.reason = ""  # The reason was an earlier refusal.
                order.has_horizon = bool(order.beyond)
                self._follow(order, state, now_s)
                if order.is_unwanted and order.now in ACTIVE:
                    self._begin_cancel(order, now_s)
            case OrderState.OFFERED if (error := refusal(order, state)) is not None:
                order.refused_with = error.text
                self._leave_out(error)
                self._refuse(order, error.text, now_s)
            case OrderState.RUNNING | OrderState.EXTENDING if is_shown:
                order.strangers = 0
                self._follow(order, state, now_s)
            case OrderState.RUNNING | OrderState.EXTENDING:
                self._wonder(order, state, now_s)
            case OrderState.CANCELLING:
                self._pass_to(order, state, now_s)

    def tick(self, now_s: float) -> None:
        """Repeat, give up, or check waiting actions, by time."""
        order = self.present
        if order is None:
            return
        match order.now:
            case OrderState.OFFERED | OrderState.EXTENDING:
                self._insist(order, now_s)
            case OrderState.REFUSED if now_s >= order.retry_s and self.is_ready(now_s):
                if not self._is_hindered(order, now_s):
                    order.states.enter(OrderState.OFFERED)
                    self._offer(order, now_s)
            case OrderState.CANCELLING:
                self._watch_cancel(order, now_s)
        if order.now in ACTIVE:
            self._heed(order, now_s)
        if order.now in ACTIVE and order.is_shown(self._view.state):
            self._judge(order, self._view.state, now_s)

    def _heed(self, order: VehicleOrder, now_s: float) -> None:
        """Treat an order as refused, if the vehicle shows it, complains of it and stands."""
        error = refusal(order, self._view.state)
        if error is None or error.error_level not in (FATAL, CRITICAL) or self._view.is_moving:
            return
        if now_s - max(order.offered_s, self._view.stirred_s) >= SETTLE_S:
            self.fail(error, now_s)

    # --- an order that is offered ----------------------------------------------------------------

    def _offer(self, order: VehicleOrder, now_s: float) -> None:
        """Send the order under a new id: a refused id may not be reused."""
        self._number += 1
        order.id = f"{self._prefix}{self._number}"
        order.ids.append(order.id)
        if order.action is not None:
            action = order.action
            order.action = Action(f"{order.id}-a", action.type, action.blocking, action.parameters)
        order.old_errors = frozenset(error.key for error in self._view.state.errors or ())
        order.acts_since_s = None
        order.offered_s, order.waits_since_s, order.quiet_since_s, order.strangers = now_s, None, None, 0
        self._remember()
        self._say(order, now_s)

    def _say(self, order: VehicleOrder, now_s: float) -> None:
        order.said_s = now_s
        self._out.append(
            Say(
                "order",
                order_body(
                    order.message(),
                    self._profile.dialect,
                    self._view.names,
                    trajectory=self._profile.trajectory,
                    without=self._without,
                ),
            )
        )

    def _insist(self, order: VehicleOrder, now_s: float) -> None:
        """Repeat an order until it is shown; one not shown in time counts as silently refused."""
        if order.is_earlier:
            if not self.may_come(order, now_s):
                self._end(order, OrderState.ENDED, NEVER_CAME, now_s)
        elif not self._is_unseen(order, now_s):
            if now_s - order.said_s >= self._profile.resend_s:
                self._say(order, now_s)
        elif order.now is OrderState.OFFERED:
            kept = kept_refusal(self._view.state)
            self._refuse(order, order.refused_with or (kept.text if kept else REFUSED_SILENTLY), now_s)
        else:
            self._take_back_update(order)

    def may_come(self, order: VehicleOrder, now_s: float) -> bool:
        """Whether an earlier life's order or update may still come to the vehicle.

        The vehicle has sent states for a while without it, and shows an action that was sent later, or shows none at all: then it has got
        all that was sent before, or never will.
        """
        if not order.is_earlier or order.is_shown_whole(self._view.state):
            return False
        is_answered = self._instant.status(ASK_STATE) != "" or self._instant.is_given_up(ASK_STATE)
        return not (is_answered and self._is_unseen(order, now_s))

    def _is_unseen(self, order: VehicleOrder, now_s: float) -> bool:
        """Whether the vehicle has sent states long enough after the order, and does not show it."""
        silent_s = self._profile.silent_s
        return now_s - order.offered_s >= silent_s and self._view.heard_s >= order.offered_s + silent_s / 2.0

    def _refuse(self, order: VehicleOrder, reason: str, now_s: float) -> None:
        order.reason = reason
        order.states.enter(OrderState.REFUSED)
        if order.is_earlier:
            self._end(order, OrderState.ENDED, reason, now_s)
            return
        is_over = len(order.ids) >= self._profile.tries or now_s - order.begun_s >= TRYING_S
        if order.is_unwanted or is_over:
            if not order.is_unwanted:
                self.unwilling.refused("" if reason == REFUSED_SILENTLY else reason, now_s)
            self._end(order, OrderState.ENDED, reason, now_s)
        else:
            order.retry_s = now_s + FIRST_RETRY_S * 2.0 ** (len(order.ids) - 1)

    def _leave_out(self, error: VehicleError) -> None:
        """Leave out unsupported fields from now on, where the profile allows that."""
        names = unsupported(error) & frozenset(self._profile.leave_out) - self._without
        if names:
            self._without |= names
            self._out.append(Note(f"left out of orders, since the vehicle says: {error.text}"))

    def _is_hindered(self, order: VehicleOrder, now_s: float) -> bool:
        """Whether the horizon of an earlier life's order blocks this one; that order is cancelled first."""
        view, instant = self._view, self._instant
        if view.is_idle or not view.shows_ours or order.reason == REFUSED_SILENTLY:
            instant.forget(CANCEL)
            return False
        if not instant.is_open(CANCEL):
            instant.say(CANCEL, now_s)
        if instant.status(CANCEL) not in OVER and not instant.is_given_up(CANCEL):
            return True
        instant.forget(CANCEL)
        return False

    # --- an order that runs ----------------------------------------------------------------------

    def _follow(self, order: VehicleOrder, state: State, now_s: float) -> None:
        if order.now is OrderState.EXTENDING:
            if state.order_id == order.id and (state.order_update_id or 0) >= order.update:
                order.states.enter(OrderState.RUNNING)
                order.sent_base, order.has_horizon = len(order.stops), bool(order.beyond)
            elif refusal(order, state) is not None:
                self._take_back_update(order)
        self._pass_to(order, state, now_s)
        self._judge(order, state, now_s)

    def _take_back_update(self, order: VehicleOrder) -> None:
        """Drop a refused update: the vehicle drives to the end of its base, and the rest goes into another order."""
        order.states.enter(OrderState.RUNNING)
        last = max(order.sent_base, order.passed + 1)
        del order.stops[last:], order.places[last:], order.speeds_mps[last:]
        order.beyond, order.takes_updates = [], False

    def _pass_to(self, order: VehicleOrder, state: State, now_s: float) -> None:
        """Tell the owner every passed node, including those that no state has shown."""
        if state.order_id not in order.ids:
            return
        reached = order.place_in(state)
        while order.passed < reached and self._has_reached(order, order.passed + 1, reached):
            order.passed += 1
            self.undriven.driven()
            self._owner.on_passed(order, order.passed, now_s)

    def _has_reached(self, order: VehicleOrder, index: int, reported: int) -> bool:
        """Whether its position allows that it has passed a node, if it reports this one, or a later one, as its last node."""
        spots = [spot for _, spot in order.stops]
        gap_m = self._reported_node.gap_m(spots, order.passed, index)
        order.contradiction = ""
        if gap_m > 0.0:
            node = order.nodes[reported]
            gap_m = self._reported_node.gap_m(spots, order.passed, reported) or gap_m
            order.contradiction = f"it says that its last node is {node}, and is {gap_m:.1f} m before it"
            self._view.doubts.note("a last node ahead of its position", order.contradiction)
        return not order.contradiction

    def _judge(self, order: VehicleOrder, state: State, now_s: float) -> None:
        """Detect the end of the order."""
        if order.action is not None:
            self._judge_action(order, order.action, state, now_s)
        elif order.passed == order.end and not self._view.is_driving:
            if order.has_horizon and not order.beyond:
                self._begin_cancel(
                    order, now_s
                )  # It waits for its horizon, which is not wanted any more, and takes no update.
            elif not order.beyond:
                self._end(order, OrderState.DONE, "", now_s)
        elif self._is_quiet(order, now_s) and not self.may_come(order, now_s):
            # Shown, never begun, and complained of: a late refusal.
            order.ended_by = critical(state, self._profile)
            error = (refusal(order, state) if not order.passed else None) or order.ended_by
            if error is None and self._stands_at_end(order):
                said = state.last_node_id or "nothing"
                self._note_once(
                    f"it stands at {order.nodes[-1]} and has no nodes left, and says that its last node is {said}"
                )
                self._pass_all(order, now_s)
                self._end(order, OrderState.DONE, "", now_s)
                return
            self._end(order, OrderState.ENDED, STOPPED_SHORT if error is None else error.text, now_s)

    def _judge_action(self, order: VehicleOrder, action: Action, state: State, now_s: float) -> None:
        shown = state.action(action.id)
        status = shown.action_status if shown is not None else ""
        order.waits_since_s = (order.waits_since_s or now_s) if status == WAITING else None
        order.acts_since_s = now_s if order.acts_since_s is None else order.acts_since_s
        if status == FINISHED:
            self._end(order, OrderState.DONE, "", now_s)
        elif status == FAILED and shown is not None:
            reason = next((error.text for error in state.errors or () if error.names(action.id)), "")
            self._end(
                order,
                OrderState.ENDED,
                shown.result or reason or "the vehicle says no more than FAILED",
                now_s,
            )
        elif status == RETRIABLE:
            order.reason = shown.result if shown is not None else ""
            self._begin_cancel(order, now_s)
        elif overdue := order.overdue(now_s, self._profile.waiting_s):
            order.reason = overdue
            self._begin_cancel(order, now_s)
        elif not status and self._is_quiet(order, now_s):
            self._end(order, OrderState.ENDED, VANISHED, now_s)

    def _pass_all(self, order: VehicleOrder, now_s: float) -> None:
        while order.passed < order.end:
            order.passed += 1
            self._owner.on_passed(order, order.passed, now_s)

    def _stands_at_end(self, order: VehicleOrder) -> bool:
        """Whether its pose is at the order's last node: the pose prevails over a stale `lastNodeId`."""
        pose, spot = self._view.pose, order.stops[-1][1]
        if pose is None or not self._view.is_on_map:
            return False
        frame = self._view.names.frame(spot.map_id)
        if frame is None or spot.map_id != self._view.map_id:
            return False
        x, y = frame.to_map(pose.x_m, pose.y_m)
        return hypot(x - spot.x, y - spot.y) * frame.scale <= self._profile.node_m

    def _note_once(self, text: str) -> None:
        if not self._has_noted:
            self._has_noted = True
            self._out.append(Note(text))

    def _is_quiet(self, order: VehicleOrder, now_s: float) -> bool:
        """Whether the vehicle has had no remaining work for a while, though the order is not done."""
        order.quiet_since_s = (order.quiet_since_s or now_s) if self._view.is_idle else None
        return order.quiet_since_s is not None and now_s - order.quiet_since_s >= SETTLE_S

    def _wonder(self, order: VehicleOrder, state: State, now_s: float) -> None:
        """The vehicle shows another order than ours, or none."""
        at_end = order.kind is Kind.STEP and state.last_node_id == order.nodes[-1]
        if (
            at_end
            and not state.order_id
            and self._view.is_idle
            and self._view.doubtful_s is None
            and self._has_reached(order, order.end, order.end)
        ):
            # It has reached the end, and clears its order at once.
            self._pass_all(order, now_s)
            self._end(order, OrderState.DONE, "", now_s)
            return
        order.strangers += 1
        if order.strangers >= STRANGERS:
            self._end(order, OrderState.ENDED, FORGOTTEN, now_s)
        else:
            self._instant.say(ASK_STATE, now_s)

    # --- an order that is cancelled --------------------------------------------------------------

    def _begin_cancel(self, order: VehicleOrder, now_s: float) -> None:
        order.states.enter(OrderState.CANCELLING)
        self._instant.say(CANCEL, now_s)

    def _watch_cancel(self, order: VehicleOrder, now_s: float) -> None:
        """End the order when cancelOrder is FINISHED, or when nothing is left to cancel; not when it is only shown."""
        state, status = self._view.state, self._instant.status(CANCEL)
        given_up = self._instant.is_given_up(CANCEL)
        self._is_quiet(order, now_s)
        quiet_s = order.quiet_since_s
        seen = quiet_s is not None and now_s - quiet_s >= CANCELLED_S
        over = status == FINISHED or seen or ((status == FAILED or given_up) and self._view.is_idle)
        forgotten = bool(state.order_id) and not order.is_shown(state)
        if not over and not forgotten:
            return
        shown = state.action(order.action.id) if order.action is not None else None
        if shown is not None and shown.action_status not in (FINISHED, FAILED):
            if not self._view.is_idle and shown.action_status != WAITING:
                return  # An action that cannot be cancelled ends first.
        done = shown is not None and shown.action_status == FINISHED
        self._instant.forget(CANCEL)
        self.cancelled += over and not done
        self._end(order, OrderState.DONE if done else OrderState.ENDED, order.reason or CANCELLED, now_s)

    @property
    def does_not_cancel(self) -> bool:
        """Whether the vehicle continues an order after the maximum of cancellations."""
        order = self.present
        return order is not None and order.now is OrderState.CANCELLING and self._instant.is_given_up(CANCEL)

    def _end(self, order: VehicleOrder, state: OrderState, reason: str, now_s: float) -> None:
        if state is OrderState.ENDED and self._is_undriven(order, reason):
            self.undriven.ended(order.contradiction or reason, now_s)
        order.states.enter(state)
        order.reason = "" if state is OrderState.DONE else reason
        if self.present is order:
            self.present = None
        self._over_s = now_s
        self._owner.on_over(order, now_s)

    def _is_undriven(self, order: VehicleOrder, reason: str) -> bool:
        """Whether it has taken an order to drive that ends where it began, and not by our wish."""
        was_taken = order.now not in (OrderState.OFFERED, OrderState.REFUSED)
        has_moved = order.passed > 0 or self._view.stirred_s > order.offered_s
        return order.kind is Kind.STEP and was_taken and not has_moved and reason != CANCELLED
