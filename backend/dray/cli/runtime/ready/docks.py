"""Docks and the gate: checks by mapping files and the running plant that each dock signals readiness before a vehicle loads there."""

from __future__ import annotations

from pathlib import Path

from dray.adapters.mapping_file import has_address, load_mapping
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import Signal, SignalMapping
from dray.cli.runtime.ready.answers import Answers
from dray.cli.runtime.ready.finding import Finding, missing, named, ok, unknown
from dray.errors import SettingsError
from dray.messages.keys import GATE
from dray.plant import Plant

NAME = "docks"


def docks(plant: Plant, mappings: Path | None, answers: Answers | None) -> Finding:
    """Whether docks have a handshake, and the gate a mapping. A missing handshake is no fault: vehicles load as soon as they stand there.

    Args:
        plant: its machines and storages have docks.
        mappings: the folder of the controllers' mapping files, each named as its machine or storage, or as the gate; None for none.
        answers: the gateway's answers; None where it does not answer.
    """
    late: list[str] = []
    people: list[str] = []
    places = (*plant.machines, *plant.stores)
    if answers is not None:
        heard = answers.picture.agents()
        late = [each.agent for each in answers.picture.alerts if each.kind == "dock_not_ready"]
        people = [each for each in (*places, GATE) if each in heard and heard[each].unconfirmed is not None]
    known: dict[str, SignalMapping] = {}
    faults: list[str] = []
    for place in (*places, GATE):
        file = None if mappings is None else mappings / f"{place}.yaml"
        if file is not None and file.is_file() and place not in people:
            try:
                known[place] = _mapping(plant, place, file)
            except SettingsError as error:
                faults.append(error.reason)
    check = "dray machine check NAME --mapping NAME.yaml --plant FILE"
    wrong = [f"a vehicle waits there, and the dock is not ready: {named(late)}"] if late else []
    wrong += [f"a mapping cannot be used: {'; '.join(faults)}"] if faults else []
    if wrong:
        return missing(
            NAME, "; ".join(wrong), f"{check} --dock; see dock_ready in its controller" if late else check
        )
    told = _told(known, people)
    rest = [each for each in (*places, GATE) if each not in known and each not in people]
    if rest:
        todo = f"--mappings FOLDER, with a NAME.yaml for each; {check} --dock tests one while no vehicle stands there"
        return unknown(NAME, "; ".join(("unknown: " + named(rest), *told)), todo)
    return ok(NAME, "; ".join(told))


def _told(known: dict[str, SignalMapping], people: list[str]) -> list[str]:
    docked = {each: mapping for each, mapping in known.items() if each != GATE}
    shaking = [each for each, mapping in docked.items() if Signal.DOCK_READY in mapping.signals]
    bare = [each for each in docked if each not in shaking]
    switched = [
        f"{each} ({item})"
        for each, mapping in docked.items()
        for item, tag in mapping.levels.items()
        if tag.at_least is not None
    ]
    told = [f"with a handshake: {named(shaking)}"] if shaking else []
    if bare:
        told.append(f"without a handshake: {named(bare)} (vehicles load as soon as they stand there)")
    if by_people := [each for each in people if each != GATE]:
        told.append(f"without a handshake: {named(by_people)} (people and vehicles report loads)")
    if switched:
        told.append(f"with a switch for a level: {named(switched)} (it bounds the stock, and counts nothing)")
    if GATE in known:
        told.append(f"the {GATE} counts by its mapping")
    if GATE in people:
        told.append(f"people count at the {GATE}")
    return told


def _mapping(plant: Plant, place: str, file: Path) -> SignalMapping:
    """The mapping of a machine, a storage or the gate.

    Raises:
        SettingsError: it cannot be used.
    """
    mapping = load_mapping(file, OpcUaMapping if has_address(file) else MqttMapping)
    try:
        if place == GATE:
            mapping.check_gate()
        elif place in plant.machines:
            mapping.check_machine()
        else:
            mapping.check_store({each.material: each.capacity for each in plant.stores[place].stocks})
    except ValueError as error:
        raise SettingsError("--mappings", f"{file}: {error}") from None
    return mapping
