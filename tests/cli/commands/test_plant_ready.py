"""`dray plant ready`: what it prints and writes, and what it refuses."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable
from functools import partial
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any

import msgspec
import pytest
from fake_gateway import FakeGateway

from dray.cli.runtime.ready import computer
from dray.messages import MachineHeartbeat, MachineStatus
from dray.plant import Plant, plant_yaml, shipped_plant
from dray.settings import Settings
from dray.store import open_store

Run = Callable[..., tuple[int, str, str]]

WORKSHOP = shipped_plant("workshop")
SCOPES = ["factory:read", "people:write", "vehicles:command"]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    made = tmp_path / "works.yaml"
    made.write_text(plant_yaml(WORKSHOP), encoding="utf-8")
    return made


@pytest.fixture
def run(call: Run, file: Path, tmp_path: Path, database: str, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run `dray plant ready` for the workshop, on a computer whose clock is right and whose disks are empty."""
    monkeypatch.setattr(computer, "ntp_synchronised", lambda: True)
    monkeypatch.setattr(computer, "free_on", lambda _folder: 2**40)
    monkeypatch.setenv("DRAY_JOURNAL_FOLDER", str(tmp_path))
    return partial(call, "plant", "ready", file, "--db", database)


def agent(name: str) -> dict[str, Any]:
    return {"id": name, "seen_at_s": time.time(), "silence": {"lost_after_s": 3600.0}}


@pytest.fixture
def served(gateway: FakeGateway) -> FakeGateway:
    """A gateway of the workshop, in which everybody is there."""
    parts = {"database": {"ok": True}, "bus": {"ok": True}, "strategist": {"ok": True, "silent_s": 1.0}}
    people = [
        {"id": "ana", "role": "manager", "secrets": ["password"]},
        {"id": "ben", "role": "operator", "areas": ["SHOP-FLOOR"], "secrets": ["pin"]},
    ]
    gateway.answers = {
        "GET /readyz": (200, {"status": "ready", "parts": parts}),
        "GET /healthz": (200, {"status": "ok"}),
        "GET /api/me": (200, {"scopes": SCOPES, "areas": None}),
        "GET /api/replay": (
            200,
            {
                "type": "snapshot",
                "at_s": time.time(),
                "plant": WORKSHOP.id,
                "factory": {"speed": 1.0},
                "machines": [agent(each) for each in WORKSHOP.machines],
                "atvs": [agent(each) for each in WORKSHOP.fleet],
                "stations": [agent(each) for each in (*WORKSHOP.stores, "gate")],
                "alerts": [],
            },
        ),
        "GET /api/plant": (200, json.loads(msgspec.json.encode(WORKSHOP.file))),
        "GET /api/people?limit=500": (200, {"items": people[:1], "next_cursor": "a/b"}),
        "GET /api/people?limit=500&cursor=a%2Fb": (200, {"items": people[1:], "next_cursor": None}),
        "GET /api/keys?limit=500": (200, {"items": [], "next_cursor": None}),
        "GET /api/duty": (200, {"state": "off", "areas_without": []}),
    }
    return gateway


def rows(out: str) -> dict[str, str]:
    """The verdict by the name of the thing."""
    found = {}
    for line in out.splitlines():
        verdict, _, rest = line.partition(" ")
        if verdict in {"ok", "missing", "unknown"}:
            found[rest.strip().split("  ")[0]] = verdict
    return found


def test_what_is_missing_is_told_with_the_command_and_makes_exit_code_1(
    run: Run, served: FakeGateway, file: Path, tmp_path: Path
) -> None:
    report = tmp_path / "report.json"
    code, out, _ = run("--gateway", served.url, "--token", "secret", "--json", report)
    assert code == 1
    found = rows(out)
    assert {name for name, verdict in found.items() if verdict == "missing"} == {
        "certificates",  # no folder is named
        "historian",  # the database is empty
        "signed commands",
    }
    assert {name for name, verdict in found.items() if verdict == "unknown"} == {"docks"}
    assert f"-> dray certs make certs --plant {file}" in out
    assert out.splitlines()[-1] == f"3 missing, 1 unknown, {len(found) - 4} ok"
    written = json.loads(report.read_text())
    assert (written["plant"], written["missing"], written["unknown"]) == (WORKSHOP.id, 3, 1)
    assert {each["name"]: each["verdict"] for each in written["findings"]} == found


def test_exit_code_0_when_nothing_is_missing(
    run: Run, call: Run, served: FakeGateway, tmp_path: Path, database: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    call("certs", "make", tmp_path / "certs", "--plant", tmp_path / "works.yaml")
    key = call("key", "signing", "--db", database)[1].strip()
    monkeypatch.setenv("DRAY_TRUSTED_KEYS", key)
    asyncio.run(write_sample(database))
    code, out, _ = run("--gateway", served.url, "--token", "secret", "--certificates", tmp_path / "certs")
    assert (code, [name for name, verdict in rows(out).items() if verdict == "missing"]) == (0, [])


async def write_sample(database: str) -> None:
    """As the historian does."""
    store = await open_store(Settings.load(database_url=database).database_url)
    beat = MachineHeartbeat(machine="SAW", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)
    async with store.write() as work:
        await work.samples.add([beat], lambda s: time.time() + s)
    await store.close()


@pytest.mark.parametrize(
    ("date", "verdict"),
    [("Sat, 01 Jan 2000 00:00:00 GMT", "missing"), ("soon", "unknown"), ("", "unknown")],
)
def test_the_clock_of_the_gateway_is_read_from_the_date_of_its_answer(
    run: Run, served: FakeGateway, monkeypatch: pytest.MonkeyPatch, date: str, verdict: str
) -> None:
    monkeypatch.setattr(BaseHTTPRequestHandler, "date_time_string", lambda _self, _at_s=None: date)
    out = run("--gateway", served.url, "--token", "secret")[1]
    assert rows(out)["clock of the gateway"] == verdict


def test_a_gateway_that_does_not_answer_is_missing_and_what_it_would_tell_is_unknown(run: Run) -> None:
    code, out, _ = run("--gateway", "http://127.0.0.1:9", "--token", "secret")
    found = rows(out)
    assert (code, found["gateway"]) == (1, "missing")
    assert {found[each] for each in ("machines", "vehicles", "people on duty", "API keys")} == {"unknown"}


def test_a_gateway_that_cannot_take_orders_says_why(run: Run, served: FakeGateway) -> None:
    refused = {"detail": "bus: the gateway is not on it", "errors": []}
    served.answers["GET /readyz"] = (503, refused)
    code, out, _ = run("--gateway", served.url, "--token", "secret")
    assert (code, rows(out)["gateway"]) == (1, "missing")
    assert "the gateway is not on it" in out


def test_without_a_token_only_the_gateway_itself_is_asked(run: Run, served: FakeGateway) -> None:
    out = run("--gateway", served.url)[1]
    assert rows(out)["gateway"] == "unknown"
    assert [path for _, path, _ in served.asked] == ["/readyz"]


def test_a_plant_that_has_no_room_for_its_vehicles_is_not_ready(run: Run, file: Path) -> None:
    wide = msgspec.structs.replace(
        WORKSHOP.file,
        vehicle_types=tuple(
            msgspec.structs.replace(each, width_m=3.0) for each in WORKSHOP.file.vehicle_types
        ),
    )
    file.write_text(plant_yaml(Plant(wide)), encoding="utf-8")
    code, out, _ = run("--gateway", "http://127.0.0.1:9")
    assert (code, rows(out)["plant file"]) == (1, "missing")
    assert f"-> dray plant check {file}" in out


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--gateway", "nowhere"), "is no address"),
        (("--certificates", "none"), "there is no folder none"),
        (("--mappings", "none"), "there is no folder none"),
        (("--settings", "none.env"), "there is no file none.env"),
        (("--json", "none/report.json"), "No such file"),
    ],
)
def test_bad_input_is_refused(run: Run, given: tuple[str, str], said: str) -> None:
    code, _, err = run(*(given if "--gateway" in given else ("--gateway", "http://127.0.0.1:9", *given)))
    assert code != 0
    assert said in err


def test_a_wrong_token_and_one_of_an_operator_are_refused(run: Run, served: FakeGateway) -> None:
    served.answers["GET /api/me"] = (200, {"scopes": SCOPES, "areas": ["SHOP-FLOOR"]})
    code, _, err = run("--gateway", served.url, "--token", "secret")
    assert (code, "does not see the whole plant" in err) == (2, True)
    served.answers["GET /api/me"] = (401, {"detail": "nobody has this token"})
    code, _, err = run("--gateway", served.url, "--token", "wrong")
    assert (code, "nobody has this token" in err) == (2, True)


def test_a_file_that_is_no_plant_is_refused(call: Run, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text("plant: 3\n")
    code, _, err = call("plant", "ready", tmp_path / "bad.yaml")
    assert (code, "bad.yaml" in err) == (2, True)
