"""The steps of a run: which its script has declared, and which have happened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dray.messages import Event, Message
from dray.scenario_steps import ScenarioStep


@dataclass(frozen=True, slots=True)
class Happened:
    """The event of a step.

    Attributes:
        at_s: when (plant clock).
        agents: concerned by it.
    """

    at_s: float
    agents: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Expected:
    step: ScenarioStep
    kind: type[Any]
    where: Callable[[Any], bool]
    by: tuple[str, ...]
    about: Callable[[Any], str] | None


class Steps:
    """A `Listener` that knows the progress of a script.

    A script reports its own actions, and names the messages that show the other steps.

    Undeclared steps are ignored: a script may be part of a run without spectators.

    Args:
        declared: in the order in which they are expected.
        now_s: the plant's clock.

    Attributes:
        declared: as given.
        happened: those that have happened, in their order.
        on_change: called when one has happened.
    """

    def __init__(self, declared: tuple[ScenarioStep, ...], now_s: Callable[[], float]) -> None:
        self.declared, self._now_s = declared, now_s
        self.happened: dict[ScenarioStep, Happened] = {}
        self.on_change: Callable[[], None] = lambda: None
        self._expected: list[_Expected] = []

    def tell(self, step: ScenarioStep, *agents: str) -> None:
        """Note a step; a repetition changes nothing.

        Args:
            step: that has happened.
            agents: concerned by it.
        """
        if step in self.declared and step not in self.happened:
            self.happened[step] = Happened(self._now_s(), tuple(agent for agent in agents if agent))
            self.on_change()

    def expect(
        self,
        step: ScenarioStep,
        kind: type[Any],
        where: Callable[[Any], bool] = lambda _said: True,
        *,
        by: tuple[str, ...] = (),
        about: Callable[[Any], str] | None = None,
    ) -> None:
        """Let a message or fact mark a step.

        Args:
            step: to be marked.
            kind: class of a fact or a message.
            where: selects messages.
            by: its possible senders; empty for all.
            about: names the agent concerned, from the message; None for the sender.
        """
        if step in self.declared:
            self._expected.append(_Expected(step, kind, where, by, about))

    def on_message(self, _at_s: float, sender: str, _address: str, message: Message) -> None:
        """Note one utterance."""
        if not self._expected:
            return
        said = message.fact if type(message) is Event else message
        for each in [one for one in self._expected if type(said) is one.kind]:
            if (not each.by or sender in each.by) and each.where(said):
                self._expected.remove(each)
                self.tell(each.step, sender if each.about is None else each.about(said))
