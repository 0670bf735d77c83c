"""Invariant 9: a vehicle obeys a command only with a grant for the place where it is.

A check like those of `dray_sim.checks.invariants`: it hears everything, looks where the vehicles are, and takes
no part. It knows the area rule by itself and asks nobody of the protocol.
"""

from __future__ import annotations

from dray.messages import Event, Message, VehicleCommand, signed_words
from dray.messages.fact import CommandObeyed
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

GIVEN_KEPT = 1000
"""Commands that are remembered: one that is obeyed was given within the last minute."""


class GrantedOnly:
    """Every command that was obeyed was granted, to that vehicle, for that place and for that time."""

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._given: dict[tuple[str, str], list[VehicleCommand]] = {}
        """By the vehicle and the name of the command: everything that was said under it."""

    def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
        if type(message) is VehicleCommand:
            self._note(address.removeprefix(">"), message)
        elif type(message) is Event and type(message.fact) is CommandObeyed and message.fact.done:
            self._check(sender, message.fact, at_s)

    def _note(self, atv: str, command: VehicleCommand) -> None:
        self._given.setdefault((atv, command.command), []).append(command)
        if len(self._given) > GIVEN_KEPT:
            del self._given[next(iter(self._given))]

    def _check(self, atv: str, obeyed: CommandObeyed, at_s: float) -> None:
        given = self._given.get((atv, obeyed.command), [])
        if not any(self._allows(atv, command, at_s) for command in given):
            pose = self._factory.vehicles[atv].sense().pose
            where = f"at {pose.x_m:.1f}, {pose.y_m:.1f} m"
            seen = f"{atv} has obeyed {obeyed.what} ({obeyed.command}) {where} without a grant for that"
            raise InvariantBroken(9, at_s, seen)

    def _allows(self, atv: str, command: VehicleCommand, at_s: float) -> bool:
        grant = command.grant
        if grant is None or at_s > grant.valid_until_s:
            return False
        if not self._factory.trusts(signed_words(atv, command, grant), grant.signature):
            return False
        pose = self._factory.vehicles[atv].sense().pose
        near = self._factory.plant.areas_near(pose.x_m, pose.y_m, command.kind.margin_m)
        return grant.everywhere or any(area in grant.areas for area in near)
