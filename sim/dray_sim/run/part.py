"""A part of a scenario: one run, as it is played in virtual time (`dray sim run`) and in the panels (`dray up --scenario`)."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Generic, TypeVar, cast

from dray.plant import Plant
from dray.scenario_steps import ScenarioStep
from dray_sim.run.evidence import HELD, Check
from dray_sim.run.stage import Played, Shift, Stage, play

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Part(Generic[T]):
    """The plant, the load, the script and the judgement of a part.

    Attributes:
        name: as in `dray up --scenario NAME`.
        shift: how long and how busy.
        plant: makes the plant that it is played in.
        script: acts on the factory.
        steps: that it tells of, in the order in which they are expected.
        judge: checks the script's result.
    """

    name: str
    shift: Shift
    plant: Callable[[], Plant]
    script: Callable[[Stage], Awaitable[T]]
    steps: tuple[ScenarioStep, ...]
    judge: Callable[[T], tuple[Check, ...]]

    def play(self, seed: int) -> Played[T]:
        """Play it in virtual time."""
        return play(self.shift, self.plant(), seed, self.script, self.steps)

    def checks(self, played: Played[T]) -> tuple[Check, ...]:
        """The checks of its run; none where a broken invariant has cut it short."""
        if played.result is None and played.invariants != HELD:
            return ()
        return self.judge(cast(T, played.result))
