"""The alert monitor: looks every second and stores alerts' begin, end and acknowledgement."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from http import HTTPStatus

import msgspec

from dray.errors import UnavailableError
from dray.gateway.http.problems import Problem
from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.alerts import (
    LOOK_S,
    ComeBack,
    is_meant,
    weight_of,
    why_back,
)
from dray.gateway.live.views import AlertView
from dray.store import Store
from dray.store.factory.alert_history import Acknowledgement, NewAlert
from dray.store.work import Work

_log = logging.getLogger(__name__)


class AlertMonitor:
    """Keeps the alerts of a projection.

    Args:
        projection: the live projection.
        store: the database for alerts and comments.
        wall_s: the wall clock.
    """

    def __init__(self, projection: Projection, store: Store, wall_s: Callable[[], float]) -> None:
        self._projection, self._store, self._wall_s = projection, store, wall_s
        self._writing = asyncio.Lock()
        self._kept: dict[str, tuple[float, AlertView | None]] = {}
        """Per open alert in SQL: its begin, and its view at the last look. Bounded like the alerts."""
        self._ended_s: dict[str, float] = {}
        """Per ended alert: when the end was seen."""
        self._back: dict[str, tuple[Acknowledgement, ComeBack]] = {}
        """Alerts that ask again, not yet written to SQL."""

    async def restore(self) -> None:
        """Restore alerts and acknowledgements from before the gateway's start."""
        async with self._store.read() as work:
            known = await work.alerts.lasting()
        self._kept = {each.alert: (each.since_at_s, None) for each in known}
        self._projection.alerts.restore(known, self._wall_s())

    async def acknowledge(
        self, alert: str, by: str, comment: str = "", until_at_s: float | None = None
    ) -> AlertView | None:
        """Take on an alert or comment on it; stored on disk before this returns.

        Args:
            alert: its id.
            by: the person's name.
            comment: a comment; empty for none.
            until_at_s: end of the acknowledgement (wall clock); None for as long as the alert lasts.

        Returns:
            The alert with the name of the first person; None when there is no such alert any more.

        Raises:
            Problem: 409, another person has taken it on, so it cannot be taken on until another time.
        """
        async with self._writing:
            known = self._projection.alerts.get(alert)
            if known is None:
                return None
            now_s = self._wall_s()
            async with self._store.write() as work:
                first = await work.alerts.get(alert)
                if first is None or not is_meant(known, first):
                    await work.alerts.end(alert, known.since_at_s, now_s)
                    await work.alerts.begin([_new(known)])
                    self._kept[alert] = known.since_at_s, known
                    self._ended_s.pop(alert, None)
                    first = Acknowledgement(alert, known.since_at_s, "", 0.0)
                taken = await self._say(work, known, first, by, comment, until_at_s, now_s)
            return self._projection.alerts.acknowledge(taken)

    async def _say(
        self,
        work: Work,
        known: AlertView,
        first: Acknowledgement,
        by: str,
        comment: str,
        until_at_s: float | None,
        now_s: float,
    ) -> Acknowledgement:
        held = first.is_held and why_back(known, first, now_s) is None
        said = {"comment": comment, "comment_by": by} if comment else {}
        if held and first.by != by and until_at_s is not None:
            raise _held(known.id, first.by)
        if held and (first.by != by or until_at_s is None):
            if comment:
                await work.alerts.comment(known.id, by, comment, now_s)
            return msgspec.structs.replace(first, **said)
        taken = Acknowledgement(
            alert=known.id,
            since_at_s=first.since_at_s,
            by=by,
            at_s=now_s,
            until_at_s=until_at_s,
            weight=weight_of(known),
            comment=comment,
            comment_by=by if comment else "",
        )
        await work.alerts.take(taken)
        return taken

    async def look(self) -> None:
        """Look once, and store alerts that began, came back or ended."""
        now_s, alerts = self._wall_s(), self._projection.alerts
        for alert in self._projection.look(now_s):
            self._ended_s.setdefault(alert, now_s)
        for taken, why in alerts.come_back(now_s):
            self._back[taken.alert] = taken, why
        async with self._writing:
            try:
                await self._write(alerts.views(), now_s)
            except UnavailableError as error:
                # Nothing is lost: the next look tries again.
                _log.warning("alerts are not written down yet: %s", error)

    async def _write(self, views: tuple[AlertView, ...], now_s: float) -> None:
        lasting = {view.id: view for view in views}
        ended = [
            (alert, since_s, last)
            for alert, (since_s, last) in self._kept.items()
            if alert in self._ended_s or (alert in lasting and lasting[alert].since_at_s > since_s + LOOK_S)
        ]
        over = {alert for alert, _, _ in ended}
        begun = [view for view in views if view.id not in self._kept or view.id in over]
        if begun or ended or self._back:
            async with self._store.write() as work:
                for taken, why in self._back.values():
                    await work.alerts.come_back(taken, why, now_s)
                for alert, since_s, last in ended:
                    told = "" if last is None else _told(last)
                    await work.alerts.end(alert, since_s + LOOK_S, self._ended_s.get(alert, now_s), told)
                await work.alerts.begin(map(_new, begun))
        self._kept = {alert: kept for alert, kept in self._kept.items() if alert not in over}
        self._kept |= {view.id: (view.since_at_s, view) for view in views}
        self._back.clear()
        self._ended_s.clear()

    async def run(self) -> None:
        """Look every second until cancelled."""
        while True:
            await self.look()
            await asyncio.sleep(LOOK_S)


def _told(view: AlertView) -> str:
    return msgspec.json.encode(view).decode()


def _new(view: AlertView) -> NewAlert:
    about = (view.agent, view.task, view.order, view.place, view.access_point, view.by)
    return NewAlert(
        alert=view.id,
        kind=view.kind,
        level=view.level,
        order=view.order,
        since_at_s=view.since_at_s,
        told=_told(view),
        texts=(*about, *view.agents, "" if view.cause is None else view.cause.text),
    )


def _held(alert: str, by: str) -> Problem:
    return Problem(
        HTTPStatus.CONFLICT,
        "alert-taken-on",
        "Somebody else has taken it on",
        f"{by!r} has {alert[:64]!r} in hand, and alone says until when; send a comment without until_at",
    )
