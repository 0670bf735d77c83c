"""The customer's page in the reader's words. The template only places them."""

from __future__ import annotations

import hashlib
from typing import Any

import msgspec

from dray.gateway.tracking.facts import NoPage
from dray.gateway.tracking.reasons import Reason
from dray.gateway.tracking.texts import Catalogue
from dray.gateway.tracking.texts.clock import Clock
from dray.gateway.tracking.track import Late, Stage, StageName, Track
from dray.store.orders.progress import OrderStatus

POLL_S = 5
"""Seconds between polls of an open page: a piece takes longer, and an unchanged answer is empty."""


class StageLine(msgspec.Struct, frozen=True):
    """A stage in words."""

    name: str
    state: str
    """done, now, next, or stopped for a cancelled order."""
    state_text: str
    note: str
    time: str
    iso: str


class ItemLine(msgspec.Struct, frozen=True):
    """A part of the order, in words."""

    name: str
    quantity: int
    quantity_text: str
    made: int
    made_text: str
    delivered: int
    delivered_text: str


class Page(msgspec.Struct, frozen=True, kw_only=True):
    """All words of the page that depend on the order."""

    title: str
    """What the page is, at its top."""
    above: str
    """Name of the order."""
    heading: str
    answer_label: str
    """Label of the expected time."""
    answer: str
    note: str
    tag: str
    """That it is late; empty if it is not."""
    tag_tone: str
    wanted: str
    reasons: tuple[str, ...]
    items: tuple[ItemLine, ...]
    stages: tuple[StageLine, ...]
    ended: bool
    poll_s: int
    announcement: str
    """Announcement for screen readers on a change, not for every piece."""


def page(told: Track, texts: Catalogue, clock: Clock, now_s: float) -> Page:
    """The page of an order.

    Args:
        told: the customer's view.
        texts: the language.
        clock: writes times in that language.
        now_s: wall clock.
    """
    label, answer, note = _answer(told, texts, clock, now_s)
    reasons = tuple(_reason(reason, told, texts) for reason in told.reasons)
    tag = _tag(told, texts)
    stage = texts.stages[told.stage]
    return Page(
        title=texts.title,
        above=texts.your_order if told.reference is None else texts.order.format(reference=told.reference),
        heading=_heading(told, texts, clock),
        answer_label=label,
        answer=answer,
        note=note,
        tag=tag,
        tag_tone="alarm" if told.late is Late.YES else "warn",
        wanted="" if told.due_at_s is None else texts.wanted_by.format(time=clock.inside(told.due_at_s)),
        reasons=reasons,
        items=tuple(_items(told, texts, clock)),
        stages=tuple(_way(told, texts, clock)),
        ended=told.ended,
        poll_s=POLL_S,
        announcement=". ".join(filter(None, (stage if not told.ended else answer, tag, *reasons))),
    )


def gone(why: NoPage, texts: Catalogue) -> dict[str, str]:
    """The page of a link without an order."""
    return {"heading": texts.gone_title[why], "text": texts.gone_text[why], "help": texts.gone_help[why]}


def entity_tag(*parts: Any) -> str:
    """A weak entity tag (RFC 9110, 8.8.3) of everything on a page."""
    return f'W/"{hashlib.sha256(msgspec.json.encode(parts)).hexdigest()[:32]}"'


def _heading(told: Track, texts: Catalogue, clock: Clock) -> str:
    quantity = clock.number(sum(item.quantity for item in told.items))
    if len(told.items) == 1:
        return texts.one_part.format(quantity=quantity, name=told.items[0].name)
    return texts.parts.format(items=len(told.items), quantity=quantity)


def _answer(told: Track, texts: Catalogue, clock: Clock, now_s: float) -> tuple[str, str, str]:
    """The time: label, answer, and note."""
    if told.status is OrderStatus.CANCELLED:
        return texts.cancelled_at, _written(told.cancelled_at_s, clock)[0], ""
    if told.delivered_at_s is not None:
        return texts.delivered_at, clock.moment(told.delivered_at_s), ""
    if Reason.NOT_RELEASED in told.reasons:
        return texts.expected, texts.not_started, ""
    if told.eta is None:
        return texts.expected, texts.cannot_say, texts.no_range_note
    return texts.expected, clock.range(told.eta, now_s), texts.range_note


def _reason(reason: Reason, told: Track, texts: Catalogue) -> str:
    if reason is Reason.MATERIAL and told.materials:
        return texts.why_material.format(materials=", ".join(told.materials))
    return texts.why[reason]


def _tag(told: Track, texts: Catalogue) -> str:
    match told.late:
        case Late.YES if told.ended:
            return texts.late_delivered
        case Late.YES:
            return texts.late_yes
        case Late.MAYBE:
            return texts.late_maybe
        case Late.NO:
            return ""


def _items(told: Track, texts: Catalogue, clock: Clock) -> list[ItemLine]:
    return [
        ItemLine(
            item.name,
            item.quantity,
            texts.one_part.format(quantity=clock.number(item.quantity), name=item.name),
            item.made,
            _part(texts.of, item.made, item.quantity, clock),
            item.delivered,
            _part(texts.of, item.delivered, item.quantity, clock),
        )
        for item in told.items
    ]


def _way(told: Track, texts: Catalogue, clock: Clock) -> list[StageLine]:
    if told.status is not OrderStatus.CANCELLED:
        return [_stage(told, stage, texts, clock) for stage in told.stages]
    # A cancelled order has no further stages.
    way = [_stage(told, stage, texts, clock) for stage in told.stages if stage.reached]
    time, iso = _written(told.cancelled_at_s, clock)
    return [*way, StageLine(texts.cancelled_at, "stopped", texts.reached, "", time, iso)]


def _stage(told: Track, stage: Stage, texts: Catalogue, clock: Clock) -> StageLine:
    # A delivered order's last stage is done; a cancelled order has no present stage.
    now = stage.name is told.stage and not told.ended
    state, state_text = ("done", texts.reached) if stage.reached else ("next", texts.not_reached)
    if now:
        state, state_text = "now", texts.now
    time, iso = _written(stage.at_s, clock)
    return StageLine(texts.stages[stage.name], state, state_text, _note(told, stage, texts, clock), time, iso)


def _written(at_s: float | None, clock: Clock) -> tuple[str, str]:
    """A time for people and for programs; empty if unknown."""
    return ("", "") if at_s is None else (clock.moment(at_s), clock.iso(at_s))


def _note(told: Track, stage: Stage, texts: Catalogue, clock: Clock) -> str:
    quantity = sum(item.quantity for item in told.items)
    match stage:
        case Stage(name=StageName.IN_PRODUCTION, reached=True):
            return _part(texts.pieces_made, sum(item.made for item in told.items), quantity, clock)
        case Stage(name=StageName.ON_ITS_WAY, reached=True):
            return _part(texts.pieces_delivered, sum(item.delivered for item in told.items), quantity, clock)
        case _:
            return ""


def _part(form: str, part: int, whole: int, clock: Clock) -> str:
    return form.format(part=clock.number(part), all=clock.number(whole))
