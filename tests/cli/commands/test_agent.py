"""`dray agent` and its like: what they need is asked for by name before anything begins."""

from __future__ import annotations

import asyncio
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.security.certificates import Authority
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.cli.runtime.gateway.gateway_process import run_historian
from dray.cli.runtime.surroundings import Surroundings
from dray.cli.simulation.floor_process import serve_floor
from dray.errors import UnavailableError
from dray.memory import WHOLE, AtvMemory
from dray.messages.kinds import Kind
from dray.plant import default_plant, plant_yaml
from dray.settings import Settings
from dray_sim.plants.generator import generate_plant

Dray = Callable[..., tuple[int, str]]

PATIENCE_S = 90.0
"""For what takes milliseconds on a computer with nothing else to do."""


@pytest.fixture
def dray(call: Callable[..., tuple[int, str, str]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Dray:
    """Run `dray` in an empty folder; its exit code and what it says is wrong."""
    monkeypatch.chdir(tmp_path)

    def run(*args: str, **environment: str) -> tuple[int, str]:
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        code, _, told = call(*args)
        return code, told

    return run


def free_address() -> str:
    """An address on this computer where nobody listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{probe.getsockname()[1]}"


def test_an_agent_that_is_not_in_the_plant_is_refused(dray: Dray) -> None:
    code, told = dray("agent", "atv", "ATV99")
    assert code == 2
    assert "there is no 'ATV99'; choose one of ATV1" in told


@pytest.mark.parametrize(
    ("name", "options", "told"),
    [
        ("ATV99", ("--type", "zeppelin", "--node", "a1"), "--type: there is no 'zeppelin'"),
        ("ATV99", ("--type", "light", "--node", "z9"), "--node: there is no 'z9'"),
        ("ATV99", ("--node", "a1"), "--type: a joining vehicle needs it beside --node"),
        ("ATV1", ("--type", "light"), "--node: a joining vehicle needs it beside --type"),
        ("ATV1", ("--type", "light", "--node", "a1"), "NAME: ATV1 is in the plant file already"),
        ("M1", ("--type", "light", "--node", "a1"), "NAME: M1 is somebody else in this plant"),
        ("Gateway", ("--type", "light", "--node", "a1"), "NAME: Gateway is somebody else in this plant"),
        ("ATV 9", ("--type", "light", "--node", "a1"), "NAME: 'ATV 9' is no id; write letters"),
    ],
)
def test_a_joining_agent_needs_a_name_a_type_and_a_place(
    dray: Dray, name: str, options: tuple[str, ...], told: str
) -> None:
    code, error = dray("agent", "atv", name, *options)
    assert code == 2
    assert told in error


def test_a_machine_that_is_a_joining_agent_stands_in_a_plant_file_that_has_it(
    dray: Dray, tmp_path: Path
) -> None:
    file = tmp_path / "new.yaml"
    file.write_text(plant_yaml(default_plant()), encoding="utf-8")
    for machine, option, wrong in (
        ("M99", file, "NAME: there is no 'M99'; choose one of M1"),
        ("M1", file, "--joining: M1 is in the plant file already"),
        ("M1", tmp_path / "none.yaml", "there is no such file"),
    ):
        code, error = dray("agent", "machine", machine, "--joining", str(option))
        assert code == 2
        assert wrong in error


def test_a_joining_agent_that_does_not_fit_into_the_plant_of_the_others_is_refused(
    dray: Dray, tmp_path: Path
) -> None:
    file = tmp_path / "elsewhere.yaml"
    elsewhere = generate_plant(1, machines=20, vehicles=2)
    file.write_text(plant_yaml(elsewhere), encoding="utf-8")
    stranger = next(reversed(elsewhere.machines))
    code, error = dray("agent", "machine", stranger, "--joining", str(file))
    assert code == 2
    assert f"{file}: machines[12]" in error


@pytest.mark.parametrize(
    ("agent", "body", "wrong"),
    [
        (("machine", "M1"), "controller", "controller is no body of a machine: give it floor or opcua"),
        (("machine", "M1"), "vda5050", "DRAY_BODY: vda5050 is no body of a machine: give it floor or opcua"),
        (("machine", "M1"), "opcua", "--mapping: a controller's body needs the file that names its signals"),
        (("machine", "M1"), "mqtt", "--mapping: a controller's body needs the file that names its signals"),
        (("atv", "ATV1"), "controller", "controller is no body of a vehicle: give it floor or vda5050"),
        (("station", "S1"), "vda5050", "vda5050 is no body of a station: give it floor or controller"),
        (("gate",), "opcua", "--mapping: a controller's body needs the file that names its signals"),
        (("gate",), "vda5050", "vda5050 is no body of the gate: give it floor or controller"),
    ],
)
def test_a_body_that_an_agent_cannot_have_is_refused_and_not_replaced_by_a_simulated_one(
    dray: Dray, agent: tuple[str, ...], body: str, wrong: str
) -> None:
    code, told = dray("agent", *agent, DRAY_BODY=body, DRAY_BUS_PLAIN="true")
    assert code == 2
    assert wrong in told


@pytest.mark.parametrize("command", [("agent", "machine", "M1"), ("strategist",), ("floor",), ("historian",)])
def test_without_certificates_plain_links_must_be_asked_for(dray: Dray, command: tuple[str, ...]) -> None:
    code, told = dray(*command)
    assert code == 2
    assert "DRAY_BUS_PLAIN=true" in told


@pytest.mark.parametrize(
    ("many", "name", "wrong"),
    [
        (
            "1",
            "strategist2",
            "NAME: there is no 'strategist2'; with DRAY_STRATEGISTS=1 choose one of strategist",
        ),
        (
            "2",
            "Strategist",
            "there is no 'Strategist'; with DRAY_STRATEGISTS=2 choose one of strategist, strategist2",
        ),
        ("10", "strategist", "DRAY_STRATEGISTS: '10': write a whole number of at least 1 and of at most 9"),
        ("two", "strategist", "DRAY_STRATEGISTS: 'two': write a whole number of at least 1 and of at most 9"),
    ],
)
def test_a_strategist_that_the_plant_does_not_have_is_refused(
    dray: Dray, many: str, name: str, wrong: str
) -> None:
    code, told = dray("strategist", name, DRAY_STRATEGISTS=many, DRAY_BUS_PLAIN="true")
    assert code == 2
    assert wrong in told


def test_a_folder_without_the_agents_certificate_is_named(dray: Dray, tmp_path: Path) -> None:
    code, told = dray("agent", "machine", "M1", DRAY_BUS_CERTIFICATES=str(tmp_path))
    assert code == 2
    assert "authority.pem: there is no such file" in told


def test_a_key_that_is_none_is_named(dray: Dray) -> None:
    code, told = dray("agent", "atv", "ATV1", DRAY_TRUSTED_KEYS="beef")
    assert code == 2
    assert "DRAY_TRUSTED_KEYS: holds something that is no public key in hex" in told


def test_an_agent_without_a_floor_says_what_to_start(dray: Dray, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.adapters.remote_body.questions.PATIENCE_S", 0.5)
    code, told = dray("agent", "machine", "M1", DRAY_BUS_PLAIN="true")
    assert code == 1
    assert (
        "the body of M1: nobody answers over 0 links; start `dray floor` first; if it runs, see that its plant"
        in told
    )


@pytest.mark.parametrize("command", [("agent", "station", "S3"), ("agent", "gate")])
def test_a_dock_with_a_controller_needs_a_broker(dray: Dray, command: tuple[str, ...]) -> None:
    code, told = dray(*command, "--body", "controller", DRAY_BUS_PLAIN="true")
    assert code == 2
    assert "DRAY_BROKER: a real body is behind a broker: say where that is" in told


@pytest.fixture
def floor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[subprocess.Popen[str]]:
    """The simulated floor as a process of its own, on a bus that this process's agents are on too."""
    address = free_address()
    monkeypatch.setenv("DRAY_BUS_PLAIN", "true")
    told = {**os.environ, "DRAY_BUS_LISTEN": address}
    process = subprocess.Popen(
        [sys.executable, "-m", "dray", "floor"], stdout=subprocess.PIPE, text=True, env=told, cwd=tmp_path
    )
    monkeypatch.setenv("DRAY_BUS_PEERS", address)
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "floor is ready\n"
        yield process
        process.kill()


def test_an_agent_whose_floor_ends_does_not_go_on_with_an_old_picture(
    dray: Dray, floor: subprocess.Popen[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.adapters.remote_body.exchanged.LOOK_EVERY_S", 0.2)
    monkeypatch.setattr("dray.cli.runtime.agent_process.say_ready", lambda _name: floor.kill())
    code, told = dray("agent", "machine", "M1")
    assert code == 1
    assert "the body of M1: has fallen silent; see whether `dray floor`, or its controller, runs" in told


def test_an_agent_does_not_begin_on_a_floor_that_knows_nothing_of_what_binds_it(
    dray: Dray, floor: subprocess.Popen[str], tmp_path: Path
) -> None:
    with closing(SqliteJournal(tmp_path / "journals/ATV1.db", events_kept=1)) as journal:
        journal.write((), {WHOLE: AtvMemory(speed_frac=0.5)})
    code, told = dray("agent", "atv", "ATV1")
    assert code == 1
    assert "journals/ATV1.db is about: is gone, for the floor has begun anew; move away the journals" in told


def test_a_gateway_without_a_certificate_of_its_own_says_so(dray: Dray, tmp_path: Path) -> None:
    authority = Authority.make(default_plant().id)
    authority.write(tmp_path)
    authority.issue(tmp_path, default_plant().id, {"M1": Kind.MACHINE})
    for end in ("pem", "key"):
        (tmp_path / f"M1.{end}").rename(tmp_path / f"gateway.{end}")
    code, told = dray("gateway", "--port", "0", DRAY_BUS_CERTIFICATES=str(tmp_path))
    assert code == 2
    assert "gateway: the certificate names M1 only" in told
    assert "Traceback" not in told


def test_a_historian_ends_when_another_one_has_been_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address, plant = free_address(), default_plant()
    url = f"sqlite:///{tmp_path / 'dray.db'}"
    settings = Settings.load(database_url=url, bus_plain=True, bus_listen=address)

    async def main() -> None:
        ready = asyncio.Event()
        monkeypatch.setattr("dray.cli.runtime.gateway.gateway_process.say_ready", lambda _name: ready.set())
        async with asyncio.timeout(PATIENCE_S), asyncio.TaskGroup() as group:
            first = group.create_task(run_historian(Surroundings(settings, plant)))
            await ready.wait()
            with closing(ZenohBus(Links(peers=(address,), plain=True), plant.id)) as bus:
                bus.join("historian", lambda _sender, _message: None, life=1_000)
                await asyncio.wait((first,))

    with pytest.raises(ExceptionGroup) as raised:
        asyncio.run(main())
    (told,) = raised.value.exceptions
    assert str(told) == "historian: has been started elsewhere; stop one of the two"


def test_a_plant_has_one_floor_and_the_first_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    address, plant = free_address(), default_plant()
    first_has = Settings.load(bus_plain=True, bus_listen=address)
    second_has = Settings.load(bus_plain=True, bus_peers=address)

    async def main() -> None:
        ready = asyncio.Event()
        monkeypatch.setattr("dray.cli.simulation.floor_process.say_ready", lambda _name: ready.set())
        async with asyncio.timeout(PATIENCE_S):
            first = asyncio.create_task(serve_floor(Surroundings(first_has, plant), seed=1))
            await ready.wait()
            with pytest.raises(UnavailableError, match="the floor of dray: runs elsewhere already; end that"):
                await serve_floor(Surroundings(second_has, plant), seed=1)
            assert not first.done()
            first.cancel()
            await asyncio.wait((first,))

    asyncio.run(main())


def test_settings_come_from_a_file_and_the_environment_wins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "atv3.env"
    file.write_text("DRAY_BUS_PEERS=10.0.0.1:7447, 10.0.0.2:7447\nDRAY_BUS_LEASE_S=1.5\n", encoding="utf-8")
    monkeypatch.setenv("DRAY_BUS_LEASE_S", "3")
    settings = Settings.load(file)
    assert settings.bus_peers == ("10.0.0.1:7447", "10.0.0.2:7447")
    assert settings.bus_lease_s == 3.0


def test_a_settings_file_that_is_not_there_is_named(dray: Dray) -> None:
    code, told = dray("strategist", "--settings", "nowhere.env")
    assert code == 2
    assert "there is no file nowhere.env" in told


def test_a_misspelt_variable_is_told(dray: Dray, tmp_path: Path) -> None:
    file = tmp_path / "atv3.env"
    file.write_text("# DRAY_BUS_LISTE=1\nDRAY_BUS_PEER=10.0.0.1:7447\nDRAY_NEXT_YEAR=1\n", encoding="utf-8")
    _, told = dray("strategist", "--settings", str(file), DRAY_BUS_CERTIFICATE="certs", DRAY_SKIP_PANELS="1")
    assert "dray: DRAY_BUS_CERTIFICATE is no setting and is not used; is DRAY_BUS_CERTIFICATES meant?" in told
    assert "dray: DRAY_BUS_PEER is no setting and is not used; is DRAY_BUS_PEERS meant?" in told
    assert told.count("is no setting") == 2
