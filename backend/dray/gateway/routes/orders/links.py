"""Links to the pages of orders and plain transports, as REST makes, tells and takes them back."""

from __future__ import annotations

from http import HTTPStatus

import msgspec
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.http.problems import Problem
from dray.store.orders.tracking_links import WORKING_MAX, Link

DAY_S = 86_400.0


class LinkView(msgspec.Struct, frozen=True):
    """A link to a page; its address is told once, when it is made. Times are wall clock seconds."""

    created_at_s: float
    expires_at_s: float | None
    """None: a quarter after the order or transport has ended."""
    revoked_at_s: float | None


class LinkDraft(BaseModel):
    """A link to make."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"days": 30}, {}]})

    days: int | None = Field(
        None,
        ge=1,
        le=3650,
        description="How long it leads to the page; else until a quarter after the end of what it leads to",
    )

    def ends_s(self, now_s: float) -> float | None:
        """When it ends, in wall clock seconds; None for a quarter after the end of what it leads to."""
        return None if self.days is None else now_s + self.days * DAY_S


class NewLink(msgspec.Struct, frozen=True):
    """A link that was made."""

    tracking_url: str
    """Told this once, and kept nowhere."""
    expires_at_s: float | None


class LinksRevoked(msgspec.Struct, frozen=True):
    """Links that were taken back."""

    count: int


def link_view(link: Link) -> LinkView:
    """What is told of a link."""
    return LinkView(link.created_at_s, link.expires_at_s, link.revoked_at_s)


def too_many_links(kind: str, subject: str) -> Problem:
    """As many links lead to the page of an order or transport as may be."""
    return Problem(
        HTTPStatus.CONFLICT,
        "too-many-links",
        f"The {kind} has too many links",
        f"{WORKING_MAX} links lead to the page of {kind} {subject}: use one of them, or take all back "
        f"(DELETE /api/{kind}s/{subject}/links)",
    )
