"""The table of `dray bench traffic`: all schemes with the same seeds, each figure beside ghosts, the planner and its aim."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from statistics import fmean

from dray.errors import SettingsError
from dray.plant import Plant
from dray_sim.bench.row import Row
from dray_sim.bench.traffic import plants
from dray_sim.bench.traffic.air import Quality
from dray_sim.bench.traffic.central import run_central
from dray_sim.bench.traffic.drawn import drawn
from dray_sim.bench.traffic.run import (
    FIRST_COME,
    WHOLE,
    Figures,
    Rules,
    Setting,
    World,
    run_boxes,
    run_ghosts,
)

SPAN_S, QUICK_SPAN_S = 1800.0, 300.0
SEEDS, QUICK_SEEDS = range(3), range(1)

STAND_S = 120.0
"""Longest stand of any vehicle though a way exists."""

DIES_AT_S, DEAD_S = 300.0, 400.0

PLANTS: dict[str, Callable[[], Plant]] = {
    "single-track-8": lambda: plants.default_with(8),
    "single-track-12": lambda: plants.default_with(12),
    "two-lanes-12": lambda: plants.default_with(12, two_lanes=True),
    "bridge": plants.bridge,
    "corridor": plants.corridor,
    "generated-50": plants.generated,
    "generated-50-two-lanes": lambda: plants.generated(two_lanes=True),
    "generated-200": lambda: plants.generated(200, 80),
    "generated-200-two-lanes": lambda: plants.generated(200, 80, two_lanes=True),
    "kiva-50": lambda: plants.kiva(50),
    "kiva-100": lambda: plants.kiva(100),
}
"""Floors by name; single track, where the name does not say otherwise."""

DRAWN = "drawn"
"""Instead of one floor: one for each seed. It is not among `PLANTS`, and runs only when it is asked for."""

DRAWN_SPAN_S = 900.0

DRAWN_SEEDS, QUICK_DRAWN_SEEDS = range(1000), range(20)

OF_GHOSTS = {
    "single-track-8": 0.75,
    "single-track-12": 0.68,
    "two-lanes-12": 0.85,
    "bridge": 0.33,
    "corridor": 0.65,
    "generated-50": 0.35,
    "generated-50-two-lanes": 0.65,
    "kiva-50": 0.55,
    "kiva-100": 0.40,
}
"""Saturated throughput that is wanted, as a part of that of ghosts."""

OF_PLANNER = 1.0
"""Least throughput, as a part of the central planner's."""

MESSAGES = {"kiva-50": 2.6, "kiva-100": 2.6}
MOST_MESSAGES = 1.3
"""Most messages to and from vehicles, per vehicle and second, when saturated."""

POISSON = {
    "single-track-8": (110.0, 1.15, 1.25),
    "two-lanes-12": (110.0, 1.05, 1.10),
    "generated-50": (183.0, 1.20, 1.30),
    "generated-50-two-lanes": (183.0, 1.05, 1.10),
}
"""Transports an hour at an ordinary load, and the most that p50 and p95 of a transport may be, as multiples of the
ghosts'."""

NETWORKS = {
    (latency_s, loss_frac): Quality(latency_s, loss_frac, double_frac=0.1 if loss_frac else 0.0)
    for latency_s in (0.02, 0.2, 1.0)
    for loss_frac in (0.0, 0.05, 0.2)
}

OF_GOOD = {(0.2, 0.2): 0.90, (1.0, 0.0): 0.80, (1.0, 0.2): 0.65}
"""Throughput that is wanted on a poor network, as a part of that on a good one."""

ABLATIONS = {
    "without yielding": Rules(yields=False),
    "without refusal": Rules(refuses=False),
    "without dock groups": Rules(groups=False),
    "without prices": Rules(prices=False),
    "without rerouting": Rules(reroutes=False),
}

SPANS_S = {"generated-200": 600.0, "generated-200-two-lanes": 600.0}
"""Spans of runs that would take an hour of the computer; all others use `SPAN_S`."""

LARGE = frozenset(name for name in PLANTS if name.startswith(("generated", "kiva")))
"""Floors whose runs take minutes: many vehicles tell as much with fewer seeds."""


@dataclass(frozen=True, slots=True)
class Case:
    """One run.

    Attributes:
        plant: name of the floor.
        scheme: ghosts, planner, first come, ours, or one of the ablations.
        what: load, network or fault, in words.
    """

    plant: str
    seed: int
    span_s: float
    scheme: str = "ours"
    what: str = "saturated"
    per_h: float = 0.0
    quality: Quality = Quality()  # noqa: RUF009

    def play(self) -> Figures:
        """Let it run."""
        plant = drawn(self.seed) if self.plant == DRAWN else PLANTS[self.plant]()
        setting = Setting(plant, self.seed, self.span_s, self.per_h, self.quality)
        if self.scheme == "ghosts":
            return run_ghosts(setting)
        if self.scheme == "planner":
            return run_central(setting)
        if self.scheme == "first come":
            return run_boxes(setting, rules=FIRST_COME)
        prepare = {"one dies": _one_dies, "machines die": _machines_die}.get(self.what)
        return run_boxes(setting, prepare, rules=ABLATIONS.get(self.scheme, WHOLE))


def _one_dies(world: World) -> None:
    """A vehicle is switched off on a lane, and on again after a while."""
    pilot = world.pilots[sorted(world.pilots)[world.setting.seed % len(world.pilots)]]

    def die() -> None:
        if pilot.right_of_way.stands:
            world.clock.call_at(world.clock.now_s + 0.5, die)
            return
        pilot.die()
        world.clock.call_at(world.clock.now_s + DEAD_S, pilot.revive)

    world.clock.call_at(min(DIES_AT_S, world.setting.span_s / 4.0), die)


def _machines_die(world: World) -> None:
    """Every machine dies once, one after another."""
    each_s = world.setting.span_s / (len(world.machines) + 1.0)
    for number, machine in enumerate(world.machines.values()):
        world.clock.call_at(each_s * (number + 0.5), machine.die)
        world.clock.call_at(each_s * (number + 1.0), machine.revive)


def measure(quick: bool, plant: str = "", seeds: Sequence[int] | None = None) -> list[Row]:
    """Run all schemes.

    Args:
        quick: one seed and five minutes each, on the small floors.
        plant: this floor only; empty for all.
        seeds: these instead of the usual ones.

    Raises:
        SettingsError: there is no such floor.
    """
    if plant == DRAWN:
        return _drawn_rows(seeds or (QUICK_DRAWN_SEEDS if quick else DRAWN_SEEDS))
    if plant and plant not in PLANTS:
        known = ", ".join((*PLANTS, DRAWN))
        raise SettingsError("plant", f"there is no floor {plant!r}; there are {known}")
    names = [plant] if plant else [name for name in PLANTS if not quick or name not in LARGE]
    chosen = tuple(seeds) if seeds is not None else tuple(QUICK_SEEDS if quick else SEEDS)
    span_s = QUICK_SPAN_S if quick else SPAN_S
    return list(_rows(names, _played(_cases(names, chosen, span_s, all_seeds=seeds is not None))))


def _played(cases: Iterable[Case]) -> dict[Case, Figures]:
    """All of them, on all processors; those that take longest first."""
    once = sorted(dict.fromkeys(cases), key=_effort, reverse=True)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max_workers=os.cpu_count(), mp_context=context) as pool:
        return dict(zip(once, pool.map(Case.play, once), strict=True))


def _effort(case: Case) -> float:
    """Rough effort of a run."""
    vehicles = 1.0 if case.plant == DRAWN else float(len(PLANTS[case.plant]().fleet))
    plans = {"ghosts": 0.1, "planner": 2.0}.get(case.scheme, 1.0)
    return vehicles**2 * case.span_s * plans


def _drawn_rows(seeds: Sequence[int]) -> list[Row]:
    """Rows for right of way on random roads; failures are named by their seeds."""
    runs = {
        case.seed: run for case, run in _played(Case(DRAWN, each, DRAWN_SPAN_S) for each in seeds).items()
    }
    stuck = [seed for seed, run in runs.items() if run.stuck]
    waited = [seed for seed, run in runs.items() if run.longest_s > STAND_S]
    faulty = [seed for seed, run in runs.items() if run.found.faults]

    def row(what: str, found: list[int]) -> Row:
        told = f"seeds {', '.join(map(str, found))}" if found else ""
        return Row(
            f"traffic drawn: {what}", len(found), f"of {len(runs)} floors", 1.0, "one", 0.0, told, less=True
        )

    return [
        row("overlaps, places held twice, broken rules", faulty),
        row("somebody stuck", stuck),
        row("somebody waited for two minutes", waited),
    ]


def _cases(
    names: Iterable[str], seeds: tuple[int, ...], longest_s: float, *, all_seeds: bool
) -> Iterator[Case]:
    for name in names:
        span_s = min(longest_s, SPANS_S.get(name, longest_s))
        for seed in seeds if all_seeds or name not in LARGE else seeds[:1]:
            for scheme in ("ghosts", "first come", "planner", "ours"):
                yield Case(name, seed, span_s, scheme)
            if name in POISSON:
                per_h = POISSON[name][0]
                yield Case(name, seed, span_s, "ghosts", "ordinary load", per_h)
                yield Case(name, seed, span_s, "ours", "ordinary load", per_h)
            if name == "single-track-8":
                for (latency_s, loss_frac), quality in NETWORKS.items():
                    what = _network(latency_s, loss_frac)
                    yield Case(name, seed, span_s, "ours", what, quality=quality)
                yield Case(name, seed, span_s, "ours", "one dies")
                yield Case(
                    name, seed, span_s, "ours", "machines die", quality=Quality(0.02, 0.2, double_frac=0.1)
                )
            if name == "single-track-12":
                for scheme in ABLATIONS:
                    yield Case(name, seed, span_s, scheme)


def _network(latency_s: float, loss_frac: float) -> str:
    return f"{latency_s * 1000:.0f} ms, {loss_frac:.0%} lost"


class _Played:
    """Figures of all runs of one kind."""

    def __init__(self, played: dict[Case, Figures], plant: str, scheme: str, what: str = "saturated") -> None:
        self.runs = [
            figures
            for case, figures in played.items()
            if (case.plant, case.scheme, case.what) == (plant, scheme, what)
        ]

    @property
    def per_h(self) -> float:
        return fmean(run.per_h for run in self.runs)

    @property
    def p50_s(self) -> float:
        return fmean(run.p50_s for run in self.runs)

    @property
    def p95_s(self) -> float:
        return fmean(run.p95_s for run in self.runs)

    @property
    def said(self) -> float:
        return fmean(run.said for run in self.runs)

    @property
    def longest_s(self) -> float:
        return max(run.longest_s for run in self.runs)

    @property
    def note(self) -> str:
        """Further observations, in words."""
        jammed = sum(run.stuck > 0 for run in self.runs)
        return (
            f"p50 {self.p50_s:.0f} s, p95 {self.p95_s:.0f} s, longest wait {self.longest_s:.0f} s, "
            f"jammed in {jammed} of {len(self.runs)} runs, overlaps {sum(r.found.overlaps for r in self.runs)}, "
            f"held twice {sum(r.found.double_holds for r in self.runs)}, {self.said:.2f} messages/(vehicle s)"
        )


def _rows(names: Iterable[str], played: dict[Case, Figures]) -> Iterator[Row]:
    for name in names:
        ghosts, planner = _Played(played, name, "ghosts"), _Played(played, name, "planner")
        ours = _Played(played, name, "ours")
        label = f"traffic {name}:"
        for scheme, runs in (("first come", _Played(played, name, "first come")), ("planner", planner)):
            if not runs.runs:
                continue
            yield Row(f"{label} {scheme}", runs.per_h, "/h", ghosts.per_h, "ghosts", note=runs.note)
        yield Row(
            f"{label} ours",
            ours.per_h,
            "/h",
            ghosts.per_h,
            "ghosts",
            OF_GHOSTS[name] * ghosts.per_h if name in OF_GHOSTS else None,
            ours.note,
        )
        if planner.runs and planner.per_h:
            yield Row(
                f"{label} ours", ours.per_h, "/h", planner.per_h, "the planner", OF_PLANNER * planner.per_h
            )
        yield Row(f"{label} longest wait", ours.longest_s, "s", STAND_S, "two minutes", STAND_S, less=True)
        most = MESSAGES.get(name, MOST_MESSAGES)
        yield Row(f"{label} messages", ours.said, "/(vehicle s)", most, "the most", most, less=True)
        if name in POISSON:
            yield from _ordinary(name, label, played)
        if name == "single-track-8":
            yield from _troubled(name, label, ours, played)
        if name == "single-track-12":
            for scheme in ABLATIONS:
                runs = _Played(played, name, scheme)
                yield Row(f"{label} {scheme}", runs.per_h, "/h", ghosts.per_h, "ghosts", note=runs.note)
    judged = [figures for case, figures in played.items() if case.scheme != "ghosts"]
    faults = sum(figures.found.faults for figures in judged)
    first = [words for figures in judged for words in figures.found.first][:3]
    yield Row(
        "traffic: overlaps, places held twice, broken rules",
        faults,
        f"in {len(judged)} runs",
        1.0,
        "one",
        0.0,
        "; ".join(first),
        less=True,
    )


def _ordinary(name: str, label: str, played: dict[Case, Figures]) -> Iterator[Row]:
    _, most_p50, most_p95 = POISSON[name]
    ghosts, ours = (_Played(played, name, scheme, "ordinary load") for scheme in ("ghosts", "ours"))
    yield Row(
        f"{label} p50 at an ordinary load",
        ours.p50_s,
        "s",
        ghosts.p50_s,
        "ghosts",
        most_p50 * ghosts.p50_s,
        ours.note,
        less=True,
    )
    yield Row(
        f"{label} p95 at an ordinary load",
        ours.p95_s,
        "s",
        ghosts.p95_s,
        "ghosts",
        most_p95 * ghosts.p95_s,
        less=True,
    )


def _troubled(name: str, label: str, ours: _Played, played: dict[Case, Figures]) -> Iterator[Row]:
    good = _Played(played, name, "ours", _network(0.02, 0.0))
    for key in NETWORKS:
        what = _network(*key)
        runs = _Played(played, name, "ours", what)
        target = OF_GOOD[key] * good.per_h if key in OF_GOOD else None
        yield Row(f"{label} {what}", runs.per_h, "/h", good.per_h, "a good network", target, runs.note)
    for what, least in (("one dies", 0.85), ("machines die", 0.95)):
        runs = _Played(played, name, "ours", what)
        yield Row(
            f"{label} {what}", runs.per_h, "/h", ours.per_h, "nobody dies", least * ours.per_h, runs.note
        )
