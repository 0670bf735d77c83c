"""What `dray plant ready` finds of people, of who is on duty, and of API keys."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from ready_kit import AREA, DAY_S, NOW_S, WORKSHOP, answers, of, seen

from dray.cli.runtime.ready.answers import Duty, Key, Person
from dray.cli.runtime.ready.finding import Finding, Verdict
from dray.cli.runtime.ready.people import people_and_keys

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
