"""The search finds bodies that forget what their controllers have counted; see `test_mutants`."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from mutants import Find, Mutant, searches

from dray.adapters.signals.gate import KeptSignals, SignalledGate
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


def with_a_gate_that_counts_early(patch: pytest.MonkeyPatch) -> None:
    """What a permit may bring in counts as soon as the permit is given, before the controller has counted it."""
    keep = SignalledGate._keep

    def count(self: SignalledGate, kept: KeptSignals) -> None:
        permit, known = kept.permit, self._kept
        goal = kept.goals.get(permit)
        is_new = permit != known.permit or kept.left > known.left
        if goal is not None and is_new and kept.left:
            more = kept.left - (known.left if permit == known.permit else 0)
            keep(self, self._with(kept, permit, replace(goal, arrived=goal.arrived + more)))
            self._say(permit)
            return
        if goal is not None and permit == known.permit and kept.left < known.left:
            kept = self._with(kept, permit, replace(goal, arrived=known.goals[permit].arrived))
        keep(self, kept)

    patch.setattr(SignalledGate, "_keep", count)


def with_a_gate_that_confirms_early(patch: pytest.MonkeyPatch) -> None:
    """That no more pieces come in than are admitted is confirmed while a permit may still bring in more."""
    patch.setattr(SignalledGate, "_is_exceeded", lambda _self, _name: False)


MUTANTS = [
    pytest.param(with_machines_that_forget_their_counter, 0, id="machine-forgets"),
    pytest.param(with_a_gate_that_forgets_its_counter, 0, id="gate-forgets"),
    pytest.param(with_machines_that_are_sure_of_their_product, 0, id="unconfirmed"),
    pytest.param(with_a_gate_that_counts_early, 0, id="gate-counts-early"),
    pytest.param(with_a_gate_that_confirms_early, 4, id="gate-confirms-early"),
]


QUICK = ("machine-forgets", "gate-forgets", "gate-counts-early", "gate-confirms-early")


@pytest.mark.parametrize(("mutant", "first"), searches(MUTANTS, *QUICK))
def test_the_search_finds_a_mutant_of_a_body(mutant: Mutant, first: int, find: Find) -> None:
    find(mutant, lambda seed: draw(seed, "bodies", traffic=True), first, "invariant [1246]")
