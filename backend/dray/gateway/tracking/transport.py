"""A plain transport for holders of its link: content, route, progress, and expected time.

It reveals nothing else of the plant: neither the carrier nor other vehicles.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from dray.gateway.tracking.facts import NoPage, ended
from dray.gateway.tracking.page import POLL_S, Page, StageLine
from dray.gateway.tracking.texts import Catalogue
from dray.gateway.tracking.texts.clock import Clock
from dray.messages import TransportState
from dray.store import Store
from dray.store.orders.transports import TransportRow

STAGES = (
    TransportState.WAITING,
    TransportState.ASSIGNED,
    TransportState.ON_BOARD,
    TransportState.DELIVERED,
)
"""Stages, in order."""


class TransportTrackAnswer(msgspec.Struct, frozen=True, kw_only=True, rename={"source": "from"}):
    """A plain transport for a holder of its link."""

    status: Literal["waiting", "assigned", "on_board", "delivered", "cancelled"]
    item: str
    name: str
    """Name of the item."""
    quantity: int
    source: str
    to: str
    wait: Literal["not_before", "no_room", "short", "no_bid", "undecided"] | None = None
    """Why no vehicle carries it."""
    expected_at: str | None = None
    """None without a promise, and after the end."""
    late: bool
    """Whether it is, was or will be there after `due_at`."""
    created_at: str
    assigned_at: str | None = None
    """When a vehicle set off to fetch it; None before, or if unknown."""
    on_board_at: str | None = None
    """When a vehicle had it; None before, or if unknown."""
    not_before: str | None = None
    due_at: str
    ended_at: str | None = None


class TransportSteps(msgspec.Struct, frozen=True):
    """When a transport reached its stages; wall clock seconds, None if not reached or unknown."""

    assigned_at_s: float | None = None
    """When the first vehicle set off to fetch it."""
    on_board_at_s: float | None = None
    """When a vehicle first had it."""


class FoundTransport(msgspec.Struct, frozen=True):
    """The result for a token."""

    row: TransportRow | None
    why: NoPage | None = None
    """Set without a transport."""


async def transport_of(store: Store, token: str, now_s: float) -> FoundTransport:
    """The transport of a link.

    Args:
        store: the database.
        token: the link's token.
        now_s: wall clock.
    """
    async with store.read() as work:
        link = await work.transport_links.find(token)
        row = None if link is None else await work.transports.get(link.subject)
        if link is None or row is None:
            return FoundTransport(None, NoPage.UNKNOWN)
        why = ended(link, row.ended_at_s, now_s)
        if why is not None:
            return FoundTransport(None, why)
        return FoundTransport(row)


def transport_track(
    row: TransportRow, steps: TransportSteps, name: str, now_s: float
) -> TransportTrackAnswer:
    """The customer's view of a transport.

    Args:
        row: the transport.
        steps: when it reached its stages.
        name: name of the item or thing.
        now_s: wall clock.
    """
    expected_s = _expected_s(row)
    return TransportTrackAnswer(
        status=row.status.value,
        item=row.item,
        name=name,
        quantity=row.quantity,
        source=row.source,
        to=row.destination,
        wait=row.wait or None,  # type: ignore[arg-type]
        expected_at=_iso(expected_s),
        late=_is_late(row, now_s),
        created_at=Clock.iso(row.created_at_s),
        assigned_at=_iso(steps.assigned_at_s),
        on_board_at=_iso(steps.on_board_at_s),
        not_before=_iso(row.not_before_s),
        due_at=Clock.iso(row.due_at_s),
        ended_at=_iso(row.ended_at_s),
    )


def transport_page(
    row: TransportRow, steps: TransportSteps, name: str, texts: Catalogue, clock: Clock, now_s: float
) -> Page:
    """The page of a transport.

    Args:
        row: the transport.
        steps: when it reached its stages.
        name: name of the item or thing.
        texts: the language.
        clock: writes times in that language.
        now_s: wall clock.
    """
    label, answer, note = _answer(row, texts, clock)
    late = _is_late(row, now_s)
    tag = "" if not late else texts.late_delivered if row.has_ended else texts.late_yes
    reason = texts.transport_why.get(row.wait, "") if row.status is TransportState.WAITING else ""
    stage = texts.transport_stages.get(row.status.value, "")
    return Page(
        title=texts.transport_title,
        above=texts.transport.format(source=row.source, to=row.destination),
        heading=texts.one_part.format(quantity=clock.number(row.quantity), name=name),
        answer_label=label,
        answer=answer,
        note=note,
        tag=tag,
        tag_tone="alarm",
        wanted=texts.wanted_by.format(time=clock.inside(row.due_at_s)),
        reasons=(reason,) if reason else (),
        items=(),
        stages=tuple(_way(row, steps, texts, clock)),
        ended=row.has_ended,
        poll_s=POLL_S,
        announcement=". ".join(filter(None, (answer if row.has_ended else stage, tag, reason))),
    )


def _iso(at_s: float | None) -> str | None:
    return None if at_s is None else Clock.iso(at_s)


def _expected_s(row: TransportRow) -> float | None:
    return None if row.has_ended else row.expected_at_s


def _is_late(row: TransportRow, now_s: float) -> bool:
    if row.status is TransportState.CANCELLED:
        return False
    there_s = row.ended_at_s
    return (max(now_s, _expected_s(row) or now_s) if there_s is None else there_s) > row.due_at_s


def _answer(row: TransportRow, texts: Catalogue, clock: Clock) -> tuple[str, str, str]:
    """The time: label, answer, and note."""
    if row.ended_at_s is not None:
        label = texts.cancelled_at if row.status is TransportState.CANCELLED else texts.delivered_at
        return label, clock.moment(row.ended_at_s), ""
    if row.is_held and row.not_before_s is not None:
        return texts.expected, texts.not_started, texts.begins.format(time=clock.inside(row.not_before_s))
    if row.expected_at_s is None:
        return texts.expected, texts.cannot_say, texts.no_range_note
    return texts.expected, clock.moment(row.expected_at_s), ""


def _way(row: TransportRow, steps: TransportSteps, texts: Catalogue, clock: Clock) -> list[StageLine]:
    at_s = {
        TransportState.WAITING: row.created_at_s,
        TransportState.ASSIGNED: steps.assigned_at_s,
        TransportState.ON_BOARD: steps.on_board_at_s,
        TransportState.DELIVERED: row.ended_at_s,
    }
    if row.status is TransportState.CANCELLED:
        # A cancelled transport has no further stages.
        called = _line(texts, clock, texts.transport_stages["waiting"], "done", row.created_at_s)
        return [called, _line(texts, clock, texts.cancelled_at, "stopped", row.ended_at_s)]
    here = STAGES.index(row.status)
    return [
        _line(texts, clock, texts.transport_stages[each.value], _state(index, here, row), at_s.get(each))
        for index, each in enumerate(STAGES)
    ]


def _state(index: int, here: int, row: TransportRow) -> str:
    if index < here or row.has_ended:
        return "done"
    return "now" if index == here else "next"


def _line(texts: Catalogue, clock: Clock, name: str, state: str, at_s: float | None) -> StageLine:
    words = {"now": texts.now, "next": texts.not_reached}.get(state, texts.reached)
    time, iso = ("", "") if at_s is None else (clock.moment(at_s), clock.iso(at_s))
    return StageLine(name, state, words, "", time, iso)
