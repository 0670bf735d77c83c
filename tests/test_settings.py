"""What an operator may choose, and where secrets come from."""

from __future__ import annotations

from pathlib import Path

import pytest

from dray import settings as settings_module
from dray.errors import SettingsError
from dray.settings import Settings, host_and_port


@pytest.fixture(autouse=True)
def secrets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder of secrets, and no variable that would say otherwise."""
    monkeypatch.setattr(settings_module, "SECRETS", tmp_path)
    for name in ("DRAY_DATABASE_URL", "DRAY_DATABASE_PASSWORD", "DRAY_ADMIN_TOKEN"):
        monkeypatch.delenv(name, raising=False)
    return tmp_path


@pytest.mark.parametrize("scheme", ["postgres", "postgresql", "postgresql+asyncpg"])
def test_one_url_chooses_the_database_however_people_write_it(scheme: str) -> None:
    settings = Settings.load(database_url=f"{scheme}://dray@db:5433/factory")
    assert settings.database_url == "postgresql+asyncpg://dray@db:5433/factory"


def test_the_password_may_come_apart_from_the_url_as_a_file(secrets: Path) -> None:
    (secrets / "dray_database_password").write_text("p@ss/word\n")
    (secrets / "dray_admin_token").write_text("let me in")
    settings = Settings.load(database_url="postgresql://dray@db/factory")
    assert settings.database_url == "postgresql+asyncpg://dray:p%40ss%2Fword@db/factory"
    assert settings.admin_token is not None
    assert settings.admin_token.get_secret_value() == "let me in"
    assert "let me in" not in repr(settings)


def test_a_url_that_was_handed_on_with_the_password_is_taken_as_it_is(secrets: Path) -> None:
    (secrets / "dray_database_password").write_text("p@ss/word\n")
    first = Settings.load(database_url="postgresql://dray@db/factory")
    assert Settings.load(database_url=first.database_url).database_url == first.database_url


def test_a_variable_overrides_a_file(secrets: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (secrets / "dray_admin_token").write_text("old")
    monkeypatch.setenv("DRAY_ADMIN_TOKEN", "new")
    token = Settings.load().admin_token
    assert token is not None
    assert token.get_secret_value() == "new"


def test_a_folder_that_is_not_there_is_no_fault(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(settings_module, "SECRETS", tmp_path / "none")
    assert Settings.load().admin_token is None


@pytest.mark.parametrize(
    "url", ["postgresql://db/factory", "postgresql://dray:old@db/factory", "sqlite:///dray.db"]
)
def test_a_password_that_cannot_be_put_anywhere_is_refused_and_not_told(url: str) -> None:
    with pytest.raises(SettingsError, match="DRAY_DATABASE_URL must name a user and no password") as raised:
        Settings.load(database_url=url, database_password="hunter2")
    assert "hunter2" not in str(raised.value)


def test_a_settings_file_that_is_no_text_is_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "atv3.env"
    file.write_bytes("DRAY_GATEWAY_NAME=Tür".encode("latin-1"))
    with pytest.raises(SettingsError, match=r"--settings: .*atv3.env is not UTF-8"):
        Settings.load(file)


@pytest.mark.parametrize(
    ("address", "parts"),
    [("127.0.0.1:9101", ("127.0.0.1", 9101)), ("[::1]:0", ("::1", 0)), ("m1.plant:80", ("m1.plant", 80))],
)
def test_an_address_has_a_host_and_a_port(address: str, parts: tuple[str, int]) -> None:
    assert host_and_port(Settings.load(metrics_listen=address).metrics_listen) == parts


@pytest.mark.parametrize("address", ["9101", ":9101", "here:", "here:http", "here:65536", "::1:9101", "[]:1"])
def test_an_address_that_is_none_is_refused_by_name(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DRAY_METRICS_LISTEN", address)
    with pytest.raises(SettingsError, match=r"DRAY_METRICS_LISTEN: .*:9101"):
        Settings.load()


@pytest.mark.parametrize("variable", ["DRAY_BUS_LISTEN", "DRAY_BUS_PEERS"])
def test_one_of_several_addresses_that_is_none_is_named(
    variable: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, "10.0.0.1:7447, strategist")
    with pytest.raises(SettingsError, match=f"{variable}: 'strategist': write it as HOST:PORT"):
        Settings.load()


def test_a_line_of_a_settings_file_that_says_nothing_is_refused_by_its_number(tmp_path: Path) -> None:
    file = tmp_path / "atv3.env"
    file.write_text("# of ATV3\n\nexport DRAY_PORT = 8001\nDRAY_LOG_FORMAT: json\n", encoding="utf-8")
    with pytest.raises(SettingsError, match=r"--settings: .*atv3\.env:4: write a line as DRAY_PORT=8000"):
        Settings.load(file)
    file.write_text(file.read_text(encoding="utf-8").replace(": json", "=json"), encoding="utf-8")
    assert Settings.load(file).port == 8001


@pytest.mark.parametrize(
    ("variable", "value", "said"),
    [
        ("TRUSTED_PROXIES", "zzz", "'zzz': write an address or a network, as 10.8.0.1 or 10.8.0.0/16"),
        ("TRUSTED_PROXIES", "10.0.0.1, proxy", "'proxy': write an address or a network"),
        ("BUS_RADIO", "10.8.0.1/16", "'10.8.0.1/16': write an address or a network"),
        ("PLANT_EPOCH_S", "inf", "'inf': write a number of at least 0"),
        ("PLANT_SPEED", "nan", "'nan': write a number above 0 and of at most 50"),
        ("STOP_PORT", "65536", "'65536': write a whole number of at least 0 and of at most 65535"),
        ("EVENTS_MOST", "20_0O0", "'20_0O0': write a whole number of at least 1000"),
        ("BUS_PLAIN", "maybe", "'maybe': write true or false"),
        ("LOG_LEVEL", "loud", "'loud': write 'debug', 'info', 'warning' or 'error'"),
        ("HOST", "http://dray", "'http://dray': write a name or an address alone"),
        ("ALLOWED_HOSTS", "a.b, dray.example.com:8443", "'dray.example.com:8443': write a name alone"),
        ("ALLOWED_HOSTS", "*.example.com", "'*.example.com': write a name alone"),
        ("PUBLIC_URL", "https://dray:80000", "'https://dray:80000': write it as https://dray.example.com"),
        ("TRACE_URL", "http:///v1", "'http:///v1': write it as http://127.0.0.1:4318/v1/traces"),
        ("BROKER", "mqtt://plant:70000", "'mqtt://plant:70000': write it as mqtt://HOST:1883"),
    ],
)
def test_a_variable_that_cannot_be_used_is_refused_with_its_value_and_what_is_allowed(
    variable: str, value: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(f"DRAY_{variable}", value)
    with pytest.raises(SettingsError) as raised:
        Settings.load()
    assert str(raised.value).startswith(f"DRAY_{variable}: {said}")


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("DATABASE_URL", "postgresql//dray:hunter2@db/factory"),
        ("BROKER", "mqtt://dray:hunter2@plant"),
        ("ADMIN_TOKEN", " "),
    ],
)
def test_a_refused_value_with_a_secret_in_it_is_not_shown(
    variable: str, value: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(f"DRAY_{variable}", value)
    with pytest.raises(SettingsError, match=f"^DRAY_{variable}: [a-z]") as raised:
        Settings.load()
    assert "hunter2" not in str(raised.value)


def test_trusted_proxies_are_addresses_and_networks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DRAY_TRUSTED_PROXIES", "10.8.0.1, fd00::/8")
    assert [str(each) for each in Settings.load().trusted_proxies] == ["10.8.0.1/32", "fd00::/8"]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("PROT", "PORT"),
        ("TRUSTED_PROXY", "TRUSTED_PROXIES"),
        ("DATABASE", "DATABASE_URL"),
        ("DB", "DATABASE_URL"),
        ("PLANT", "PLANT_FILE"),
    ],
)
def test_a_misspelt_variable_is_known_by_what_is_meant(
    written: str, meant: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(f"DRAY_{written}", "1")
    assert settings_module.misspelt()[f"DRAY_{written}"] == f"DRAY_{meant}"
