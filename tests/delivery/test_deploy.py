"""What is deployed: every part named is there, nothing is open to the world, and no secret stands in a file."""

from __future__ import annotations

import configparser
import json
import re
from ipaddress import ip_address, ip_network
from pathlib import Path
from typing import Any

import pytest
import yaml
from msgspec.structs import replace
from typer.testing import CliRunner

from dray.adapters.security.identity import Identity
from dray.adapters.security.seals import Seals
from dray.cli import app
from dray.cli.compose.document import compose_text, targets_text
from dray.cli.runtime.roster import agents_of
from dray.errors import SettingsError
from dray.messages.kinds import Kind
from dray.plant import Plant, default_plant, plant_yaml, shipped_plant
from dray.settings import PREFIX, Settings, host_and_port
from dray_sim.plants.generator import generate_plant

ROOT = Path(__file__).parents[2]
SECRETS = "/run/secrets/"

VARIABLES = {f"{PREFIX}{field.upper()}" for field in Settings.model_fields}


SMALL = generate_plant(2, machines=4, vehicles=3)
"""Any other plant than the default one."""


@pytest.fixture(scope="module", params=["default", "two-halls", "other"])
def plant(request: pytest.FixtureRequest) -> Plant:
    return SMALL if request.param == "other" else shipped_plant(request.param)


@pytest.fixture
def small_plant() -> Plant:
    return Plant(replace(SMALL.file, fleet=SMALL.file.fleet[:1]))


@pytest.fixture(scope="module")
def compose(plant: Plant) -> dict[str, Any]:
    seen = {"dray": "", SMALL.id: "./plants/own.yaml"}.get(plant.id, plant.id)
    loaded: dict[str, Any] = yaml.safe_load(compose_text(plant, seen))
    return loaded


@pytest.fixture(scope="module")
def services(compose: dict[str, Any]) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = compose["services"]
    return found


def stages() -> list[list[str]]:
    """The instructions of the Dockerfile's stages, continued lines joined."""
    lines = [
        line
        for line in (ROOT / "Dockerfile").read_text().replace("\\\n", " ").splitlines()
        if line and not line.startswith("#")
    ]
    found: list[list[str]] = []
    for line in lines:
        if line.startswith("FROM "):
            found.append([])
        elif not found:
            continue  # an argument of the stages' images
        found[-1].append(" ".join(line.split()))
    return found


def test_the_image_is_built_in_one_stage_and_runs_in_another_as_nobody_special() -> None:
    build, final = stages()
    assert all(stage[0].startswith("FROM ${PYTHON_IMAGE}") for stage in (build, final))
    default = re.search(r"^ARG PYTHON_IMAGE=(.*)$", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    assert default is not None
    assert re.fullmatch(r"[a-z]+:\d[\w.-]*", default[1]), "a version, never latest"
    assert any("install --directory --owner dray" in line and "journals" in line for line in final)
    assert any(line.startswith("COPY --from=build ") for line in final)
    # What is needed to build and to test does not get into what runs.
    assert not [line for line in final if "requirements-dev" in line]
    assert all(
        "--require-hashes" in line for line in (*build, *final) if "pip install" in line and "-r " in line
    )
    user = [line for line in final if line.startswith("USER ")]
    assert user == ["USER dray"]
    assert final.index("USER dray") < next(i for i, line in enumerate(final) if line.startswith("CMD "))
    assert any(line.startswith("HEALTHCHECK ") and "/readyz" in line for line in final)


def test_every_variable_of_ours_is_one_that_dray_knows(services: dict[str, dict[str, Any]]) -> None:
    named = {name for service in services.values() for name in service.get("environment", {})}
    texts = (ROOT / "Dockerfile").read_text() + (ROOT / "deploy/env.example").read_text()
    named |= set(re.findall(r"^(?:ENV )?(\w+)=", texts, re.MULTILINE))
    ours = {name for name in named if name.startswith(PREFIX)}
    assert "DRAY_DATABASE_URL" in ours
    assert ours <= VARIABLES


def test_the_files_in_the_repository_are_those_that_are_written_for_the_default_plant() -> None:
    written = "write them anew: dray compose"
    assert (ROOT / "docker-compose.yml").read_text() == compose_text(default_plant()), written
    assert (ROOT / "deploy/prometheus/targets.json").read_text() == targets_text(default_plant()), written


def test_every_agent_of_the_plant_has_a_process(plant: Plant, services: dict[str, dict[str, Any]]) -> None:
    wanted = [
        *(["dray", "agent", kind, name] for name, kind in agents_of(plant).items()),
        ["dray", "strategist"],
        ["dray", "historian"],
        ["dray", "floor"],
    ]
    commands = [service["command"] for service in services.values() if "build" in service]
    for command in wanted:
        assert commands.count(command) == 1, command
    (gateway,) = [command for command in commands if command not in wanted]
    assert gateway[:2] == ["dray", "gateway"]


def test_every_process_has_its_own_certificate_and_notes_that_outlive_its_container(
    plant: Plant, compose: dict[str, Any], services: dict[str, dict[str, Any]]
) -> None:
    seen: set[str] = set()
    for name, service in services.items():
        if "build" not in service:
            continue
        assert "DRAY_BUS_PLAIN" not in service["environment"]
        mounts = dict(mount.split(":", 1) for mount in service["volumes"])
        targets = {target: source for source, target in mounts.items()}
        own = Path(targets[service["environment"]["DRAY_BUS_CERTIFICATES"] + ":ro"])
        agent = service["command"][-1] if "agent" in service["command"] else service["command"][1]
        assert own == Path("certs") / agent, name
        journal = targets["/var/lib/dray/journals"]
        assert compose["volumes"][journal] == {"labels": ["dray.journal"]}
        seen |= {journal, str(own)}
        plant_file = service["environment"].get("DRAY_PLANT_FILE")
        if plant is SMALL:
            assert targets[f"{plant_file}:ro"] == "./plants/own.yaml"
        else:
            # The image has it.
            assert plant_file == (None if plant.id == default_plant().id else "two-halls")
            assert len(mounts) == 2
    assert len(seen) == 2 * len([service for service in services.values() if "build" in service])


def test_each_of_several_strategists_is_a_container_that_knows_how_many_there_are(small_plant: Plant) -> None:
    compose = yaml.safe_load(compose_text(small_plant, strategists=2))
    first, second = (compose["services"][name] for name in ("strategist", "strategist2"))
    assert (first["command"], second["command"]) == (
        ["dray", "strategist"],
        ["dray", "strategist", "strategist2"],
    )
    for name in ("strategist2", "gateway", "floor", "historian"):
        assert compose["services"][name]["environment"]["DRAY_STRATEGISTS"] == 2
    assert "journal-strategist2" in compose["volumes"]
    assert '"strategist2:9101"' in targets_text(small_plant, strategists=2)


def test_a_name_that_yaml_takes_for_something_else_stays_a_name(small_plant: Plant) -> None:
    (vehicle,) = small_plant.file.fleet
    fleet = (replace(vehicle, id="off"), replace(vehicle, id="Y"))
    services = yaml.safe_load(compose_text(Plant(replace(small_plant.file, fleet=fleet))))["services"]
    assert services["atv-off"]["command"] == ["dray", "agent", "atv", "off"]
    assert services["atv-y"]["command"] == ["dray", "agent", "atv", "Y"]


def test_two_agents_whose_names_differ_in_capitals_alone_are_told_apart_by_nobody(small_plant: Plant) -> None:
    (vehicle,) = small_plant.file.fleet
    fleet = (replace(vehicle, id="v1"), replace(vehicle, id="V1"))
    with pytest.raises(SettingsError, match="one name on a network"):
        compose_text(Plant(replace(small_plant.file, fleet=fleet)))


def test_compose_writes_what_is_missing_and_nothing_else(small_plant: Plant, tmp_path: Path) -> None:
    folder, plant_file = tmp_path / "sources", tmp_path / "sources/small.yaml"
    (folder / "deploy/prometheus").mkdir(parents=True)
    command = ("compose", "--plant", str(plant_file), "--folder", str(folder))
    plant_file.write_text(plant_yaml(small_plant))
    refused = CliRunner().invoke(app, command)
    assert isinstance(refused.exception, SettingsError)
    (folder / "deploy/prometheus/prometheus.yml").touch()
    assert CliRunner().invoke(app, command).exit_code == 0
    assert (folder / "docker-compose.yml").read_text() == compose_text(small_plant, "./small.yaml")
    for agent, kind in {**agents_of(small_plant), "floor": Kind.HISTORIAN, "gateway": Kind.GATEWAY}.items():
        identity = Identity.in_folder(folder / "certs" / agent, agent)
        assert Seals(identity, small_plant.id).agents[agent] is kind
        assert sorted(file.name for file in (folder / "certs" / agent).iterdir()) == sorted(
            ("authority.pem", f"{agent}.key", f"{agent}.pem")
        )
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    (folder / "certs/revoked.pem").write_bytes(b"list")
    (folder / "certs/strategist/strategist.pem").unlink()
    assert "1 certificates made" in CliRunner().invoke(app, command).output
    changed = {file for file, data in before.items() if file.read_bytes() != data}
    assert {file.name for file in changed} == {"strategist.pem", "strategist.key", "authority.issued"}
    assert (folder / "certs/floor/revoked.pem").read_bytes() == b"list"
    other = plant_file.with_name("other.yaml")
    other.write_text(plant_yaml(Plant(replace(small_plant.file, plant="other"))))
    refused = CliRunner().invoke(app, ("compose", "--plant", str(other), "--folder", str(folder)))
    assert isinstance(refused.exception, SettingsError)


def test_every_process_is_on_the_bus_and_calls_some_that_are(services: dict[str, dict[str, Any]]) -> None:
    for name, service in services.items():
        if "build" in service:
            assert "bus" in service["networks"], name
            for peer in service["environment"]["DRAY_BUS_PEERS"].split(","):
                host, port = peer.split(":")
                assert "build" in services[host]
                assert service["environment"]["DRAY_BUS_LISTEN"].endswith(f":{port}")
        for other in service.get("depends_on", {}):
            assert set(service["networks"]) & set(services[other]["networks"]), (name, other)


def test_services_are_reached_from_this_machine_only(
    compose: dict[str, Any], services: dict[str, dict[str, Any]]
) -> None:
    assert compose["networks"]["bus"] == {"internal": True}
    published = [port for service in services.values() for port in service.get("ports", ())]
    assert len(published) >= 3
    assert "ports" not in services["gateway"], "people reach it by TLS"
    for port in published:
        assert re.fullmatch(r"127\.0\.0\.1:\d+:\d+", port)
    assert "ports" not in services["database"]


def test_services_come_back_and_say_how_they_are(services: dict[str, dict[str, Any]]) -> None:
    for name, service in services.items():
        assert service["restart"] == "unless-stopped", name
        assert ("image" in service and ":" in service["image"]) or "build" in service, name
        assert not service.get("image", "").endswith(":latest") or "build" in service, name
        # Agents watch one another; nobody waits for the traces.
        if "build" not in service and name != "traces":
            assert service["healthcheck"]["test"][0] == "CMD", name
        for other, how in service.get("depends_on", {}).items():
            assert how["condition"] == "service_healthy"
            assert services[other]["healthcheck"]["test"][0] == "CMD"


def test_a_container_can_write_what_it_must_keep_and_nothing_else(
    services: dict[str, dict[str, Any]],
) -> None:
    for name, service in services.items():
        assert "no-new-privileges:true" in service["security_opt"], name
        # Compose refuses a secret from a variable in a container that cannot be written.
        secret = bool(service.get("secrets"))
        assert service.get("read_only", False) is not secret, name
        if name != "database":  # which gives its rights away by itself
            assert service["cap_drop"] == ["ALL"], name
        if "build" in service:
            assert [mount for mount in service["volumes"] if mount.endswith(":/var/lib/dray/journals")], name


def test_images_are_pinned_by_digest_or_can_be(services: dict[str, dict[str, Any]]) -> None:
    for name, service in services.items():
        if "build" not in service:
            pinned = re.fullmatch(r"[\w./-]+:[\w.-]+@sha256:[0-9a-f]{64}", service["image"])
            setting = re.fullmatch(r"\$\{\w+_IMAGE:-[\w./-]+:[\w.-]+\}", service["image"])
            assert pinned or setting, name
        else:
            assert service["build"]["args"] == {"PYTHON_IMAGE": "${PYTHON_IMAGE:-python:3.11-slim}"}


def test_the_front_ends_tls_and_the_gateway_believes_it_alone(
    compose: dict[str, Any], services: dict[str, dict[str, Any]]
) -> None:
    front, gateway = services["front"], services["gateway"]
    address = front["networks"]["front"]["ipv4_address"]
    assert gateway["environment"]["DRAY_TRUSTED_PROXIES"] == address
    (pool,) = compose["networks"]["front"]["ipam"]["config"]
    assert ip_address(address) in ip_network(pool["subnet"])
    # Nobody else could say to come from that address.
    assert {name for name, each in services.items() if "front" in each["networks"]} == {"front", "gateway"}
    text = (ROOT / "deploy/caddy/Caddyfile").read_text()
    assert "reverse_proxy gateway:8000" in text
    environment = gateway["environment"]
    assert f"reverse_proxy gateway:{environment['DRAY_STOP_PORT']}" in text
    stops = environment["DRAY_STOP_URL"].rpartition(":")[2]
    assert f"https://{{$PANEL_NAME}}:{stops} {{" in text
    assert f"127.0.0.1:{stops}:{stops}" in front["ports"]
    assert set(re.findall(r"\{\$(\w+)", text)) == set(front["environment"])
    (_, port), published = front["healthcheck"]["test"][-1].rstrip("/").rsplit(":", 1), front["ports"]
    assert f"http://127.0.0.1:{port}" in text
    assert not [each for each in published if each.endswith(f":{port}")]


def test_volumes_and_secrets_are_declared_and_used(
    compose: dict[str, Any], services: dict[str, dict[str, Any]]
) -> None:
    mounts = [
        mount.split(":")
        for service in services.values()
        for mount in service.get("volumes", ())
        if not mount.startswith("/")  # the container's own
    ]
    named = {source for source, *_ in mounts if not source.startswith(".")}
    assert named == set(compose["volumes"])
    for source, _, *options in (mount for mount in mounts if mount[0].startswith(".")):
        # The last two are a user's own.
        assert (ROOT / source).is_dir() or source.startswith(("./certs/", "./plants/")), source
        assert options == ["ro"]
    used = {secret for service in services.values() for secret in service.get("secrets", ())}
    assert used == set(compose["secrets"])


def test_no_secret_stands_in_a_file(compose: dict[str, Any], services: dict[str, dict[str, Any]]) -> None:
    example = dict(
        line.split("=", 1)
        for line in (ROOT / "deploy/env.example").read_text().splitlines()
        if line and not line.startswith("#")
    )
    for name, secret in compose["secrets"].items():
        assert list(secret) == ["environment"], name
        assert example[secret["environment"]] == ""
    for name, service in services.items():
        for variable, value in service.get("environment", {}).items():
            if re.search("PASSWORD|TOKEN|SECRET", variable):
                assert variable.endswith("_FILE"), f"{name}: {variable}"
            if variable.endswith("_FILE") and variable != "DRAY_PLANT_FILE":
                assert value.removeprefix(SECRETS) in service["secrets"]
            for used in re.findall(r"\$\{(\w+)", str(value)):
                assert used in example
    ours = set(services["gateway"]["secrets"])
    assert {name.upper() for name in ours} <= VARIABLES, "read as files: see `dray.settings.SECRETS`"
    for ignored in (".gitignore", ".dockerignore"):
        assert ".env" in (ROOT / ignored).read_text().splitlines()


def test_prometheus_asks_every_process_where_it_listens(
    plant: Plant, compose: dict[str, Any], services: dict[str, dict[str, Any]]
) -> None:
    folder = ROOT / "deploy/prometheus"
    configuration = yaml.safe_load((folder / "prometheus.yml").read_text())
    (job,) = configuration["scrape_configs"]
    assert job["file_sd_configs"] == [{"files": ["targets.json"]}]
    ours = {name: service for name, service in services.items() if "build" in service}
    listens = {
        f"{name}:{host_and_port(service['environment']['DRAY_METRICS_LISTEN'])[1]}"
        for name, service in ours.items()
    }
    (told,) = json.loads(targets_text(plant))
    assert set(told["targets"]) == listens
    assert len(listens) == len(ours)
    # Nobody logs in there, so the network is for nothing else.
    shared = {name for name, service in services.items() if "metrics" in service.get("networks", ())}
    assert shared == {*ours, "prometheus"}
    assert compose["networks"]["metrics"] == {"internal": True}
    (relabelled,) = job["relabel_configs"]
    assert re.fullmatch(relabelled["regex"], "machine-m1:9101")[1] == "machine-m1"  # type: ignore[index]
    for rules in configuration["rule_files"]:
        assert (folder / rules).is_file()


def test_grafana_finds_its_source_and_its_board(services: dict[str, dict[str, Any]]) -> None:
    folder = ROOT / "deploy/grafana"
    (source,) = yaml.safe_load((folder / "provisioning/datasources/prometheus.yml").read_text())[
        "datasources"
    ]
    assert source["url"] == "http://prometheus:9090"
    (provider,) = yaml.safe_load((folder / "provisioning/dashboards/boards.yml").read_text())["providers"]
    mounted = {mount.split(":")[1]: mount.split(":")[0] for mount in services["grafana"]["volumes"]}
    boards = ROOT / mounted[provider["options"]["path"]]
    home = services["grafana"]["environment"]["GF_DASHBOARDS_DEFAULT_HOME_DASHBOARD_PATH"]
    board = json.loads((boards / Path(home).name).read_text())
    (variable,) = board["templating"]["list"]
    assert variable["current"]["value"] == source["uid"]


def test_the_unit_of_a_vehicle_brings_its_agent_back_and_may_do_little() -> None:
    unit = configparser.ConfigParser(interpolation=None)
    unit.optionxform = str  # type: ignore[assignment,method-assign]  # the names are written in this way
    unit.read(ROOT / "deploy/systemd/dray-atv@.service")
    service = unit["Service"]
    assert service["ExecStart"] == "/opt/dray/bin/dray agent atv %i"
    # Whoever wants it known elsewhere says so in the file, which wins.
    assert service["Environment"] == "DRAY_METRICS_LISTEN=127.0.0.1:9101"
    assert service["Type"] == "notify"
    assert service["Restart"] == "always"
    assert unit["Unit"]["StartLimitIntervalSec"] == "0"
    assert service["User"] not in {"", "root"}
    for hardened in ("NoNewPrivileges", "ProtectHome", "PrivateTmp"):
        assert service[hardened] == "true"
    assert service["ProtectSystem"] == "strict"
    assert service["CapabilityBoundingSet"] == ""
