"""`dray certs`: an authority and a certificate for every agent of a plant."""

from __future__ import annotations

import stat
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from cryptography.hazmat.primitives import serialization

from dray.adapters.security.certificates import read_key
from dray.adapters.security.identity import Identity
from dray.adapters.security.seals import Seals
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of
from dray.plant import default_plant, plant_yaml

Dray = Callable[..., tuple[int, str, str]]


@pytest.fixture
def dray(call: Dray) -> Dray:
    """Run `dray certs`; its exit code and what it printed."""
    return partial(call, "certs")


def test_every_agent_of_the_plant_gets_its_certificate(dray: Dray, tmp_path: Path) -> None:
    folder, plant = tmp_path / "certs", default_plant()
    code, out, _ = dray("make", folder)
    assert code == 0
    expected = {
        **dict.fromkeys(plant.machines, Kind.MACHINE),
        **dict.fromkeys(plant.storages, Kind.STATION),
        **dict.fromkeys(plant.fleet, Kind.ATV),
        "gate": Kind.GATE,
        "strategist": Kind.STRATEGIST,
        "gateway": Kind.GATEWAY,
        "historian": Kind.HISTORIAN,
    }
    assert f"{len(expected)} certificates for {plant.id}" in out
    for agent, kind in expected.items():
        assert Seals(Identity.in_folder(folder, agent), plant.id).agents == names_of(agent, kind)


def test_each_of_several_strategists_gets_a_certificate(
    dray: Dray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DRAY_STRATEGISTS", "2")
    assert dray("make", tmp_path)[0] == 0
    for name in ("strategist", "strategist2"):
        assert Seals(Identity.in_folder(tmp_path, name), default_plant().id).agents == {name: Kind.STRATEGIST}


def test_nobody_else_may_read_a_key(dray: Dray, tmp_path: Path) -> None:
    dray("make", tmp_path)
    modes = {stat.S_IMODE(file.stat().st_mode) for file in tmp_path.glob("*.key")}
    assert modes == {0o600}


def test_a_new_vehicle_gets_one_that_all_others_trust(dray: Dray, tmp_path: Path) -> None:
    dray("make", tmp_path)
    code, out, _ = dray("issue", tmp_path, "atv", "ATV9")
    assert (code, out.strip()) == (0, str(tmp_path / "ATV9.pem"))
    plant = default_plant().id
    joining, machine = (Seals(Identity.in_folder(tmp_path, name), plant) for name in ("ATV9", "M1"))
    assert machine.examine(joining.seal("k", 1, 1, b"x"), "ATV9", "k", 1, 1, b"x") is Kind.ATV


def test_an_authority_is_never_overwritten(dray: Dray, tmp_path: Path) -> None:
    dray("make", tmp_path)
    before = (tmp_path / "authority.pem").read_bytes()
    code, _, err = dray("make", tmp_path)
    assert code == 2
    assert "has an authority already" in err
    assert (tmp_path / "authority.pem").read_bytes() == before


def test_without_an_authority_nothing_is_issued(dray: Dray, tmp_path: Path) -> None:
    code, _, err = dray("issue", tmp_path, "atv", "ATV9")
    assert code == 2
    assert "`dray certs make` makes an authority" in err


@pytest.mark.parametrize("agent", ["", "A" * 65, "Fräse1", "a/b", "ATV 9", "../ATV9"])
def test_a_name_that_no_agent_may_have_is_refused(dray: Dray, tmp_path: Path, agent: str) -> None:
    dray("make", tmp_path)
    before = sorted(tmp_path.iterdir())
    code, _, err = dray("issue", tmp_path, "atv", agent)
    assert code == 2
    assert f"{agent!r}: is no id of an agent; write letters" in err
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize("agent", ["authority", "Authority"])
def test_no_agent_takes_the_place_of_the_authority(dray: Dray, tmp_path: Path, agent: str) -> None:
    dray("make", tmp_path)
    before = (tmp_path / "authority.key").read_bytes()
    code, _, err = dray("issue", tmp_path, "atv", agent)
    assert code == 2
    assert f"{agent}: is the name of the authority's own files" in err
    assert (tmp_path / "authority.key").read_bytes() == before


def test_a_kind_of_agent_that_there_is_not_is_refused(dray: Dray, tmp_path: Path) -> None:
    dray("make", tmp_path)
    code, _, err = dray("issue", tmp_path, "robot", "R1")
    assert code == 2
    assert "there is no 'robot'; choose one of atv, machine" in err


def test_a_key_with_a_password_is_refused_with_a_remedy(dray: Dray, tmp_path: Path) -> None:
    dray("make", tmp_path)
    file = tmp_path / "authority.key"
    file.write_bytes(
        read_key(file.read_bytes()).private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.BestAvailableEncryption(b"hunter2"),
        )
    )
    code, _, err = dray("issue", tmp_path, "atv", "ATV9")
    assert code == 2
    assert f"{tmp_path}: holds no authority of ours: the key is encrypted; store it without" in err


def test_a_folder_that_cannot_be_made_is_named(dray: Dray, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    code, _, err = dray("make", tmp_path / "file" / "certs")
    assert code == 1
    assert str(tmp_path / "file" / "certs") in err


@pytest.fixture
def elsewhere(tmp_path: Path) -> Path:
    """The file of another plant than the default one."""
    file = tmp_path / "elsewhere.yaml"
    file.write_text(plant_yaml(default_plant()).replace("plant: dray\n", "plant: elsewhere\n", 1))
    return file


def test_a_joining_agent_belongs_to_the_plant_of_its_authority(
    dray: Dray, tmp_path: Path, elsewhere: Path
) -> None:
    folder = tmp_path / "certs"
    dray("make", folder, "--plant", elsewhere)
    code, _, _ = dray("issue", folder, "atv", "ATV9")
    assert code == 0
    assert Seals(Identity.in_folder(folder, "ATV9"), "elsewhere").agents == {"ATV9": Kind.ATV}


def test_an_authority_certifies_nobody_of_another_plant(dray: Dray, tmp_path: Path, elsewhere: Path) -> None:
    folder = tmp_path / "certs"
    dray("make", folder)
    code, _, err = dray("issue", folder, "atv", "ATV9", "--plant", elsewhere)
    assert code == 2
    assert "is of the plant elsewhere, and the authority of dray; leave it out" in err
    assert not (folder / "ATV9.pem").exists()


def test_certificates_are_for_the_plant_that_the_environment_names(
    dray: Dray, tmp_path: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DRAY_PLANT_FILE", str(elsewhere))
    code, out, _ = dray("make", tmp_path / "certs")
    assert code == 0
    assert "certificates for elsewhere" in out


def test_a_certificate_is_called_back_by_the_agents_name(dray: Dray, tmp_path: Path) -> None:
    dray("make", tmp_path)
    code, out, _ = dray("revoke", tmp_path, "ATV3", "--reason", "key-compromise")
    assert code == 0
    assert out.startswith("1 certificate of ATV3 revoked; copy ")
    assert str(tmp_path / "revoked.pem") in out
    code, out, _ = dray("revoke", tmp_path, "ATV3", "--reason", "superseded")
    assert (code, out.partition(";")[0]) == (0, "ATV3: all its certificates were revoked already")


@pytest.mark.parametrize(
    ("args", "told"),
    [
        (("ATV3",), "--reason"),
        (("ATV3", "--reason", "stolen"), "key-compromise"),
        (("ATV99", "--reason", "superseded"), "knows of no certificate"),
    ],
)
def test_what_cannot_be_called_back_is_named(
    dray: Dray, tmp_path: Path, args: tuple[str, ...], told: str
) -> None:
    dray("make", tmp_path)
    code, _, err = dray("revoke", tmp_path, *args)
    assert code == 2
    assert told in err
    assert not (tmp_path / "revoked.pem").exists()
