"""How much delay the factory endures: the same demand with 0 to 5 seconds of latency on every link."""

from __future__ import annotations

from dataclasses import replace

from dray.plant import Plant, default_plant
from dray_sim.network.latency import WLAN, Latency
from dray_sim.run.evidence import Check, Table
from dray_sim.run.scenario import Findings, Scenario
from dray_sim.run.stage import Played, Shift, play
from dray_sim.scenarios.tally import HEAD, Tally, all_delivered, listed, row, run_out

LATENCIES_S = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0)
"""Up to the latency that the longest bidding window allows for."""

ENDURED_S = 1.0
"""Largest latency under which the claim must hold. The grant of a place takes four links, one after the other, so vehicles
that take up room drive ever more slowly beyond it, as the table shows."""

SHIFT = Shift(name="latency-sweep", duration_s=2 * 3600.0, load=0.6)
"""Low load: the question is whether work goes on, and at what cost."""

STARVED_FRAC = 0.02
"""Fraction of the time with work: above it, machines do not reorder early enough for such a network."""


def sweep(
    seed: int,
    latencies_s: tuple[float, ...] = LATENCIES_S,
    shift: Shift = SHIFT,
    plant: Plant | None = None,
    *,
    endured_s: float = ENDURED_S,
) -> Findings:
    """Play the same demand once for every latency, and judge those up to `endured_s`."""
    runs = tuple(_run(seed, latency_s, shift, plant or default_plant()) for latency_s in latencies_s)
    endured = tuple(
        played for latency_s, played in zip(latencies_s, runs, strict=True) if latency_s <= endured_s
    )
    starved = [played.report.starvation_frac for played in endured]
    suspicions = [played.result.suspicions if played.result else -1 for played in endured]
    return Findings(
        runs=runs,
        checks=(
            all_delivered(endured),
            Check(
                "Late is not dead: nobody is suspected for a delay that every message shares",
                not any(suspicions),
                f"suspicions: {listed(suspicions)}",
            ),
            Check(
                f"Machines reorder early enough: less than {STARVED_FRAC:.0%} of their time without material",
                max(starved) < STARVED_FRAC,
                f"{', '.join(f'{frac:.2%}' for frac in starved)}",
            ),
        ),
        tables=(
            Table(
                "The same demand at each latency (one way)",
                ("latency", *HEAD),
                tuple(
                    (f"{latency_s:g} s", *row(played))
                    for latency_s, played in zip(latencies_s, runs, strict=True)
                ),
            ),
        ),
    )


def _run(seed: int, latency_s: float, shift: Shift, plant: Plant) -> Played[Tally]:
    latency = Latency(WLAN.base_s + latency_s, WLAN.mean_extra_s, WLAN.cap_s + latency_s)
    return play(replace(shift, latency=latency), plant, seed, run_out)


LATENCY_SWEEP = Scenario(
    name="latency-sweep",
    shows="The same demand with 0 to 5 s of latency on every link.",
    source="paper, 3.1 and 4.2 case 3",
    claim=(
        "Connections may be slow. Bidding that lasts long enough finds its contracts all the same; it is "
        "enough that machines reckon with the time it takes and reorder earlier."
    ),
    story=(
        f"{SHIFT.duration_s / 3600:g} hours of demand at {SHIFT.load:.0%} load in the default plant, once for each "
        "latency on all links in both directions, and then as long as the last order takes. It is judged up to "
        f"{ENDURED_S:g} s; beyond that the table shows what it costs."
    ),
    play=sweep,
    elsewhere=lambda seed, site: sweep(seed, shift=site.shift(SHIFT), plant=site.ground),
)
