"""Alerts: what is wrong, since when, and who has taken it on.

They are made of how things are and not of what has happened, so no alert outlives its cause and none is
missing because a message was lost. Whoever acknowledges one says that it is in good hands; it stays until
its cause is gone. When the same comes back later, it is a new alert that nobody has acknowledged.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal, get_args

import msgspec

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import AlertKind, AlertResponse, AlertView
from dray.gateway.live.views.alert import Condition
from dray.store.factory.acknowledgements import Acknowledgement

RESPONSES: Mapping[AlertKind, tuple[Literal["alarm", "warning"], AlertResponse]] = {
    "plant_behind": ("alarm", "look_at_server"),
    "overloaded": ("warning", "add_vehicles"),
    "part_lost": ("alarm", "look_at_part"),
    "machine_lost": ("alarm", "look_at_machine"),
    "station_lost": ("alarm", "look_at_station"),
    "machine_error": ("alarm", "repair"),
    "machine_shut_out": ("warning", "put_right_and_readmit"),
    "station_shut_out": ("warning", "put_right_and_readmit"),
    "atv_shut_out": ("warning", "put_right_and_readmit"),
    "machine_starved": ("warning", "see_to_supply"),
    "machine_blocked": ("warning", "see_to_removal"),
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
    "jam": ("alarm", "clear_way"),
    "atv_waits": ("warning", "clear_way"),
    "handover_disputed": ("warning", "check_vehicle"),
    "clock_wrong": ("warning", "set_clock"),
    "word_disbelieved": ("warning", "check_vehicle"),
    "strangers": ("warning", "look_at_network"),
    "task_trouble": ("warning", "look_at_auction"),
    "order_impossible": ("warning", "cancel_order"),
    "order_waits": ("warning", "restore_machines"),
    "order_late": ("warning", "tell_customer"),
}
"""How grave each kind is, and what it asks of people."""

ORDER = {kind: place for place, kind in enumerate(get_args(AlertKind))}
"""Graver kinds come first in their level."""

LOOK_S = 1.0
"""Wall seconds between two looks: sooner than anybody could do something about it."""

REMEMBERED_S = 60.0
"""Wall seconds after a start in which all agents have spoken: what is not wrong again by then has ended."""


class Alerts:
    """The alerts of this moment."""

    def __init__(self) -> None:
        self._alerts: dict[str, AlertView] = {}
        self._remembered: dict[str, Acknowledgement] = {}
        """Of an earlier life of the gateway: what was acknowledged and may still be wrong."""
        self._forget_at_s = 0.0
        self.changes = Changes("alert")

    def restore(self, acknowledged: Iterable[Acknowledgement], wall_s: float) -> None:
        """Start from what SQL knows."""
        self._remembered = {each.alert: each for each in acknowledged}
        self._forget_at_s = wall_s + REMEMBERED_S

    def look(self, conditions: Iterable[Condition], wall_s: float) -> list[str]:
        """Compare what is wrong now with what was wrong before.

        Returns:
            The alerts that had been acknowledged and have ended.
        """
        wrong = {condition.alert: condition for condition in conditions}
        for condition in wrong.values():
            self._put(condition, wall_s)
        ended = [alert for alert in self._alerts.values() if alert.id not in wrong]
        for alert in ended:
            del self._alerts[alert.id]
            self.changes.drop(alert.id)
        over = [alert.id for alert in ended if alert.acknowledged_by]
        if self._remembered and wall_s >= self._forget_at_s:
            over += self._remembered
            self._remembered = {}
        return over

    def on_acknowledged(self, acknowledged: Iterable[Acknowledgement]) -> None:
        """Take in what SQL knows: people at other gateways have acknowledged some."""
        for each in acknowledged:
            alert = self._alerts.get(each.alert)
            if alert is not None and is_meant(alert, each):
                self.acknowledge(each)

    def get(self, alert: str) -> AlertView | None:
        """One alert, as long as its cause lasts."""
        return self._alerts.get(alert)

    def acknowledge(self, acknowledgement: Acknowledgement) -> AlertView | None:
        """Somebody has taken an alert on; who was first stays.

        Returns:
            The alert as it is now; None when it has ended.
        """
        alert = self._alerts.get(acknowledgement.alert)
        if alert is None or alert.acknowledged_by:
            return alert
        taken = msgspec.structs.replace(
            alert, acknowledged_by=acknowledgement.by, acknowledged_at_s=acknowledgement.at_s
        )
        self._alerts[alert.id] = taken
        self.changes.mark(alert.id)
        return taken

    def views(self) -> tuple[AlertView, ...]:
        """All of them: alarms first, and graver kinds before others; of one kind the oldest first."""
        return tuple(sorted(self._alerts.values(), key=_rank))

    def take_changed(self) -> tuple[AlertView, ...]:
        """Those that have changed since the last call."""
        return tuple(self._alerts[alert] for alert in self.changes.take_changed())

    def _put(self, condition: Condition, wall_s: float) -> None:
        known = self._alerts.get(condition.alert)
        alert = _view(condition, wall_s)
        if known is not None:
            alert.since_at_s = known.since_at_s
            alert.acknowledged_by, alert.acknowledged_at_s = known.acknowledged_by, known.acknowledged_at_s
            if alert == known:
                return
        elif (remembered := self._remembered.pop(condition.alert, None)) is not None:
            alert.since_at_s = remembered.since_at_s
            alert.acknowledged_by, alert.acknowledged_at_s = remembered.by, remembered.at_s
        self._alerts[alert.id] = alert
        self.changes.mark(alert.id)


def is_meant(alert: AlertView, acknowledgement: Acknowledgement) -> bool:
    """Whether this alert was taken on, and not an earlier one of the same cause.

    At another gateway it may have begun a look earlier.
    """
    return acknowledgement.at_s + LOOK_S > alert.since_at_s


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
