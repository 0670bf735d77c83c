"""Right of way in lean worlds with everything that can go wrong, and the proof that the checks see what is wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from variants import variants

from dray.messages.floor.traffic import PlaceRequested, PlaceReservation
from dray.plant import Plant
from dray.protocol.traffic.driving import evidence, yielding
from dray.protocol.traffic.places import Footprint, Places
from dray.protocol.traffic.reservations.copies import Copies
from dray.protocol.traffic.reservations.reservation_table import ReservationTable
from dray_sim.bench.traffic import plants
from dray_sim.bench.traffic.air import Quality
from dray_sim.bench.traffic.checks import Found, overlap
from dray_sim.bench.traffic.drawn import drawn
from dray_sim.bench.traffic.faults import draw_faults
from dray_sim.bench.traffic.run import FIRST_COME, Setting, World, build, finish, run_boxes, run_ghosts

CALM_S = 300.0
"""At the end of a run nothing is wrong any more."""

STAND_S = 120.0
"""Nobody stands longer though a way exists."""

GOOD = Quality()
POOR = Quality(0.2, loss_frac=0.2, double_frac=0.1, wire_loss_frac=0.1)
SLOW = Quality(1.0, loss_frac=0.05, double_frac=0.1, wire_loss_frac=0.05)

FLOORS: dict[str, Callable[[], Plant]] = {
    "default": lambda: plants.default_with(8),
    "bridge": plants.bridge,
    "corridor": plants.corridor,
}


def stands_s(world: World, from_s: float) -> float:
    """How long any vehicle stood with somewhere to go, after a moment."""
    until_s = world.setting.span_s
    spans = [span for carrier in world.carriers for span in carrier.stands]
    spans += [(c.stood_since_s, until_s) for c in world.carriers if c.stood_since_s is not None]
    return max((end_s - max(begin_s, from_s) for begin_s, end_s in spans if end_s > from_s), default=0.0)


def played(floor: str, seed: int, quality: Quality, *, gap_s: float = 0.0, span_s: float = 900.0) -> World:
    """A world that has run, with a fault every `gap_s`."""
    world = build(Setting(FLOORS[floor](), seed, span_s, quality=quality))
    if gap_s:
        draw_faults(world, seed, gap_s=gap_s, until_s=span_s - CALM_S)
    world.clock.run(span_s)
    return world


@pytest.mark.parametrize("floor", variants(FLOORS, "default", "corridor"))
@pytest.mark.parametrize("quality", variants([GOOD, POOR, SLOW]), ids=["good", "poor", "slow"])
def test_nobody_overlaps_and_nobody_is_stuck(floor: str, quality: Quality) -> None:
    world = played(floor, 1, quality)
    assert world.checks.found == Found()
    assert stands_s(world, 0.0) < STAND_S
    assert finish(world).per_h > 20.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [292, 969, 111, *(pytest.param(s, marks=pytest.mark.slow) for s in (572, 825, 930, 901))]
)
def test_nobody_is_stuck_where_chance_has_put_roads(seed: int) -> None:
    """Two who had to make room in turn did so for ever, or waited for one who could have driven on, and was asked to let them past;
    room was made again and again where it did not suffice; one waited for all that had begun before it."""
    world = build(Setting(drawn(seed), seed, 900.0))
    world.clock.run(900.0)
    assert world.checks.found == Found()
    assert stands_s(world, 0.0) < STAND_S


@pytest.mark.parametrize("floor", variants(FLOORS))
@pytest.mark.parametrize("seed", variants([0, 1]))
def test_faults_make_nobody_overlap_and_traffic_goes_on_after_them(floor: str, seed: int) -> None:
    world = played(floor, seed, POOR, gap_s=10.0, span_s=1200.0)
    assert world.checks.found == Found()
    assert stands_s(world, 1200.0 - CALM_S + 60.0) < STAND_S


def test_a_vehicle_that_dies_on_a_lane_keeps_its_places_and_others_go_round_it() -> None:
    world = build(Setting(FLOORS["default"](), 3, 900.0))
    pilot = world.pilots["ATV3"]
    world.clock.call_at(200.0, pilot.die)
    world.clock.call_at(600.0, pilot.revive)
    world.clock.run(590.0)
    assert pilot.right_of_way.way.held
    world.clock.run(900.0)
    assert world.checks.found == Found()
    assert finish(world).per_h > 150.0


@pytest.mark.slow
def test_every_machine_dies_once_and_no_place_is_held_twice() -> None:
    world = build(Setting(FLOORS["default"](), 4, 900.0, quality=POOR))
    for number, machine in enumerate(world.machines.values()):
        world.clock.call_at(30.0 + 45.0 * number, machine.die)
        world.clock.call_at(60.0 + 45.0 * number, machine.revive)
    world.clock.run(900.0)
    assert world.checks.found == Found()
    assert stands_s(world, 0.0) < STAND_S


def test_a_table_that_all_replicas_have_lost_is_made_of_what_the_vehicles_hold() -> None:
    world = build(Setting(FLOORS["bridge"](), 5, 600.0))
    world.clock.run(100.0)
    for machine in world.machines.values():
        machine.die()
    world.clock.run(101.0)
    for machine in world.machines.values():
        machine.revive(forget=True)
    world.clock.run(600.0)
    assert world.checks.found == Found()
    assert any(done_s > 200.0 for carrier in world.carriers for done_s, _ in carrier.done)


def test_the_same_seed_gives_the_same_run() -> None:
    one, other = (run_boxes(Setting(FLOORS["corridor"](), 7, 300.0, quality=POOR)) for _ in range(2))
    assert one == other


@pytest.mark.slow
def test_ghosts_carry_more_and_first_come_is_stuck() -> None:
    setting = Setting(FLOORS["default"](), 1, 900.0)
    ghosts, ours, first = run_ghosts(setting), run_boxes(setting), run_boxes(setting, rules=FIRST_COME)
    assert first.per_h < 0.5 * ours.per_h < 0.5 * ghosts.per_h
    assert first.stuck


# --- the checks see what is wrong -----------------------------------------------------------------


def faults_of(floor: str, seeds: Sequence[int], quality: Quality, gap_s: float) -> Found:
    """What the checks find in the first of some runs in which it finds anything."""
    for seed in seeds:
        found = played(floor, seed, quality, gap_s=gap_s, span_s=CALM_S + 500.0).checks.found
        if found.faults:
            return found
    return Found()


def test_a_grant_without_the_table_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def write(self: ReservationTable, line: PlaceReservation) -> None:
        before = self._lines.get(line.place)
        if before is not None:
            del self._by_atv[before.atv][line.place]
        self._lines[line.place] = line
        self._by_atv.setdefault(line.atv, {})[line.place] = line

    monkeypatch.setattr(ReservationTable, "holder", lambda self, place: "")
    monkeypatch.setattr(ReservationTable, "_write", write)
    found = faults_of("default", range(2), GOOD, 0.0)
    assert found.double_holds
    assert found.overlaps


@pytest.mark.slow
def test_a_grant_that_no_majority_has_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    # Else the witness refuses nearly all of them.
    monkeypatch.setattr(evidence, "WITNESS_ASKED", -1)
    monkeypatch.setattr(Copies, "majority", property(lambda self: 1))
    assert faults_of("bridge", range(12), POOR, 8.0).double_holds


@pytest.mark.slow
def test_a_release_that_is_believed_too_early_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def strike(self: ReservationTable, request: PlaceRequested, atv: str) -> bool:
        gone = [line.place for line in self.of(atv) if line.place not in request.holds]
        self._rub_out(atv, gone)
        return bool(gone)

    monkeypatch.setattr(ReservationTable, "strike", strike)
    assert faults_of("default", range(6), SLOW, 0.0).double_holds


def test_a_group_that_is_taken_in_halves_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Places, "group_end", lambda self, nodes, first: first)
    assert faults_of("default", range(2), GOOD, 0.0).in_entries


def test_an_inherited_rank_that_never_lapses_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(yielding, "LAPSE_S", 1e9)
    assert faults_of("corridor", range(6), GOOD, 0.0).outdated


@pytest.mark.parametrize(
    ("other", "touches"),
    [
        ((0.7, 0.0, 0.0), True),
        ((0.9, 0.0, 0.0), False),
        ((0.75, 0.0, 1.57), False),
        ((0.65, 0.0, 1.57), True),
    ],
)
def test_rectangles_overlap_when_they_have_a_point_in_common(
    other: tuple[float, float, float], *, touches: bool
) -> None:
    assert overlap((0.0, 0.0, 0.0), other, Footprint()) == touches
