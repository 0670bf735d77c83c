"""How long a Stop takes while everything else is under attack: from its request to the vehicle's confirmation.

One `dray up` runs in a process of its own, with a factory at work. A tablet sends Stops to the port that is for them
alone, each on a new connection, as after a reload. Some go to the gateway's own port, for comparison. Attacks run in
further processes, one kind at a time, from 127.0.0.1 like everything here. All are bounded in number and in time.
Attacks on the bus alone hit a small `dray fleet up` with certificates.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import ceil

from dray.errors import UnavailableError
from dray_sim.bench.row import Row
from dray_sim.bench.stop.attacks import ATTACKS, Attack, under_attack
from dray_sim.bench.stop.bus_attacks import BUS_ATTACKS
from dray_sim.bench.stop.house import House, Tablet, open_fleet, open_house

TARGET_MS = 300.0
"""Longest 99th percentile: a person takes longer than that to let go of the button."""

PACE_S = 0.05
"""Interval between two Stops: a person who stops all vehicles of an area, one after the other, takes longer."""

SAMPLES, QUICK_SAMPLES = 100, 20
"""Stops per attack."""

COMPARED_EVERY = 5
"""Every so many Stops, one goes to the gateway's own port as well."""

RAMP_S = 2.0
"""Wall seconds for which an attack is under way before the first Stop."""

BEGIN_S = 120.0
"""Longest wait for an attacker to begin: a process with its imports, on a computer that is busy elsewhere."""

PATIENCE_S = 5.0
"""A Stop that is not answered by then counts as having taken so long."""


@dataclass(frozen=True, slots=True)
class Latencies:
    """The latencies of some Stops.

    Attributes:
        took_s: wall seconds of each, in ascending order.
        unanswered: Stops without an answer, or without the vehicle's confirmation.
    """

    took_s: Sequence[float]
    unanswered: int

    def at_ms(self, share: float) -> float:
        """The latency that this share of them did not exceed, in milliseconds."""
        return 1e3 * self.took_s[ceil(share * len(self.took_s)) - 1]

    def words(self) -> str:
        """A text for a table."""
        lost = f", {self.unanswered} of {len(self.took_s)} unanswered" if self.unanswered else ""
        return f"p50 {self.at_ms(0.5):.0f}, p99 {self.at_ms(0.99):.0f}, max {self.at_ms(1):.0f} ms{lost}"


def measure(quick: bool) -> list[Row]:
    """Latency of a Stop under each attack, beside that of the idle plant."""
    samples = QUICK_SAMPLES if quick else SAMPLES
    with ThreadPoolExecutor(4) as compared:
        return [*_rows(samples, compared), *asyncio.run(_rows_on_bus(samples, compared))]


def _rows(samples: int, compared: ThreadPoolExecutor) -> Iterator[Row]:
    with open_house() as house:
        yield from _attacked(house, ATTACKS, "nothing else", "connections", samples, compared)
        idle, _ = _stops(house, samples, compared)
        with house.database_away() as how:
            time.sleep(RAMP_S)
            beside, own = _stops(house, samples, compared)
        yield _row(f"the database away ({how})", beside, own, idle)


async def _rows_on_bus(samples: int, compared: ThreadPoolExecutor) -> list[Row]:
    async with open_fleet() as house:
        rows = _attacked(house, BUS_ATTACKS, "nothing else, a fleet of processes", "words", samples, compared)
        # The loop goes on reading the fleet's output.
        return await asyncio.to_thread(list, rows)


def _attacked(
    house: House,
    attacks: Mapping[str, Attack],
    nothing: str,
    tried: str,
    samples: int,
    compared: ThreadPoolExecutor,
) -> Iterator[Row]:
    """A row for each attack, beside the same house without an attack."""
    idle, own = _stops(house, samples, compared)
    yield _row(nothing, idle, own, idle)
    for name, attack in attacks.items():
        with under_attack(attack, house.target) as tries:
            _wait_for(tries)
            beside, own = _stops(house, samples, compared)
            made = f"; {tries():,} {tried} by the attackers"
        yield _row(name, beside, own, idle, made)


def _wait_for(tries: Callable[[], int]) -> None:
    """Wait until the attack is under way.

    Raises:
        UnavailableError: it has not begun, so there is nothing to measure.
    """
    until_s = time.monotonic() + BEGIN_S
    while not tries():
        if time.monotonic() > until_s:
            raise UnavailableError(
                "the attack", f"has not begun in {BEGIN_S:.0f} s", "try it on an idle computer"
            )
        time.sleep(PACE_S)
    time.sleep(RAMP_S)


def _row(name: str, beside: Latencies, own: Latencies, idle: Latencies, more: str = "") -> Row:
    return Row(
        f"a stop, p99, under: {name}",
        beside.at_ms(0.99),
        "ms",
        idle.at_ms(0.99),
        "the idle plant",
        target=TARGET_MS,
        note=f"{beside.words()}; at the gateway's own address {own.words()}{more}",
        less=True,
    )


def _stops(house: House, samples: int, compared: ThreadPoolExecutor) -> tuple[Latencies, Latencies]:
    """Send Stops at the pace of a hasty person to their own port, and some to the gateway's port."""
    tablet, took_s, others = house.tablet, [], []
    for number in range(samples):
        begun_s = time.monotonic()
        atv = house.vehicles[number % len(house.vehicles)]
        if number % COMPARED_EVERY == 0:
            others.append(compared.submit(_timed, tablet, house.target.port, atv))
        took_s.append(_timed(tablet, house.target.stop_port, atv))
        time.sleep(max(0.0, PACE_S - (time.monotonic() - begun_s)))
    return _latencies(took_s), _latencies([each.result() for each in others])


def _timed(tablet: Tablet, port: int, atv: str) -> tuple[float, bool]:
    begun_s = time.perf_counter()
    answered = tablet.stop(port, atv, PATIENCE_S)
    return time.perf_counter() - begun_s, answered


def _latencies(timed: Sequence[tuple[float, bool]]) -> Latencies:
    took_s = sorted(took_s if answered else max(took_s, PATIENCE_S) for took_s, answered in timed)
    return Latencies(took_s, sum(not answered for _, answered in timed))
