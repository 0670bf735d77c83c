"""Invitations: a link by which somebody logs in once, and chooses a secret afterwards or never."""

from __future__ import annotations

from dray.gateway.access.tokens import new_token
from dray.store.access.login_links import LoginLink
from dray.store.work import Work

LIFE_S = 86_400.0
"""A day: the link is sent today and used today."""

KEPT_S = 30 * 86_400.0
"""Links stay this long after they ran out."""


async def invite(work: Work, person_id: str, now_s: float, life_s: float = LIFE_S) -> str:
    """Make a link's token; links that the person was given before work no more.

    Args:
        work: a transaction that writes.
        person_id: whom it logs in.
        now_s: wall clock.
        life_s: how long it works.
    """
    token = new_token()
    await work.login_links.forget_before(now_s - KEPT_S)
    await work.login_links.end_all(person_id, now_s)
    await work.login_links.add(token, LoginLink(person_id, now_s, now_s + life_s))
    return token
