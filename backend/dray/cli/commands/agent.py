"""`dray agent`, `dray strategist`: the agents of a plant, one process each.

Settings come from the environment and from a file (see `dray.settings`): the addresses of the others, our certificate, the
journal.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from dray.cli.runtime.options import SettingsFile, Traffic

if TYPE_CHECKING:
    from dray.adapters.security.signing import TrustedKeys
    from dray.cli.runtime.surroundings import Surroundings
    from dray.plant import Plant, VehicleSpec

app = typer.Typer(no_args_is_help=True, help="One agent of a plant as a process of its own.")

Body = Literal["floor", "vda5050"]

GateBody = Annotated[
    Literal["floor", "controller", "opcua", "mqtt", "people"] | None,
    typer.Option(
        "--body",
        help="floor: simulated, on `dray floor`; controller: that of its docks, behind a broker; opcua, mqtt: a counter and a reader of labels, by OPC UA or on topics; "
        "people: who work there say at the tablet what has arrived; else DRAY_BODY.",
    ),
]

StationBody = Annotated[
    Literal["floor", "controller", "opcua", "mqtt", "people"] | None,
    typer.Option(
        "--body",
        help="floor: simulated, on `dray floor`; controller: that of its dock, behind a broker; opcua, mqtt: likewise, by OPC UA or on topics; "
        "people: who work there say at the tablet what has happened; else DRAY_BODY.",
    ),
]

MachineBody = Annotated[
    Literal["floor", "opcua", "mqtt", "people"] | None,
    typer.Option(
        "--body",
        help="floor: simulated, on `dray floor`; opcua: its controller, by OPC UA; mqtt: its sensors, on topics of a broker; "
        "people: who work there say at the tablet what has happened; else DRAY_BODY.",
    ),
]

Mapping = Annotated[
    Path | None,
    typer.Option(
        "--mapping",
        help="The file that says which nodes or topics of its controller are which signals; else DRAY_MAPPING.",
    ),
]

Broker = Annotated[
    str | None,
    typer.Option(
        "--broker",
        help="Broker of a controller: mqtt://HOST:1883, or mqtts:// for TLS; else DRAY_BROKER.",
    ),
]

Probation = Annotated[
    int,
    typer.Option(
        "--probation",
        min=0,
        help="On probation: take short tasks only until so many transports were done well.",
    ),
]


@app.callback()
def agent() -> None:
    """One agent of a plant as a process of its own."""


@app.command()
def machine(
    name: Annotated[str, typer.Argument(help="Its id in the plant, as M8.")],
    joining: Annotated[
        Path | None,
        typer.Option("--joining", help="A plant file that has it, when that of the others does not know it."),
    ] = None,
    probation: Probation = 0,
    traffic: Traffic = None,
    body: MachineBody = None,
    broker: Broker = None,
    mapping: Mapping = None,
    settings: SettingsFile = None,
) -> None:
    """Run the agent of a machine; a joining one takes part as soon as it is there. SIGTERM lets it shut down gracefully."""
    import asyncio

    from dray import __version__
    from dray.cli.runtime.agent_process import run_agent
    from dray.cli.runtime.bodies.embodied import reading
    from dray.cli.runtime.bodies.on_floor import on_floor
    from dray.cli.runtime.bodies.people import by_people
    from dray.cli.runtime.bodies.signals import by_signals
    from dray.cli.runtime.output import one_of
    from dray.protocol.machine.machine import Machine
    from dray.protocol.runtime.running import Running

    said = _surroundings(settings, traffic=traffic, body=body, broker=broker, mapping=mapping)
    where = _with_body(said, "a machine", "opcua", "mqtt", "people")
    plant = where.plant if joining is None else _grown(where.plant, joining, name)
    spec, places = one_of(plant.machines, name, "NAME"), where.traffic
    trusts = _trusted(where)

    def make(life: int) -> Machine:
        return Machine(
            name,
            plant,
            incarnation=life,
            software=__version__,
            joining=joining is not None,
            probation=probation,
            traffic=places,
            trusts=trusts,
            running=Running(starts_again=where.settings.starts_again),
        )

    folder = where.settings.journal_folder / "documents"
    if where.settings.body in ("opcua", "mqtt"):
        embody = by_signals(where, name, spec)
    elif where.settings.body == "people":
        embody = by_people(where, name, spec)
    else:
        embody = on_floor(where, name, None if joining is None else spec)
    asyncio.run(run_agent(where, name, make, reading(embody, folder)))


@app.command()
def atv(
    name: Annotated[str, typer.Argument(help="Its id, as ATV3.")],
    type_: Annotated[
        str | None,
        typer.Option("--type", help="Type of a joining vehicle, which the plant file does not know."),
    ] = None,
    node: Annotated[str | None, typer.Option(help="Where a joining vehicle stands.")] = None,
    probation: Probation = 0,
    traffic: Traffic = None,
    body: Annotated[
        Body | None,
        typer.Option(help="floor: simulated, on `dray floor`; vda5050: a real vehicle; else DRAY_BODY."),
    ] = None,
    broker: Annotated[
        str | None,
        typer.Option(
            help="Broker of a real vehicle: mqtt://HOST:1883, or mqtts:// for TLS; else DRAY_BROKER."
        ),
    ] = None,
    manufacturer: Annotated[
        str | None,
        typer.Option(help="Manufacturer of a real vehicle, as its topics name it; else DRAY_MANUFACTURER."),
    ] = None,
    serial: Annotated[
        str | None, typer.Option(help="Its serial number, as its topics name it; else DRAY_SERIAL.")
    ] = None,
    profile: Annotated[
        str | None,
        typer.Option(help="What it understands: a file, or one that is shipped; else DRAY_PROFILE."),
    ] = None,
    settings: SettingsFile = None,
) -> None:
    """Run the agent of a vehicle, a simulated or a real one; a joining one takes part as soon as it is there.

    SIGTERM lets it shut down gracefully.
    """
    import asyncio

    from dray import __version__
    from dray.adapters.security.own_key import own_key
    from dray.adapters.security.signing import VehicleKey
    from dray.cli.runtime.agent_process import run_agent
    from dray.cli.runtime.bodies.on_floor import counted_on_floor, on_floor
    from dray.cli.runtime.bodies.vda5050 import RealVehicle, by_vda5050
    from dray.cli.runtime.output import one_of
    from dray.protocol.vehicle.atv import Atv

    where = _surroundings(
        settings,
        traffic=traffic,
        body=body,
        broker=broker,
        manufacturer=manufacturer,
        serial=serial,
        profile=profile,
    )
    joining = _joining(where.plant, name, type_, node)
    spec = joining or one_of(where.plant.fleet, name, "NAME")
    _with_body(where, "a vehicle", "vda5050")
    trusts, places = _trusted(where), where.traffic
    key = VehicleKey(name, own_key(where.settings.journal_folder / f"{name}.key"))

    def make(life: int) -> Atv:
        return Atv(
            name,
            where.plant,
            vehicle_type=spec.type,
            incarnation=life,
            software=__version__,
            probation=probation,
            trusts=trusts,
            traffic=places,
            sign_request=key.sign,
        )

    if where.settings.body == "vda5050":
        kind = where.plant.vehicle_types[spec.type]
        embody = by_vda5050(where, name, kind, RealVehicle.of(where.settings))
        if name in where.settings.foreign:
            embody = counted_on_floor(where, name, embody)
    else:
        embody = on_floor(where, name, joining)
    asyncio.run(run_agent(where, name, make, embody))


@app.command()
def station(
    name: Annotated[
        str, typer.Argument(help="The id of its storage or source warehouse in the plant, as S3.")
    ],
    traffic: Traffic = None,
    body: StationBody = None,
    broker: Broker = None,
    mapping: Mapping = None,
    settings: SettingsFile = None,
) -> None:
    """Run the station of a storage, without which nothing is fetched there. SIGTERM lets it shut down gracefully."""
    import asyncio

    from dray import __version__
    from dray.body import StorageState
    from dray.cli.runtime.agent_process import run_agent
    from dray.cli.runtime.bodies.controller import by_controller
    from dray.cli.runtime.bodies.on_floor import on_floor
    from dray.cli.runtime.bodies.people import store_by_people
    from dray.cli.runtime.bodies.signals import store_by_signals
    from dray.cli.runtime.output import one_of
    from dray.protocol.station.station import Station

    said = _surroundings(settings, traffic=traffic, body=body, broker=broker, mapping=mapping)
    where = _with_body(said, "a station", "controller", "opcua", "mqtt", "people")
    spec = one_of(where.plant.stores, name, "NAME")
    trusts, places = _trusted(where), where.traffic

    def make(life: int) -> Station:
        return Station(
            name, where.plant, incarnation=life, software=__version__, traffic=places, trusts=trusts
        )

    match where.settings.body:
        case "controller":
            embody = by_controller(where, name, StorageState)
        case "opcua" | "mqtt":
            embody = store_by_signals(where, name, spec)
        case "people":
            embody = store_by_people(where, name, spec)
        case _:
            embody = on_floor(where, name)
    asyncio.run(run_agent(where, name, make, embody))


@app.command()
def gate(
    name: Annotated[str, typer.Argument(help="Its id; every plant has one gate, of this name.")] = "gate",
    body: GateBody = None,
    broker: Broker = None,
    mapping: Mapping = None,
    settings: SettingsFile = None,
) -> None:
    """Run the gate of the delivery warehouses, which counts arrivals. SIGTERM lets it shut down gracefully.

    Without it no order is known to be delivered. Admitted goods are let in all the same, and counted when it is back.
    """
    import asyncio

    from dray import __version__
    from dray.body import GateState
    from dray.cli.runtime.agent_process import run_agent
    from dray.cli.runtime.bodies.controller import by_controller
    from dray.cli.runtime.bodies.on_floor import on_floor
    from dray.cli.runtime.bodies.people import gate_by_people
    from dray.cli.runtime.bodies.signals import gate_by_signals
    from dray.cli.runtime.output import one_of
    from dray.messages.keys import GATE
    from dray.protocol.gate.gate import DeliveryGate

    said = _surroundings(settings, body=body, broker=broker, mapping=mapping)
    where = _with_body(said, "the gate", "controller", "opcua", "mqtt", "people")
    one_of({GATE: None}, name, "NAME")
    trusts = _trusted(where)

    def make(life: int) -> DeliveryGate:
        return DeliveryGate(where.plant, incarnation=life, software=__version__, trusts=trusts)

    match where.settings.body:
        case "controller":
            embody = by_controller(where, name, GateState)
        case "opcua" | "mqtt":
            embody = gate_by_signals(where, name)
        case "people":
            embody = gate_by_people(where, name)
        case _:
            embody = on_floor(where, name)
    asyncio.run(run_agent(where, name, make, embody))


def strategist(
    name: Annotated[
        str, typer.Argument(help="Its name, where DRAY_STRATEGISTS says that there are several.")
    ] = "strategist",
    settings: SettingsFile = None,
) -> None:
    """Run a strategist, which turns orders into production goals. SIGTERM lets it shut down gracefully.

    Where there are several, as DRAY_STRATEGISTS says, each is a process: strategist, strategist2 and so on. When one falls silent
    the others go on with its orders.
    """
    import asyncio

    from dray.cli.runtime.agent_process import run_agent
    from dray.cli.runtime.bodies.embodied import bodiless
    from dray.errors import SettingsError
    from dray.protocol.strategist.gated import GatedStrategist

    where = _surroundings(settings)
    there = where.strategists
    if name not in there:
        reason = f"there is no {name!r}; with DRAY_STRATEGISTS={len(there)} choose one of {', '.join(there)}"
        raise SettingsError("NAME", reason)
    others = tuple(other for other in there if other != name)

    def make(life: int) -> GatedStrategist:
        return GatedStrategist(where.plant, agent=name, incarnation=life, others=others)

    asyncio.run(run_agent(where, name, make, bodiless))


def _surroundings(
    file: Path | None, *, traffic: bool | None = None, **options: str | Path | None
) -> Surroundings:
    from dray.cli.runtime.options import load_settings
    from dray.cli.runtime.surroundings import Surroundings

    return Surroundings.of(load_settings(settings_file=file, traffic=traffic, **options))


def _with_body(where: Surroundings, agent: str, *real: str) -> Surroundings:
    """The same surroundings, if this kind of agent can have their body.

    Raises:
        SettingsError: it cannot.
    """
    from dray.errors import SettingsError

    kinds = ("floor", *real)
    if where.settings.body not in kinds:
        reason = f"{where.settings.body} is no body of {agent}: give it {' or '.join(kinds)}"
        raise SettingsError("DRAY_BODY", reason)
    return where


def _grown(plant: Plant, file: Path, name: str) -> Plant:
    """The plant with a machine of another plant file.

    Raises:
        PlantError: that file cannot be used, or the machine does not fit into the plant of the others.
        SettingsError: that file lacks the machine, or the plant has it already.
    """
    from dray.cli.runtime.output import one_of
    from dray.errors import SettingsError
    from dray.plant import load_plant, with_machine

    spec = one_of(load_plant(file).machines, name, "NAME")
    if name in plant.machines:
        raise SettingsError("--joining", f"{name} is in the plant file already: start it without")
    return with_machine(plant, spec, str(file))


def _joining(plant: Plant, name: str, type_: str | None, node: str | None) -> VehicleSpec | None:
    """A joining vehicle that the plant file lacks; None without one.

    Raises:
        SettingsError: its description is incomplete, its type or node does not exist, or its name is invalid or taken.
    """
    from dray.cli.runtime.output import one_of
    from dray.errors import SettingsError
    from dray.plant.file.check import RESERVED
    from dray.plant.model import ID_RULE, VehicleSpec, is_id

    if type_ is None and node is None:
        return None
    if type_ is None or node is None:
        lacking, given = ("--type", "--node") if type_ is None else ("--node", "--type")
        reason = f"a joining vehicle needs it beside {given}; give neither for a vehicle of the plant file"
        raise SettingsError(lacking, reason)
    if name in plant.fleet:
        raise SettingsError(
            "NAME", f"{name} is in the plant file already: start it without --type and --node"
        )
    if name in plant.machines or name in plant.stores or name.lower() in RESERVED:
        raise SettingsError("NAME", f"{name} is somebody else in this plant: choose another id")
    if not is_id(name):
        raise SettingsError("NAME", f"{name!r} is no id; {ID_RULE}")
    return VehicleSpec(
        name,
        one_of(plant.vehicle_types, type_, "--type").id,
        one_of({stop: stop for stop in plant.stops}, node, "--node"),
    )


def _trusted(where: Surroundings) -> TrustedKeys:
    from dray.adapters.security.signing import TrustedKeys
    from dray.errors import SettingsError

    try:
        return TrustedKeys(*(bytes.fromhex(key) for key in where.settings.trusted_keys))
    except ValueError:
        reason = "holds something that is no public key in hex; `dray key signing` prints one"
        raise SettingsError("DRAY_TRUSTED_KEYS", reason) from None
