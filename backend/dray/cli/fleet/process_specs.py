"""The process specs of a fleet: which processes there are, and how each is started.

Every process calls three others, at distances of 1, 2 and 4 in a ring, so that no single one is between
any two others, and the number of links grows with the factory and not with its square.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from dray.cli.fleet.addresses import free_addresses
from dray.cli.fleet.folder import CONTROLLERS, GATEWAY, HISTORIAN, LOGS
from dray.cli.runtime.roster import FLOOR, agents_of
from dray.messages.keys import GATE, STRATEGIST
from dray.messages.kinds import Kind
from dray.plant import Plant
from dray.settings import PREFIX

DISTANCES = (1, 2, 4)
"""In the ring. Any two neighbours may be gone, and all others still hear one another."""


@dataclass(frozen=True, slots=True)
class ProcessSpec:
    """One process to be kept running.

    Attributes:
        name: of its agent.
        kind: what it is: atv, machine, station, gate, strategist, historian, gateway or floor.
        command: what follows `dray`.
        address: where others call it.
        environment: all of it.
        metrics: where it tells Prometheus its metrics; empty: nowhere.
        log: the file that its words are added to.
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
        """Whether its words are for the person who has started the fleet."""
        return self.kind == GATEWAY

    @property
    def comes_back(self) -> bool:
        """Whether another process can go on where it has ended; not the floor, whose bodies end with it."""
        return self.kind != FLOOR

    def probation(self, tasks: int) -> tuple[str, ...]:
        """What follows the command of a canary with so many tasks; not every kind knows probation."""
        return ("--probation", str(tasks)) if tasks and self.kind in ON_PROBATION else ()


ON_PROBATION = frozenset[str]({Kind.ATV, Kind.MACHINE})
"""Kinds of agents that take no more than they can show themselves by, while they are on probation."""


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
    """The specs of all processes of a plant, in the order in which they are to be started: agents need a floor, people a panel.

    Args:
        plant: the factory.
        strategists: those that share its orders.
        folder: the fleet's.
        common: the settings of all.
        secret: further ones, for the gateway alone.
        demand: the gateway places orders, too.
        metrics: every process tells its own.
        opcua: machines are behind the floor's OPC UA server.
        vda5050: the broker at which vehicles speak VDA 5050; empty for vehicles that do not.
        people_at_gate: people are the body of the gate.
    """
    controllers = folder / CONTROLLERS
    commands: dict[str, tuple[str, ...]] = {
        FLOOR: (
            FLOOR,
            *(("--opcua", str(controllers)) if opcua else ()),
            *(("--vda5050",) if vda5050 else ()),
            *(("--open-gate",) if people_at_gate else ()),
        ),
        HISTORIAN: (HISTORIAN,),
        # One alone is not named: a version of Dray that knows no others can be gone back to.
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
            # Said also where there is none: two processes cannot listen on what this one's variable names.
            f"{PREFIX}METRICS_LISTEN": told[name],
        }
        command = commands[name]
        body = {}
        if opcua and name in plant.machines:
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
    """What the agent of a vehicle of the floor is told of it (`dray_sim.vda5050.floor_fleet`)."""
    return {"MANUFACTURER": "Dray", "SERIAL": name, "PROFILE": "dray-sim"}
