"""First users: the people of a first start, and their login links while they have no secrets."""

from __future__ import annotations

from collections.abc import Iterable

from dray.gateway.access.login.invitations import invite
from dray.gateway.access.principal import Role
from dray.plant.model import Area, PlantFile
from dray.store import Store
from dray.store.access.people import Person

MANAGER = "manager"


async def welcome(store: Store, plant: PlantFile, now_s: float) -> dict[str, str]:
    """Create a manager, and an operator per area, if nobody exists yet.

    Args:
        store: the store.
        plant: the plant, with its areas.
        now_s: wall clock.

    Returns:
        A new login link's token for each of these without a secret, by id.
    """
    usual = usual_people(plant, now_s)
    async with store.write() as work:
        if not await work.people.all():
            for person in usual:
                await work.people.add(person)
        known = {person.id: person for person in await work.people.all()}
        return {
            person.id: await invite(work, person.id, now_s)
            for person in _without_secret(known[each.id] for each in usual if each.id in known)
        }


def usual_people(plant: PlantFile, now_s: float) -> list[Person]:
    """The manager, and an operator per area."""
    manager = Person(id=MANAGER, name="Management", role=Role.MANAGER, created_at_s=now_s)
    return [manager, *(_operator(area, now_s) for area in plant.areas)]


def _operator(area: Area, now_s: float) -> Person:
    return Person(
        id=f"operator-{area.id}".lower(),
        name=f"Operator {area.name}",
        role=Role.OPERATOR,
        created_at_s=now_s,
        areas=(area.id,),
    )


def _without_secret(people: Iterable[Person]) -> list[Person]:
    return [person for person in people if person.disabled_at_s is None and not person.has_secret]
