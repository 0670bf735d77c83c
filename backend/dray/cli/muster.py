"""What `dray fleet up` starts: which processes there are, how each is started, and that each is kept running.

Every process calls three others, at distances of 1, 2 and 4 in a ring, so that no single one is between
any two others, and the number of links grows with the factory and not with its square.

A process that ends is started again, as a service manager does. Who runs stands in the roll (`dray.cli.roll`).
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import typer

from dray.adapters.certificates import Authority
from dray.adapters.sqlite_journal import SqliteJournal
from dray.cli.authority import authority_of
from dray.cli.process import FLOOR
from dray.cli.roll import CERTIFICATES, GATEWAY, RollKeeper
from dray.cli.serving import stopped_by_signals
from dray.errors import UnavailableError
from dray.messages.speakers import Kind
from dray.plant import Plant
from dray.protocol.strategist import STRATEGIST
from dray.settings import PREFIX, Settings
from dray.store import open_store
from dray.worker import HISTORY_FACTS

DISTANCES = (1, 2, 4)
"""In the ring. Any two neighbours may be gone, and all others still hear one another."""

REST_S = 1.0
"""Before a process that has ended is started again: one that ends at once must not take the computer."""

STOP_S = 10.0
"""To end in peace; then it is killed."""

SETTINGS, JOURNALS, LOGS = "fleet.env", "journals", "logs"
"""In the fleet's folder."""


@dataclass(frozen=True, slots=True)
class Muster:
    """A fleet that is to be started.

    Attributes:
        settings: of the gateway: its port and its database.
        plant: the factory.
        folder: where everything is kept.
        speed: factory seconds per real second.
        plain: links without certificates.
        demand: let orders be placed.
    """

    settings: Settings
    plant: Plant
    folder: Path
    speed: float
    plain: bool
    demand: bool


async def run_muster(muster: Muster) -> None:
    """Run a fleet until a signal.

    Raises:
        UnavailableError: the folder or the database is not to be had.
    """
    stopped = asyncio.Event()
    folder = muster.folder.resolve()
    with _kept_in(folder):
        (folder / LOGS).mkdir(parents=True, exist_ok=True)
        _forget_bodies(folder)
        if not muster.plain:
            _certify(muster.plant, folder / CERTIFICATES)
    common = await _common_environment(muster, folder)
    posts = _posts(muster, folder, common)
    _write_settings(folder / SETTINGS, common, posts)
    roll = RollKeeper(folder, muster.plant.id, plain=muster.plain)
    with stopped_by_signals(stopped.set):
        async with asyncio.TaskGroup() as group:
            keepers = [group.create_task(_keep(post, roll), name=post.name) for post in posts]
            keepers.append(group.create_task(_tell_started(muster.folder, len(posts), roll)))
            await stopped.wait()
            for keeper in keepers:
                keeper.cancel()
    roll.close()


# --- what is started ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Post:
    """One process to be kept running."""

    name: str
    command: tuple[str, ...]
    address: str
    environment: Mapping[str, str]
    log: Path
    joins: bool = True


def _posts(muster: Muster, folder: Path, common: Mapping[str, str]) -> list[_Post]:
    plant = muster.plant
    commands = {
        FLOOR: (FLOOR,),
        "historian": ("historian",),
        STRATEGIST: ("strategist",),
        **{machine: ("agent", "machine", machine) for machine in plant.machines},
        **{atv: ("agent", "atv", atv) for atv in plant.fleet},
        GATEWAY: ("gateway", "--demand" if muster.demand else "--no-demand"),
    }
    names = tuple(commands)
    addresses = dict(zip(names, _free_addresses(len(names)), strict=True))
    posts = []
    for place, name in enumerate(names):
        called = {names[(place + distance) % len(names)] for distance in DISTANCES} - {name}
        links = {
            f"{PREFIX}BUS_LISTEN": addresses[name],
            f"{PREFIX}BUS_PEERS": ",".join(sorted(addresses[each] for each in called)),
        }
        log = folder / LOGS / f"{name}.log"
        posts.append(
            _Post(
                name,
                commands[name],
                addresses[name],
                {**os.environ, **common, **links},
                log,
                joins=name != FLOOR,
            )
        )
    return posts


async def _common_environment(muster: Muster, folder: Path) -> dict[str, str]:
    settings = muster.settings
    # Opened here first, so that no two processes make its tables at once.
    store = await open_store(settings.database_url)
    try:
        trusted = (await authority_of(store)).public.hex()
    finally:
        await store.close()
    environment = {
        f"{PREFIX}DATABASE_URL": settings.database_url,
        f"{PREFIX}HOST": settings.host,
        f"{PREFIX}PORT": str(settings.port),
        f"{PREFIX}JOURNAL_FOLDER": str(folder / JOURNALS),
        f"{PREFIX}TRUSTED_KEYS": trusted,
        f"{PREFIX}PLANT_SPEED": str(muster.speed),
        f"{PREFIX}PLANT_EPOCH_S": str(time.time()),
        f"{PREFIX}BUS_PLAIN": str(muster.plain),
    }
    if not muster.plain:
        environment[f"{PREFIX}BUS_CERTIFICATES"] = str(folder / CERTIFICATES)
    if settings.plant_file is not None:
        environment[f"{PREFIX}PLANT_FILE"] = str(settings.plant_file.resolve())
    return environment


def _write_settings(file: Path, common: Mapping[str, str], posts: Sequence[_Post]) -> None:
    """What a newcomer needs: the settings of all, and some addresses to call."""
    peers = ",".join(post.address for post in posts[: len(DISTANCES)])
    lines = [f"{name}={value}" for name, value in (*common.items(), (f"{PREFIX}BUS_PEERS", peers))]
    # The URL of the database may hold a password.
    file.unlink(missing_ok=True)
    file.touch(mode=0o600)
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _certify(plant: Plant, folder: Path) -> None:
    """A certificate for every process, by an authority of this fleet, which may certify newcomers."""
    authority = Authority.make(plant.id)
    authority.write(folder)
    kinds = {
        FLOOR: Kind.HISTORIAN,
        "historian": Kind.HISTORIAN,
        STRATEGIST: Kind.STRATEGIST,
        GATEWAY: Kind.GATEWAY,
        **dict.fromkeys(plant.machines, Kind.MACHINE),
        **dict.fromkeys(plant.fleet, Kind.ATV),
    }
    for name, kind in kinds.items():
        authority.issue(folder, plant.id, {name: kind})


def _forget_bodies(folder: Path) -> None:
    """The floor begins anew, so what agents were bound by to the last one is no more."""
    for file in (folder / JOURNALS).glob("*.db"):
        with contextlib.closing(SqliteJournal(file, events_kept=HISTORY_FACTS)) as journal:
            journal.forget()


def _free_addresses(count: int) -> list[str]:
    """Addresses on this computer where nobody listens."""
    with contextlib.ExitStack() as stack:
        # All of them at once, so that none is given twice.
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [f"127.0.0.1:{each.getsockname()[1]}" for each in sockets]


@contextlib.contextmanager
def _kept_in(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise UnavailableError(str(folder), reason, "choose another --folder") from None


# --- and kept running --------------------------------------------------------------------------------


async def _tell_started(folder: Path, count: int, roll: RollKeeper) -> None:
    await roll.has(count)
    typer.echo(f"{count} processes; `dray fleet status --folder {folder}` shows them")
    sys.stdout.flush()


async def _keep(post: _Post, roll: RollKeeper) -> None:
    """Keep one process running until cancelled; then let it end."""
    while True:
        # The gateway tells on the terminal where the panels are.
        with post.log.open("ab") as log:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "dray",
                *post.command,
                env=post.environment,
                stdout=None if post.name == GATEWAY else log,
                stderr=log,
                # Ctrl-C is for us; we tell them.
                start_new_session=True,
            )
        roll.started(post.name, process.pid, post.address, joins=post.joins)
        try:
            await process.wait()
        except asyncio.CancelledError:
            await _end(process)
            raise
        await asyncio.sleep(REST_S)


async def _end(process: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        process.terminate()
        try:
            await asyncio.wait_for(process.wait(), STOP_S)
        except TimeoutError:
            process.kill()
            await process.wait()
