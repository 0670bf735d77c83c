"""What `dray plant ready` finds of a plant's agents, and of whether a gateway serves that plant."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from ready_kit import NOW_S, WORKSHOP, answers, heard, of, picture, seen

from dray.cli.runtime.ready.agents import agents, bodies, plant_of_gateway
from dray.cli.runtime.ready.answers import Agent, Factory, Part
from dray.cli.runtime.ready.finding import Verdict, named
from dray.messages.keys import GATE


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


def test_a_clock_that_is_not_that_of_the_wall_is_no_service() -> None:
    fast = picture(factory=Factory(speed=10.0))
    assert seen(plant_of_gateway(WORKSHOP, answers(fast)), Verdict.MISSING, "10 times real time")


def test_of_many_names_the_first_ones_are_said() -> None:
    assert named(f"M{number}" for number in range(1, 12)) == "M1, M2, M3, M4, M5, M6, M7, M8 and 3 more"
