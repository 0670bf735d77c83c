"""The implementation of `dray fleet up`: it prepares a fleet, starts it, and supervises it until a signal."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import typer
from pydantic import SecretStr

from dray.cli.fleet.control import controlled
from dray.cli.fleet.folder import (
    CERTIFICATES,
    FLEET_LOCK,
    GATEWAY,
    JOURNALS,
    LOGS,
    alone,
    forget_controllers,
    make,
    prepare,
    write_settings,
    write_targets,
)
from dray.cli.fleet.process_registry import RegistryWriter, read_registry
from dray.cli.fleet.process_specs import DISTANCES, specs_of
from dray.cli.fleet.process_supervisor import Filling, ProcessSupervisor
from dray.cli.fleet.software import OWN
from dray.cli.runtime.gateway.authority import authority_of
from dray.cli.runtime.listener import listen
from dray.cli.runtime.roster import FLOOR
from dray.cli.runtime.signals import stopped_by_signals
from dray.errors import UnavailableError
from dray.gateway.access.tokens import new_token
from dray.messages.keys import strategists_of
from dray.plant import Plant, is_shipped
from dray.settings import PREFIX, Settings
from dray.store import open_store

STARTS_AT_ONCE = max(2, os.cpu_count() or 1)
"""Maximum concurrent starts; a start is mostly processor work. If all began at once, running agents would be silent for too
long. Others would count them as failed, which causes more work."""


@dataclass(frozen=True, slots=True)
class FleetOptions:
    """The parameters of a fleet.

    Attributes:
        settings: the gateway's settings, with its port and its database.
        plant: the factory.
        folder: the fleet's folder.
        speed: factory seconds per real second.
        plain: whether links have no certificates.
        demand: whether orders are placed automatically.
        metrics: whether every process serves Prometheus metrics.
        opcua: whether machines, storages and the gate are behind an OPC UA server of the floor.
        vda5050: the broker of vehicles that speak VDA 5050; empty for none.
        people_at_gate: whether people operate the gate.
    """

    settings: Settings
    plant: Plant
    folder: Path
    speed: float
    plain: bool
    demand: bool
    metrics: bool
    opcua: bool = False
    vda5050: str = ""
    people_at_gate: bool = False


async def run_fleet(options: FleetOptions) -> None:
    """Run a fleet until a signal.

    Raises:
        UnavailableError: the folder, the port or the database is unavailable, processes of an earlier fleet
            run, or the floor has ended.
    """
    folder = options.folder.resolve()
    make(folder)
    remedy = "end it with `dray fleet down`, or choose another --folder"
    with alone(folder, FLEET_LOCK, "`dray fleet up`", remedy):
        _refuse_leftovers(folder)
        token = options.settings.admin_token or SecretStr(new_token())
        strategists = strategists_of(options.settings.strategists)
        # Hold the port until all others have addresses: then the gateway finds it free.
        with contextlib.closing(listen(options.settings.host, options.settings.port)) as held:
            prepare(folder, options.plant, strategists, plain=options.plain)
            if options.opcua:
                forget_controllers(folder, options.plant)
            common = await _common_environment(options, folder, port=held.getsockname()[1])
            specs = specs_of(
                options.plant,
                strategists,
                folder,
                common,
                # The same for all of its lives: programs with this token continue after an update.
                {f"{PREFIX}ADMIN_TOKEN": token.get_secret_value()},
                demand=options.demand,
                metrics=options.metrics,
                opcua=options.opcua,
                vda5050=options.vda5050,
                people_at_gate=options.people_at_gate,
            )
        write_settings(folder, common, [spec.address for spec in specs[: len(DISTANCES)]])
        write_targets(folder, {spec.name: spec.metrics for spec in specs if spec.metrics})
        registry = RegistryWriter(folder, options.plant.id, plain=options.plain)
        leave_s = options.settings.leave_s
        turns = asyncio.Semaphore(STARTS_AT_ONCE)
        supervisors = {
            spec.name: ProcessSupervisor(spec, registry, turns, leave_s, Filling(OWN)) for spec in specs
        }
        greeting = f"{len(specs)} processes; `dray fleet status --folder {options.folder}` shows them"
        if options.settings.admin_token is None:
            greeting += f"\n  Admin token       {token.get_secret_value()}"
        async with controlled(folder, supervisors):
            bodies_gone = await _keep(supervisors, registry, greeting)
        registry.close()
    if bodies_gone:
        remedy = f"see {folder / LOGS / FLOOR}.log, and start the fleet again"
        raise UnavailableError("the floor", "has ended, and all vehicles and machines with it", remedy)


async def _keep(
    supervisors: Mapping[str, ProcessSupervisor], registry: RegistryWriter, greeting: str
) -> bool:
    """Supervise all processes until a signal, or until the floor has ended; returns whether it has."""
    stopped = asyncio.Event()
    with stopped_by_signals(stopped.set):
        async with asyncio.TaskGroup() as group:
            running = {
                name: group.create_task(supervisor.keep(), name=name)
                for name, supervisor in supervisors.items()
            }
            running[FLOOR].add_done_callback(lambda _: stopped.set())
            greeted = group.create_task(_greet(greeting, len(supervisors), registry))
            await stopped.wait()
            bodies_gone = running[FLOOR].done()
            for each in (*running.values(), greeted):
                each.cancel()
    return bodies_gone


def _refuse_leftovers(folder: Path) -> None:
    """Refuse to start beside the processes of a killed `dray fleet up`: two fleets would conflict on one floor."""
    try:
        left = read_registry(folder).running
    except UnavailableError:
        return
    if left:
        named = ", ".join(f"{member.name} ({member.pid})" for member in left)
        raise UnavailableError(
            str(folder),
            f"processes of an earlier fleet still run: {named}",
            "end them with `dray fleet down`",
        )


async def _common_environment(options: FleetOptions, folder: Path, port: int) -> dict[str, str]:
    """The settings of all processes; the port is the gateway's, in all of its lives."""
    settings = options.settings
    # Open it here first, so that no two processes create its tables at once.
    store = await open_store(settings.database_url)
    try:
        trusted = (await authority_of(store)).public.hex()
        # The floor is new, and the agents' memories were forgotten; a process that is started again later has its journal.
        await store.begin_anew(options.plant.id, time.time())
    finally:
        await store.close()
    environment = {
        f"{PREFIX}DATABASE_URL": settings.database_url,
        f"{PREFIX}HOST": settings.host,
        f"{PREFIX}PORT": str(port),
        f"{PREFIX}JOURNAL_FOLDER": str(folder / JOURNALS),
        f"{PREFIX}TRUSTED_KEYS": trusted,
        f"{PREFIX}PLANT_SPEED": str(options.speed),
        f"{PREFIX}PLANT_EPOCH_S": str(time.time()),
        f"{PREFIX}BUS_PLAIN": str(options.plain),
        # Set even at its default: our own environment may have another value for one process.
        f"{PREFIX}BUS_CERTIFICATES": "" if options.plain else str(folder / CERTIFICATES),
        f"{PREFIX}GATEWAY_NAME": GATEWAY,
        f"{PREFIX}TRAFFIC": str(settings.traffic),
        f"{PREFIX}STRATEGISTS": str(settings.strategists),
        f"{PREFIX}STARTS_AGAIN": "true",
    }
    if settings.traffic_log is not None:
        environment[f"{PREFIX}TRAFFIC_LOG"] = str(settings.traffic_log.resolve())
    if settings.plant_file is not None:
        named = is_shipped(settings.plant_file)
        environment[f"{PREFIX}PLANT_FILE"] = str(
            settings.plant_file if named else settings.plant_file.resolve()
        )
    return environment


async def _greet(greeting: str, count: int, registry: RegistryWriter) -> None:
    await registry.has(count)
    typer.echo(greeting)
    sys.stdout.flush()
