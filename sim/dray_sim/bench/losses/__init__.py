"""Benchmark `losses`: what is lost, and at what cost, when processes of a factory are killed under load.

A whole fleet runs on this computer and orders come in over REST. Signal 9 kills one process after the other: every
kind in turn, then processes drawn by chance. Its supervisor starts each again, as a service manager does; a few
vehicles and machines stay away for long. The database is a PostgreSQL of the benchmark's own, of which all processes
are killed at once. In the end all orders must be delivered; then the judgement examines the histories, the database
and the floor. The baseline is the same fleet before the first kill.

    campaign     what is done, on a fleet, with a customer and a watch
    victims      who is next
    outage       the database is killed, and started again
    history      all that agents have told
    judgement    what must not be
    works, cost  what became of the victims' work
    calling      who has something brought meanwhile (benchmark `calls`)
    figures      of all that
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from dray.plant import default_plant
from dray_sim.bench.losses.campaign import Campaign, Outcome, play
from dray_sim.bench.losses.figures import rows, rows_with_calls
from dray_sim.bench.postgres import MISSING, PostgresServer, installed
from dray_sim.bench.row import Row
from dray_sim.people.demand import HEAD_START_S, LOAD

QUICK = 10
"""A quick run has a tenth of the kills."""

_log = logging.getLogger(__name__)


CALLS, RECURRING = 500, 20
"""Calls and recurring transports of the benchmark `calls`."""


def measure(quick: bool, traffic: bool | None = None) -> list[Row]:
    """Kill processes, and report what is lost.

    Args:
        quick: a tenth of the kills.
        traffic: whether vehicles drive with right of way; None: as `dray fleet up` does.

    Returns:
        The figures. When something was found that must not be, the fleet's folder stays, to be looked into.

    Raises:
        UnavailableError: the fleet does not start, or too little was carried to tell anything.
    """
    return _played(campaign_of(quick, traffic), rows)


def measure_calls(quick: bool, traffic: bool | None = None) -> list[Row]:
    """The same, while people and programs have something brought: benchmark `calls`.

    Args:
        quick: a tenth of the kills and of the calls.
        traffic: whether vehicles drive with right of way; None: as `dray fleet up` does.

    Raises:
        UnavailableError: the fleet does not start, or does not recover from a kill.
    """
    share = QUICK if quick else 1
    calls, recurring = CALLS // share, RECURRING // share
    campaign = replace(campaign_of(quick, traffic), calls=calls, recurring=recurring)
    return _played(campaign, rows_with_calls)


def campaign_of(quick: bool, traffic: bool | None) -> Campaign:
    """The campaign; a quick one has a tenth of the kills."""
    share = QUICK if quick else 1
    return Campaign(
        plant=default_plant(),
        speed=10.0,
        plain=False,
        load=LOAD,
        head_start_s=HEAD_START_S,
        warm_s=60.0,
        quiet_s=120.0 / (2 if quick else 1),
        each=10 // share,
        lasting=3 if share == 1 else 1,
        kills=200 // share,
        pause_s=2.5,
        down=3,
        # A quarter of an hour of the plant: loads on a silent vehicle are replaced after ten minutes.
        lasting_s=90.0,
        dark_s=5.0,
        drain_s=600.0,
        seed=1,
        traffic=traffic,
    )


def _played(campaign: Campaign, figures: Callable[[Outcome], list[Row]]) -> list[Row]:
    folder = Path(tempfile.mkdtemp(prefix="dray-losses-"))
    with contextlib.ExitStack() as stack:
        server = server_in(stack)
        found = figures(asyncio.run(play(campaign, folder, server)))
        if all(row.met for row in found):
            shutil.rmtree(folder)
            return found
        if server is not None:
            server.dump(folder / "database.dump")
    return [row if row.met else replace(row, note=f"{row.note}; see {folder}") for row in found]


def server_in(stack: contextlib.ExitStack) -> PostgresServer | None:
    """A server to be killed, as long as the stack lasts; None, with a warning, when PostgreSQL is not installed."""
    programs = installed()
    if programs is None:
        _log.warning("!!! %s: the database is a file, and IS NOT KILLED", MISSING)
        return None
    return stack.enter_context(contextlib.closing(PostgresServer(programs)))
