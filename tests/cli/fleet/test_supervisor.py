"""What `dray fleet up` makes of its options and of the environment."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from dray.cli.fleet.folder import forget_controllers, read_settings, write_settings
from dray.cli.fleet.process_specs import specs_of
from dray.cli.fleet.supervisor import FleetOptions, _common_environment
from dray.plant import default_plant
from dray.settings import Settings
from dray.store import open_store

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def supervised(monkeypatch: pytest.MonkeyPatch) -> list[FleetOptions]:
    """The fleets that were to be started; none is."""
    asked: list[FleetOptions] = []

    async def note(options: FleetOptions) -> None:
        asked.append(options)

    monkeypatch.setattr("dray.cli.fleet.supervisor.run_fleet", note)
    return asked


def test_the_database_is_the_options_the_environments_or_the_folders(
    call: Call, supervised: list[FleetOptions], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("DRAY_DATABASE_URL", raising=False)
    call("fleet", "up", "--folder", tmp_path)
    monkeypatch.setenv("DRAY_DATABASE_URL", "postgresql://dray@db/factory")
    call("fleet", "up", "--folder", tmp_path)
    call("fleet", "up", "--folder", tmp_path, "--db", "sqlite:///other.db")
    assert [each.settings.database_url for each in supervised] == [
        f"sqlite+aiosqlite:///{tmp_path / 'dray.db'}",
        "postgresql+asyncpg://dray@db/factory",
        "sqlite+aiosqlite:///other.db",
    ]


def test_a_fleet_with_controllers_begins_with_none_and_its_agents_wait_for_theirs(
    call: Call, supervised: list[FleetOptions], tmp_path: Path
) -> None:
    call("fleet", "up", "--folder", tmp_path, "--opcua")
    assert [each.opcua for each in supervised] == [True]
    plant = default_plant()
    files = [tmp_path / "controllers" / f"{name}.yaml" for name in ("M8", "S1", "gate")]
    files += [tmp_path / "journals" / f"{name}.json" for name in ("M8.workcell", "S1.store", "gate.signals")]
    other = tmp_path / "journals" / "M8-elsewhere.workcell.json"
    for file in (*files, other):
        file.parent.mkdir(exist_ok=True)
        file.touch()
    forget_controllers(tmp_path, plant)
    assert [file.exists() for file in (*files, other)] == [*[False] * len(files), True]
    specs = specs_of(plant, ("strategist",), tmp_path, {}, {}, demand=False, metrics=False, opcua=True)
    told = {spec.name: (spec.command, spec.environment.get("DRAY_BODY", "")) for spec in specs}
    assert told["floor"] == (("floor", "--opcua", str(tmp_path / "controllers")), "")
    assert told["M8"] == (("agent", "machine", "M8"), "opcua")
    assert told["S1"] == (("agent", "station", "S1"), "opcua")
    assert told["gate"] == (("agent", "gate", "gate"), "opcua")
    assert told["ATV1"] == (("agent", "atv", "ATV1"), "")


def test_controllers_need_what_is_not_always_installed(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    code, _, err = call("fleet", "up", "--opcua")
    assert code == 2
    assert "dray[opcua]" in err


def test_a_fleet_begins_without_a_memory_once_and_no_process_that_starts_later_does(tmp_path: Path) -> None:
    """What the fleet before it left open has ended; what a gateway finds that starts again goes on."""
    settings = Settings.load(database_url=f"sqlite:///{tmp_path / 'dray.db'}")
    options = FleetOptions(
        settings, default_plant(), tmp_path, speed=1.0, plain=True, demand=False, metrics=False
    )

    async def fleet_then_gateway() -> list[int]:
        await _common_environment(options, tmp_path, port=8000)
        store = await open_store(settings.database_url)
        try:
            later = await store.next_incarnation(options.plant.id)
            async with store.read() as work:
                begun = [each.incarnation for each in await work.beginnings.all()]
        finally:
            await store.close()
        return [*begun, later]

    assert asyncio.run(fleet_then_gateway()) == [1, 2]
    assert asyncio.run(fleet_then_gateway()) == [1, 3, 4]


def test_what_the_environment_says_of_one_process_is_not_said_of_a_fleet(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("DRAY_BUS_CERTIFICATES", "/etc/dray/certs")
    monkeypatch.setenv("DRAY_GATEWAY_NAME", "gateway2")
    settings = Settings.load(database_url=f"sqlite:///{tmp_path / 'dray.db'}")
    options = FleetOptions(
        settings, default_plant(), tmp_path, speed=1.0, plain=True, demand=False, metrics=False
    )
    common = asyncio.run(_common_environment(options, tmp_path, port=8000))
    for name, value in common.items():
        monkeypatch.setenv(name, value)
    write_settings(tmp_path, common, ())
    for told in (Settings.load(), read_settings(tmp_path)):
        assert (told.bus_plain, told.bus_certificates, told.gateway_name) == (True, None, "gateway")
