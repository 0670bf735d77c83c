"""What `dray plant ready` finds of certificates, database, disks, clocks, people and keys."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from alembic.script import ScriptDirectory
from databases import Files
from msgspec.structs import replace
from sqlalchemy import text

from dray.adapters.security.certificates import Authority
from dray.adapters.security.revocations import call_back
from dray.cli.runtime.gateway.authority import authority_of
from dray.cli.runtime.ready.agents import agents, bodies, plant_of_gateway
from dray.cli.runtime.ready.answers import (
    Agent,
    Alert,
    Answers,
    Clock,
    Duty,
    Factory,
    Key,
    Part,
    Person,
    Picture,
    Silence,
)
from dray.cli.runtime.ready.certificates import certificates
from dray.cli.runtime.ready.computer import clocks, disks
from dray.cli.runtime.ready.database import database
from dray.cli.runtime.ready.docks import docks
from dray.cli.runtime.ready.finding import Finding, Verdict, named
from dray.cli.runtime.ready.people import people_and_keys
from dray.cli.runtime.roster import certified_of
from dray.messages import MachineHeartbeat, MachineStatus
from dray.messages.keys import GATE
from dray.messages.kinds import Kind
from dray.plant import shipped_plant
from dray.settings import Settings
from dray.store import open_store
from dray.store.database.migrate import configuration

WORKSHOP = shipped_plant("workshop")
AREA = "SHOP-FLOOR"
NOW_S = 1_900_000_000.0
DAY_S = 86_400.0
GIB = 2**30

OLDEST = list(ScriptDirectory.from_config(configuration()).walk_revisions())[-1].revision

WANTED = certified_of(WORKSHOP, ("strategist",), "gateway")


def heard(agent: str, **fields: Any) -> Agent:
    return Agent(id=agent, seen_at_s=NOW_S - 1.0, silence=Silence(3.5), **fields)


def picture(**fields: Any) -> Picture:
    usual: dict[str, Any] = {
        "machines": tuple(map(heard, WORKSHOP.machines)),
        "atvs": tuple(map(heard, WORKSHOP.fleet)),
        "stations": tuple(map(heard, (*WORKSHOP.stores, GATE))),
    }
    return Picture(at_s=NOW_S, plant=WORKSHOP.id, **usual | fields)


def answers(told: Picture | None = None, **fields: Any) -> Answers:
    usual: dict[str, Any] = {"parts": {"strategist": Part(ok=True)}, "plant": {}}
    return Answers(picture=told or picture(), **usual | fields)


def of(name: str, found: Iterable[Finding]) -> Finding:
    """The finding of this name; the only one."""
    (it,) = (each for each in found if each.name == name)
    return it


def seen(finding: Finding, verdict: Verdict, words: str) -> bool:
    return finding.verdict is verdict and words in finding.seen


# --- agents ------------------------------------------------------------------------------------------


def test_a_plant_in_which_all_are_heard_lacks_no_agent() -> None:
    found = list(agents(WORKSHOP, ("strategist",), answers()))
    assert [each.name for each in found] == [
        "machines",
        "storages and warehouses",
        "gate",
        "vehicles",
        "strategist",
    ]
    assert {each.verdict for each in found} == {Verdict.OK}


@pytest.mark.parametrize(
    ("agent", "said"),
    [
        (None, "never heard: SAW"),
        (heard("SAW", shut_out={"by": "ana"}), "shut out: SAW"),
        (heard("SAW", removal={"by": "ana"}), "reported as off the floor: SAW"),
        (replace(heard("SAW"), seen_at_s=NOW_S - 3.6), "silent: SAW"),
    ],
)
def test_an_agent_that_takes_no_part_is_missing_with_its_reason(agent: Agent | None, said: str) -> None:
    others = tuple(heard(each) for each in WORKSHOP.machines if each != "SAW")
    told = picture(machines=others if agent is None else (*others, agent))
    found = of("machines", agents(WORKSHOP, ("strategist",), answers(told)))
    assert (found.verdict, found.seen) == (Verdict.MISSING, said)
    assert "dray agent machine NAME" in found.todo


def test_silence_is_judged_by_the_plants_clock_and_who_is_out_of_service_is_there() -> None:
    slow = replace(heard("CART1"), seen_at_s=NOW_S - 3.4)
    told = picture(atvs=(slow, heard("CART2", out_of_service={"by": "ana"})))
    found = of("vehicles", agents(WORKSHOP, (), answers(told)))
    assert seen(found, Verdict.OK, "out of service: CART2")
    faster = replace(told, factory=Factory(speed=2.0))
    assert seen(of("vehicles", agents(WORKSHOP, (), answers(faster))), Verdict.MISSING, "silent: CART1")


def test_a_strategist_that_is_silent_is_missing_also_when_others_go_on() -> None:
    lost = {"strategist": Part(ok=True, reason="nothing is heard of strategist2")}
    found = of("strategist", agents(WORKSHOP, ("strategist", "strategist2"), answers(parts=lost)))
    assert seen(found, Verdict.MISSING, "strategist2")
    assert found.todo.endswith("dray strategist strategist; dray strategist strategist2")


def test_a_body_that_does_not_answer_is_a_problem_by_its_name() -> None:
    broken = heard("SAW", status="error", problem="no answer of opc.tcp://saw")
    told = picture(machines=(broken, heard("DRILL"), heard("BENCH")))
    assert seen(bodies(WORKSHOP, answers(told)), Verdict.MISSING, "SAW (no answer of opc.tcp://saw)")
    assert bodies(WORKSHOP, answers(picture(machines=(), atvs=()))).verdict is Verdict.UNKNOWN
    assert seen(bodies(WORKSHOP, answers()), Verdict.OK, "5 machines and vehicles report no problem")
    told = picture(stations=(heard(GATE, problem="its controller is not heard: cut"),))
    assert seen(bodies(WORKSHOP, answers(told)), Verdict.MISSING, "gate (its controller is not heard: cut)")
    silent = replace(heard("CART1"), seen_at_s=NOW_S - 60.0)
    told = picture(atvs=(silent, heard("CART2")))
    assert seen(bodies(WORKSHOP, answers(told)), Verdict.OK, "4 machines and vehicles report no problem")


BY_PEOPLE = tuple(heard(each, unconfirmed=()) for each in WORKSHOP.machines)

COUNTER = "url: opc.tcp://saw\nsignals:\n  pieces: {node: ns=2;s=Good}\n"
SAFE = COUNTER + "  dock_permit: {node: ns=2;s=Here}\n  dock_ready: {node: ns=2;s=Safe}\n"
SCALES = (
    "signals:\n  dock_permit: {topic: a}\n  dock_ready: {topic: b}\nlevels: {paint: {topic: b, path: c}}\n"
)


def test_of_a_dock_of_which_nobody_knows_it_cannot_be_told() -> None:
    found = docks(WORKSHOP, None, None)
    assert seen(found, Verdict.UNKNOWN, "unknown: SAW, DRILL, BENCH, RACK, PAINT")
    some = answers(picture(machines=(heard("SAW"), *BY_PEOPLE[1:])))
    found = docks(WORKSHOP, None, some)
    assert seen(
        found, Verdict.UNKNOWN, "unknown: SAW, RACK, PAINT; without a handshake: DRILL, BENCH (people"
    )


def test_a_dock_that_does_not_get_ready_for_a_vehicle_is_missing() -> None:
    late = Alert("dock_not_ready", "DRILL", ("CART1",))
    assert seen(docks(WORKSHOP, None, answers(picture(alerts=(late,)))), Verdict.MISSING, "DRILL")


def test_mappings_tell_which_docks_shake_hands(tmp_path: Path) -> None:
    stores = {store: [each.material for each in spec.stocks] for store, spec in WORKSHOP.stores.items()}
    for store, items in stores.items():
        (tmp_path / f"{store}.yaml").write_text(SCALES.replace("paint", items[0]))
    (tmp_path / "SAW.yaml").write_text(SAFE)
    (tmp_path / "DRILL.yaml").write_text(COUNTER)
    told = answers(picture(machines=(heard("SAW"), heard("DRILL"), BY_PEOPLE[2])))
    found = docks(WORKSHOP, tmp_path, told)
    assert found.verdict is Verdict.OK
    assert found.seen.split("; ") == [
        "with a handshake: SAW, RACK, PAINT",
        "without a handshake: DRILL (vehicles load as soon as they stand there)",
        "without a handshake: BENCH (people and vehicles report loads)",
    ]


@pytest.mark.parametrize(
    ("place", "text", "said"),
    [
        ("SAW", "signals: 3", "SAW.yaml"),
        ("SAW", "url: opc.tcp://saw\nsignals: {}", "`pieces` is missing"),
        ("RACK", COUNTER, "a storage has"),
        ("RACK", SCALES.replace("paint", "gold"), "levels.gold: this is not kept there"),
    ],
)
def test_a_mapping_that_cannot_be_used_is_missing(tmp_path: Path, place: str, text: str, said: str) -> None:
    (tmp_path / f"{place}.yaml").write_text(text)
    assert seen(docks(WORKSHOP, tmp_path, None), Verdict.MISSING, said)


def test_a_clock_that_is_not_that_of_the_wall_is_no_service() -> None:
    fast = picture(factory=Factory(speed=10.0))
    assert seen(plant_of_gateway(WORKSHOP, answers(fast)), Verdict.MISSING, "10 times real time")


# --- people and keys ---------------------------------------------------------------------------------

ANA, BEN = Person("ana", "manager", (), ("password",)), Person("ben", "operator", (AREA,), ("pin",))


def people(*known: Person, keys: tuple[Key, ...] = (), duty: Duty | None = None) -> list[Finding]:
    return list(people_and_keys(WORKSHOP, answers(people=known, keys=keys, duty=duty), NOW_S))


def test_managers_and_operators_who_can_log_in_are_enough() -> None:
    found = people(ANA, BEN, duty=Duty())
    assert {each.verdict for each in found} == {Verdict.OK}


@pytest.mark.parametrize(
    ("name", "known", "said", "todo"),
    [
        ("managers", (BEN,), "there is none", "dray user add NAME --role manager"),
        ("managers", (replace(ANA, secrets=()),), "none has a password: ana", "dray user password ana"),
        ("managers", (replace(ANA, disabled_at_s=1.0),), "there is none", "dray user add"),
        ("operators", (ANA,), f"no operator may work in {AREA}", f"--area {AREA} --plant FILE"),
        ("operators", (replace(BEN, areas=()),), f"no operator may work in {AREA}", "dray user add"),
        ("operators", (replace(BEN, secrets=()),), "no operator has a PIN", "dray user pin ben"),
    ],
)
def test_whoever_cannot_log_in_is_not_there(
    name: str, known: tuple[Person, ...], said: str, todo: str
) -> None:
    found = of(name, people(*known))
    assert seen(found, Verdict.MISSING, said)
    assert todo in found.todo


def test_an_area_without_anybody_on_duty_is_missing_unless_it_rests() -> None:
    assert seen(of("people on duty", people(duty=Duty((AREA,)))), Verdict.MISSING, AREA)
    resting = Duty((AREA,), {AREA: NOW_S + 3600.0})
    assert seen(of("people on duty", people(duty=resting)), Verdict.OK, f"outside of working time: {AREA}")
    assert of("people on duty", people()).verdict is Verdict.UNKNOWN


@pytest.mark.parametrize(
    ("key", "verdict", "said"),
    [
        (Key("1", "ERP", ("orders:write",)), Verdict.OK, "may place orders: ERP"),
        (Key("1", "MES", ("orders:read",)), Verdict.OK, "none may place orders"),
        (Key("1", "ERP", ("orders:write",), NOW_S + 29 * DAY_S), Verdict.MISSING, "ERP"),
        (Key("1", "ERP", ("orders:write",), NOW_S + 31 * DAY_S), Verdict.OK, "may place orders: ERP"),
        (Key("1", "ERP", ("orders:write",), NOW_S - 1, NOW_S - 2), Verdict.OK, "none may place orders"),
    ],
)
def test_keys_are_renewed_in_time(key: Key, verdict: Verdict, said: str) -> None:
    assert seen(of("API keys", people(keys=(key,))), verdict, said)


# --- certificates ------------------------------------------------------------------------------------


def settings(**fields: Any) -> Settings:
    return Settings.load(**fields)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The certificates of the workshop, made now."""
    authority = Authority.make(WORKSHOP.id)
    authority.write(tmp_path)
    for each in WANTED.values():
        authority.issue(tmp_path, WORKSHOP.id, each)
    return tmp_path


def certified(folder: Path | None, now_s: float, **fields: Any) -> Finding:
    return certificates(WORKSHOP.id, WANTED, settings(**fields), folder, now_s)


@pytest.fixture
def made_s(folder: Path) -> float:
    """When they were made, to the second: they end 397 days later."""
    return Authority.load(folder).certificate.not_valid_before_utc.timestamp() + 3600.0


def test_certificates_of_all_processes_are_good_until_a_month_before_their_end(
    folder: Path, made_s: float
) -> None:
    found = certified(folder, made_s + 365 * DAY_S)
    assert seen(found, Verdict.OK, f"all {len(WANTED)} are there")
    assert seen(certified(None, made_s, bus_certificates=folder), Verdict.OK, "all")
    assert seen(certified(folder, made_s + 368 * DAY_S), Verdict.MISSING, "expires within 30 days")
    assert seen(certified(folder, made_s + 398 * DAY_S), Verdict.MISSING, "expired")


def _remove(folder: Path) -> None:
    (folder / "SAW.pem").unlink()


def _spoil(folder: Path) -> None:
    (folder / "SAW.pem").write_text("no certificate")


def _lose_key(folder: Path) -> None:
    (folder / "SAW.key").unlink()


def _of_another_authority(folder: Path) -> None:
    Authority.make(WORKSHOP.id).issue(folder, WORKSHOP.id, {"SAW": Kind.MACHINE})


def _of_another_plant(folder: Path) -> None:
    Authority.load(folder).issue(folder, "elsewhere", {"SAW": Kind.MACHINE})


def _of_another_kind(folder: Path) -> None:
    Authority.load(folder).issue(folder, WORKSHOP.id, {"SAW": Kind.ATV})


def _call_back(folder: Path) -> None:
    call_back(Authority.load(folder), folder, "SAW", "key-compromise")


@pytest.mark.parametrize(
    ("do", "said"),
    [
        (_remove, "missing for: SAW"),
        (_spoil, "cannot be read: SAW"),
        (_lose_key, "without a key file: SAW"),
        (_of_another_authority, "of another authority: SAW"),
        (_of_another_plant, f"not for this agent of {WORKSHOP.id}: SAW"),
        (_of_another_kind, f"not for this agent of {WORKSHOP.id}: SAW"),
        (_call_back, "revoked: SAW"),
    ],
)
def test_what_is_wrong_with_a_certificate_is_said(
    folder: Path, made_s: float, do: Callable[[Path], None], said: str
) -> None:
    do(folder)
    found = certified(folder, made_s)
    assert (found.verdict, found.seen) == (Verdict.MISSING, said)
    assert f"dray certs issue {folder} machine SAW" in found.todo


def test_without_certificates_links_are_said_to_be_plain_or_something_is_missing(tmp_path: Path) -> None:
    assert seen(certified(None, NOW_S, bus_plain=True), Verdict.OK, "forge messages")
    assert seen(certified(None, NOW_S), Verdict.MISSING, "no folder")
    assert seen(certified(tmp_path, NOW_S), Verdict.MISSING, "authority.pem: No such file")
    (tmp_path / "authority.pem").write_text("no certificate")
    assert certified(tmp_path, NOW_S).verdict is Verdict.MISSING


# --- database ----------------------------------------------------------------------------------------


async def in_database(url: str, now_s: float = NOW_S, **fields: Any) -> dict[str, Finding]:
    return {each.name: each async for each in database(settings(database_url=url, **fields), now_s)}


@pytest.fixture
def url(files: Files, tmp_path: Path) -> str:
    return files.new(tmp_path)


@pytest.mark.anyio
async def test_a_database_that_is_not_there_is_not_made(tmp_path: Path) -> None:
    file = tmp_path / "none.db"
    found = await in_database(f"sqlite:///{file}")
    assert seen(found["database"], Verdict.MISSING, "there is no file")
    assert found["database"].todo == f"dray db upgrade --db sqlite:///{file}"
    assert not await asyncio.to_thread(file.exists)


@pytest.mark.anyio
async def test_what_is_no_database_is_said(tmp_path: Path) -> None:
    (tmp_path / "other.db").write_bytes(b"no database" * 100)
    found = await in_database(f"sqlite:///{tmp_path / 'other.db'}")
    assert seen(found["database"], Verdict.MISSING, "not a database")


@pytest.mark.anyio
async def test_a_database_of_this_version_knows_no_gateway_and_no_agent_yet(url: str) -> None:
    found = await in_database(url)
    assert seen(found["database"], Verdict.OK, "can be written")
    assert seen(found["historian"], Verdict.MISSING, "it has recorded no agent yet")
    assert seen(found["signed commands"], Verdict.MISSING, "no gateway has started")


@pytest.mark.anyio
async def test_the_key_of_the_gateway_has_to_be_one_that_agents_believe(url: str) -> None:
    store = await open_store(url)
    public = (await authority_of(store)).public.hex()
    await store.close()
    assert (await in_database(url))["signed commands"].verdict is Verdict.UNKNOWN
    trusted = await in_database(url, trusted_keys=(public.upper(),))
    assert trusted["signed commands"].verdict is Verdict.OK
    other = await in_database(url, trusted_keys=("00" * 32,))
    assert other["signed commands"].verdict is Verdict.MISSING


@pytest.mark.anyio
async def test_a_historian_that_writes_nothing_is_missing(url: str) -> None:
    store = await open_store(url)
    beat = MachineHeartbeat(machine="SAW", incarnation=1, seq=1, at_s=0.0, status=MachineStatus.IDLE)
    async with store.write() as work:
        await work.samples.add([beat], lambda s: NOW_S + s)
    await store.close()
    assert (await in_database(url, NOW_S + 290.0))["historian"].verdict is Verdict.OK
    late = (await in_database(url, NOW_S + 600.0))["historian"]
    assert seen(late, Verdict.MISSING, "for 10 min")


@pytest.mark.anyio
@pytest.mark.parametrize(
    ("revision", "said"), [(OLDEST, f"at migration {OLDEST} and not "), ("9999", "of a newer Dray")]
)
async def test_tables_of_another_version_are_told(url: str, revision: str, said: str) -> None:
    store = await open_store(url)
    async with store.database.write() as connection:
        await connection.execute(text("UPDATE alembic_version SET version_num = :it"), {"it": revision})
    await store.close()
    assert seen((await in_database(url))["database"], Verdict.MISSING, said)


# --- this computer -----------------------------------------------------------------------------------


def free(count: float) -> Callable[[Path], int]:
    return lambda _folder: round(count)


def test_a_disk_has_to_have_room_for_the_days_that_are_kept(tmp_path: Path) -> None:
    here = settings(database_url=f"sqlite:///{tmp_path / 'd.db'}", journal_folder=tmp_path / "journals")
    # Two vehicles: 500 facts of 500 bytes an hour each in 14 days, and a GiB for all else.
    wanted = 2 * 500 * 500 * 24 * 14 + GIB
    enough = {each.name: each.verdict for each in disks(WORKSHOP, here, free(wanted))}
    assert set(enough.values()) == {Verdict.OK}
    found = {each.name: each.verdict for each in disks(WORKSHOP, here, free(wanted - 1))}
    assert found == {"disk of the database": Verdict.MISSING, "disk of the journals": Verdict.OK}
    assert of("disk of the journals", disks(WORKSHOP, here, free(GIB - 1))).verdict is Verdict.MISSING
    many = here.model_copy(update={"events_most": 1000})
    assert of("disk of the database", disks(WORKSHOP, many, free(GIB + 500_000))).verdict is Verdict.OK


def test_what_a_database_has_taken_is_not_wanted_again(tmp_path: Path) -> None:
    here = settings(database_url=f"sqlite:///{tmp_path / 'd.db'}", journal_folder=tmp_path)
    (tmp_path / "d.db").write_bytes(bytes(100_000_000))
    needed = 2 * 500 * 500 * 24 * 14 + GIB - 100_000_000
    assert of("disk of the database", disks(WORKSHOP, here, free(needed))).verdict is Verdict.OK
    assert of("disk of the database", disks(WORKSHOP, here, free(needed - 1))).verdict is Verdict.MISSING


def test_the_disk_of_a_database_elsewhere_cannot_be_seen() -> None:
    here = settings(database_url="postgresql://dray@db.plant/dray")
    found = of("disk of the database", disks(WORKSHOP, here, free(100 * GIB)))
    assert seen(found, Verdict.UNKNOWN, "it is on db.plant")


@pytest.mark.parametrize(
    ("synchronised", "verdict"),
    [(True, Verdict.OK), (False, Verdict.MISSING), (None, Verdict.UNKNOWN)],
)
def test_a_computer_has_to_keep_its_clock_right(synchronised: bool | None, verdict: Verdict) -> None:
    found = list(clocks(None, lambda: synchronised))
    assert [(each.name, each.verdict) for each in found] == [("clock of this computer", verdict)]


@pytest.mark.parametrize(
    ("ahead_s", "verdict", "said"),
    [
        # The gateway tells whole seconds up to a second old; clocks of one plant agree within a second.
        (0.0, Verdict.OK, "agrees"),
        (1.0, Verdict.OK, "agrees"),
        (1.4, Verdict.MISSING, "at least 1 s ahead of"),
        (-3.0, Verdict.OK, "agrees"),
        (-3.1, Verdict.MISSING, "at least 1 s behind"),
        (3600.0, Verdict.MISSING, "at least 3600 s ahead of"),
    ],
)
def test_the_clock_of_the_gateway_is_compared_as_far_as_it_is_told(
    ahead_s: float, verdict: Verdict, said: str
) -> None:
    told = answers(clock=(NOW_S, NOW_S + ahead_s, NOW_S))
    assert seen(of("clock of the gateway", clocks(told, lambda: True)), verdict, said)


def test_a_slow_answer_makes_no_clock_wrong() -> None:
    told = answers(clock=(NOW_S, NOW_S + 9.0, NOW_S + 10.0))
    assert of("clock of the gateway", clocks(told, lambda: True)).verdict is Verdict.OK
    assert of("clock of the gateway", clocks(answers(), lambda: True)).verdict is Verdict.UNKNOWN


def test_an_agent_whose_clock_is_wrong_is_named() -> None:
    wrong = heard("CART1", clock=Clock(ahead_s=42.0, wrong=True))
    right = heard("CART2", clock=Clock(ahead_s=0.2, wrong=False))
    found = of("clocks of the agents", clocks(answers(picture(atvs=(wrong, right))), lambda: True))
    assert (found.verdict, found.seen) == (Verdict.MISSING, "wrong: CART1 (+42.0 s)")


def test_of_many_names_the_first_ones_are_said() -> None:
    assert named(f"M{number}" for number in range(1, 12)) == "M1, M2, M3, M4, M5, M6, M7, M8 and 3 more"
