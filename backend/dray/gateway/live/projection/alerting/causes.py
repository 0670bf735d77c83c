"""Causes: many troubles with one reason become one alert that names the reason. Pure rules.

A person deals with a cause once. Ten alerts of one cause hide the eleventh, which has another.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from dray.gateway.live.views.alert import Condition
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S

SHARED_BY_LEAST = 2
"""Minimum vehicles that lost the same access point: with one, the vehicle may be at fault."""

SILENT_LEAST = 3
"""Minimum agents that fell silent at once: more than two do not fail together by chance."""

_CALLS = {"call_nobody", "call_unanswered"}
_SILENT = {"machine_lost", "station_lost", "gate_lost", "atv_lost"}
_OF_THE_CALLER = _SILENT | {"machine_error", "atv_error", "atv_help"}


def gathered(wrong: Iterable[Condition], speed: float) -> Iterator[Condition]:
    """The same troubles, with those of one cause joined.

    Args:
        wrong: the present troubles.
        speed: factory seconds per real second.
    """
    left = list(wrong)
    left = _without_late_clocks(left)
    left = _with_their_calls(left)
    left = _by_access_point(left)
    yield from _by_moment(left, IDLE_INTERVAL_S / speed)


def _without_late_clocks(wrong: list[Condition]) -> list[Condition]:
    """Where the plant is behind, all messages are late: drop alerts of clocks that seem slow."""
    if not any(each.kind == "plant_behind" for each in wrong):
        return wrong
    return [each for each in wrong if each.kind != "clock_wrong" or (each.clock_ahead_s or 0) > 0]


def _with_their_calls(wrong: list[Condition]) -> list[Condition]:
    """Join a call in vain with the alert of its caller."""
    calls = {each.agent: each.kind for each in wrong if each.kind in _CALLS}
    told = {each.agent for each in wrong if each.kind in _OF_THE_CALLER}
    return [
        replace(each, call=calls.get(each.agent)) if each.kind in _OF_THE_CALLER else each
        for each in wrong
        if each.kind not in _CALLS or each.agent not in told
    ]


def _by_access_point(wrong: list[Condition]) -> list[Condition]:
    """Join vehicles that lost the same access point."""
    of_point: dict[str, list[Condition]] = defaultdict(list)
    for each in wrong:
        if each.kind == "atv_mesh" and each.access_point:
            of_point[each.access_point].append(each)
    lost = {point: those for point, those in of_point.items() if len(those) >= SHARED_BY_LEAST}
    return [
        *(each for each in wrong if each.kind != "atv_mesh" or each.access_point not in lost),
        *(
            Condition(
                kind="access_point", access_point=point, agents=_names(those), seen_at_s=_first_s(those)
            )
            for point, those in lost.items()
        ),
    ]


def _by_moment(wrong: list[Condition], window_s: float) -> list[Condition]:
    """Join agents last heard within one heartbeat interval (wall seconds): a shared part has failed."""
    silent = sorted((each for each in wrong if each.kind in _SILENT), key=lambda each: each.seen_at_s or 0.0)
    parts: list[list[Condition]] = []
    for each in silent:
        if parts and (each.seen_at_s or 0.0) - _first_s(parts[-1]) <= window_s:
            parts[-1].append(each)
        else:
            parts.append([each])
    lost = [part for part in parts if len(part) >= SILENT_LEAST]
    told = {each.agent for part in lost for each in part}
    return [
        *(each for each in wrong if each.kind not in _SILENT or each.agent not in told),
        *(Condition(kind="part_lost", agents=_names(part), seen_at_s=_first_s(part)) for part in lost),
    ]


def _names(those: list[Condition]) -> tuple[str, ...]:
    return tuple(sorted(each.agent for each in those))


def _first_s(those: list[Condition]) -> float:
    return min(each.seen_at_s or 0.0 for each in those)
