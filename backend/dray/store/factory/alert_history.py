"""Alerts in SQL: their times, their acknowledgements, and people's comments.

Alerts follow from the present state. Several gateways see the same state, and each writes its view. A lasting alert has one row,
whichever gateway saw it first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import msgspec
from sqlalchemy import (
    CheckConstraint,
    Column,
    ColumnElement,
    Double,
    ForeignKey,
    Index,
    Integer,
    String,
    Table,
    Text,
    and_,
    delete,
    func,
    insert,
    or_,
    select,
    update,
)
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.database.counting import total_of
from dray.store.database.dialect import insert_new
from dray.store.database.searching import Sought, searched
from dray.store.tables import Id, metadata

Said = Literal["taken", "commented", "over", "worse"]
"""An event of an alert. The last two are no person's: the acknowledgement has expired, or the alert has become worse."""

alerts = Table(
    "alerts",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=True),
    Column("alert", String(192), nullable=False),
    Column("kind", String(32), nullable=False),
    Column("level", String(16), nullable=False),
    Column("order_id", Id, nullable=False),
    Column("since_at_s", Double, nullable=False),
    Column("ended_at_s", Double),
    Column("by", String(200), nullable=False, server_default=""),
    Column("at_s", Double, nullable=False, server_default="0"),
    Column("until_at_s", Double),
    Column("weight", Double, nullable=False, server_default="0"),
    Column("came_back", String(16), nullable=False, server_default=""),
    Column("comment", String(500), nullable=False, server_default=""),
    Column("comment_by", String(200), nullable=False, server_default=""),
    Column("told", Text, nullable=False),
    Column("search", Text, nullable=False),
    CheckConstraint("level IN ('alarm', 'warning')", name="level"),
    CheckConstraint("came_back IN ('', 'over', 'worse')", name="came_back"),
    Index(None, "since_at_s", "number"),
    Index(None, "ended_at_s"),
    comment="Alerts. at_s: when it was taken on; weight: how bad it was then; told: all that was known of it, in JSON.",
    sqlite_autoincrement=True,
)

Index(
    "ux_alerts_lasting",
    alerts.c.alert,
    unique=True,
    sqlite_where=alerts.c.ended_at_s.is_(None),
    postgresql_where=alerts.c.ended_at_s.is_(None),
)

SAME_S = 1.0
"""Gateways look once a second: beginnings within less, of one subject, are one alert."""

alert_words = Table(
    "alert_words",
    metadata,
    Column("number", Integer, primary_key=True, autoincrement=True),
    Column("of", Integer, ForeignKey("alerts.number", ondelete="CASCADE"), nullable=False),
    Column("at_s", Double, nullable=False),
    Column("by", String(200), nullable=False),
    Column("said", String(16), nullable=False),
    Column("comment", String(500), nullable=False),
    Column("until_at_s", Double),
    Index(None, "of"),
    comment="What was said of alerts, and by whom; by nobody where an alert came back by itself.",
    sqlite_autoincrement=True,
)


class Acknowledgement(msgspec.Struct, frozen=True, gc=False):
    """A lasting alert, and its acknowledgement. Times are wall clock seconds."""

    alert: str
    since_at_s: float
    """The alert's beginning: the same alert may return another day."""
    by: str
    """The acknowledging person's name; empty for none."""
    at_s: float
    until_at_s: float | None = None
    """The end of the acknowledgement; None for as long as the alert lasts."""
    weight: float = 0.0
    """The alert's severity then."""
    came_back: str = ""
    """Why it needs a new acknowledgement: the old one is `over`, or the alert is `worse`."""
    comment: str = ""
    comment_by: str = ""

    @property
    def is_held(self) -> bool:
        """Whether it is acknowledged."""
        return self.by != "" and self.came_back == ""


class NewAlert(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """An alert as a gateway saw it. Times are wall clock seconds."""

    alert: str
    kind: str
    level: str
    order: str
    since_at_s: float
    told: str
    """The whole alert, in JSON."""
    texts: tuple[str, ...]
    """The searched texts."""


class Word(msgspec.Struct, frozen=True, gc=False):
    """An event of an alert, with its author."""

    at_s: float
    by: str
    said: Said
    comment: str
    until_at_s: float | None


class AlertRow(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A present or past alert."""

    number: int
    ended_at_s: float | None
    since_at_s: float
    told: str
    taken: Acknowledgement
    words: tuple[Word, ...] = ()


class AlertFilter(msgspec.Struct, frozen=True, kw_only=True, gc=False):
    """A filter for alerts; empty fields match all. Times are wall clock seconds."""

    kind: str = ""
    level: str = ""
    lasting: bool | None = None
    since_s: float | None = None
    """Alerts that lasted until then or longer; the next field: alerts that began before then."""
    before_s: float | None = None
    orders: bool = True
    """Whether alerts about orders match."""
    words: tuple[Sought, ...] = ()

    def conditions(self) -> list[ColumnElement[bool]]:
        """The conditions for a row."""
        c = alerts.c
        exact = {c.kind: self.kind, c.level: self.level}
        wanted: list[ColumnElement[bool]] = [column == value for column, value in exact.items() if value]
        if self.lasting is not None:
            wanted.append(c.ended_at_s.is_(None) if self.lasting else c.ended_at_s.is_not(None))
        if self.since_s is not None:
            wanted.append(or_(c.ended_at_s.is_(None), c.ended_at_s >= self.since_s))
        if self.before_s is not None:
            wanted.append(c.since_at_s < self.before_s)
        if not self.orders:
            wanted.append(c.order_id == "")
        # Of alerts from before this history, only the acknowledgement is known.
        wanted.append(c.told != "")
        for word in self.words:
            texts = (word.text, *word.named)
            wanted.append(or_(*(c.search.contains(text.casefold(), autoescape=True) for text in texts)))
        return wanted


_TAKEN = [alerts.c[name] for name in Acknowledgement.__struct_fields__]
_ROW = [alerts.c.number, alerts.c.ended_at_s, alerts.c.told, *_TAKEN]


class AlertHistory:
    """The alerts, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def lasting(self) -> list[Acknowledgement]:
        """All alerts that lasted when a gateway last looked."""
        query = select(*_TAKEN).where(alerts.c.ended_at_s.is_(None))
        return [Acknowledgement(*row) for row in await self._connection.execute(query)]

    async def get(self, alert: str) -> Acknowledgement | None:
        """A lasting alert, or None."""
        query = select(*_TAKEN).where(alerts.c.alert == alert, alerts.c.ended_at_s.is_(None))
        row = (await self._connection.execute(query)).one_or_none()
        return None if row is None else Acknowledgement(*row)

    async def begin(self, new: Iterable[NewAlert]) -> None:
        """Add new alerts that are not lasting yet; the first gateway determines the time of the beginning.

        If another gateway has written both beginning and end before this one writes, it is the same alert: it lasts again, until this
        gateway has seen its end, too.
        """
        new = tuple(new)
        for each in new:
            await self._reopen(each)
        rows = [
            {
                "alert": each.alert,
                "kind": each.kind,
                "level": each.level,
                "order_id": each.order,
                "since_at_s": each.since_at_s,
                "told": each.told,
                "search": searched((each.alert, *each.texts), ()),
            }
            for each in new
        ]
        if rows:
            await self._connection.execute(insert_new(self._connection, alerts), rows)

    async def _reopen(self, new: NewAlert) -> None:
        c, since_s = alerts.c, new.since_at_s
        same = select(func.max(c.number)).where(
            c.alert == new.alert,
            c.ended_at_s.is_not(None),
            c.since_at_s > since_s - SAME_S,
            c.since_at_s < since_s + SAME_S,
        )
        one_lasts = select(c.number).where(_lasts(new.alert))
        number = (await self._connection.execute(same)).scalar()
        if number is not None and (await self._connection.execute(one_lasts)).first() is None:
            await self._connection.execute(update(alerts).where(c.number == number).values(ended_at_s=None))

    async def end(self, alert: str, since_s: float, at_s: float, told: str = "") -> None:
        """An alert has ended.

        Args:
            alert: its id.
            since_s: it began at or before this time: a later return lasts.
            at_s: when its end was noticed.
            told: its last known content, in JSON; empty for unknown.
        """
        last = {"told": told} if told else {}
        await self._connection.execute(
            update(alerts)
            .where(_lasts(alert), alerts.c.since_at_s <= since_s)
            .values(ended_at_s=at_s, **last)
        )

    async def take(self, word: Acknowledgement) -> None:
        """Acknowledge a lasting alert."""
        fields = msgspec.structs.asdict(word)
        del fields["alert"], fields["since_at_s"]
        await self._connection.execute(update(alerts).where(_lasts(word.alert)).values(**fields))
        await self._say(word.alert, Word(word.at_s, word.by, "taken", word.comment, word.until_at_s))

    async def comment(self, alert: str, by: str, comment: str, at_s: float) -> None:
        """Add a person's comment to a lasting alert."""
        known = update(alerts).where(_lasts(alert)).values(comment=comment, comment_by=by)
        await self._connection.execute(known)
        await self._say(alert, Word(at_s, by, "commented", comment, None))

    async def come_back(self, held: Acknowledgement, why: Literal["over", "worse"], at_s: float) -> None:
        """End an acknowledgement; recorded once, whichever gateway does it first."""
        back = update(alerts).where(
            _lasts(held.alert), alerts.c.at_s == held.at_s, alerts.c.came_back == "", alerts.c.by == held.by
        )
        if (await self._connection.execute(back.values(came_back=why))).rowcount:
            await self._say(held.alert, Word(at_s, "", why, "", None))

    async def page(self, wanted: AlertFilter, after: tuple[float, int] | None, limit: int) -> list[AlertRow]:
        """A part of the list, newest first.

        Args:
            wanted: the filter.
            after: beginning and number of the previous page's last alert.
            limit: maximum number of alerts.
        """
        began, number = alerts.c.since_at_s, alerts.c.number
        query = select(*_ROW).where(*wanted.conditions()).order_by(began.desc(), number.desc()).limit(limit)
        if after is not None:
            since_s, last = after
            query = query.where(or_(began < since_s, and_(began == since_s, number < last)))
        rows = (await self._connection.execute(query)).all()
        words = await self._words([row.number for row in rows])
        return [
            AlertRow(
                number=row.number,
                ended_at_s=row.ended_at_s,
                since_at_s=row.since_at_s,
                told=row.told,
                taken=Acknowledgement(*row[3:]),
                words=tuple(words.get(row.number, ())),
            )
            for row in rows
        ]

    async def total(self, wanted: AlertFilter) -> int | None:
        """The number of matching alerts; None for very many."""
        return await total_of(self._connection, select(alerts.c.number).where(*wanted.conditions()))

    async def prune(self, before_s: float, at_most: int) -> int:
        """Delete some that had ended before then, with their events; returns the number."""
        c = alerts.c
        query = select(c.number).where(c.ended_at_s < before_s).limit(at_most)
        old = list((await self._connection.execute(query)).scalars())
        if old:
            await self._connection.execute(delete(alert_words).where(alert_words.c.of.in_(old)))
            await self._connection.execute(delete(alerts).where(c.number.in_(old)))
        return len(old)

    async def _words(self, numbers: Sequence[int]) -> dict[int, list[Word]]:
        c = alert_words.c
        query = select(c.of, c.at_s, c.by, c.said, c.comment, c.until_at_s).where(c.of.in_(numbers))
        found: dict[int, list[Word]] = {}
        for row in await self._connection.execute(query.order_by(c.number)):
            found.setdefault(row.of, []).append(Word(*row[1:]))
        return found

    async def _say(self, alert: str, word: Word) -> None:
        known = select(alerts.c.number, alerts.c.search).where(_lasts(alert))
        row = (await self._connection.execute(known)).one()
        fields = msgspec.structs.asdict(word) | {"of": row.number}
        await self._connection.execute(insert(alert_words), [fields])
        search = "\n".join((row.search, word.by, word.comment)).casefold()
        await self._connection.execute(
            update(alerts).where(alerts.c.number == row.number).values(search=search)
        )


def _lasts(alert: str) -> ColumnElement[bool]:
    return and_(alerts.c.alert == alert, alerts.c.ended_at_s.is_(None))
