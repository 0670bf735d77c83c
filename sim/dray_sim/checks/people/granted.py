"""Invariant 9: a vehicle or a machine obeys a command only with a grant for the place where it is.

A check like those of `dray_sim.checks.invariants`: it hears everything, looks where they are, and takes no part. It
implements the area rule itself, without the protocol's code.
"""

from __future__ import annotations

from dray.messages import (
    AtvHeartbeat,
    CommandKind,
    Event,
    MachineCommand,
    Message,
    VehicleCommand,
    signed_words,
)
from dray.messages.fact import CommandObeyed
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

NODES_KEPT = 8
"""Nodes that are passed while no heartbeat gets through, at most."""

GIVEN_KEPT = 1000
"""Commands that are remembered: one that is obeyed was given within the last minute."""


class GrantedOnly:
    """Every command that was obeyed was granted, to that agent, for that place and for that time."""

    hears = (VehicleCommand, MachineCommand, AtvHeartbeat, Event)

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._given: dict[tuple[str, str], list[VehicleCommand | MachineCommand]] = {}
        """All commands under one name, by agent and name."""
        self._goods_at: dict[str, dict[str, None]] = {}
        """Last known position of its carrier, by task: the operators of that area decide about goods on board."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if type(message) is VehicleCommand or type(message) is MachineCommand:
            self._note(address.removeprefix(">"), message)
        elif type(message) is AtvHeartbeat:
            if message.task is not None:
                self._note_goods(message.task.task, message.node)
        elif type(message) is Event and type(message.fact) is CommandObeyed and message.fact.done:
            # An insider without a body stands nowhere.
            if sender in self._factory.vehicles or self._factory.plant.has_place(sender):
                self._check(sender, message.fact, at_s)

    def _note(self, agent: str, command: VehicleCommand | MachineCommand) -> None:
        self._given.setdefault((agent, command.command), []).append(command)
        if len(self._given) > GIVEN_KEPT:
            del self._given[next(iter(self._given))]

    def _check(self, agent: str, obeyed: CommandObeyed, at_s: float) -> None:
        given = self._given.get((agent, obeyed.command), [])
        if not any(self._allows(agent, command, at_s) for command in given):
            x_m, y_m = self._place_m(agent)
            where = f"at {x_m:.1f}, {y_m:.1f} m"
            seen = f"{agent} has obeyed {obeyed.what} ({obeyed.command}) {where} without a grant for that"
            raise InvariantBroken(9, at_s, seen)

    def _allows(self, agent: str, command: VehicleCommand | MachineCommand, at_s: float) -> bool:
        grant = command.grant
        if grant is None or at_s > grant.valid_until_s:
            return False
        if not self._factory.trusts(signed_words(agent, command, grant), grant.signature):
            return False
        margin_m = command.kind.margin_m if isinstance(command.kind, CommandKind) else 0.0
        places_m = [self._place_m(agent)]
        if isinstance(command, MachineCommand) and command.kind.is_about_goods:
            nodes = self._goods_at.get(command.task, {})
            spots = [self._factory.plant.nodes[node] for node in nodes if node in self._factory.plant.nodes]
            places_m = [(spot.x_m, spot.y_m) for spot in spots] or places_m
        near = {area for place in places_m for area in self._factory.plant.areas_near(*place, margin_m)}
        return grant.everywhere or not near.isdisjoint(grant.areas)

    def _note_goods(self, task: str, node: str) -> None:
        nodes = self._goods_at.pop(task, {})
        nodes.pop(node, None)
        # The newest word may not have reached their machine.
        self._goods_at[task] = dict.fromkeys((*list(nodes)[-NODES_KEPT:], node))
        if len(self._goods_at) > GIVEN_KEPT:
            del self._goods_at[next(iter(self._goods_at))]

    def _place_m(self, agent: str) -> tuple[float, float]:
        if agent not in self._factory.vehicles:
            return self._factory.plant.position_of(agent)
        pose = self._factory.vehicles[agent].sense().pose
        return pose.x_m, pose.y_m
