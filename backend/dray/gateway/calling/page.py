"""The page of a call key in words: possible calls and calls made. The template only places them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from datetime import UTC, datetime

import msgspec

from dray.gateway.access.principal import Principal
from dray.gateway.live.projection import Projection
from dray.gateway.live.views import StrandedView
from dray.messages import TransportState
from dray.store.orders.transports import TransportRow

SHOWN = 8
"""Maximum transports on the page, newest first: more than wait at one place."""


class Tile(msgspec.Struct, frozen=True):
    """A material that can be called for."""

    item: str
    name: str
    here: str
    """Quantity there, in words; empty if unknown."""
    chosen: bool
    lot: int
    away: int
    """Pieces that one load can take away; 0 if none are there."""


class Choices(msgspec.Struct, frozen=True):
    """The choices for a thing without master data, and the last values sent."""

    places: tuple[tuple[str, str], ...]
    """Possible other places: id and name of each."""
    abilities: tuple[str, ...]
    """Ways in which it can be carried."""
    thing: str = ""
    place: str = ""
    ability: str = ""


class Called(msgspec.Struct, frozen=True):
    """A call that was made."""

    id: str
    what: str
    state: str
    why: str
    """Why it waits, or when it arrives."""
    open: bool
    """Whether it can be cancelled."""


def tiles(
    projection: Projection, caller: Principal, chosen: str, texts: Mapping[str, str]
) -> tuple[Tile, ...]:
    """The materials of the place that the key may call for."""
    plant, place = projection.site.plant, caller.station
    items = frozenset() if caller.calls is None else caller.calls.items
    machine, station = projection.machines.view(place), projection.stations.view(place)
    levels = {each.item: each.level for each in (machine.buffers if machine else ())}
    levels |= {each.item: each.level for each in (station.stocks if station else ())}
    return tuple(
        Tile(
            item=item,
            name=spec.name,
            here="" if item not in levels else texts["here"].format(level=levels[item]),
            chosen=item == chosen,
            lot=spec.lot,
            away=min(spec.lot, levels.get(item, spec.lot)),
        )
        for item, spec in plant.materials.items()
        if (not items or item in items) and plant.keeps(place, item)
    )


def choices(
    projection: Projection, caller: Principal, abilities: tuple[str, ...], sent: Mapping[str, str]
) -> Choices | None:
    """The choices for a thing; None if the key is limited to materials.

    Args:
        projection: knows the places.
        caller: the key.
        abilities: the vehicles' abilities.
        sent: the fields of a refused form; empty without one.
    """
    if caller.calls is not None and caller.calls.items:
        return None
    plant = projection.site.plant
    named = {place: spec.name for place, spec in plant.stores.items()}
    named |= {place: spec.name for place, spec in plant.machines.items()}
    places = tuple(
        (place, place if name in ("", place) else f"{place} · {name}")
        for place, name in named.items()
        if place != caller.station
    )
    return Choices(places, abilities, sent.get("thing", ""), sent.get("place", ""), sent.get("ability", ""))


def called(
    rows: Iterable[TransportRow], projection: Projection, place: str, now_s: float, texts: Mapping[str, str]
) -> tuple[Called, ...]:
    """The calls made, with their state."""
    return tuple(_called(row, projection, place, now_s, texts) for row in rows)


def _called(
    row: TransportRow, projection: Projection, place: str, now_s: float, texts: Mapping[str, str]
) -> Called:
    spec = projection.site.plant.materials.get(row.item)
    brought = row.destination == place
    what = texts["brought" if brought else "taken"].format(
        quantity=row.quantity,
        item=row.thing or (row.item if spec is None else spec.name),
        place=row.source if brought else row.destination,
    )
    is_open = row.status in (TransportState.WAITING, TransportState.ASSIGNED)
    ending = row.cancel_at_s is not None and not row.has_ended
    why = ""
    if row.status is TransportState.WAITING:
        why = texts.get(f"wait_{row.wait}", "").format(place=row.destination)
    if row.expected_at_s is not None and not row.has_ended:
        minutes = round((row.expected_at_s - now_s) / 60)
        why = texts["minutes"].format(n=minutes) if minutes >= 1 else texts["soon"]
    task = projection.tasks.view(row.task) if row.task and not row.has_ended else None
    if task is not None and task.stranded is not None:
        why = _left_aboard(task.stranded, texts)
    return Called(
        id=row.id,
        what=what,
        state=texts["state_being_cancelled" if ending else f"state_{row.status.value}"],
        why=why,
        open=is_open and not ending,
    )


def _left_aboard(left: StrandedView, texts: Mapping[str, str]) -> str:
    """Where a thing is on board of a failed vehicle."""
    if left.handed_at:
        return texts["handed"].format(node=left.handed_at)
    if not left.node:
        return texts["left_nowhere"].format(vehicle=left.atv)
    return texts["left"].format(vehicle=left.atv, node=left.node)


def until(caller: Principal, texts: Mapping[str, str]) -> str:
    """The key's end in words; empty if it has none."""
    if caller.expires_at_s is None:
        return ""
    return texts["until"].format(day=datetime.fromtimestamp(caller.expires_at_s, UTC).date().isoformat())
