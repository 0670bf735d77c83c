"""The compose file of a plant, and its companions: text alone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files

import msgspec
from jinja2 import Environment, StrictUndefined

from dray.cli.runtime.roster import agents_of
from dray.errors import SettingsError
from dray.messages.keys import strategists_of
from dray.messages.kinds import Kind
from dray.plant import Plant

COMPOSE_MIN = "2.26"
"""The oldest Compose version tested with these files (`docker compose config`)."""

CERTIFICATES = "certs"
"""The folder beside the compose file with a folder of certificates for each process."""

METRICS_PORT = 9101

SINGLE = ("gateway", "historian", "strategist", "floor")
"""Processes that exist once in every plant."""

JOURNALS = "/var/lib/dray/journals"


@dataclass(frozen=True, slots=True)
class Service:
    """One process of a plant in its compose file.

    Attributes:
        name: the service's name, by which others call it.
        agent: the agent in its certificate.
        kind: the argument of `dray agent`; empty for one of `SINGLE`.
    """

    name: str
    agent: str
    kind: Kind | None = None

    @property
    def journal(self) -> str:
        """The volume of its journal, which outlives its containers."""
        return f"journal-{self.name}"

    def mounts(self, plant_file: str) -> str:
        """Its own mounts, in YAML: journal, certificates, and the plant file where it is not the default one."""
        own = [f"{self.journal}:{JOURNALS}", f"./{CERTIFICATES}/{self.agent}:/etc/dray/certs:ro"]
        if _is_mounted(plant_file):
            own.append(f"{plant_file}:/etc/dray/plant.yaml:ro")
        return ", ".join(msgspec.json.encode(each.replace("$", "$$")).decode() for each in own)


def services_of(plant: Plant, strategists: int = 1) -> tuple[Service, ...]:
    """All processes of a plant.

    Args:
        plant: the plant.
        strategists: number of strategists.

    Raises:
        SettingsError: two would have one name on the network, which ignores case.
    """
    single = [Service(name, name) for name in (*SINGLE, *strategists_of(strategists)[1:])]
    agents = [
        Service(agent if agent == kind else f"{kind}-{agent}".lower(), agent, kind)
        for agent, kind in agents_of(plant).items()
    ]
    called: dict[str, str] = {}
    for each in agents:
        other = called.setdefault(each.name, each.agent)
        if other != each.agent:
            raise SettingsError(
                each.agent, f"and {other} would have one name on a network: give one of them another id"
            )
    return (*single, *agents)


def compose_text(plant: Plant, plant_file: str = "", strategists: int = 1) -> str:
    """`docker-compose.yml` of a plant.

    Args:
        plant: the plant; each agent gets a service.
        plant_file: its path relative to the compose file, as `./plant.yaml`; or the name of a shipped plant, which the
            image contains; empty for the default plant.
        strategists: number of strategists.

    Raises:
        SettingsError: see `services_of`.
    """
    services = services_of(plant, strategists)
    template = files("dray.cli.compose").joinpath("template.yml").read_text(encoding="utf-8")
    command = ["dray compose"]
    command += [f"--plant {plant_file}"] * bool(plant_file) + [f"--strategists {strategists}"] * (
        strategists > 1
    )
    # There is no HTML here; quoting uses JSON, which YAML reads.
    jinja = Environment(
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,  # noqa: S701
    )
    return jinja.from_string(template).render(
        command=" ".join(command),
        strategists=strategists_of(strategists),
        compose_min=COMPOSE_MIN,
        project=re.sub(r"[^a-z0-9_-]", "-", plant.id.lower()),
        plant_file="/etc/dray/plant.yaml" if _is_mounted(plant_file) else plant_file,
        single={each.agent: each.mounts(plant_file) for each in services if each.kind is None},
        agents=[
            {
                "service": each.name,
                "kind": each.kind,
                "agent": each.agent,
                "mounts": each.mounts(plant_file),
            }
            for each in services
            if each.kind is not None
        ],
        journals=[each.journal for each in services],
    )


def _is_mounted(plant_file: str) -> bool:
    """Whether it is a file beside the compose file, instead of one in the image."""
    return plant_file.startswith(".")


def targets_text(plant: Plant, strategists: int = 1) -> str:
    """The metrics addresses of all processes, in Prometheus' format (`file_sd_configs`).

    Raises:
        SettingsError: see `services_of`.
    """

    def lines() -> Iterator[str]:
        for each in services_of(plant, strategists):
            yield f'    "{each.name}:{METRICS_PORT}"'

    return '[{"targets": [\n' + ",\n".join(lines()) + "\n]}]\n"
