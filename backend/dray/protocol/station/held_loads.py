"""People at a station: calls for disputed loads and for things on board of failed vehicles, and people's decisions.

A station has no other commands; if its body is people, it passes on their reports (`PassedWords`). It follows
operators on duty from its first call on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from dray.body import StorageState
from dray.memory import CommandMemory
from dray.messages import CommandRefusal, Grant, MachineCommand, MachineCommandKind, Message, PeopleAsBody
from dray.messages.heartbeat import LOADS_TOLD
from dray.plant import Plant
from dray.protocol.calls.help_calls import HelpCalls, PlaceCaller
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.people.granted_commands import GrantedCommands
from dray.protocol.people.words import PassedWords
from dray.protocol.runtime.life import Life
from dray.protocol.transports.goods_recovery import GoodsRecovery
from dray.protocol.transports.held import HeldTransports

ONLY_LOADS = "a station takes a person's word about loads alone"
"""Explanation of a refusal, for people."""


class HeldLoads:
    """The held loads of one station.

    Args:
        plant: its areas and places.
        held: its held transports.
        aboard: things for it on board of failed vehicles.
        authority: checks who may command it.

    Attributes:
        message_handlers, alarms: entries for the agent's tables.
        people: the loads that wait for people's reports, if people are its body; else None.
        words: people's reports on their way to the body.
    """

    def __init__(
        self,
        plant: Plant,
        held: HeldTransports,
        aboard: GoodsRecovery,
        authority: CommandAuthorisation,
        life: Life,
    ) -> None:
        self._held, self._aboard = held, aboard
        self._place_m = plant.position_of(life.agent)
        self._granted = GrantedCommands[MachineCommand](authority, self._try, _detail, life)
        self.words = PassedWords(self._granted, life)
        self.people: PeopleAsBody | None = None
        self._calls = HelpCalls(PlaceCaller(plant, life), plant, life)
        self._listens = False
        self.message_handlers: dict[type[Message], Callable[[str, Any, float], None]] = {
            **self._calls.message_handlers
        }
        self.alarms = self._calls.alarms

    @property
    def answered(self) -> tuple[CommandMemory, ...]:
        """Commands for the next life, which would obey them if they were repeated."""
        return self._granted.answered

    def restore(self, answered: Iterable[CommandMemory]) -> None:
        """Restore an earlier life's commands."""
        self._granted.restore(answered)

    def on_command(self, sender: str, command: MachineCommand, now_s: float) -> None:
        """Handle a person's command; see `GrantedCommands.on_command`."""
        if command.kind.is_word and self.people is not None:
            self.words.pass_on(sender, command, (self._place_m,), now_s)
            return
        load = self._aboard if command.kind.is_about_goods else self._held
        self._granted.on_command(sender, command, load.place_m(command.task) or self._place_m, now_s)

    def sense(self, body: StorageState) -> bool:
        """Note the loads that wait for people's reports; returns whether that has changed."""
        people = PeopleAsBody(loads=body.loads[:LOADS_TOLD]) if body.people else None
        is_news, self.people = people != self.people, people
        return is_news

    def update_calls(self, now_s: float, *, expected: bool) -> None:
        """Open and close the calls for loads to look for, or to hand over.

        Args:
            now_s: the present time.
            expected: False for a station that leaves: its next life calls.
        """
        if expected and not self._listens and (self._held.names() or self._aboard.names(now_s)):
            self._listens = True
            self._calls.listen()
        self._aboard.update_calls(self._calls, now_s, expected=expected)

    def _try(self, command: MachineCommand, _grant: Grant, now_s: float) -> CommandRefusal | None:
        if command.kind is MachineCommandKind.FETCH_GOODS:
            return self._aboard.fetch(command.task, command.node, now_s)
        if command.kind is MachineCommandKind.WRITE_OFF:
            return self._aboard.write_off(command.task, now_s)
        if not command.kind.is_about_held:
            return CommandRefusal.NOT_SUPPORTED
        return self._held.obey(command, now_s)


def _detail(_command: MachineCommand, refused: CommandRefusal) -> str:
    return ONLY_LOADS if refused is CommandRefusal.NOT_SUPPORTED else ""
