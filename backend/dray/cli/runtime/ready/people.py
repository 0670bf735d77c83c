"""People and keys: checks of logins, people on duty, and keys of other systems."""

from __future__ import annotations

from collections.abc import Iterator

from dray.cli.runtime.ready.answers import DUTY, PEOPLE, Answers, Key, Person
from dray.cli.runtime.ready.finding import Finding, missing, named, ok, unknown
from dray.plant import Plant

SOON_S = 30 * 86_400.0
"""Remaining validity in seconds below which to renew."""

WRITES_ORDERS = "orders:write"


def people_and_keys(plant: Plant, answers: Answers, now_s: float) -> Iterator[Finding]:
    """Findings about people and keys.

    Args:
        plant: the plant, whose areas need operators.
        answers: the gateway's answers.
        now_s: unix time.
    """
    lacks = f"not permitted: the token needs {PEOPLE}"
    if answers.people is None or answers.keys is None:
        yield from (unknown(name, lacks) for name in ("managers", "operators", "API keys"))
    else:
        may = [each for each in answers.people if each.disabled_at_s is None]
        yield _managers(may)
        yield _operators(plant, may)
        yield _keys([each for each in answers.keys if each.revoked_at_s is None], now_s)
    yield _duty(plant, answers)


def _managers(may: list[Person]) -> Finding:
    managers = [each for each in may if each.role == "manager"]
    ready = [each.id for each in managers if each.secrets]
    if ready:
        return ok("managers", f"with a password: {named(ready)}")
    if managers:
        first = managers[0].id
        return missing(
            "managers",
            f"none has a password: {named(each.id for each in managers)}",
            f"dray user password {first}",
        )
    return missing("managers", "there is none", "dray user add NAME --role manager; dray user password NAME")


def _operators(plant: Plant, may: list[Person]) -> Finding:
    operators = [each for each in may if each.role == "operator"]
    if not plant.areas:
        return ok("operators", "the plant file has no areas: managers answer calls for help")
    nobody = [area for area in plant.areas if not any(area in each.areas for each in operators)]
    if nobody:
        todo = f"dray user add NAME --role operator --area {nobody[0]} --plant FILE; dray user pin NAME"
        return missing("operators", f"no operator may work in {named(nobody)}", todo)
    locked = [
        area for area in plant.areas if not any(area in each.areas and each.secrets for each in operators)
    ]
    if locked:
        first = next(each.id for each in operators if locked[0] in each.areas)
        seen = f"no operator has a PIN or a badge in {named(locked)}; a login link works once"
        return missing("operators", seen, f"dray user pin {first}, or dray user badge {first}")
    return ok(
        "operators",
        f"{len(operators)} for {len(plant.areas)} areas, at least one in each with a PIN or a badge",
    )


def _keys(keys: list[Key], now_s: float) -> Finding:
    ending = [each for each in keys if each.expires_at_s is not None and each.expires_at_s < now_s + SOON_S]
    if ending:
        first = ending[0]
        scopes = " ".join(f"--scope {scope}" for scope in first.scopes)
        seen = f"expired, or expires within 30 days: {named(each.name for each in ending)}"
        return missing(
            "API keys", seen, f"dray key create {first.name!r} {scopes}; dray key revoke {first.id}"
        )
    orders = [each.name for each in keys if WRITES_ORDERS in each.scopes]
    if orders:
        return ok("API keys", f"may place orders: {named(orders)}")
    return ok(
        "API keys",
        "none may place orders: people place them in the panel",
        "dray key create ERP --scope orders:write",
    )


def _duty(plant: Plant, answers: Answers) -> Finding:
    name, duty = "people on duty", answers.duty
    if duty is None:
        return unknown(name, f"not permitted: the token needs {DUTY}")
    absent = [area for area in duty.areas_without if area not in duty.comes_at_s and area in plant.areas]
    if absent:
        todo = "log in at a tablet there (/operator), and choose On duty"
        return missing(name, f"no operator is on duty in {named(absent)}", todo)
    resting = [area for area in duty.areas_without if area in plant.areas]
    at_rest = f"; outside of working time: {named(resting)}" if resting else ""
    return ok(name, f"an operator in {len(plant.areas) - len(resting)} of {len(plant.areas)} areas{at_rest}")
