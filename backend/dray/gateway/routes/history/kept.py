"""How long each history is kept, and its oldest entry."""

from __future__ import annotations

from typing import Literal

from fastapi import APIRouter

from dray.gateway.factory.figure_sampler import KEPT_S
from dray.gateway.http.provided import Now, Provided
from dray.gateway.http.responses import Json, list_of, listing
from dray.gateway.live.views.base import View
from dray.settings import Settings
from dray.store import Store

router = APIRouter(tags=["history"])

DAY_S = 86_400.0

KeptKind = Literal[
    "orders", "events", "replay", "samples", "figures", "lanes", "tasks", "transports", "alerts", "audit"
]  # fmt: skip
"""`lanes` is lane traffic by the hour, `samples` are of heartbeats, `figures` by the minute, `replay` is what
panels showed."""


class KeptView(View, kw_only=True):
    """One kind of history. Times are wall clock."""

    kind: KeptKind
    days: float | None
    """Retention in days; null for unlimited, 0 for none."""
    setting: str
    """Setting for the days; empty if there is none."""
    since_at_s: float | None
    """Oldest entry; null if there is none yet."""
    gone_before_at_s: float | None
    """Time before which entries are deleted; null if none are deleted or kept."""
    is_full: bool
    """Whether the size limit is reached (`DRAY_EVENTS_MOST`), so that the oldest entries are deleted
    early."""


EXAMPLE = KeptView(
    kind="events",
    days=14.0,
    setting="DRAY_EVENTS_DAYS",
    since_at_s=1_893_456_000.0 - 3 * DAY_S,
    gone_before_at_s=1_893_456_000.0 - 14 * DAY_S,
    is_full=False,
)


@router.get(
    "/kept", responses={200: list_of(KeptView, "Kinds of history, orders first")}, response_class=Json
)
async def list_kept(store: Provided[Store], settings: Provided[Settings], now_s: Now) -> Json:
    """How long each history is kept, its oldest entry, and the time before which all is deleted."""
    async with store.read() as work:
        oldest = await work.kept.oldest()
    days: dict[KeptKind, tuple[float | None, str]] = {
        "orders": (None, ""),
        "events": (settings.events_days, "DRAY_EVENTS_DAYS"),
        "replay": (settings.replay_days, "DRAY_REPLAY_DAYS"),
        "samples": (settings.samples_days, "DRAY_SAMPLES_DAYS"),
        "figures": (settings.figures_days, "DRAY_FIGURES_DAYS"),
        "lanes": (KEPT_S / DAY_S, ""),
        "tasks": (settings.tasks_days, "DRAY_TASKS_DAYS"),
        "transports": (settings.transports_days, "DRAY_TRANSPORTS_DAYS"),
        "alerts": (settings.alerts_days, "DRAY_ALERTS_DAYS"),
        "audit": (settings.audit_days, "DRAY_AUDIT_DAYS"),
    }
    items = []
    for kind, (kept_days, setting) in days.items():
        since_s: float | None = getattr(oldest, f"{kind}_s")
        is_full = kind == "events" and oldest.events >= settings.events_most
        gone_s = now_s - kept_days * DAY_S if kept_days else None
        if is_full and since_s is not None and gone_s is not None:
            gone_s = max(gone_s, since_s)
        items.append(
            KeptView(
                kind=kind,
                days=kept_days,
                setting=setting,
                since_at_s=since_s,
                gone_before_at_s=gone_s,
                is_full=is_full,
            )
        )
    return listing(items, None)
