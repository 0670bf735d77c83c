"""Docks: checks by mapping files and the running plant that each signals readiness before a vehicle loads there."""

from __future__ import annotations

from pathlib import Path

from dray.adapters.mapping_file import has_address, load_mapping
from dray.adapters.mqtt.mapping_file import MqttMapping
from dray.adapters.opcua.mapping_file import OpcUaMapping
from dray.adapters.signals.signal import Signal
from dray.cli.runtime.ready.answers import Answers
from dray.cli.runtime.ready.finding import Finding, missing, named, ok, unknown
from dray.errors import SettingsError
from dray.plant import Plant

NAME = "docks"


def docks(plant: Plant, mappings: Path | None, answers: Answers | None) -> Finding:
    """Whether docks have a handshake. A missing one is no fault: vehicles load as soon as they stand there.

    Args:
        plant: its machines and storages have docks.
        mappings: the folder of the controllers' mapping files, each named as its machine or storage; None for none.
        answers: the gateway's answers; None where it does not answer.
    """
    late: list[str] = []
    people: list[str] = []
    if answers is not None:
        heard = answers.picture.agents()
        late = [each.agent for each in answers.picture.alerts if each.kind == "dock_not_ready"]
        people = [each for each in plant.machines if each in heard and heard[each].unconfirmed is not None]
    check = "dray machine check NAME --mapping NAME.yaml --plant FILE"
    if late:
        seen = f"a vehicle waits there, and the dock is not ready: {named(late)}"
        return missing(NAME, seen, f"{check} --dock; see dock_ready in its controller")
    known: dict[str, bool] = {}
    faults: list[str] = []
    for place in (*plant.machines, *plant.stores):
        file = None if mappings is None else mappings / f"{place}.yaml"
        if file is not None and file.is_file() and place not in people:
            try:
                known[place] = _shakes_hands(plant, place, file)
            except SettingsError as error:
                faults.append(error.reason)
    if faults:
        return missing(NAME, f"a mapping cannot be used: {'; '.join(faults)}", check)
    told = _told(known, people)
    rest = [each for each in (*plant.machines, *plant.stores) if each not in known and each not in people]
    if rest:
        todo = f"--mappings FOLDER, with a NAME.yaml for each; {check} --dock tests one while no vehicle stands there"
        return unknown(NAME, "; ".join(("unknown: " + named(rest), *told)), todo)
    return ok(NAME, "; ".join(told))


def _told(known: dict[str, bool], people: list[str]) -> list[str]:
    shaking = [each for each, shakes in known.items() if shakes]
    bare = [each for each, shakes in known.items() if not shakes]
    told = [f"with a handshake: {named(shaking)}"] if shaking else []
    if bare:
        told.append(f"without a handshake: {named(bare)} (vehicles load as soon as they stand there)")
    if people:
        told.append(f"without a handshake: {named(people)} (people and vehicles report loads)")
    return told


def _shakes_hands(plant: Plant, place: str, file: Path) -> bool:
    """Whether the controller of a machine or a storage signals that its dock is safe.

    Raises:
        SettingsError: its mapping cannot be used.
    """
    mapping = load_mapping(file, OpcUaMapping if has_address(file) else MqttMapping)
    try:
        if place in plant.machines:
            mapping.check_machine()
        else:
            mapping.check_store({each.material for each in plant.stores[place].stocks})
    except ValueError as error:
        raise SettingsError("--mappings", f"{file}: {error}") from None
    return Signal.DOCK_READY in mapping.signals
