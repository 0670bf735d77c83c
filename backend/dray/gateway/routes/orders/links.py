"""Links to the pages of orders and plain transports: creating, showing and revoking them."""

from __future__ import annotations

from http import HTTPStatus

import msgspec
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.http.problems import Problem
from dray.store.orders.tracking_links import WORKING_MAX, Link

DAY_S = 86_400.0


class LinkView(msgspec.Struct, frozen=True):
    """A link to a page; its address is shown once, on creation. Times are wall clock seconds."""

    created_at_s: float
    expires_at_s: float | None
    """None: three months after the order or transport has ended."""
    revoked_at_s: float | None


class LinkDraft(BaseModel):
    """A link to create."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"days": 30}, {}]})

    days: int | None = Field(
        None,
        ge=1,
        le=3650,
        description="How long it leads to the page; else until a quarter after the end of what it leads to",
    )

    def ends_s(self, now_s: float) -> float | None:
        """The link's end in wall clock seconds; None for three months after its subject's end."""
        return None if self.days is None else now_s + self.days * DAY_S


NO_END = LinkDraft(days=None)
"""A request without a body."""


class NewLink(msgspec.Struct, frozen=True):
    """A new link."""

    tracking_url: str
    """Shown only here, and not stored."""
    expires_at_s: float | None


class LinksRevoked(msgspec.Struct, frozen=True):
    """The number of revoked links."""

    count: int


def link_view(link: Link) -> LinkView:
    """A link for the answer."""
    return LinkView(link.created_at_s, link.expires_at_s, link.revoked_at_s)


def too_many_links(kind: str, subject: str) -> Problem:
    """The problem: the page has its maximum of links."""
    return Problem(
        HTTPStatus.CONFLICT,
        "too-many-links",
        f"The {kind} has too many links",
        f"{WORKING_MAX} links lead to the page of {kind} {subject}: use one of them, or take all back "
        f"(DELETE /api/{kind}s/{subject}/links)",
    )
