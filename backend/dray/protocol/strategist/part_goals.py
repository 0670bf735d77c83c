"""Goals of parts, which other machines use: they end when their pieces are made, and no customer gets these."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from msgspec import UNSET

from dray.messages import AtvHeartbeat, GoalBrief, MachineHeartbeat, Message, StationHeartbeat
from dray.messages.fact import GoalWithdrawn
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.strategist.goal_auctions import GoalAuctions
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import OpenGoal, OrderBook, OrderInWork
from dray.protocol.strategist.part_leads import PartLeads
from dray.protocol.strategist.part_planning import PLAN_EVERY_S, PartPlanner
from dray.protocol.strategist.part_stock import PartStock

PLAN = "plan"
"""Alarm of the check for missing parts."""


class PartGoals:
    """The part goals of one strategist.

    Args:
        plant: its parts; without parts there are no subscriptions.
        keys: the plant's bus keys.
        book: all goals.
        auctions: those of the goals.
        machines: the machines and their products.
        life: the agent's life; alarms are named `PLAN`.
        shutdown: of the strategist: while it drains it gives nothing out.
        alone: whether there is no other strategist, whose orders may take what these do not need.

    Attributes:
        message_handlers, alarms: entries for the strategist's tables.
    """

    def __init__(
        self,
        plant: Plant,
        keys: Keys,
        book: OrderBook,
        auctions: GoalAuctions,
        machines: MachineMonitor,
        life: Life,
        shutdown: GracefulShutdown,
        *,
        alone: bool,
    ) -> None:
        self._plant, self._keys, self._book = plant, keys, book
        self._auctions, self._life, self._shutdown = auctions, life, shutdown
        self._alone = alone
        self._leads = PartLeads(machines, plant.working_time)
        self._stock = PartStock(plant)
        self._planner = PartPlanner(plant, book, self._stock, self._leads)
        self.message_handlers: dict[type[Message], Callable[..., None]] = {
            StationHeartbeat: self._stock.on_station,
            AtvHeartbeat: self._stock.on_vehicle,
        }
        self.alarms: dict[str, Callable[[Any, float], None]] = {PLAN: self._plan}

    def start(self, now_s: float) -> None:
        """Follow the stock of all agents, and start planning."""
        if self._plant.parts:
            self._life.subscribe(self._keys.all_station_heartbeats)
            self._life.subscribe(self._keys.all_atv_heartbeats)
            self._life.alarm(PLAN, now_s + PLAN_EVERY_S)

    def excuse(self, span_s: float) -> None:
        """The strategist was deaf for this long."""
        self._stock.excuse(span_s)

    def on_machine(self, heartbeat: MachineHeartbeat, now_s: float) -> None:
        """Note a machine's stock."""
        if self._plant.parts:
            self._stock.on_machine(heartbeat, now_s)

    def on_brief(self, goal: OpenGoal, brief: GoalBrief, now_s: float) -> bool:
        """Note a machine's progress with a goal; returns whether all pieces of a part goal are made."""
        goal.to_begin = brief.quantity - brief.made if brief.to_begin is UNSET else brief.to_begin
        if not goal.work.part_of or brief.made <= goal.arrived:
            return False
        self._book.count(goal, brief.made)
        is_made = goal.arrived >= goal.work.quantity
        if is_made:
            self._leads.note(goal, now_s)
        return is_made

    def lose(self, goal: OpenGoal) -> None:
        """End a part goal whose machine has failed or that is unneeded. Made pieces stay; the rest is planned anew."""
        self._auctions.close_goal(goal, "withdrawn")
        self._book.close(goal)
        if goal.machine:
            self._life.record(GoalWithdrawn(goal.id, goal.machine, 0, self._book.held_with(goal.work.order)))

    def withdraw(self, order: OrderInWork) -> None:
        """End the part goals of an order."""
        for goal in order.goals_of_parts:
            self.lose(goal)

    def _plan(self, _about: None, now_s: float) -> None:
        self._life.alarm(PLAN, now_s + PLAN_EVERY_S)
        if self._shutdown.begun:
            return
        plan = self._planner.plan(now_s)
        for goal in plan.unneeded if self._alone else ():
            self.lose(goal)
        # An auction may also have ended with its order, while another goal of the part waited for it.
        for part in self._plant.parts:
            self._auctions.ask_next(part, now_s)
