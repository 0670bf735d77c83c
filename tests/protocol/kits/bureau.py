"""Orders for a strategist, and machines that take its goals, for tests."""

from __future__ import annotations

from defaults import PLANT
from effects import award_number, published, remember, sent
from rigs import StrategistRig
from spoken import accepted, goal_bid, mhb

from dray.messages import (
    Award,
    GoalBrief,
    OrderItem,
    OrderReleased,
    Production,
    TaskAnnounced,
)
from dray.protocol.runtime.events import Effect


def order(name: str = "O1", due_s: float = 7200.0, **quantities: int) -> OrderReleased:
    """An order; products by their short names."""
    full = {"g1": "gear-unit-g1", "g2": "gear-unit-g2", "pump": "pump-p3", "motor": "motor-e4"}
    items = tuple(OrderItem(product=full[short], quantity=each) for short, each in quantities.items())
    return OrderReleased(order=name, items=items, due_s=due_s)


def released(message: OrderReleased, **options: object) -> StrategistRig:
    """A strategist that has just been given an order."""
    rig = StrategistRig(**options)
    rig.start()
    rig.on_message("gateway", message)
    return rig


def announced(effects: list[Effect]) -> list[tuple[str, str, int]]:
    """The goals that were announced for the first time: name, product, quantity."""
    return [
        (message.task, message.work.product, message.work.quantity)
        for message in published(effects, TaskAnnounced)
        if message.round == 1 and isinstance(message.work, Production)
    ]


def contract(rig: StrategistRig, goal: str, machine: str, cost_s: float = 100.0) -> list[Effect]:
    """One machine bids alone for a goal that is announced now, and takes it."""
    [epoch] = [message.epoch for message in published(rig.all, TaskAnnounced) if message.task == goal][-1:]
    effects = rig.on_message(machine, goal_bid(goal, cost_s, epoch=epoch))
    while not sent(effects, Award, to=machine):
        effects += rig.run(rig.agent.wake_at_s)
    number = award_number(effects, machine, goal)
    return effects + rig.on_message(machine, accepted(goal, epoch=epoch, number=number))


def contract_all(rig: StrategistRig) -> dict[str, tuple[str, int]]:
    """Machines take every goal; goal -> machine and quantity."""
    taken: dict[str, tuple[str, int]] = {}
    waiting = announced(rig.all)
    while waiting:
        goal, product, quantity = waiting.pop(0)
        machines = PLANT.machines_for(product)
        machine = machines[len(taken) % len(machines)]
        taken[goal] = (machine, quantity)
        waiting += announced(contract(rig, goal, machine))
    return taken


def done(goal: str, quantity: int, delivered: int | None = None, product: str = "pump-p3") -> GoalBrief:
    """A machine's word that a goal is made, and how much of it is delivered."""
    there = quantity if delivered is None else delivered
    return GoalBrief(goal=goal, product=product, quantity=quantity, made=quantity, delivered=there)


def beats(
    rig: StrategistRig, until_s: float, *machines: str, goals: tuple[GoalBrief, ...] = ()
) -> list[Effect]:
    """These machines say that they are well, once a second; the first one names the goals."""
    effects: list[Effect] = []
    while rig.now_s < until_s:
        effects += rig.run(min(until_s, rig.now_s + 1.0))
        for machine in machines:
            named = goals if machine == machines[0] else ()
            effects += rig.on_message(machine, mhb(machine, *named, seq=round(rig.now_s * 10)))
    return effects


def making(quantity: int = 24) -> tuple[StrategistRig, str]:
    """M7 makes the only goal of an order of pumps; M8 and M9 could make it, too."""
    rig = released(order(pump=quantity))
    [(goal, _, _)] = announced(rig.all)
    contract(rig, goal, "M7")
    return rig, goal


def brief(goal: str, made: int = 5, delivered: int = 0, quantity: int = 24) -> GoalBrief:
    return GoalBrief(goal=goal, product="pump-p3", quantity=quantity, made=made, delivered=delivered)


def reborn(rig: StrategistRig, incarnation: int = 2, **options: object) -> StrategistRig:
    """The strategist is started again, with its gate as it is and what it had written down."""
    again = StrategistRig(memory=remember(rig.memory, rig.all), incarnation=incarnation, **options)
    again.arrived, again.now_s = rig.arrived, rig.now_s
    again.start()
    return again
