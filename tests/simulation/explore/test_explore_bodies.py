"""The search where machines, stores and the gate are controllers: wires are cut, counters reset and memories damaged, and every piece counts once."""

from __future__ import annotations

from itertools import pairwise

import pytest

from dray.messages.keys import GATE
from dray_sim.controllers.wired import Moment
from dray_sim.explore.bodies import LONGEST_CUT_S, WAITS_S
from dray_sim.explore.play import play
from dray_sim.explore.profile import PROFILES
from dray_sim.explore.run import FAULTS_UNTIL_S, draw
from dray_sim.faults import JournalLost

SEEDS = (*range(30), 14433)
"""The last one drew counters that are reset at the moment in which their wire is whole again."""


def test_wires_of_all_kinds_are_cut_and_are_whole_again_by_the_quiet_phase() -> None:
    kinds = set()
    for seed in SEEDS:
        run = draw(seed, "bodies")
        assert run.wired
        for agent in {cut.agent for cut in run.cuts}:
            cuts = [cut for cut in run.cuts if cut.agent == agent]
            assert all(one.until_s < other.at_s for one, other in pairwise(cuts))
            kinds.add("gate" if agent == GATE else "machine" if agent in run.plant.machines else "store")
        for cut in run.cuts:
            assert cut.until_s - cut.at_s <= LONGEST_CUT_S + 0.1 + (WAITS_S if cut.moment else 0.0)
        assert all(cut.until_s <= FAULTS_UNTIL_S for cut in run.cuts)
        assert len(run.timetable()) == len(run.schedule) + len(run.cuts) + len(run.damages)
    assert kinds == {"gate", "machine", "store"}
    assert any(cut.is_reset for seed in SEEDS for cut in draw(seed, "bodies").cuts)


def test_some_wires_break_at_the_worst_moment_and_some_machines_begin_one_more_piece() -> None:
    cuts = [(cut, run) for run in (draw(seed, "bodies") for seed in SEEDS) for cut in run.cuts]
    for moment, agents in (
        (Moment.PERMIT, {GATE}),
        (Moment.PIECE, {machine for _, run in cuts for machine in run.plant.machines}),
    ):
        drawn = {cut.agent for cut, _ in cuts if cut.moment is moment}
        assert drawn
        assert drawn <= agents
    more = [(cut, run) for cut, run in cuts if cut.more]
    assert more
    assert all(cut.agent in run.plant.machines and not cut.is_reset for cut, run in more)


def test_some_memories_are_damaged_some_journals_lost_and_some_orders_cancelled() -> None:
    runs = [draw(seed, "bodies") for seed in SEEDS]
    damaged = [(damage, run) for run in runs for damage in run.damages]
    assert {
        "gate" if each.agent == GATE else "machine" if each.agent in run.plant.machines else "store"
        for each, run in damaged
    } == {"gate", "machine", "store"}
    assert all(damage.until_s < FAULTS_UNTIL_S for damage, _ in damaged)
    for run in runs:
        assert len({damage.agent for damage in run.damages}) == len(run.damages)
    assert any(not run.damages for run in runs)
    assert any(run.cancelled for run in runs)
    assert any(isinstance(timed.fault, JournalLost) for run in runs for timed in run.schedule)


def test_other_profiles_have_no_controllers() -> None:
    for profile in PROFILES:
        run = draw(7, profile)
        assert run.wired is (profile == "bodies")
        assert run.wired or not (run.cuts or run.damages)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_every_piece_is_counted_once_over_cut_wires_and_reset_counters(seed: int) -> None:
    outcome = play(draw(seed, "bodies", traffic=True))
    assert outcome.broken == ""
    assert outcome.transports > 0
