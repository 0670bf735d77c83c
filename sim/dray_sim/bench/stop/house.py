"""A plant in a process of its own, and the tablet of a logged-in person."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import sqlite3
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, asynccontextmanager, closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import urlsplit

from dray.adapters.addresses import free_addresses
from dray.errors import UnavailableError
from dray.gateway.access.gate import COOKIE
from dray.plant import default_plant
from dray_sim.bench.losses.fleet import running
from dray_sim.bench.losses.watch import gathered
from dray_sim.bench.postgres import PostgresServer, installed
from dray_sim.bench.stop.attacks import HOST, Target
from dray_sim.plants.generator import generate_plant

START_S, END_S = 90.0, 20.0
"""Longest waits for the process: ten times what a busy machine takes."""

AGAIN_S = 0.2
"""Interval between two looks whether it answers."""

JOIN_S = 240.0
"""Longest time until all processes of a fleet are on the bus, on a busy computer."""

SMALL = generate_plant(1, machines=2, vehicles=2)
"""The plant of a fleet: a dozen processes share the computer's cores with the attackers."""


@dataclass(frozen=True, slots=True)
class Tablet:
    """The tablet of a person who may stop vehicles.

    Attributes:
        known_by: the header that identifies the person.
    """

    known_by: tuple[str, str]

    def stop(self, port: int, atv: str, patience_s: float) -> bool:
        """Send a Stop on a connection of its own; returns whether the vehicle has confirmed it."""
        connection = http.client.HTTPConnection(HOST, port, timeout=patience_s)
        headers = dict([("Content-Type", "application/json"), self.known_by])
        with closing(connection), suppress(OSError, http.client.HTTPException, ValueError):
            connection.request("POST", f"/api/atvs/{atv}/commands", b'{"kind": "stop"}', headers)
            answer = connection.getresponse()
            return answer.status == 200 and bool(json.loads(answer.read())["done"])
        return False


@dataclass(frozen=True, slots=True)
class House:
    """A plant that is open.

    Attributes:
        target: where it is attacked.
        tablet: whose stops are measured.
        vehicles: which ones there are.
        database: the file of its database.
    """

    target: Target
    tablet: Tablet
    vehicles: tuple[str, ...]
    database: PostgresServer | Path

    @contextmanager
    def database_away(self) -> Iterator[str]:
        """Take the database away for a while; says how."""
        if isinstance(self.database, PostgresServer):
            asyncio.run(self.database.kill())
            try:
                yield "its server killed"
            finally:
                self.database.start()
        else:
            # SQLite has no server to kill: no other can write, and every write waits until its timeout.
            with closing(sqlite3.connect(self.database)) as connection:
                connection.execute("BEGIN EXCLUSIVE")
                yield "its file locked"
                connection.rollback()


@contextmanager
def open_house() -> Iterator[House]:
    """Start a plant, and log in.

    Raises:
        UnavailableError: it does not start.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        programs = installed()
        database: PostgresServer | Path = folder / "dray.db"
        if programs is not None:
            database = stack.enter_context(closing(PostgresServer(programs)))
        url = database.url() if isinstance(database, PostgresServer) else f"sqlite:///{database}"
        port, stop_port = (int(each.rpartition(":")[2]) for each in free_addresses(2))
        environment = os.environ | {
            "DRAY_DATABASE_URL": url,
            "DRAY_ADMIN_TOKEN": "bench",
            "DRAY_STOP_PORT": str(stop_port),
        }
        log = stack.enter_context((folder / "log").open("w+b"))
        process = subprocess.Popen(  # noqa: S603 (no shell, and no word of a stranger's)
            [sys.executable, "-m", "dray", "up", "--port", str(port)],
            env=environment,
            cwd=folder,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        stack.callback(_end, process)
        link = _link_in(process, folder / "log")
        tablet = Tablet(("Cookie", f"{COOKIE}={log_in(port, link)}"))
        yield House(Target(port, stop_port, "bench"), tablet, tuple(default_plant().fleet), database)


@asynccontextmanager
async def open_fleet() -> AsyncIterator[House]:
    """Start a small plant of processes with certificates, whose bus can be attacked; a system with the administrator's token stops.

    Raises:
        UnavailableError: it does not start.
    """
    stop_port = int(free_addresses(1)[0].rpartition(":")[2])
    with TemporaryDirectory() as name:
        folder = Path(name)
        async with running(folder, SMALL, speed=1.0, plain=False, demand=True, stop_port=stop_port) as fleet:
            with fleet.bus() as bus:
                await gathered(fleet, bus, JOIN_S)
            target = Target(urlsplit(fleet.url).port or 0, stop_port, fleet.token, name)
            tablet = Tablet(("Authorization", f"Bearer {fleet.token}"))
            yield House(target, tablet, tuple(SMALL.fleet), folder / "dray.db")


def _link_in(process: subprocess.Popen[bytes], log: Path) -> str:
    """The manager's link, when requests are answered."""
    until_s = time.monotonic() + START_S
    while time.monotonic() < until_s and process.poll() is None:
        said = log.read_text(errors="replace")
        if "Ctrl-C stops it." in said:
            return next(line.rpartition("/login/")[2] for line in said.splitlines() if "/login/" in line)
        time.sleep(AGAIN_S)
    raise UnavailableError("dray up", f"did not start:\n{log.read_text(errors='replace')[-1000:]}", "see why")


def log_in(port: int, link: str) -> str:
    """The cookie of a session that begins by this link."""
    with closing(http.client.HTTPConnection(HOST, port, timeout=START_S)) as connection:
        connection.request(
            "POST", f"/login/{link}", b"", {"Content-Type": "application/x-www-form-urlencoded"}
        )
        answer = connection.getresponse()
        cookies = answer.headers.get_all("set-cookie") or []
    for cookie in cookies:
        name, _, value = cookie.partition(";")[0].partition("=")
        if name == COOKIE:
            return value
    raise UnavailableError("the login", f"was answered with {answer.status}", "see the gateway's log")


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
