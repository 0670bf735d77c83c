"""The process specs of a fleet: its processes, and their start commands.

Every process calls three others, at distances of 1, 2 and 4 in a ring. So no single one separates two others, and the number of
links grows linearly with the factory.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from dray.adapters.addresses import free_addresses
from dray.cli.fleet.folder import CONTROLLERS, GATEWAY, HISTORIAN, LOGS
from dray.cli.runtime.roster import FLOOR, agents_of
from dray.messages.keys import GATE, STRATEGIST
from dray.messages.kinds import Kind
from dray.plant import Plant
from dray.settings import PREFIX

DISTANCES = (1, 2, 4)
"""Distances in the ring. If any two neighbours are gone, all others still hear one another."""


@dataclass(frozen=True, slots=True)
class ProcessSpec:
    """One process to supervise.

    Attributes:
        name: its agent's name.
        kind: its kind: atv, machine, station, gate, strategist, historian, gateway or floor.
        command: the arguments of `dray`.
        address: its listening address.
        environment: its whole environment.
        metrics: the address of its Prometheus metrics; empty: none.
        log: the file to which its output is appended.
    """

    name: str
    kind: str
    command: tuple[str, ...]
    address: str
    environment: Mapping[str, str]
    metrics: str
    log: Path

    @property
    def speaks(self) -> bool:
        """Whether its output is for the person who has started the fleet."""
        return self.kind == GATEWAY

    @property
    def comes_back(self) -> bool:
        """Whether a new process can replace it after its end; not the floor, whose bodies end with it."""
        return self.kind != FLOOR

    def probation(self, tasks: int) -> tuple[str, ...]:
        """The arguments of a canary with this number of tasks; empty for kinds without probation."""
        return ("--probation", str(tasks)) if tasks and self.kind in ON_PROBATION else ()


ON_PROBATION = frozenset[str]({Kind.ATV, Kind.MACHINE})
"""Kinds of agents with probation: they take few tasks until they have proved themselves."""


def specs_of(
    plant: Plant,
    strategists: Sequence[str],
    folder: Path,
    common: Mapping[str, str],
    secret: Mapping[str, str],
    *,
    demand: bool,
    metrics: bool,
    opcua: bool = False,
    vda5050: str = "",
    people_at_gate: bool = False,
) -> list[ProcessSpec]:
    """The specs of all processes of a plant, in starting order: agents need a floor, people a panel.

    Args:
        plant: the factory.
        strategists: the strategists.
        folder: the fleet's folder.
        common: the settings of all.
        secret: more settings, for the gateway alone.
        demand: whether the gateway places orders, too.
        metrics: whether every process serves its metrics.
        opcua: whether machines, storages and the gate are behind the floor's OPC UA server.
        vda5050: the broker of vehicles that speak VDA 5050; empty for none.
        people_at_gate: whether people operate the gate.
    """
    controllers = folder / CONTROLLERS
    controlled = {*plant.machines, *plant.stores, *(() if people_at_gate else (GATE,))}
    commands: dict[str, tuple[str, ...]] = {
        FLOOR: (
            FLOOR,
            *(("--opcua", str(controllers)) if opcua else ()),
            *(("--vda5050",) if vda5050 else ()),
            *(("--open-gate",) if people_at_gate else ()),
        ),
        HISTORIAN: (HISTORIAN,),
        # A single one is not named, so that a rollback to a version with only one is possible.
        **{name: (STRATEGIST,) if name == STRATEGIST else (STRATEGIST, name) for name in strategists},
        GATEWAY: (GATEWAY, "--demand" if demand else "--no-demand"),
        **{agent: ("agent", kind, agent) for agent, kind in agents_of(plant).items()},
    }
    names = tuple(commands)
    free = free_addresses(2 * len(names))
    addresses = dict(zip(names, free, strict=False))
    told = dict(zip(names, free[len(names) :], strict=True)) if metrics else dict.fromkeys(names, "")
    specs = []
    for place, name in enumerate(names):
        called = {names[(place + distance) % len(names)] for distance in DISTANCES} - {name}
        links = {
            f"{PREFIX}BUS_LISTEN": addresses[name],
            f"{PREFIX}BUS_PEERS": ",".join(sorted(addresses[each] for each in called)),
            # Set even when empty: two processes cannot listen on the address in this one's variable.
            f"{PREFIX}METRICS_LISTEN": told[name],
        }
        command = commands[name]
        body = {}
        if opcua and name in controlled:
            body = {"BODY": "opcua", "MAPPING": str(controllers / f"{name}.yaml")}
        elif vda5050 and name in plant.fleet:
            body = {"BODY": "vda5050", "BROKER": vda5050} | _simulated_vehicle(name)
        elif vda5050 and name == FLOOR:
            body = {"BROKER": vda5050}
        elif people_at_gate and name == GATE:
            body = {"BODY": "people"}
        specs.append(
            ProcessSpec(
                name=name,
                kind=command[1] if command[0] == "agent" else command[0],
                command=command,
                address=addresses[name],
                environment={
                    **os.environ,
                    **common,
                    **links,
                    **{f"{PREFIX}{key}": value for key, value in body.items()},
                    **(secret if name == GATEWAY else {}),
                },
                metrics=told[name],
                log=folder / LOGS / f"{name}.log",
            )
        )
    return specs


def _simulated_vehicle(name: str) -> dict[str, str]:
    """The environment of the agent of a vehicle of the floor (`dray_sim.vda5050.floor_fleet`)."""
    return {"MANUFACTURER": "Dray", "SERIAL": name, "PROFILE": "dray-sim"}
