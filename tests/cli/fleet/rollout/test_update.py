"""An update: who is replaced and in which order, when all go back, and what is told of it."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from dray.adapters.processes import Process
from dray.cli.fleet.process_registry import Member, ProcessRegistry, State
from dray.cli.fleet.rollout.history import History, RecordedFact
from dray.cli.fleet.rollout.order_statistics import OrderCount
from dray.cli.fleet.rollout.replacement import Terms
from dray.cli.fleet.rollout.report import Report, Step, Verdict
from dray.cli.fleet.rollout.update import Plan, Update, proven_kinds, replaceable
from dray.cli.fleet.software import Software
from dray.errors import SettingsError, UnavailableError
from dray.messages import MachineHeartbeat, Reason
from dray.messages.fact import CarrierChanged, TaskClosed

OLD, NEW = Software("/old/python", "1.0", 1), Software("/new/python", "2.0", 1)

KINDS = {
    "floor": "floor",
    "historian": "historian",
    "strategist": "strategist",
    "M1": "machine",
    "ATV1": "atv",
    "ATV2": "atv",
    "gateway": "gateway",
}


def member(
    name: str, software: Software = OLD, state: State = State.AT_WORK, proven: Software | None = None
) -> Member:
    return Member(
        pid=1,
        born="",
        name=name,
        kind=KINDS[name],
        address="",
        starts=1,
        software=software,
        proven=proven or software,
        state=state,
    )


def registry(*changed: Member) -> ProcessRegistry:
    members = {name: member(name) for name in KINDS} | {each.name: each for each in changed}
    return ProcessRegistry("plant", plain=True, supervisor=Process(1, ""), members=tuple(members.values()))


def plan(*only: str, target: Software = NEW) -> Plan:
    return Plan(Path("fleet"), target, only, canary_tasks=2, patience_s=60.0)


class Scene:
    """A fleet on paper: every replacement takes ten seconds and ends as the test says."""

    speed, first_s = 2.0, 0.0

    def __init__(self, verdicts: dict[str, Verdict], back: Verdict = Verdict.PASSED) -> None:
        self._back = back
        self.done: list[tuple[str, str, int, bool]] = []
        self.settled: list[str] = []
        self._verdicts = verdicts
        self._now_s = 4000.0

    def now_s(self) -> float:
        return self._now_s

    async def replace(self, member: Member, terms: Terms) -> Step:
        self.done.append((member.name, terms.software.version, terms.canary_tasks, terms.at_once))
        verdict = self._verdicts.get(member.name, Verdict.PASSED) if terms.canary_tasks else self._back
        began_s, self._now_s = self._now_s, self._now_s + 10.0
        return Step(
            agent=member.name,
            kind=member.kind,
            version=terms.software.version,
            verdict=verdict,
            began_s=began_s,
            ended_s=self._now_s,
            left_s=1.0,
            killed=False,
            away_s=1.0,
            canary_s=3.0,
            why="it is late" if verdict is Verdict.FAILED else "",
        )

    async def settle(self, member: Member) -> None:
        self.settled.append(member.name)


class OrderStatistics:
    """The database on paper."""

    def __init__(self, history: History | None = None) -> None:
        self._history = history
        self._delivered = 5

    async def orders(self) -> OrderCount:
        self._delivered += 2
        return OrderCount(self._delivered, self._delivered - 6)

    async def missing(self, numbers: dict[str, tuple[int, int]]) -> int:
        return 0

    async def history(self, from_s: float, to_s: float) -> History:
        assert from_s == 400.0, "an hour before"
        if self._history is None:
            raise UnavailableError("database", "is away", "wait")
        return self._history


class Listener:
    """Nobody says anything."""

    def __init__(self) -> None:
        self.numbers: dict[str, tuple[int, int]] = {}
        self.machines: dict[str, MachineHeartbeat] = {}


def update(
    scene: Scene,
    members: Sequence[Member],
    statistics: OrderStatistics | None = None,
    proven: Sequence[str] = (),
) -> Report:
    paper: Any = (scene, Listener(), statistics or OrderStatistics(History(())))
    return asyncio.run(Update(plan(), *paper, lambda _: None).run(members, set(proven)))


def test_vehicles_come_first_and_people_last_and_the_floor_never() -> None:
    names = [each.name for each in replaceable(registry(), plan())]
    assert names == ["ATV1", "ATV2", "M1", "strategist", "historian", "gateway"]
    assert [each.name for each in replaceable(registry(), plan("M1", "ATV2"))] == ["ATV2", "M1"]
    assert [each.name for each in replaceable(registry(), plan("ATV1", "ATV1"))] == ["ATV1"]


def test_an_update_goes_on_where_it_was_stopped() -> None:
    there = registry(member("ATV1", NEW), member("ATV2", NEW, State.CANARY))
    assert [each.name for each in replaceable(there, plan())][:2] == ["ATV2", "M1"]
    assert proven_kinds(there, NEW) == {"atv"}
    assert proven_kinds(registry(member("ATV2", NEW, State.CANARY)), NEW) == set()


@pytest.mark.parametrize("name", ["ATV9", "floor"])
def test_nobody_is_replaced_who_is_not_there_or_has_no_software(name: str) -> None:
    with pytest.raises(SettingsError, match="--only: there is no"):
        replaceable(registry(), plan(name))


@pytest.mark.parametrize("wire", [0, 2])
def test_another_wire_version_is_refused(wire: int) -> None:
    with pytest.raises(SettingsError, match=f"3.0 speaks wire version {wire} and historian 1"):
        replaceable(registry(), plan(target=Software("/new", "3.0", wire)))


def test_all_are_replaced_on_probation_and_each_that_passes_is_settled() -> None:
    scene = Scene({})
    report = update(scene, [member("ATV1"), member("M1")])
    assert scene.done == [("ATV1", "2.0", 2, False), ("M1", "2.0", 2, False)]
    assert scene.settled == ["ATV1", "M1"]
    assert report.done
    assert report.took_s == 10.0


def test_when_one_fails_it_goes_back_at_once_and_then_all_others_in_order() -> None:
    scene = Scene({"M1": Verdict.FAILED})
    report = update(scene, [member("ATV1"), member("ATV2"), member("M1"), member("gateway")])
    assert scene.done[2:] == [
        ("M1", "2.0", 2, False),
        ("M1", "1.0", 0, True),
        ("ATV2", "1.0", 0, False),
        ("ATV1", "1.0", 0, False),
    ]
    assert not report.done
    assert report.end == "M1 has failed with 2.0: it is late; all are back"
    assert [step.verdict for step in report.steps[3:]] == [Verdict.BACK] * 3


def test_each_goes_back_to_the_software_that_it_had() -> None:
    older = Software("/older/python", "0.9", 1)
    scene = Scene({"M1": Verdict.FAILED})
    interrupted = member("ATV2", NEW, State.CANARY, proven=OLD)
    update(scene, [member("ATV1", older), interrupted, member("M1")])
    back = [(name, version) for name, version, _, _ in scene.done[3:]]
    assert back == [("M1", "1.0"), ("ATV2", "1.0"), ("ATV1", "0.9")]


def test_who_does_not_come_back_is_named() -> None:
    scene = Scene({"ATV1": Verdict.FAILED}, back=Verdict.FAILED)
    report = update(scene, [member("ATV1")])
    assert report.end.endswith("ATV1 did not come back")


def test_the_first_of_a_kind_that_finds_no_work_goes_back_alone_and_the_update_stops() -> None:
    scene = Scene({"M1": Verdict.UNTRIED})
    report = update(scene, [member("ATV1"), member("M1"), member("gateway")])
    assert scene.done == [("ATV1", "2.0", 2, False), ("M1", "2.0", 2, False), ("M1", "1.0", 0, False)]
    assert scene.settled == ["ATV1"]
    assert not report.done
    assert "M1 has done 0 of 2 tasks" in report.end


@pytest.mark.parametrize(("first", "proven"), [(["ATV1"], []), ([], ["atv"])], ids=["now", "before"])
def test_who_finds_no_work_stays_when_another_of_its_kind_has_passed(
    first: list[str], proven: list[str]
) -> None:
    scene = Scene({"ATV2": Verdict.UNTRIED})
    report = update(scene, [*map(member, first), member("ATV2")], proven=proven)
    assert report.done
    assert scene.settled == [*first, "ATV2"]
    assert report.steps[-1].verdict is Verdict.UNTRIED


def test_nothing_is_done_when_all_run_it() -> None:
    report = update(Scene({}), [])
    assert (report.done, report.steps, report.end) == (True, (), "every process runs it already")


def test_the_report_tells_what_it_has_cost() -> None:
    moments_s = [500.0 + 60.0 * minute for minute in range(50)]
    told = [
        RecordedFact("M1", at_s, TaskClosed(task=f"t{at_s}", epoch=1, outcome="delivered", carrier="ATV1"))
        for at_s in moments_s
    ]
    left = CarrierChanged(task="t", epoch=2, replaced="ATV1", carrier="ATV2", reason=Reason.GRACEFUL_SHUTDOWN)
    report = update(
        Scene({}), [member("ATV1")], OrderStatistics(History([*told, RecordedFact("M1", 4005.0, left)]))
    )
    assert report.cost is not None
    assert report.cost.before.mean == pytest.approx(50 / 60)
    assert report.cost.during.mean == 0.0
    assert report.cost.orders == OrderCount(2, 2)
    assert [step.passed_on for step in report.steps] == [1]


def test_without_a_database_the_update_is_told_all_the_same() -> None:
    report = update(Scene({}), [member("ATV1")], OrderStatistics(None))
    assert report.done
    assert report.cost is None
