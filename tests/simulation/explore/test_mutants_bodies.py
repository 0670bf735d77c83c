"""The search finds bodies that forget what their controllers have counted; see `test_mutants`."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from mutants import Find, Mutant, searches

from dray.adapters.signals.gate import SignalledGate
from dray.adapters.signals.workcell import SignalledWorkcell
from dray_sim.explore.run import draw


def with_machines_that_forget_their_counter(patch: pytest.MonkeyPatch) -> None:
    """What a machine's controller counts while its wire is cut is counted by nobody."""
    lost = SignalledWorkcell.on_link_lost

    def forget(self: SignalledWorkcell, reason: str) -> None:
        lost(self, reason)
        self._kept = replace(self._kept, pieces=None)

    patch.setattr(SignalledWorkcell, "on_link_lost", forget)


def with_a_gate_that_forgets_its_counter(patch: pytest.MonkeyPatch) -> None:
    """What comes in while the gate's wire is cut is counted by nobody."""
    lost = SignalledGate.on_link_lost

    def forget(self: SignalledGate, reason: str) -> None:
        lost(self, reason)
        self._kept = replace(self._kept, pieces=None)

    patch.setattr(SignalledGate, "on_link_lost", forget)


def with_machines_that_are_sure_of_their_product(patch: pytest.MonkeyPatch) -> None:
    """A machine takes what it has asked for for what is made, whether its controller has heard that or not."""
    patch.setattr(SignalledWorkcell, "_hold_unconfirmed", lambda _self: False)


MUTANTS = [
    pytest.param(with_machines_that_forget_their_counter, 0, id="machine-forgets"),
    pytest.param(with_a_gate_that_forgets_its_counter, 0, id="gate-forgets"),
    pytest.param(with_machines_that_are_sure_of_their_product, 0, id="unconfirmed"),
]


@pytest.mark.parametrize(("mutant", "first"), searches(MUTANTS, "machine-forgets", "gate-forgets"))
def test_the_search_finds_a_mutant_of_a_body(mutant: Mutant, first: int, find: Find) -> None:
    find(mutant, lambda seed: draw(seed, "bodies", traffic=True), first, "invariant [1246]")
