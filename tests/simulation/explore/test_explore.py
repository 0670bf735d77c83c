"""The search: what a seed stands for, how it is played, and how many are."""

from __future__ import annotations

import multiprocessing
import signal
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import msgspec
import pytest
from hash_seeds import printed_by_each

from dray.errors import UnavailableError
from dray.plant.file.check import faults as plant_faults
from dray.plant.file.check_levels import levels_of
from dray.priorities import Priority
from dray.protocol.strategist.strategist import Strategist
from dray_sim.checks.bounds import Bounds
from dray_sim.explore.outcome import Outcome
from dray_sim.explore.play import play, try_seed
from dray_sim.explore.profile import PROFILES
from dray_sim.explore.run import FAULTS_UNTIL_S, Run, draw
from dray_sim.explore.search import search

PRINT_TRACES = """
from dray_sim.explore.play import play
from dray_sim.explore.run import draw
print(*(play(draw(seed, profile), listen=True).trace for seed, profile in ((4, "all"), (1, "links"))))
"""

# --- runs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", PROFILES)
def test_a_seed_stands_for_one_run(profile: str) -> None:
    first, again, other = draw(7, profile), draw(7, profile), draw(8, profile)
    assert first == again
    assert first.plant != other.plant
    assert str(first) == str(again)
    assert first.timetable() == again.timetable()


def test_runs_have_plants_without_faults() -> None:
    for seed in range(20):
        assert list(plant_faults(draw(seed).plant.file)) == []


def test_runs_last_twenty_minutes_and_end_without_faults() -> None:
    for seed in range(20):
        run = draw(seed)
        assert run.duration_s >= 1200.0
        assert run.faults_until_s < run.duration_s
        assert all(timed.until_s is not None for timed in run.schedule)
        assert all((timed.until_s or 0.0) <= run.faults_until_s for timed in run.schedule)
        assert all(order.at_s <= run.faults_until_s for order in run.orders)


def test_runs_are_of_all_sorts() -> None:
    runs = [draw(seed) for seed in range(60)]
    assert {len(run.plant.fleet) for run in runs} == {1, 2, 3, 4, 5, 6}
    assert {run.habits is None for run in runs} == {True, False}
    assert {run.random_operator for run in runs} == {True, False}
    assert {run.codec for run in runs} == {True, False}
    assert {len(run.cancelled) > 0 for run in runs} == {True, False}
    assert {len(run.revocations) > 0 for run in runs} == {True, False}
    times = [revocations.times_s for run in runs for revocations in run.revocations]
    assert {len(each) for each in times} == {1, 2, 3}
    flat = [[moment for pair in each for moment in pair] for each in times]
    assert all(each == sorted(each) and each[-1] <= FAULTS_UNTIL_S for each in flat)
    assert len({type(timed.fault) for run in runs for timed in run.schedule}) >= 10


def test_runs_have_parts_bad_pieces_and_priorities() -> None:
    runs = [draw(seed) for seed in range(60)]
    assert {levels_of(run.plant.file) for run in runs} == {1, 2, 3}
    assert {run.has_scrap for run in runs} == {True, False}
    assert {order.priority for run in runs for order in run.orders} == set(Priority)
    assert {len(run.calls) > 0 for run in runs} == {True, False}
    for run in (draw(seed, "levels") for seed in range(60)):
        assert list(plant_faults(run.plant.file)) == []
        assert run.plant.parts
        used = {line.material for product in run.plant.products.values() for line in product.bill}
        assert set(run.plant.parts) <= used
        assert {part for part in run.plant.products if part not in run.plant.parts} == set(run.plant.ordered)


def has_stations(run: Run) -> bool:
    """Whether vehicles refill its storages, or machines fetch in the warehouse."""
    return any(warehouse.stocks for warehouse in run.plant.file.warehouses)


def test_whoever_draws_no_parts_draws_what_was_drawn_before_there_were_any() -> None:
    drawn = [draw(seed) for seed in range(60)]
    plain = [
        run
        for run in drawn
        if not run.plant.parts
        and not run.has_scrap
        and not has_stations(run)
        and all(order.priority is Priority.NORMAL for order in run.orders)
    ]
    assert len(plain) > 5
    assert all(replace(run, profile="one-level") == draw(run.seed, "one-level") for run in plain)


# --- playing ----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_run_is_played_the_same_in_every_process() -> None:
    here = [play(draw(seed, profile), listen=True).trace for seed, profile in ((4, "all"), (1, "links"))]
    assert {each.strip() for each in printed_by_each(PRINT_TRACES)} == {" ".join(here)}


@pytest.mark.slow
def test_listening_changes_nothing() -> None:
    quiet, heard = play(draw(5)), play(draw(5), listen=True)
    assert msgspec.structs.replace(heard, trace="") == quiet
    assert len(heard.trace) == 32


def test_an_error_in_a_run_is_an_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> list[object]:
        raise ZeroDivisionError("never mind")

    monkeypatch.setattr(Strategist, "handle", fail)
    outcome = try_seed(1)
    assert outcome.broken.startswith("invariant 8 is broken: ended by ZeroDivisionError('never mind')")
    assert "test_explore.py" in outcome.broken


def test_an_outcome_passes_as_data() -> None:
    outcome = play(draw(2))
    assert msgspec.json.decode(msgspec.json.encode(outcome), type=Outcome) == outcome
    assert outcome.replay == "dray sim explore --seed 2 --no-traffic"
    assert play(draw(0, "faultless")).replay == "dray sim explore --seed 0 --profile faultless --no-traffic"


def test_a_violation_is_told_with_what_came_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def bounds_of_no_time(_self: Bounds, _item: str, _done: int) -> float:
        return 1.0

    monkeypatch.setattr(Bounds, "task_s", bounds_of_no_time)
    outcome = next(found for found in map(try_seed, range(50)) if found.broken)
    assert "did not end in" in outcome.broken
    assert outcome.story
    assert outcome.trace
    task = outcome.broken.split(": ")[1].split()[0]
    assert any(task in line for line in outcome.story)


# --- many runs ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_processes_change_nothing_but_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 1)
    seeds: list[int] = []
    one = search(0, 3, profile="faultless")
    two = search(0, 3, profile="faultless", jobs=2, progress=lambda outcome: seeds.append(outcome.seed))
    assert seeds == list(range(3))
    assert one.runs == two.runs == 3
    assert (one.virtual_s, one.messages, one.transports) == (two.virtual_s, two.messages, two.transports)
    assert not one.interrupted
    assert one.rate > 0


@pytest.mark.parametrize(
    ("jobs", "how"),
    [
        (1, signal.SIGINT),
        pytest.param(2, signal.SIGTERM, marks=pytest.mark.slow),
        pytest.param(1, signal.SIGTERM, marks=pytest.mark.slow),
        pytest.param(2, signal.SIGINT, marks=pytest.mark.slow),
    ],
)
def test_a_search_that_is_stopped_tells_what_it_has_seen(
    jobs: int, how: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 2)

    def stop(outcome: Outcome) -> None:
        if outcome.seed == 1:
            signal.raise_signal(how)

    summary = search(0, 10_000, profile="faultless", jobs=jobs, progress=stop)
    assert summary.interrupted
    assert summary.runs == 2
    assert (summary.first, summary.last) == (0, 10_000)
    assert not multiprocessing.active_children()


@pytest.mark.slow
def test_a_second_ctrl_c_leaves_no_process_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    shutdown = ProcessPoolExecutor.shutdown

    def interrupted(pool: ProcessPoolExecutor, **how: bool) -> None:
        signal.raise_signal(signal.SIGINT)
        shutdown(pool, **how)

    monkeypatch.setattr(ProcessPoolExecutor, "shutdown", interrupted)
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 1)
    before = signal.getsignal(signal.SIGINT)
    summary = search(
        0, 10_000, profile="faultless", jobs=2, progress=lambda _outcome: signal.raise_signal(signal.SIGINT)
    )
    assert summary.interrupted
    assert not multiprocessing.active_children()
    assert signal.getsignal(signal.SIGINT) is before


def test_a_process_that_is_killed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray_sim.explore.search.CHUNK", 1)

    def kill(_outcome: Outcome) -> None:
        for child in multiprocessing.active_children():
            child.kill()

    with pytest.raises(UnavailableError, match=r"one of its processes was killed; .* fewer --jobs"):
        search(0, 10_000, profile="faultless", jobs=2, progress=kill)


@pytest.mark.slow
def test_violations_are_kept_for_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Bounds, "task_s", lambda *_: 1.0)
    summary = search(4, 7)
    assert summary.broken == len(summary.violations) > 0
    assert [found.seed for found in summary.violations] == sorted(found.seed for found in summary.violations)
