"""The benchmark that kills: its judgement finds what is planted, and a small fleet survives a few kills."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any, Literal

import msgspec
import pytest
from check_kit import opened

sys.path.insert(0, str(Path(__file__).parents[2] / "cli/fleet"))

from registries import NOBODY, write_registry

from dray.adapters.zenoh.tokens import Tokens
from dray.cli.fleet.folder import LOGS, REGISTRY, write_settings
from dray.cli.fleet.processes import Process
from dray.errors import UnavailableError
from dray.gateway.live.timescale import TimeScale
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    Event,
    GoalBrief,
    MachineHeartbeat,
    MachineStatus,
    Phase,
    Pose,
    Production,
    Role,
)
from dray.messages.fact import (
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    Fact,
    GoalLost,
    GoodsDelivered,
    OrderFulfilled,
    PhaseEntered,
    PieceMade,
    TaskClosed,
    WatchLost,
)
from dray.messages.keys import Keys
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray_sim.bench.losses import campaign
from dray_sim.bench.losses.campaign import Campaign, Outcome
from dray_sim.bench.losses.cost import (
    ANNOUNCED,
    GIVEN_AWAY,
    KEPT,
    TAKEN_OVER,
    WATCHED_ANEW,
    Fate,
    Kill,
    fates,
)
from dray_sim.bench.losses.figures import rows
from dray_sim.bench.losses.fleet import Fleet, running
from dray_sim.bench.losses.history import History
from dray_sim.bench.losses.judgement import ENDED, Aftermath, judge
from dray_sim.bench.losses.victims import DATABASE, LASTING, Kind, Rota, Victim, crew, machine, vehicle
from dray_sim.bench.losses.watch import gathered
from dray_sim.bench.losses.works import Works
from dray_sim.bench.postgres import PostgresServer
from dray_sim.bodies.floor import Pieces
from dray_sim.explore.run import draw
from dray_sim.run.witness import Witness

GOAL = Production(product="pump-p3", quantity=24, order="O-1", item=0)
ORDER = Order(
    id="O-1",
    status=OrderStatus.DELIVERED,
    customer="Benchmark",
    token="t",
    items=(Item("pump-p3", 24),),
    created_at_s=0.0,
    reference="D1",
    due_at_s=900.0,
    delivered_at_s=600.0,
)
PATIENCE_S = 30.0
"""Real seconds for what takes a moment."""

PIECES = Pieces(balance={"shaft": 100, "pump-p3": 0}, delivered={}, arrived={})


class Told:
    """Facts, one second after the other, numbered as agents number them."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self._numbers: Counter[tuple[str, int]] = Counter()

    def by(self, agent: str, *facts: Fact, life: int = 1) -> None:
        for fact in facts:
            self._numbers[agent, life] += 1
            at_s = 1.0 + len(self.events)
            self.events.append(Event(agent, life, self._numbers[agent, life], at_s, fact))

    @property
    def history(self) -> History:
        history = History()
        history.add(self.events)
        return history


def taken(task: str, role: Role = Role.PRIMARY) -> ContractTaken:
    return ContractTaken(task=task, epoch=1, role=role, coordinator="M8")


def handed_over(task: str) -> ContractEnded:
    return ContractEnded(task=task, epoch=1, role=Role.PRIMARY, reason="handed_over")


def closed(
    task: str, carrier: str = "ATV2", outcome: Literal["delivered", "withdrawn"] = "delivered"
) -> TaskClosed:
    return TaskClosed(task=task, epoch=1, outcome=outcome, carrier=carrier)


def changed(carrier: str) -> CarrierChanged:
    return CarrierChanged(task="M8-1", epoch=2, replaced="ATV2", carrier=carrier, reason="silent")


def arrived(goal: str, pieces: int) -> GoodsDelivered:
    return GoodsDelivered(
        goal=goal, order="O-1", item=0, product="pump-p3", quantity=pieces, delivered=pieces
    )


def heartbeat(**fields: object) -> MachineHeartbeat:
    return MachineHeartbeat(
        machine="M8", incarnation=1, seq=1, at_s=1000.0, status=MachineStatus.IDLE, **fields
    )


def whole() -> Told:
    """One order, made and delivered, with one transport of material."""
    told = Told()
    told.by("strategist", opened("G1", GOAL))
    told.by("M8", opened("M8-1"))
    told.by("ATV2", taken("M8-1"), handed_over("M8-1"))
    told.by("M8", closed("M8-1"))
    told.by("strategist", arrived("G1", 24), closed("G1", "M8"), OrderFulfilled(order="O-1"))
    return told


def aftermath(told: Told) -> Aftermath:
    """Of a factory in which nothing went wrong, but for what was told."""
    return Aftermath(
        history=told.history,
        unwritten=[],
        heartbeats=[heartbeat()],
        accepted={"D1": "O-1"},
        refused={},
        orders=[ORDER],
        first=PIECES,
        last=Pieces(balance=PIECES.balance, delivered={"pump-p3": 24}, arrived={"G1": 24}),
        starts={"M8": 2, "ATV2": 1},
        kills={"M8": 1},
    )


def found(after: Aftermath) -> set[str]:
    return {finding.what for finding in judge(after) if finding.seen}


def test_where_nothing_is_wrong_nothing_is_found() -> None:
    after = aftermath(whole())
    assert found(after) == set()
    assert all(finding.of for finding in judge(after))


def test_a_task_that_its_machine_has_forgotten_is_found() -> None:
    told = whole()
    told.by("M8", opened("M8-2"))
    assert found(aftermath(told)) == {"tasks lost"}


def test_a_finding_hides_no_other() -> None:
    told = whole()
    told.by("M9", closed("M9-1"), closed("M9-2"))
    lost = next(finding for finding in judge(aftermath(told)) if finding.what == "tasks lost")
    assert len(lost.seen) == 2


def test_a_task_that_two_vehicles_have_handed_over_is_found() -> None:
    told = whole()
    told.by("ATV3", taken("M8-1"), handed_over("M8-1"))
    assert found(aftermath(told)) == {"handovers doubled"}


def test_a_vehicle_that_was_primary_of_two_tasks_is_found_over_its_lives() -> None:
    told = whole()
    told.by("ATV3", taken("M8-1"))
    told.by("ATV3", taken("M9-1"), life=2)
    assert found(aftermath(told)) == {"vehicles with two tasks"}


def test_a_carrier_that_is_released_from_a_contract_that_it_had_is_found() -> None:
    accepted = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    released = ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason="released")
    told = whole()
    told.by("M8", opened("M8-2"), accepted)
    told.by("ATV2", taken("M8-2"), released)
    told.by("M8", closed("M8-2"))
    assert found(aftermath(told)) == {"contracts lost for nothing"}


@pytest.mark.parametrize("answer", ["silent", "accepted"])
def test_a_carrier_is_released_for_a_reason_when_it_was_silent_or_replaced(answer: str) -> None:
    answered = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer=answer)
    replaced = CarrierChanged(task="M8-2", epoch=2, replaced="ATV2", carrier="", reason="silent")
    told = whole()
    told.by("M8", opened("M8-2"), answered, *([replaced] if answer == "accepted" else []))
    told.by(
        "ATV2",
        taken("M8-2"),
        ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason="released"),
    )
    told.by("M8", closed("M8-2"))
    assert found(aftermath(told)) == set()


def test_a_carrier_that_was_silent_is_released_for_a_reason_though_it_is_asked_again_and_accepts() -> None:
    def answered(answer: str) -> AwardAnswered:
        return AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer=answer)

    released = ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason="released")
    told = whole()
    told.by("M8", opened("M8-2"), answered("silent"))
    told.by("ATV2", taken("M8-2"), released, taken("M8-2"))
    told.by("M8", answered("accepted"), closed("M8-2"))
    assert found(aftermath(told)) == set()


def test_a_carrier_that_comes_back_when_its_task_was_withdrawn_is_released_for_a_reason() -> None:
    accepted = AwardAnswered(task="M8-2", epoch=1, role=Role.PRIMARY, bidder="ATV2", answer="accepted")
    told = whole()
    told.by("M8", opened("M8-2"), accepted, closed("M8-2", outcome="withdrawn"))
    told.by(
        "ATV2",
        taken("M8-2"),
        ContractEnded(task="M8-2", epoch=1, role=Role.PRIMARY, reason="released"),
    )
    assert found(aftermath(told)) == set()


def test_an_accepted_order_that_is_not_delivered_is_found() -> None:
    after = aftermath(whole())
    in_work = msgspec.structs.replace(ORDER, status=OrderStatus.IN_PRODUCTION)
    assert found(replace(after, orders=[in_work])) == {"accepted orders lost"}


def test_an_accepted_order_that_nobody_knows_is_found() -> None:
    after = aftermath(whole())
    assert found(replace(after, accepted={"D1": "O-1", "D2": "O-2"})) == {"accepted orders lost"}


def test_an_order_that_is_there_twice_is_found() -> None:
    after = aftermath(whole())
    twin = msgspec.structs.replace(ORDER, id="O-2", items=())
    assert found(replace(after, orders=[ORDER, twin])) == {"orders doubled"}


def test_an_order_that_was_refused_is_found() -> None:
    assert found(replace(aftermath(whole()), refused={"D2": "no"})) == {"orders refused"}


@pytest.mark.parametrize("pieces", [23, 25])
def test_a_piece_too_few_or_too_many_at_the_gate_is_found(pieces: int) -> None:
    after = aftermath(whole())
    last = Pieces(balance=PIECES.balance, delivered={"pump-p3": pieces}, arrived={"G1": pieces})
    assert found(replace(after, last=last)) == {"pieces too many or too few"}


def test_pieces_that_arrived_beside_the_gate_are_found() -> None:
    after = aftermath(whole())
    last = msgspec.structs.replace(after.last, delivered={"pump-p3": 25})
    assert found(replace(after, last=last)) == {"pieces too many or too few"}


@pytest.mark.parametrize("pieces", [99, 101])
def test_material_that_is_lost_or_made_of_nothing_is_found(pieces: int) -> None:
    after = aftermath(whole())
    last = msgspec.structs.replace(after.last, balance={"shaft": pieces, "pump-p3": 0})
    assert found(replace(after, last=last)) == {"pieces lost or made of nothing"}


def test_a_process_that_ended_by_itself_is_found() -> None:
    after = aftermath(whole())
    assert found(replace(after, starts={"M8": 3, "ATV2": 1})) == {ENDED}


def test_a_hole_in_a_history_is_found() -> None:
    told = whole()
    del told.events[2]
    assert found(aftermath(told)) == {"holes in histories"}
    assert told.history.holes == ["ATV2, life 1: 1"]


def test_a_long_hole_is_told_in_few_words() -> None:
    told = Told()
    told.by("M8", *(PieceMade(goal="G1", product="pump-p3", made=made) for made in range(1, 13)))
    del told.events[2:7], told.events[4]
    assert told.history.holes == ["M8, life 1: 3 to 7, 10"]


def test_a_fact_that_only_its_agent_has_is_found() -> None:
    told = whole()
    told.by("M9", *(PieceMade(goal="G2", product="pump-p3", made=made) for made in range(1, 4)))
    written = History()
    written.add(told.events[:-2])
    unwritten = written.lacking(told.events)
    assert unwritten == ["M9, life 1: 2 to 3"]
    assert found(replace(aftermath(whole()), unwritten=unwritten)) == {"facts not in the database"}


def test_what_the_database_and_a_journal_both_have_is_told_once() -> None:
    told = whole()
    history = told.history
    history.add(told.events)
    assert history.events == told.events


# --- what it costs ----------------------------------------------------------------------------------


def fate_of(kind: Kind, name: str, work: str, told: Told) -> list[Fate]:
    return fates(Kill(Victim(name, kind, (work,)), at_s=1.5, away_s=2.0), Works(told.events))


def test_a_task_is_taken_over_when_its_secondary_has_it() -> None:
    told = Told()
    told.by("M8", opened("M8-1"), changed("ATV3"))
    assert fate_of(Kind.FETCHING, "ATV2", "M8-1", told) == [Fate(TAKEN_OVER, 2.0)]


def test_a_task_that_was_announced_anew_goes_on_when_somebody_has_taken_it() -> None:
    told = Told()
    told.by("M8", opened("M8-1"), changed(""))
    told.by("ATV3", taken("M8-1"))
    for kind in (Kind.LOADED, Kind.VEHICLE_AWAY):
        assert fate_of(kind, "ATV2", "M8-1", told) == [Fate(ANNOUNCED, 3.0)]


def test_a_vehicle_that_comes_back_in_time_keeps_its_task() -> None:
    told = Told()
    told.by("M8", opened("M8-1"))
    told.by("ATV2", PhaseEntered(task="M8-1", epoch=1, phase=Phase.LOADING), life=2)
    assert fate_of(Kind.FETCHING, "ATV2", "M8-1", told) == [Fate(KEPT, 2.0)]


def test_a_task_without_its_secondary_is_watched_anew() -> None:
    told = Told()
    told.by("M8", opened("M8-1"), WatchLost(task="M8-1", epoch=1, secondary="ATV4", reason="silent"))
    told.by("ATV5", taken("M8-1", Role.SECONDARY))
    assert fate_of(Kind.WATCHING, "ATV4", "M8-1", told) == [Fate(WATCHED_ANEW, 3.0)]


def test_a_goal_is_given_to_another_machine_or_kept() -> None:
    told = Told()
    told.by("strategist", opened("G1", GOAL), GoalLost(goal="G1", machine="M8", arrived=0, successor="G2"))
    for kind in (Kind.MACHINE, Kind.MACHINE_AWAY):
        assert fate_of(kind, "M8", "G1", told) == [Fate(GIVEN_AWAY, 2.0)]
    told = Told()
    told.by("strategist", opened("G1", GOAL))
    told.by("M8", PieceMade(goal="G1", product="pump-p3", made=7), life=2)
    assert fate_of(Kind.MACHINE, "M8", "G1", told) == [Fate(KEPT, 2.0)]


def test_what_was_over_before_the_kill_has_no_fate() -> None:
    told = Told()
    told.by("M8", closed("M8-1"))
    assert fate_of(Kind.LOADED, "ATV2", "M8-1", told) == []


# --- who is next ------------------------------------------------------------------------------------


def beat(**fields: object) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv="ATV2",
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.WORKING,
        pose=Pose(0.0, 0.0, 0.0),
        node="c3",
        speed_mps=0.0,
        battery_frac=1.0,
        **fields,
    )


def brief(role: Role, phase: Phase | None = None) -> Brief:
    return Brief(task="M8-1", epoch=1, role=role, coordinator="M8", phase=phase)


def test_a_victim_is_what_it_says_of_itself() -> None:
    approaching = brief(Role.PRIMARY, Phase.APPROACHING)
    assert vehicle(beat()) == Victim("ATV2", Kind.IDLE)
    assert vehicle(beat(task=approaching)) == Victim("ATV2", Kind.FETCHING, ("M8-1",))
    assert vehicle(beat(task=brief(Role.PRIMARY, Phase.CARRYING), load="shaft")).kind is Kind.LOADED
    assert vehicle(beat(task=brief(Role.PRIMARY, Phase.LOADING), load="shaft")).kind is Kind.LOADED
    assert vehicle(beat(watches=(brief(Role.SECONDARY),))) == Victim("ATV2", Kind.WATCHING, ("M8-1",))
    assert vehicle(beat(task=approaching, watches=(brief(Role.SECONDARY),))).kind is Kind.FETCHING
    assert machine(heartbeat()) == Victim("M8", Kind.MACHINE)


def test_a_machine_is_killed_with_all_that_carry_for_it() -> None:
    carrier, other = (
        brief(Role.PRIMARY, Phase.CARRYING),
        msgspec.structs.replace(brief(Role.PRIMARY), coordinator="M9"),
    )
    vehicles = [beat(task=carrier), msgspec.structs.replace(beat(task=other), atv="ATV3"), beat()]
    killed = crew(heartbeat(), vehicles)
    assert killed is not None
    assert (killed.name, killed.kind) == ("M8", Kind.CREW_MACHINE)
    assert killed.crew == (Victim("ATV2", Kind.CREW_VEHICLE, ("M8-1",)),)
    assert crew(heartbeat(), vehicles[1:]) is None


def test_every_kind_has_its_turns_before_chance_does() -> None:
    living = [Victim(kind.value, kind) for kind in Kind]
    rota = Rota(Random(1), dict.fromkeys(Kind, 2))
    assert [rota.choose(living) for _ in range(2 * len(living))] == [*living, *living]
    named = {rota.choose(living) for _ in range(100)}
    assert named == {victim for victim in living if victim.kind not in LASTING}


def test_a_kind_that_nobody_is_of_waits_for_its_turn() -> None:
    rota = Rota(Random(1), dict.fromkeys(Kind, 1))
    idle, loaded = Victim("ATV1", Kind.IDLE), Victim("ATV2", Kind.LOADED)
    assert rota.choose([loaded]) == loaded
    assert rota.choose([idle, loaded]) == idle
    assert rota.choose([loaded]) == loaded
    assert rota.choose([]) is None


def around(killed: dict[Victim, float], back: set[str]) -> list[Victim]:
    """Who may be killed next, of a vehicle and a machine with work, the offices and the database."""
    watch = Deaf(back)
    watch.heard.on_message(0.0, "", "", beat(task=brief(Role.PRIMARY, Phase.CARRYING), load="shaft"))
    goal = GoalBrief(goal="G1", product="pump-p3", quantity=24, made=0, delivered=0)
    watch.heard.on_message(0.0, "", "", heartbeat(goals=(goal,)))
    paper: Any = Ailing(ended=False), watch, None, object()
    field = campaign._Field(SMALL, *paper)
    field._killed = list(killed.items())
    return list(field._living())


def test_who_has_work_may_also_stay_away_one_of_a_kind_at_a_time() -> None:
    assert {victim.kind for victim in around({}, set())} == {
        Kind.LOADED,
        Kind.MACHINE,
        Kind.CREW_MACHINE,
        *(Kind.STRATEGIST, Kind.HISTORIAN, Kind.GATEWAY, Kind.DATABASE),
        *LASTING,
    }
    away = {Victim("ATV7", Kind.VEHICLE_AWAY): 1.0}
    assert Kind.VEHICLE_AWAY not in {victim.kind for victim in around(away, set())}
    assert Kind.VEHICLE_AWAY in {victim.kind for victim in around(away, {"ATV7"})}


def test_who_is_away_is_not_killed_and_the_database_not_while_others_could_not_start_without_it() -> None:
    away = {Victim("ATV2", Kind.LOADED): 1.0, Victim("gateway", Kind.GATEWAY): 1.0}
    assert {victim.name for victim in around(away, set())} == {"M8", "strategist", "historian"}
    assert DATABASE in around(away, {"gateway"})


# --- a fleet that does not do what it should ---------------------------------------------------------


class Ailing:
    """A fleet that cannot be killed, or of which nobody comes back."""

    url, token = "http://127.0.0.1:1", "t"
    time = TimeScale(0.0, 0.0, 1.0)

    def __init__(self, *, ended: bool) -> None:
        self._ended = ended

    def kill(self, name: str) -> bool:
        if self._ended:
            raise UnavailableError("fleet.json", "no such file", "start a fleet")
        return True

    def last_words(self, name: str) -> str:
        return f"the log of {name} ends with: Aargh"


class Deaf:
    """A watch that hears nobody, and sees some come back."""

    def __init__(self, back: Collection[str] = ()) -> None:
        self.heard = Witness()
        self._back = back

    def joined_since(self, agent: str, since_s: float) -> float | None:
        return since_s + 1.0 if agent in self._back else None


@pytest.mark.parametrize(
    ("ended", "told"),
    [
        (True, "fleet.json: no such file"),
        (False, r"(\w+), \w+: not back in 0 s; the log of \1 ends with: Aargh"),
    ],
    ids=["has ended", "does not come back"],
)
def test_a_fleet_that_ends_or_does_not_recover_ends_the_campaign_with_the_reason(
    monkeypatch: pytest.MonkeyPatch, ended: bool, told: str
) -> None:
    monkeypatch.setattr(campaign, "RETURN_S", 0.0)
    plan: Any = replace(SMALL, quiet_s=0.0, pause_s=0.01, head_start_s=0.0)
    paper: Any = Ailing(ended=ended), Deaf(), None, None

    async def play() -> None:
        async with asyncio.timeout(PATIENCE_S):
            await campaign._Field(plan, *paper).play()

    with pytest.raises(UnavailableError, match=told):
        asyncio.run(play())


class Bus:
    """A bus on which nobody is."""

    keys = Keys("plant")
    tokens = Tokens(keys.alive, None, print)

    @property
    def inner(self) -> Any:
        return self

    def join(self, name: str, on_message: object) -> Any:
        return self

    def subscribe(self, key: str) -> None:
        pass

    def liveliness(self) -> Any:
        return self

    def declare_subscriber(self, key: str, on_sample: object, *, history: bool) -> None:
        pass


DEAF_TO_SIGNALS = """\
#!/bin/sh
trap '' TERM
echo "2 processes; all of them were started"
while true; do sleep 0.1; done
"""


def write_fleet(folder: Path, *pids: int) -> None:
    """A fleet's folder whose keeper has ended and whose processes have not."""
    write_registry(folder, NOBODY, *map(Process.of, pids))
    write_settings(folder, {"DRAY_PORT": "4711", "DRAY_DATABASE_URL": f"sqlite:///{folder / 'fleet.db'}"}, ())
    (folder / LOGS).mkdir()


def test_whoever_is_not_there_in_time_is_named_with_what_it_has_said(tmp_path: Path) -> None:
    with subprocess.Popen(["sleep", "60"]) as member:
        write_fleet(tmp_path, member.pid)
        (tmp_path / LOGS / "ATV1.log").write_text("first\n" * 20 + "no floor\n")
        bus: Any = Bus()
        with pytest.raises(UnavailableError, match=r"(?s)ATV1: not on the bus in 0 s; .*first\nno floor$"):
            asyncio.run(gathered(Fleet(tmp_path, "t"), bus, 0.0))
        member.kill()


def test_a_fleet_is_known_by_its_folder_whatever_the_environment_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_fleet(tmp_path)
    monkeypatch.setenv("DRAY_DATABASE_URL", "sqlite:///elsewhere.db")
    monkeypatch.setenv("DRAY_PORT", "80")
    fleet = Fleet(tmp_path, "t")
    assert fleet.database_url.endswith(f"{tmp_path}/fleet.db")
    assert fleet.url == "http://127.0.0.1:4711"


TELLS_HOW_IT_WAS_STARTED = """\
#!/bin/sh
env | grep ^DRAY_ | cut -d= -f1 > "$0.env"
echo "$@" > "$0.options"
echo "2 processes; all of them were started"
exec sleep 60
"""


def test_a_fleet_knows_nothing_of_the_database_and_the_settings_of_whoever_measures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DRAY_DATABASE_URL", "postgresql://shop@db/shop")
    monkeypatch.setenv("DRAY_LEAVE_S", "1")
    python = tmp_path / "python"
    python.write_text(TELLS_HOW_IT_WAS_STARTED)
    python.chmod(0o700)
    monkeypatch.setattr("sys.executable", str(python))
    write_fleet(tmp_path)

    async def story() -> None:
        async with running(tmp_path, SMALL.plant, speed=1.0, plain=True):
            pass

    asyncio.run(story())
    assert Path(f"{python}.env").read_text().split() == ["DRAY_ADMIN_TOKEN"]
    assert f"--db sqlite:///{tmp_path}/dray.db" in Path(f"{python}.options").read_text()


def test_a_fleet_that_does_not_end_is_killed_with_all_its_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray_sim.bench.losses.fleet.STOP_S", 0.0)
    python = tmp_path / "python"
    python.write_text(DEAF_TO_SIGNALS)
    python.chmod(0o700)
    monkeypatch.setattr("sys.executable", str(python))

    async def story() -> None:
        async with running(tmp_path, SMALL.plant, speed=1.0, plain=True):
            pass

    # Whoever runs the tests in the background of a shell has them, and what they start, ignore that signal.
    with subprocess.Popen(["env", "--default-signal=INT", "sleep", "60"]) as member:
        write_fleet(tmp_path, member.pid)
        asyncio.run(story())
        assert member.wait(PATIENCE_S) == -signal.SIGINT
    assert not (tmp_path / REGISTRY).exists()


# --- a small fleet ----------------------------------------------------------------------------------

SMALL = Campaign(
    # Small containers and short cycles: much is carried in little time.
    plant=draw(24).plant,
    speed=20.0,
    plain=True,
    load=0.8,
    head_start_s=100.0,
    warm_s=0.0,
    quiet_s=15.0,
    each=1,
    lasting=1,
    kills=14,
    pause_s=2.0,
    down=2,
    # Ten minutes of the plant, as its goods are waited for.
    lasting_s=30.0,
    dark_s=2.0,
    drain_s=240.0,
    seed=1,
)


@pytest.mark.slow
def test_a_small_fleet_loses_nothing_when_one_of_every_kind_is_killed(
    tmp_path: Path, mortal_postgres: PostgresServer
) -> None:
    outcome: Outcome = asyncio.run(campaign.play(SMALL, tmp_path, mortal_postgres))
    # The last one may have been a machine with all that carry for it.
    assert len(outcome.kills) + len(outcome.outages) >= SMALL.kills
    assert outcome.outages
    assert all(kill.away_s is not None for kill in outcome.kills)
    assert {Kind.MACHINE, Kind.STRATEGIST, Kind.HISTORIAN, Kind.GATEWAY} <= {
        kill.victim.kind for kill in outcome.kills
    }
    assert any(kill.victim.kind in LASTING for kill in outcome.kills)
    findings = judge(outcome.after)
    # Beside other tests a process may find no way to its body for so long that it gives up and is started again.
    lost = {finding.what: finding.seen for finding in findings if finding.what != ENDED}
    assert not any(lost.values()), lost
    assert all(finding.of for finding in findings)
    figures = rows(outcome)
    assert all(row.met for row in figures if ENDED not in row.name)
    assert {f"losses: {kill.victim.kind}, away" for kill in outcome.kills} <= {row.name for row in figures}
