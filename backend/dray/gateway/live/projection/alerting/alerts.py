"""Alerts: what is wrong, since when, and who has taken it on.

Alerts follow from present conditions, not from past events. No alert outlives its cause, and no lost message
hides one. A person who acknowledges an alert takes it on; the alert stays until its cause is gone. An alert
taken on until a set time asks again then, or sooner when it is worse. If the same cause returns later, that
is a new, unacknowledged alert.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Literal, get_args

import msgspec

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import AlertKind, AlertResponse, AlertView
from dray.gateway.live.views.alert import OF_MANY, Condition
from dray.plant.charger_queue import RESERVE_FRAC
from dray.store.factory.alert_history import Acknowledgement

RESPONSES: Mapping[AlertKind, tuple[Literal["alarm", "warning"], AlertResponse]] = {
    "plant_behind": ("alarm", "look_at_server"),
    "no_strategist": ("alarm", "look_at_strategist"),
    "strategist_lost": ("warning", "look_at_strategist"),
    "overloaded": ("warning", "add_vehicles"),
    "part_lost": ("alarm", "look_at_part"),
    "machine_lost": ("alarm", "look_at_machine"),
    "station_lost": ("alarm", "look_at_station"),
    "gate_lost": ("alarm", "look_at_gate"),
    "gate_error": ("alarm", "see_to_gate"),
    "machine_error": ("alarm", "repair"),
    "machine_shut_out": ("warning", "put_right_and_readmit"),
    "station_shut_out": ("warning", "put_right_and_readmit"),
    "atv_shut_out": ("warning", "put_right_and_readmit"),
    "machine_starved": ("warning", "see_to_supply"),
    "machine_document": ("warning", "put_document_right"),
    "machine_blocked": ("warning", "see_to_removal"),
    "dock_fails": ("alarm", "see_to_dock"),
    "dock_not_ready": ("alarm", "see_to_dock"),
    "stock_unknown": ("alarm", "count_stock"),
    "load_doubtful": ("warning", "count_stock"),
    "atv_lost": ("alarm", "find_vehicle"),
    "call_nobody": ("alarm", "send_somebody"),
    "call_unanswered": ("alarm", "send_somebody"),
    "atv_help": ("alarm", "promise_help"),
    "atv_promised": ("warning", "help"),
    "atv_error": ("alarm", "help"),
    "atv_stopped": ("warning", "resume"),
    "atv_battery": ("warning", "bring_to_charger"),
    "atv_mesh": ("warning", "repair_link"),
    "access_point": ("warning", "repair_access_point"),
    "atv_awaited": ("alarm", "switch_on"),
    "atv_unplaced": ("alarm", "see_to_place"),
    "atv_unheard": ("alarm", "shut_out_and_clear"),
    "jam": ("alarm", "clear_way"),
    "atv_waits": ("warning", "clear_way"),
    "handover_disputed": ("warning", "check_vehicle"),
    "clock_wrong": ("warning", "set_clock"),
    "word_disbelieved": ("warning", "check_vehicle"),
    "strangers": ("warning", "look_at_network"),
    "goods_stranded": ("warning", "see_to_goods"),
    "task_trouble": ("warning", "look_at_auction"),
    "order_impossible": ("warning", "cancel_order"),
    "order_waits": ("warning", "restore_machines"),
    "order_late": ("warning", "tell_customer"),
}
"""Level of each kind, and the response that it asks of people."""

ORDER = {kind: place for place, kind in enumerate(get_args(AlertKind))}
"""Rank of each kind in its level: graver kinds come first."""

LOOK_S = 1.0
"""Wall seconds between two looks: shorter than any person's reaction."""

REMEMBERED_S = 60.0
"""Wall seconds after a start, in which all agents have spoken: a trouble not seen again by then has ended."""


ComeBack = Literal["over", "worse"]
"""Reason why an alert that was taken on asks again: its time is over, or it is worse."""


class Alerts:
    """The alerts of this moment."""

    def __init__(self) -> None:
        self._alerts: dict[str, AlertView] = {}
        self._taken: dict[str, Acknowledgement] = {}
        """Acknowledgements of alerts that are taken on."""
        self._remembered: dict[str, Acknowledgement] = {}
        """Acknowledgements from before the gateway's start, whose causes may still last."""
        self._forget_at_s = 0.0
        self.changes = Changes("alert")

    def restore(self, lasting: Iterable[Acknowledgement], wall_s: float) -> None:
        """Restore acknowledgements from SQL."""
        self._remembered = {each.alert: each for each in lasting}
        self._forget_at_s = wall_s + REMEMBERED_S

    def look(self, conditions: Iterable[Condition], wall_s: float) -> list[str]:
        """Compare present troubles with those before.

        Returns:
            The alerts that have ended.
        """
        wrong = {condition.alert: condition for condition in conditions}
        for condition in wrong.values():
            self._put(condition, wall_s)
        over = [alert for alert in self._alerts if alert not in wrong]
        for alert in over:
            del self._alerts[alert]
            self._taken.pop(alert, None)
            self.changes.drop(alert)
        if self._remembered and wall_s >= self._forget_at_s:
            over += self._remembered
            self._remembered = {}
        return over

    def come_back(self, wall_s: float) -> Iterator[tuple[Acknowledgement, ComeBack]]:
        """Let alerts ask again whose time is over or which are worse; yields them with the reason."""
        for taken in list(self._taken.values()):
            if why := why_back(self._alerts[taken.alert], taken, wall_s):
                self._show(msgspec.structs.replace(taken, came_back=why))
                yield taken, why

    def on_acknowledged(self, lasting: Iterable[Acknowledgement]) -> None:
        """Take in acknowledgements from SQL that people made at other gateways."""
        for each in lasting:
            alert = self._alerts.get(each.alert)
            if alert is not None and each.by and is_meant(alert, each):
                self._show(each)

    def get(self, alert: str) -> AlertView | None:
        """One alert, while its cause lasts."""
        return self._alerts.get(alert)

    def acknowledge(self, acknowledgement: Acknowledgement) -> AlertView | None:
        """Take on an alert for a person; the first person to do so keeps it.

        Returns:
            The alert as it is now; None when it has ended.
        """
        alert = self._alerts.get(acknowledgement.alert)
        if alert is None or alert.acknowledged_by not in ("", acknowledgement.by):
            return alert
        return self._show(acknowledgement)

    def views(self) -> tuple[AlertView, ...]:
        """All alerts: alarms first, then graver kinds, then older ones."""
        return tuple(sorted(self._alerts.values(), key=_rank))

    def take_changed(self) -> tuple[AlertView, ...]:
        """Those that have changed since the last call."""
        return tuple(self._alerts[alert] for alert in self.changes.take_changed())

    def _put(self, condition: Condition, wall_s: float) -> None:
        known = self._alerts.get(condition.alert)
        alert = _view(condition, wall_s)
        if known is not None:
            alert.since_at_s = known.since_at_s
            for name in _OF_PEOPLE:
                setattr(alert, name, getattr(known, name))
            if alert == known:
                return
        self._alerts[alert.id] = alert
        self.changes.mark(alert.id)
        if known is None and (remembered := self._remembered.pop(condition.alert, None)) is not None:
            alert.since_at_s = remembered.since_at_s
            self._show(remembered)

    def _show(self, taken: Acknowledgement) -> AlertView:
        known = self._alerts[taken.alert]
        view = msgspec.structs.replace(
            known,
            acknowledged_by=taken.by if taken.is_held else "",
            acknowledged_at_s=taken.at_s if taken.is_held else None,
            acknowledged_until_at_s=taken.until_at_s if taken.is_held else None,
            came_back=taken.came_back or None,
            comment=taken.comment,
            comment_by=taken.comment_by,
        )
        if taken.is_held:
            self._taken[taken.alert] = taken
        else:
            self._taken.pop(taken.alert, None)
        if view != known:
            self._alerts[taken.alert] = view
            self.changes.mark(taken.alert)
        return view


_OF_PEOPLE = (
    *("acknowledged_by", "acknowledged_at_s", "acknowledged_until_at_s"),
    *("came_back", "comment", "comment_by"),
)


def weight_of(alert: AlertView) -> float:
    """The severity of an alert, to compare with its earlier severity.

    It rises when the alert becomes an alarm, or when help was called in vain. It also rises with more
    affected agents, and with each doubling of the measured value.
    """
    weight = 1000.0 * (alert.level == "alarm") + 100.0 * (alert.call is not None)
    if alert.kind in OF_MANY:
        weight += len(alert.agents)
    for measured in (alert.waiting, alert.behind_s, alert.clock_ahead_s):
        weight += int(abs(measured or 0)).bit_length()
    if alert.battery_frac is not None:
        weight += int(RESERVE_FRAC / max(alert.battery_frac, RESERVE_FRAC / 1024)).bit_length()
    return weight


def why_back(alert: AlertView, taken: Acknowledgement, wall_s: float) -> ComeBack | None:
    """Why an alert taken on until a set time asks again.

    None while it does not, or if it was taken on for good.
    """
    if taken.until_at_s is None:
        return None
    if wall_s >= taken.until_at_s:
        return "over"
    return "worse" if weight_of(alert) > taken.weight else None


def is_meant(alert: AlertView, acknowledgement: Acknowledgement) -> bool:
    """Whether the acknowledgement is for this alert, not for an earlier one of the same cause.

    Another gateway may have seen its begin one look earlier.
    """
    return max(acknowledgement.at_s, acknowledgement.since_at_s) + LOOK_S > alert.since_at_s


def _view(condition: Condition, wall_s: float) -> AlertView:
    level, response = RESPONSES[condition.call or condition.kind]
    return AlertView(
        id=condition.alert,
        level=level,
        response=response,
        since_at_s=wall_s,
        **msgspec.structs.asdict(condition),
    )


def _rank(alert: AlertView) -> tuple[bool, int, float, str]:
    return alert.level != "alarm", ORDER[alert.kind], alert.since_at_s, alert.id
