"""What a factory did meanwhile, from its history: flows, what was lost or done twice, who passed on what."""

from __future__ import annotations

import pytest
from makings import making

from dray.cli.fleet.rollout.history import WINDOW_S, History, RecordedFact
from dray.messages import (
    AnyFact,
    MachineHeartbeat,
    MachineStatus,
    Production,
    Reason,
    Role,
    TaskBrief,
    Transport,
)
from dray.messages.fact import CarrierChanged, ContractEnded, TaskClosed, TaskOpened
from dray.messages.keys import STRATEGIST

TRANSPORT = Transport(item="steel", quantity=1, sources=("S1",), destination="M1", ability="pallet")


def opened(task: str, role: Role = Role.PRIMARY, work: Transport | Production = TRANSPORT) -> TaskOpened:
    return TaskOpened(
        task=task, epoch=1, role=role, round=1, work=work, radius_m=1.0, deadline_s=0.0, bids_until_s=0.0
    )


def closed(task: str, outcome: str = "delivered", carrier: str = "ATV1") -> TaskClosed:
    return TaskClosed(task=task, epoch=1, outcome=outcome, carrier=carrier)


def handed_over(task: str, role: Role = Role.PRIMARY) -> ContractEnded:
    return ContractEnded(task=task, epoch=1, role=role, reason=Reason.HANDED_OVER)


def words(at_s: float, *tasks: str) -> dict[str, MachineHeartbeat]:
    """What M1 says at that moment that it has open."""
    briefs = tuple(
        TaskBrief(task=task, epoch=1, item="steel", quantity=1, source="", destination="M1", deadline_s=0.0)
        for task in tasks
    )
    heard = MachineHeartbeat(
        machine="M1", incarnation=1, seq=1, at_s=at_s, status=MachineStatus.IDLE, tasks=briefs
    )
    return {"M1": heard}


def told(*facts: tuple[str, AnyFact], every_s: float = 1.0) -> History:
    return History(RecordedFact(agent, every_s * place, fact) for place, (agent, fact) in enumerate(facts))


def test_a_task_that_is_open_and_that_its_machine_does_not_name_is_lost() -> None:
    history = told(("M1", opened("a")), ("M1", opened("b")), ("M1", closed("b")), ("M1", opened("c")))
    assert history.lost(words(10.0, "c")) == {"a"}
    assert history.lost(words(10.0, "a", "c")) == set()
    assert history.lost(words(0.0)) == set(), "it was said before they were opened"
    assert history.lost({}) == set(), "nobody has said anything"


def test_goals_and_watches_are_no_transports() -> None:
    goal = making("P1", 1, "O1")
    history = told((STRATEGIST, opened("g", work=goal)), ("M1", opened("w", role=Role.SECONDARY)))
    assert history.lost(words(10.0)) == set()
    assert told((STRATEGIST, closed("g")), (STRATEGIST, closed("g"))).twice == set()


def test_what_is_delivered_or_handed_over_twice_is_told() -> None:
    twice = told(("M1", closed("a")), ("M1", closed("a")), ("M1", closed("b", "withdrawn")))
    assert (twice.twice, twice.delivered_s) == ({"a"}, [0.0])
    by_two = told(("ATV1", handed_over("a")), ("ATV2", handed_over("a")), ("ATV1", handed_over("b")))
    assert by_two.twice == {"a"}
    assert told(("ATV1", handed_over("a")), ("ATV1", handed_over("a"))).twice == set()


def test_what_a_vehicle_passes_on_is_counted_within_its_time() -> None:
    change = CarrierChanged(
        task="a", epoch=2, replaced="ATV1", carrier="ATV2", reason=Reason.GRACEFUL_SHUTDOWN
    )
    history = told(("M1", change), ("M1", change), ("M2", change))
    assert history.passed_on("ATV1", 1.0, 2.0) == 2
    assert history.passed_on("ATV2", 0.0, 9.0) == 0


def test_a_flow_is_transports_per_minute() -> None:
    history = told(*(("M1", closed(f"t{number}")) for number in range(61)), every_s=30.0)
    assert history.per_minute(0.0, 1800.0) == pytest.approx(2.0, rel=0.02)
    assert history.per_minute(5.0, 5.0) == 0.0
    assert history.worst_per_minute(0.0, 1800.0) == pytest.approx(2.0, rel=0.05)


def test_the_worst_window_is_where_least_was_delivered() -> None:
    busy = [("M1", closed(f"t{number}")) for number in range(30)]
    gap_s = 2 * WINDOW_S
    facts = [RecordedFact(agent, 60.0 * place, fact) for place, (agent, fact) in enumerate(busy)]
    facts += [
        RecordedFact("M1", 1800.0 + gap_s + 60.0 * number, closed(f"u{number}")) for number in range(30)
    ]
    history = History(facts)
    assert history.worst_per_minute(0.0, 3600.0 + gap_s) == 0.0
    assert history.worst_per_minute(0.0, 1740.0) == pytest.approx(1.0, rel=0.1)
    assert history.worst_per_minute(0.0, WINDOW_S / 2) == history.per_minute(0.0, WINDOW_S / 2)
