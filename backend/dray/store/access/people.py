"""People in SQL: their logins, their areas, and the hashes of their secrets."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec
from sqlalchemy import ColumnElement, delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection

from dray.store.tables import people, people_areas


class Person(msgspec.Struct, frozen=True, kw_only=True):
    """A person who may log in. Times are wall clock seconds."""

    id: str
    """The login name; never given to another person."""
    name: str
    role: str
    """`manager` or `operator`."""
    created_at_s: float
    areas: tuple[str, ...] = ()
    """The areas of an operator."""
    password_hash: str | None = None
    pin_hash: str | None = None
    badge_hash: str | None = None
    disabled_at_s: float | None = None

    @property
    def has_secret(self) -> bool:
        """Whether login is possible without a link."""
        return any((self.password_hash, self.pin_hash, self.badge_hash))


class People:
    """The people, inside one transaction."""

    def __init__(self, connection: AsyncConnection) -> None:
        self._connection = connection

    async def add(self, person: Person) -> None:
        """Store a new person."""
        row = msgspec.structs.asdict(person)
        areas = row.pop("areas")
        await self._connection.execute(insert(people), [row])
        if areas:
            rows = [{"person_id": person.id, "area": area} for area in areas]
            await self._connection.execute(insert(people_areas), rows)

    async def get(self, person_id: str) -> Person | None:
        """The person with this id, disabled or not."""
        if "\0" in person_id:  # PostgreSQL supports no such text, and refuses the query.
            return None
        return await self._one(people.c.id == person_id)

    async def with_badge(self, badge_hash: str) -> Person | None:
        """The person with this badge."""
        return await self._one(people.c.badge_hash == badge_hash)

    async def all(self) -> list[Person]:
        """All people, by id."""
        rows = (await self._connection.execute(select(people).order_by(people.c.id))).all()
        areas = await self._areas(row.id for row in rows)
        return [Person(areas=areas.get(row.id, ()), **row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's public name

    async def change(self, person_id: str, **columns: object) -> None:
        """Set columns of one person, as `pin_hash`."""
        await self._connection.execute(update(people).where(people.c.id == person_id).values(**columns))

    async def move(self, person_id: str, areas: Iterable[str]) -> None:
        """Replace an operator's areas."""
        await self._connection.execute(delete(people_areas).where(people_areas.c.person_id == person_id))
        rows = [{"person_id": person_id, "area": area} for area in areas]
        if rows:
            await self._connection.execute(insert(people_areas), rows)

    async def _one(self, condition: ColumnElement[bool]) -> Person | None:
        row = (await self._connection.execute(select(people).where(condition))).one_or_none()
        if row is None:
            return None
        areas = await self._areas([row.id])
        return Person(areas=areas.get(row.id, ()), **row._mapping)  # noqa: SLF001 - SQLAlchemy's public name

    async def _areas(self, person_ids: Iterable[str]) -> dict[str, tuple[str, ...]]:
        query = (
            select(people_areas)
            .where(people_areas.c.person_id.in_(list(person_ids)))
            .order_by(people_areas.c.person_id, people_areas.c.area)
        )
        found: dict[str, tuple[str, ...]] = {}
        for row in await self._connection.execute(query):
            found[row.person_id] = (*found.get(row.person_id, ()), row.area)
        return found
