"""Changes of who may come in: what each ends at once, for the console and for REST alike."""

from __future__ import annotations

import re

from dray.gateway.access.principal import SCOPES, Principal, Role, Scope
from dray.store.work import Work

LOGIN_NAME = re.compile(r"[a-z0-9][a-z0-9._-]{0,63}")
"""What is typed to log in."""


async def change(work: Work, person_id: str, now_s: float, **columns: object) -> None:
    """Set columns of one person, who must log in anew: whatever let them in before does so no more.

    Args:
        work: a transaction that writes.
        person_id: of somebody whom there is.
        now_s: wall clock.
        columns: as `pin_hash`.
    """
    await work.people.change(person_id, **columns)
    await work.sessions.end_all(person_id, now_s)
    await work.login_links.end_all(person_id, now_s)
    await work.lockouts.clear(person_id)


def may_decide_on(caller: Principal, role: str) -> bool:
    """Whether a caller may let people of this role in and out: nobody gives away what it does not have itself."""
    return may_give(caller, SCOPES[Role(role)])


def may_give(caller: Principal, scopes: frozenset[Scope]) -> bool:
    """Whether a caller has all of these itself."""
    return all(caller.may(scope) for scope in scopes)
