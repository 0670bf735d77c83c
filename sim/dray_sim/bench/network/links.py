"""Benchmark `links`: the experiments of the paper's Figure 6 on real links (paper, 4.3).

They run in network namespaces (`dray_sim.bench.network.field`). The baselines are settings: the lease of a link,
after which messages take another way, and the silence after which a vehicle is suspected.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import TypeVar

from dray.adapters.zenoh.links import RETRY_MS
from dray.messages import AtvHeartbeat, Link, MachineHeartbeat, TaskBrief
from dray.messages.fact import CarrierChanged, PrimarySuspected, TookOver
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S, bound_s
from dray_sim.bench.network.field import LEASE_S, Field
from dray_sim.bench.row import Row

T = TypeVar("T")

REPEATS = 5

AGAIN_S = 1.0
"""Aim of the first experiment: longest time after the lease until the vehicle is heard again."""

AIR_S = 0.5
"""Largest difference in transit time between two heartbeats, on a busy computer."""

WATCH_S = 6.0
"""After a cut, no vehicle may be suspected for this long: longer than a lease plus the longest silence on a good
link."""


@dataclass(frozen=True, slots=True)
class Cut:
    """Observations when the WLAN of the primary was cut and repaired.

    Attributes:
        heard_s: from the cut until the first heartbeat came that was said after it.
        noticed_s: until the vehicle's word came that it is left with its radio.
        silent_s: the longest silence of the vehicle.
        disturbed: suspicions, takeovers and changes of the carrier.
        back_s: from the repair until the vehicle's word came that it is on the WLAN again.
    """

    heard_s: float
    noticed_s: float
    silent_s: float
    disturbed: int
    back_s: float


@dataclass(frozen=True, slots=True)
class Takeover:
    """Observations when the primary was switched off.

    Attributes:
        took_s: until the new carrier's announcement came.
        carrier: the new carrier.
        epoch: of the task by then, in the machine's word.
        takeovers: how many.
    """

    took_s: float
    carrier: str
    epoch: int
    takeovers: int


def cut_wlan(field: Field, task: TaskBrief) -> Cut:
    """Cut the WLAN of the primary, watch, and repair it."""
    primary = task.primary
    field.computers.switch_wlan(primary, "down")
    cut_s = time.time()
    heard = field.seen(AtvHeartbeat, lambda seen: seen.said.atv == primary and seen.said.at_s > cut_s)
    noticed_s = _on(field, primary, Link.MESH, cut_s)
    field.seen(AtvHeartbeat, lambda seen: seen.said.atv == primary and seen.said.at_s > cut_s + WATCH_S)
    # Before that the vehicle was idle, and beat less often.
    beats_s = [
        seen.at_s
        for seen in field.witness.all(AtvHeartbeat)
        if seen.said.atv == primary and seen.said.task is not None
    ]
    disturbed = sum(len(field.witness.all(kind)) for kind in (PrimarySuspected, TookOver, CarrierChanged))
    field.computers.switch_wlan(primary, "up")
    repaired_s = time.time()
    back_s = _on(field, primary, Link.WLAN, repaired_s)
    return Cut(
        heard_s=heard.at_s - cut_s,
        noticed_s=noticed_s - cut_s,
        silent_s=max(later - before for before, later in pairwise(beats_s)),
        disturbed=disturbed,
        back_s=back_s - repaired_s,
    )


def switch_off(field: Field, task: TaskBrief) -> Takeover:
    """Switch the primary off, and observe the takeover."""
    off_s = time.time()
    field.switch_off(task.primary)
    took = field.seen(TookOver, lambda seen: seen.said.task == task.task)
    settled = field.seen(
        MachineHeartbeat, lambda seen: _carrier(seen.said, task) not in {task.primary, ""}, since_s=off_s
    )
    brief = next(each for each in settled.said.tasks if each.task == task.task)
    return Takeover(
        took_s=took.at_s - off_s,
        carrier=brief.primary,
        epoch=brief.epoch,
        takeovers=len(field.witness.all(TookOver)),
    )


def _on(field: Field, vehicle: str, link: Link, since_s: float) -> float:
    """When the first heartbeat of a vehicle came that says that it is on this link."""
    beat = field.seen(
        AtvHeartbeat, lambda seen: seen.said.atv == vehicle and seen.said.link is link, since_s=since_s
    )
    return beat.at_s


def _carrier(heartbeat: MachineHeartbeat, task: TaskBrief) -> str:
    return next((each.primary for each in heartbeat.tasks if each.task == task.task), "")


def play(experiment: Callable[[Field, TaskBrief], T]) -> T:
    """Run one experiment in a laboratory of its own."""
    with tempfile.TemporaryDirectory() as folder, Field.opened(Path(folder)) as field:
        return experiment(field, field.contract())


def measure(quick: bool) -> list[Row]:
    """Measure both experiments.

    Args:
        quick: once each.

    Raises:
        UnavailableError: this computer does not have, or allow, namespaces of networks.
    """
    repeats = 1 if quick else REPEATS
    cuts = [play(cut_wlan) for _ in range(repeats)]
    takeovers = [play(switch_off) for _ in range(repeats)]
    allowed_s = bound_s(WORKING_INTERVAL_S)
    disturbed = sum(cut.disturbed for cut in cuts)
    return [
        _row(
            "WLAN cut, heard again over a neighbour",
            [cut.heard_s for cut in cuts],
            ("the lease", LEASE_S, LEASE_S + AGAIN_S),
            f"{disturbed} suspicions; longest silence {max(cut.silent_s for cut in cuts):.2f} s",
        ),
        _row(
            "WLAN repaired, used again",
            [cut.back_s for cut in cuts],
            ("the longest rest between two calls", RETRY_MS["period_max_ms"] / 1000, None),
        ),
        _row(
            "switched off, taken over by the secondary",
            [takeover.took_s for takeover in takeovers],
            ("the bound of suspicion", allowed_s, allowed_s + AIR_S),
            f"{sum(takeover.takeovers for takeover in takeovers)} takeovers in {repeats}",
        ),
    ]


def _row(name: str, times_s: list[float], bound: tuple[str, float, float | None], note: str = "") -> Row:
    """The worst of several times beside its bound."""
    baseline_name, baseline_s, target_s = bound
    note = "; ".join(filter(None, (f"median of {len(times_s)}: {median(times_s):.2f} s", note)))
    return Row(f"links: {name}", max(times_s), "s", baseline_s, baseline_name, target_s, note, less=True)
