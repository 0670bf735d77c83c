"""Invitations: a link that logs a person in once; choosing a secret afterwards is optional."""

from __future__ import annotations

from dray.gateway.access.tokens import new_token
from dray.store.access.login_links import LoginLink
from dray.store.work import Work

LIFE_S = 86_400.0
"""Validity in seconds, a day: the link is sent and used on the same day."""

KEPT_S = 30 * 86_400.0
"""Seconds for which expired links are kept."""


async def invite(work: Work, person_id: str, now_s: float, life_s: float = LIFE_S) -> str:
    """Create a link's token; the person's earlier links become invalid.

    Args:
        work: a write transaction.
        person_id: the person whom it logs in.
        now_s: wall clock.
        life_s: validity in seconds.
    """
    token = new_token()
    await work.login_links.forget_before(now_s - KEPT_S)
    await work.login_links.end_all(person_id, now_s)
    await work.login_links.add(token, LoginLink(person_id, now_s, now_s + life_s))
    return token
