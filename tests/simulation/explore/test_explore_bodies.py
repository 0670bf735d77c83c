"""The search where machines, stores and the gate are controllers: wires are cut and counters reset, and every piece counts once."""

from __future__ import annotations

from itertools import pairwise

import pytest
from msgspec.structs import replace

from dray.adapters.signals.workcell import SignalledWorkcell
from dray.messages.keys import GATE
from dray_sim.explore.bodies import LONGEST_CUT_S
from dray_sim.explore.play import play
from dray_sim.explore.profile import PROFILES
from dray_sim.explore.run import FAULTS_UNTIL_S, draw

SEEDS = range(30)


def test_wires_of_all_kinds_are_cut_and_are_whole_again_by_the_quiet_phase() -> None:
    kinds = set()
    for seed in SEEDS:
        run = draw(seed, "bodies")
        assert run.wired
        for agent in {cut.agent for cut in run.cuts}:
            cuts = [cut for cut in run.cuts if cut.agent == agent]
            assert all(one.until_s <= other.at_s for one, other in pairwise(cuts))
            kinds.add("gate" if agent == GATE else "machine" if agent in run.plant.machines else "store")
        assert all(cut.until_s - cut.at_s <= LONGEST_CUT_S + 0.1 for cut in run.cuts)
        assert all(cut.until_s <= FAULTS_UNTIL_S for cut in run.cuts)
        assert len(run.timetable()) == len(run.schedule) + len(run.cuts)
    assert kinds == {"gate", "machine", "store"}
    assert any(cut.is_reset for seed in SEEDS for cut in draw(seed, "bodies").cuts)


def test_other_profiles_have_no_controllers() -> None:
    for profile in PROFILES:
        run = draw(7, profile)
        assert (run.wired, bool(run.cuts)) == (profile == "bodies", profile == "bodies")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_every_piece_is_counted_once_over_cut_wires_and_reset_counters(seed: int) -> None:
    outcome = play(draw(seed, "bodies", traffic=True))
    assert outcome.broken == ""
    assert outcome.transports > 0


@pytest.mark.slow
def test_the_search_finds_a_machine_that_forgets_its_counter_when_its_wire_is_cut(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lost = SignalledWorkcell.on_link_lost

    def forget(self: SignalledWorkcell, reason: str) -> None:
        lost(self, reason)
        self._kept = replace(self._kept, pieces=None)

    monkeypatch.setattr(SignalledWorkcell, "on_link_lost", forget)
    assert any(play(draw(seed, "bodies", traffic=True)).broken for seed in range(6))
