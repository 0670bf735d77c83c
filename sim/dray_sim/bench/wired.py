"""Benchmark `wired`: right of way between processes on the real bus, while one process after the other is killed.

A whole fleet runs on this computer in real time and under load, with certificates. Every twelve seconds signal 9
kills a vehicle, a machine that keeps reservation tables, both at once, all replicas of one reservation table, or any other process. Only the
floor is spared, because it has the bodies. Every fourth victim stays away for a while. Then there are no kills for
some minutes. Afterwards all sent and received messages are judged (`checks.traffic_log_check`), and compared with the
tables in the replicas' journals.
"""

from __future__ import annotations

import asyncio
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random

from dray.adapters.journal.sqlite_journal import read_events, read_memory
from dray.adapters.telemetry.traffic_log import read_traffic_log
from dray.cli.runtime.roster import FLOOR
from dray.memory import TableMemory
from dray.messages.fact import TaskClosed
from dray.plant import Plant, default_plant
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.reservation_handling import NOTE
from dray_sim.bench.losses.fleet import Fleet, running
from dray_sim.bench.losses.watch import gathered
from dray_sim.bench.row import Row
from dray_sim.checks.floor.traffic_log_check import (
    GRANTED_TWICE,
    HELD_TWICE,
    NOT_HELD,
    OVERLAP,
    Judgement,
    TrafficLogCheck,
)

JOIN_S = 240.0
"""Longest time for three dozen processes to import and join, on a busy computer."""

STUCK_S = 120.0
"""Longest stand of a vehicle while no process is away: as in simulation."""


@dataclass(frozen=True, slots=True)
class Campaign:
    """The plan of a campaign.

    Attributes:
        plant: the factory.
        killing_s: real seconds in which somebody is killed.
        calm_s: real seconds after that without a kill.
        pause_s: real seconds from one kill to the next.
        away_s: real seconds for which some stay away, from and to.
        seed: of the choice of victims.
    """

    plant: Plant
    killing_s: float
    calm_s: float
    pause_s: float = 12.0
    away_s: tuple[float, float] = (10.0, 60.0)
    seed: int = 1


def measure(quick: bool) -> list[Row]:
    """Kill, and see whether a place is held twice.

    Args:
        quick: three minutes instead of thirty.

    Raises:
        UnavailableError: the fleet does not start.
    """
    campaign = Campaign(default_plant(), killing_s=1_620.0, calm_s=180.0)
    if quick:
        campaign = replace(campaign, killing_s=120.0, calm_s=60.0)
    folder = Path(tempfile.mkdtemp(prefix="dray-wired-"))
    found = asyncio.run(play(campaign, folder))
    if all(row.met for row in found):
        shutil.rmtree(folder)
        return found
    return [row if row.met else replace(row, note=f"{row.note}; see {folder}") for row in found]


async def play(campaign: Campaign, folder: Path) -> list[Row]:
    """Play a campaign in an empty folder; its figures."""
    lines, places = folder / "traffic", Places(campaign.plant)
    async with running(
        folder, campaign.plant, speed=1.0, plain=False, demand=True, traffic=True, traffic_log=lines
    ) as fleet:
        with fleet.bus() as bus:
            await gathered(fleet, bus, JOIN_S)
        begun_s = time.monotonic()
        kills = await _kill(campaign, fleet, places)
        await asyncio.sleep(campaign.calm_s)
        until_s = time.monotonic()
        journals = fleet.journals
    told = read_traffic_log(lines)
    judgement = TrafficLogCheck(places).judge(line for line in told if line.at_s <= until_s)
    whole = TrafficLogCheck(places)
    whole.judge(told)
    amiss = whole.disagreement(_tables(journals, places))
    return rows(judgement, kills, amiss, _transports(journals, campaign.plant), until_s - begun_s)


async def _kill(campaign: Campaign, fleet: Fleet, places: Places) -> Counter[str]:
    """Kill one after the other; how many of which kind."""
    random, kills = Random(campaign.seed), Counter[str]()
    until_s = time.monotonic() + campaign.killing_s
    while time.monotonic() < until_s:
        kind, names = _victims(random, campaign.plant, fleet, places)
        if random.random() < 0.25:
            done = [await fleet.take_away(name, random.uniform(*campaign.away_s)) for name in names]
            kind += ", away"
        else:
            done = [fleet.kill(name) for name in names]
        kills[kind] += 1
        kills["processes"] += sum(done)
        await asyncio.sleep(campaign.pause_s)
    return kills


def _victims(random: Random, plant: Plant, fleet: Fleet, places: Places) -> tuple[str, list[str]]:
    """The next victims, which are killed at the same moment."""
    atv, machine = random.choice(list(plant.fleet)), random.choice(list(plant.machines))
    others = [member.name for member in fleet.registry.running if member.name != FLOOR]
    kinds: tuple[tuple[str, list[str]], ...] = (
        ("a vehicle", [atv]),
        ("a machine", [machine]),
        ("both", [atv, machine]),
        ("all replicas of a reservation table", list(random.choice(list(places.replicas_of.values())))),
        ("anybody", [random.choice(others)]),
    )
    return random.choices(kinds, (4, 3, 1, 1, 2))[0]


def rows(
    judgement: Judgement, kills: Counter[str], amiss: list[str], transports: int, span_s: float
) -> list[Row]:
    """The figures."""
    counts, seen = judgement.counts, "; ".join(judgement.broken[:3])
    away = ", ".join(f"{count} x {kind}" for kind, count in sorted(kills.items()) if kind != "processes")
    stuck = [atv for atv, wait in judgement.waiting.items() if wait.waited_s > STUCK_S]
    return [
        Row(
            "wired: places held twice",
            counts[HELD_TWICE],
            "",
            judgement.requests,
            "requests",
            0.0,
            seen,
            less=True,
        ),
        Row(
            "wired: granted though held",
            counts[GRANTED_TWICE],
            "",
            judgement.grants,
            "grants",
            0.0,
            "",
            less=True,
        ),
        Row(
            "wired: lanes driven without holding them",
            counts[NOT_HELD],
            "",
            judgement.lanes,
            "lanes",
            0.0,
            "",
            less=True,
        ),
        Row("wired: overlaps", counts[OVERLAP], "", judgement.lanes, "lanes", 0.0, "", less=True),
        Row(
            "wired: places that a reservation table gives to somebody else",
            len(amiss),
            "",
            judgement.grants,
            "grants",
            0.0,
            "; ".join(amiss[:3]),
            less=True,
        ),
        Row(
            "wired: vehicles that are stuck at the end",
            len(stuck),
            "",
            STUCK_S,
            "s of standing",
            0.0,
            ", ".join(stuck),
            less=True,
        ),
        Row(
            "wired: longest wait for a place",
            judgement.longest_s,
            "s",
            max(judgement.median_s, 0.001),
            "median wait",
            note=f"{len(judgement.waits)} waits",
        ),
        Row(
            "wired: transports",
            transports,
            "",
            kills["processes"],
            "kills",
            note=f"in {span_s:.0f} s; {away}",
        ),
    ]


def _transports(journals: Path, plant: Plant) -> int:
    """Number of delivered transports, by their coordinators' journals."""
    return sum(
        isinstance(event.fact, TaskClosed) and event.fact.outcome == "delivered"
        for machine in plant.machines
        for event in read_events(journals / f"{machine}.db")
    )


def _tables(journals: Path, places: Places) -> Mapping[str, Mapping[str, str]]:
    """District -> place -> holder, from the newest copy in the replicas' journals."""
    return dict(_newest(journals, places))


def _newest(journals: Path, places: Places) -> Iterator[tuple[str, dict[str, str]]]:
    for district, replicas in places.replicas_of.items():
        notes = [read_memory(journals / f"{replica}.db").get(NOTE + district) for replica in replicas]
        tables = [note for note in notes if isinstance(note, TableMemory)]
        if tables:
            newest = max(tables, key=lambda table: (table.kept_epoch, table.version))
            yield district, {line.place: line.atv for line in newest.reservations}
