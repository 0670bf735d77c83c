"""What `dray fleet up` makes of its options and of the environment."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from dray.cli.fleet.folder import read_settings, write_settings
from dray.cli.fleet.supervisor import FleetOptions, _common_environment
from dray.plant import default_plant
from dray.settings import Settings

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
