"""Agents: checks that each one of the plant file is heard, and that its body answers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import msgspec

from dray.cli.runtime.ready.answers import Agent, Alert, Answers, Picture
from dray.cli.runtime.ready.finding import Finding, missing, named, ok, unknown
from dray.messages.keys import GATE
from dray.plant import Plant

BESIDE = frozenset({"products", "machines"})
"""Parts of a plant file that may differ in a running plant: people define products there, and machines join."""


def plant_of_gateway(plant: Plant, answers: Answers) -> Finding:
    """Whether the gateway serves this plant, and not a simulated one."""
    name, picture = "plant of the gateway", answers.picture
    file = msgspec.json.decode(msgspec.json.encode(plant.file))
    if picture.plant != plant.id:
        seen = f"it serves {picture.plant}, but the plant of this file is {plant.id}"
    elif picture.fault_injection:
        seen = "it is simulated: people may cause faults there"
    elif picture.factory.speed != 1.0:
        seen = f"its clock runs at {picture.factory.speed:g} times real time"
    else:
        theirs = answers.plant
        fields = sorted(key for key in {*file, *theirs} - BESIDE if file.get(key) != theirs.get(key))
        if not fields:
            return ok(name, f"{plant.id}, in real time")
        seen = f"its plant file differs from this one in {named(fields)}"
    return missing(
        name, seen, "start the gateway and all agents with DRAY_PLANT_FILE=FILE, and simulate nothing"
    )


def agents(plant: Plant, strategists: Iterable[str], answers: Answers) -> Iterator[Finding]:
    """Whether every machine, storage and vehicle, the gate and the strategist are heard.

    Args:
        plant: the plant.
        strategists: all strategists, by id.
        answers: the gateway's answers.
    """
    picture, alerts = answers.picture, answers.picture.alerts
    heard = picture.agents()
    yield _kind(
        "machines",
        plant.machines,
        picture,
        heard,
        "dray agent machine NAME --body opcua --mapping NAME.yaml, or --body mqtt, or --body people",
    )
    yield _kind(
        "storages and warehouses",
        plant.stores,
        picture,
        heard,
        "dray agent station NAME --body opcua --mapping NAME.yaml, or --body mqtt, or --body controller",
    )
    yield _kind(
        "gate",
        (GATE,),
        picture,
        heard,
        "dray agent gate --body opcua --mapping gate.yaml, or --body mqtt, or --body controller, or --body people",
    )
    yield _kind(
        "vehicles",
        plant.fleet,
        picture,
        heard,
        "dray agent atv NAME --body vda5050 --broker URL --manufacturer MAKER --serial SERIAL",
    )
    yield _strategists(tuple(strategists), answers, alerts)


def _kind(name: str, wanted: Iterable[str], picture: Picture, heard: dict[str, Agent], start: str) -> Finding:
    all_ = list(wanted)
    lacks: dict[str, list[str]] = {}
    for each in all_:
        if reason := _lack(heard.get(each), picture):
            lacks.setdefault(reason, []).append(each)
    if lacks:
        seen = "; ".join(f"{reason}: {named(names)}" for reason, names in lacks.items())
        todo = f"on its computer: {start}; while it waits for its body, its log says why"
        if "shut out" in lacks:
            todo += "; dray readmit NAME admits it again"
        return missing(name, seen, todo)
    out = [each for each in all_ if heard[each].out_of_service is not None]
    away = f"; out of service: {named(out)}" if out else ""
    return ok(name, f"all {len(all_)} are heard{away}" if len(all_) != 1 else f"{all_[0]} is heard{away}")


def _lack(agent: Agent | None, picture: Picture) -> str:
    """Why an agent does not take part; empty where it does."""
    if agent is None:
        return "never heard"
    if agent.shut_out is not None:
        return "shut out"
    if agent.removal is not None:
        return "reported as off the floor"
    if (picture.at_s - agent.seen_at_s) * picture.factory.speed > agent.silence.lost_after_s:
        return "silent"
    return ""


def _strategists(wanted: tuple[str, ...], answers: Answers, alerts: Iterable[Alert]) -> Finding:
    name, part = "strategist", answers.parts.get("strategist")
    todo = f"on its computer: {'; '.join(f'dray strategist {each}' for each in wanted)}"
    if part is None:
        return unknown(name, "the gateway reports nothing about it", todo)
    lost = any(each.kind == "strategist_lost" for each in alerts)
    if not part.ok or part.reason or lost:
        return missing(name, part.reason or "one of several is silent", todo)
    return ok(name, "it is heard")


def bodies(plant: Plant, answers: Answers) -> Finding:
    """Whether the bodies of machines, vehicles and the gate answer: a silent body is a problem of its agent."""
    name, heard = "bodies", answers.picture.agents()
    wanted = [each for each in (*plant.machines, *plant.fleet) if not _lack(heard.get(each), answers.picture)]
    broken = [
        f"{each} ({heard[each].problem or heard[each].status})"
        for each in (*wanted, *([] if _lack(heard.get(GATE), answers.picture) else [GATE]))
        if heard[each].problem or heard[each].status == "error"
    ]
    if broken:
        todo = "dray machine check NAME --mapping NAME.yaml --plant FILE, dray vehicle status NAME; then clear the fault at the tablet"
        return missing(name, f"with a problem: {named(broken)}", todo)
    if not wanted:
        return unknown(name, "no machine and no vehicle is heard")
    people = [each for each in wanted if heard[each].unconfirmed is not None]
    by_people = f"; operated by people: {named(people)}" if people else ""
    return ok(name, f"{len(wanted)} machines and vehicles report no problem{by_people}")
