"""Alerts of a projection, for tests."""

from __future__ import annotations

from facts_kit import wall_s

from dray.gateway.live.projection import Projection
from dray.gateway.live.views import AlertView


def alerts(projection: Projection, plant_s: float = 2.0) -> list[AlertView]:
    projection.look(wall_s(plant_s))
    return list(projection.alerts.views())


def the_alert(projection: Projection, plant_s: float = 2.0) -> AlertView:
    (alert,) = alerts(projection, plant_s)
    return alert
