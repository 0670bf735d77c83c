"""The search is able to fail about people: with a safeguard of calls for help taken out, it finds a violation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from mutants import Find

from dray.messages import CallState
from dray.protocol.calls.help_calls import CALL, HelpCalls
from dray.protocol.transports.goods_recovery import GoodsRecovery
from dray_sim.explore.run import draw

Mutant = Callable[[pytest.MonkeyPatch], None]


def with_two_takers_of_one_turn(patch: pytest.MonkeyPatch) -> None:
    """Who takes a call after somebody else had it gets the same turn."""
    taken = HelpCalls._taken

    def take(self: HelpCalls, call: Any, sender: str, wait_s: float, now_s: float) -> None:
        call.turn = 0
        taken(self, call, sender, wait_s, now_s)

    patch.setattr(HelpCalls, "_taken", take)


def that_assigns(patch: pytest.MonkeyPatch) -> None:
    """Who is asked is expected, whether that one answers or not."""
    ask = HelpCalls._ask

    def assign(self: HelpCalls, call: Any, now_s: float) -> None:
        ask(self, call, now_s)
        if call.states.now is CallState.ASKING:
            self._taken(call, call.asked[0], 120.0, now_s)

    patch.setattr(HelpCalls, "_ask", assign)


def that_says_a_call_once(patch: pytest.MonkeyPatch) -> None:
    """A call that nobody has answered is not said again."""
    go_on = HelpCalls._go_on

    def say_once(self: HelpCalls, call: Any, now_s: float) -> None:
        go_on(self, call, now_s)
        if call.states.now is CallState.RESTING:
            self._life.cancel((CALL, call.goods))

    patch.setattr(HelpCalls, "_go_on", say_once)


def that_calls_nobody_for_goods(patch: pytest.MonkeyPatch) -> None:
    """A machine asks nobody to come for goods that a failed vehicle has on board."""
    patch.setattr(GoodsRecovery, "update_calls", lambda *_, **_kw: None)


MUTANTS = [
    pytest.param(with_two_takers_of_one_turn, "hands", 1, "invariant 17 .* was taken by", id="two-takers"),
    pytest.param(that_assigns, "hands", 0, "invariant 18 .* was assigned", id="assigned"),
    pytest.param(that_says_a_call_once, "hands", 12, "invariant 19 .* calls nobody", id="said-once"),
    pytest.param(that_calls_nobody_for_goods, "deaths", 0, "invariant 27 .* calls nobody", id="goods"),
]
"""A mutant, from where runs are drawn, the seed to begin with, and what will be seen."""


@pytest.mark.campaign
@pytest.mark.parametrize(("mutant", "profile", "first", "finding"), MUTANTS)
def test_the_search_finds_what_calls_for_help_guard_against(
    mutant: Mutant, profile: str, first: int, finding: str, find: Find
) -> None:
    find(mutant, lambda seed: draw(seed, profile), first, finding)
