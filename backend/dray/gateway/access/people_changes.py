"""Changes of people's access, and what each ends at once, for the console and for REST alike."""

from __future__ import annotations

import re

from dray.gateway.access.principal import SCOPES, Principal, Role, Scope
from dray.store.work import Work

LOGIN_NAME = re.compile(r"[a-z0-9][a-z0-9._-]{0,63}")
"""Form of a login name."""


async def change(work: Work, person_id: str, now_s: float, **columns: object) -> None:
    """Set columns of a person, who must log in anew: sessions, links and lock-outs end.

    Args:
        work: a write transaction.
        person_id: an existing person.
        now_s: wall clock.
        columns: columns such as `pin_hash`.
    """
    await work.people.change(person_id, **columns)
    await work.sessions.end_all(person_id, now_s)
    await work.login_links.end_all(person_id, now_s)
    await work.lockouts.clear(person_id)


def may_decide_on(caller: Principal, role: str) -> bool:
    """Whether a caller may manage people of this role: it needs all their rights itself."""
    return may_give(caller, SCOPES[Role(role)])


def may_give(caller: Principal, scopes: frozenset[Scope]) -> bool:
    """Whether a caller has all these scopes itself."""
    return all(caller.may(scope) for scope in scopes)
