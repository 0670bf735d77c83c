"""All findings of a plant, in the order of bringing it into service."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from dray.cli.runtime.ready.agents import agents, bodies, plant_of_gateway
from dray.cli.runtime.ready.answers import Answers, Client, Ready, ask
from dray.cli.runtime.ready.certificates import certificates
from dray.cli.runtime.ready.computer import clocks, disks
from dray.cli.runtime.ready.database import database
from dray.cli.runtime.ready.docks import docks
from dray.cli.runtime.ready.finding import Finding, missing, named, ok, unknown
from dray.cli.runtime.ready.people import people_and_keys
from dray.cli.runtime.roster import certified_of
from dray.errors import UnavailableError
from dray.messages.keys import strategists_of
from dray.plant import Plant, sum_up
from dray.plant.planning.advice import advice
from dray.settings import Settings

ASKED = (
    *(
        "plant of the gateway",
        "machines",
        "storages and warehouses",
        "gate",
        "vehicles",
        "strategist",
    ),
    *("bodies", "managers", "operators", "API keys", "people on duty"),
)
"""Requirements that only a gateway can answer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewpoint:
    """The sources for the checks.

    Attributes:
        file: the plant file, as commands name it.
        settings: this computer's settings.
        client: asks the gateway.
        url: the gateway's address, for people.
        has_token: whether requests carry a token.
        certificates: the folder of their creation; None for that of the settings.
        mappings: the folder of the mapping files of controllers; None for none.
        wall_s: this computer's wall clock.
        ntp: whether that is synchronised; None if unknown.
        free_bytes: free space on the disk of a folder.
    """

    file: str
    settings: Settings
    client: Client
    url: str
    has_token: bool
    certificates: Path | None
    mappings: Path | None
    wall_s: Callable[[], float]
    ntp: Callable[[], bool | None]
    free_bytes: Callable[[Path], int]


async def findings(plant: Plant, here: Viewpoint) -> list[Finding]:
    """All findings about a plant, with commands for this plant file.

    Raises:
        SettingsError: the gateway does not know the asker, or the asker may not see the whole plant.
    """
    return [replace(each, todo=each.todo.replace("FILE", here.file)) async for each in _all(plant, here)]


async def _all(plant: Plant, here: Viewpoint) -> AsyncIterator[Finding]:
    settings = here.settings
    yield _file(plant)
    strategists = strategists_of(settings.strategists)
    wanted = certified_of(plant, strategists, settings.gateway_name)
    yield certificates(plant.id, wanted, settings, here.certificates, here.wall_s())
    async for finding in database(settings, here.wall_s()):
        yield finding
    for finding in disks(plant, settings, here.free_bytes):
        yield finding
    said, answers = _gateway(here)
    for finding in clocks(answers, here.ntp):
        yield finding
    yield docks(plant, here.mappings, answers)
    yield said
    if answers is None:
        for name in ASKED:
            yield unknown(name, "only the gateway knows")
        return
    yield plant_of_gateway(plant, answers)
    for finding in agents(plant, strategists, answers):
        yield finding
    yield bodies(plant, answers)
    for finding in people_and_keys(plant, answers, here.wall_s()):
        yield finding


def _file(plant: Plant) -> Finding:
    found = advice(plant)
    errors = [each for each in found if each.level == "error"]
    if errors:
        return missing(
            "plant file", "; ".join(f"{each.field}: {each.text}" for each in errors), "dray plant check FILE"
        )
    warned = f"; warnings: {named(dict.fromkeys(each.kind for each in found))}" if found else ""
    return ok("plant file", sum_up(plant) + warned, "dray plant check FILE" if found else "")


def _gateway(here: Viewpoint) -> tuple[Finding, Answers | None]:
    start = "start dray gateway, or name its address with --gateway"
    try:
        if not here.has_token:
            here.client.ask("GET", "/readyz", Ready)
            seen = f"{here.url} takes orders; without a token it tells no more"
            return unknown("gateway", seen, "--token TOKEN or DRAY_ADMIN_TOKEN"), None
        answers = ask(here.client, here.wall_s)
    except UnavailableError as error:
        return missing("gateway", f"{error.what}: {error.reason}", start), None
    return ok("gateway", f"{here.url} takes orders"), answers


def lines(found: list[Finding]) -> Iterator[str]:
    """The findings for people: an unmet requirement has a line with the remedy."""
    width = max(len(each.name) for each in found)
    for each in found:
        yield f"{each.verdict:8} {each.name:{width}}  {each.seen}"
        if each.todo:
            yield f"{'':8} {'':{width}}  -> {each.todo}"
