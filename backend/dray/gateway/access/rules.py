"""Rules: what every route requires of its caller. One table; a route without a row is refused.

A new route needs a row. The row of a method that changes something names its `action` in the audit log.
`by_area` opens a route to callers limited to areas: its router then shows and does only what lies inside. All
other rows are for callers of the whole plant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from starlette.routing import compile_path

from dray.gateway.access.principal import Scope


@dataclass(frozen=True, slots=True)
class Rule:
    """The requirements of one route.

    Attributes:
        scope: the required right; None if being recognised is enough.
        by_area: whether callers limited to areas are admitted.
        public: whether everybody is admitted, recognised or not.
        action: its name in the audit log; empty if it changes nothing.
        bulk: whether its body may be a whole file.
    """

    scope: Scope | None = None
    by_area: bool = False
    public: bool = False
    action: str = ""
    bulk: bool = False


PUBLIC = Rule(public=True)

KNOWN = Rule(by_area=True)
"""Any recognised caller."""

RULES: Mapping[tuple[str, str], Rule] = {
    ("GET", "/api/openapi.json"): PUBLIC,
    ("GET", "/api/docs"): PUBLIC,
    ("GET", "/healthz"): PUBLIC,
    ("GET", "/readyz"): PUBLIC,
    ("GET", "/metrics"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/track/{token}"): PUBLIC,
    ("GET", "/api/track/transports/{token}"): PUBLIC,
    ("GET", "/track/{token}"): PUBLIC,
    ("GET", "/call/{token}"): PUBLIC,
    ("GET", "/call/{token}/code.svg"): PUBLIC,
    ("GET", "/call/{token}/sign"): PUBLIC,
    ("POST", "/call/{token}"): Rule(public=True, action="transport.call"),
    ("POST", "/call/{token}/{transport}/cancel"): Rule(public=True, action="transport.cancel"),
    ("GET", "/login"): PUBLIC,
    ("POST", "/login"): Rule(public=True, action="login"),
    ("GET", "/login/station"): KNOWN,
    ("POST", "/login/station"): Rule(by_area=True, action="login.station"),
    ("GET", "/login/{token}"): PUBLIC,
    ("POST", "/login/{token}"): Rule(public=True, action="login"),
    ("POST", "/logout"): Rule(public=True, action="logout"),
    ("GET", "/"): KNOWN,
    ("GET", "/operator"): KNOWN,
    ("GET", "/operator/shell"): PUBLIC,
    ("GET", "/operator/worker.js"): PUBLIC,
    ("GET", "/api/me"): KNOWN,
    ("GET", "/api/people"): Rule(Scope.PEOPLE_WRITE),
    ("POST", "/api/people"): Rule(Scope.PEOPLE_WRITE, action="user.add"),
    ("POST", "/api/people/{person}/link"): Rule(Scope.PEOPLE_WRITE, action="user.link"),
    ("PUT", "/api/people/{person}/secret"): Rule(Scope.PEOPLE_WRITE, action="user.secret"),
    ("PUT", "/api/people/{person}/areas"): Rule(Scope.PEOPLE_WRITE, action="user.move"),
    ("POST", "/api/people/{person}/disable"): Rule(Scope.PEOPLE_WRITE, action="user.disable"),
    ("POST", "/api/people/{person}/enable"): Rule(Scope.PEOPLE_WRITE, action="user.enable"),
    ("GET", "/api/keys"): Rule(Scope.PEOPLE_WRITE),
    ("POST", "/api/keys"): Rule(Scope.PEOPLE_WRITE, action="key.create"),
    ("POST", "/api/keys/{key}/revoke"): Rule(Scope.PEOPLE_WRITE, action="key.revoke"),
    ("GET", "/api/audit"): Rule(Scope.AUDIT_READ),
    ("GET", "/api/stream"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/priorities"): KNOWN,
    ("GET", "/api/plant"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/products"): Rule(Scope.ORDERS_READ),
    ("GET", "/api/products/{product}"): Rule(Scope.ORDERS_READ),
    ("PUT", "/api/products/{product}"): Rule(Scope.FLOOR_WRITE, action="product.define"),
    ("DELETE", "/api/products/{product}"): Rule(Scope.FLOOR_WRITE, action="product.remove"),
    ("POST", "/api/products/remove"): Rule(Scope.FLOOR_WRITE, action="product.remove_several"),
    ("GET", "/api/product-definitions"): Rule(Scope.ORDERS_READ),
    ("POST", "/api/products/import"): Rule(Scope.FLOOR_WRITE, action="product.import", bulk=True),
    ("GET", "/api/inventory"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/storages"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/materials"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/machines"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/machines/{machine}"): Rule(Scope.FACTORY_READ, by_area=True),
    ("POST", "/api/machines/{machine}/commands"): Rule(
        Scope.VEHICLES_COMMAND, by_area=True, action="machine.command"
    ),
    ("POST", "/api/stations/{station}/commands"): Rule(
        Scope.VEHICLES_COMMAND, by_area=True, action="station.command"
    ),
    ("GET", "/api/atvs"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/atvs/{atv}"): Rule(Scope.FACTORY_READ, by_area=True),
    ("POST", "/api/atvs/{atv}/commands"): Rule(Scope.VEHICLES_STOP, by_area=True, action="vehicle.command"),
    ("POST", "/api/atvs/{atv}/carried-away"): Rule(
        Scope.VEHICLES_COMMAND, by_area=True, action="vehicle.carry_away"
    ),
    ("POST", "/api/atvs/{atv}/put-back"): Rule(
        Scope.VEHICLES_COMMAND, by_area=True, action="vehicle.put_back"
    ),
    ("GET", "/api/tasks"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/tasks/history"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/tasks/{task}"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/tasks/{task}/timeline"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/tasks/{task}/load"): Rule(Scope.VEHICLES_COMMAND, by_area=True, action="load.see"),
    ("GET", "/api/alerts"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/alerts/history"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/alerts/{alert}/acknowledge"): Rule(
        Scope.ALERTS_ACKNOWLEDGE, by_area=True, action="alert.acknowledge"
    ),
    ("GET", "/api/duty"): Rule(Scope.VEHICLES_COMMAND, by_area=True),
    ("PUT", "/api/duty"): Rule(Scope.VEHICLES_COMMAND, by_area=True, action="duty.set"),
    ("POST", "/api/calls/{call}/answer"): Rule(Scope.VEHICLES_COMMAND, by_area=True, action="call.answer"),
    ("GET", "/api/agents/{agent}/knowledge"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/agents/shut-out"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/agents/{agent}/shut-out"): Rule(Scope.AGENTS_WRITE, action="agent.shut_out"),
    ("POST", "/api/agents/{agent}/readmit"): Rule(Scope.AGENTS_WRITE, action="agent.readmit"),
    ("GET", "/api/closures"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/closures"): Rule(Scope.FLOOR_WRITE, action="floor.close"),
    ("POST", "/api/closures/preview"): Rule(Scope.FACTORY_READ),
    ("DELETE", "/api/closures/{closure}"): Rule(Scope.FLOOR_WRITE, action="floor.open"),
    ("POST", "/api/areas/{area}/pause"): Rule(Scope.FLOOR_WRITE, action="area.pause"),
    ("POST", "/api/areas/{area}/go-on"): Rule(Scope.FLOOR_WRITE, action="area.go_on"),
    ("GET", "/editor"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/plant-drafts"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/plant-drafts"): Rule(Scope.FLOOR_WRITE, action="draft.begin", bulk=True),
    ("GET", "/api/plant-drafts/running"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/plant-drafts/{draft}"): Rule(Scope.FACTORY_READ),
    ("PUT", "/api/plant-drafts/{draft}"): Rule(Scope.FLOOR_WRITE, action="draft.change", bulk=True),
    ("DELETE", "/api/plant-drafts/{draft}"): Rule(Scope.FLOOR_WRITE, action="draft.remove"),
    ("GET", "/api/plant-drafts/{draft}/file"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/plant-drafts/{draft}/plan"): Rule(Scope.FACTORY_READ),
    ("PUT", "/api/plant-drafts/{draft}/plan"): Rule(Scope.FLOOR_WRITE, action="draft.plan", bulk=True),
    ("GET", "/api/plant-drafts/{draft}/play"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/plant-drafts/{draft}/play"): Rule(Scope.FLOOR_WRITE, action="draft.play"),
    ("GET", "/api/obstacles"): Rule(Scope.FACTORY_READ, by_area=True),
    ("POST", "/api/obstacles/cleared"): Rule(Scope.VEHICLES_COMMAND, by_area=True, action="floor.cleared"),
    ("GET", "/api/waits"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/traffic"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/promises"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/events"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/kept"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/replay"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/replay/film"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/replay/overview"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/spells"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/kpis"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/kpis/history"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/kpis/quality"): Rule(Scope.FACTORY_READ, by_area=True),
    ("GET", "/api/reports/shift"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/reports/targets"): Rule(Scope.FACTORY_READ),
    ("PUT", "/api/reports/targets"): Rule(Scope.FLOOR_WRITE, action="report.targets"),
    ("GET", "/api/orders"): Rule(Scope.ORDERS_READ),
    ("POST", "/api/orders"): Rule(Scope.ORDERS_WRITE, action="order.place"),
    ("POST", "/api/orders/import"): Rule(Scope.ORDERS_WRITE, action="order.import", bulk=True),
    ("POST", "/api/orders/preview"): Rule(Scope.ORDERS_READ),
    ("GET", "/api/orders/{order}"): Rule(Scope.ORDERS_READ),
    ("GET", "/api/orders/{order}/timeline"): Rule(Scope.ORDERS_READ),
    ("POST", "/api/orders/{order}/links"): Rule(Scope.ORDERS_WRITE, action="link.create"),
    ("DELETE", "/api/orders/{order}/links"): Rule(Scope.ORDERS_WRITE, action="link.revoke"),
    ("PATCH", "/api/orders/{order}"): Rule(Scope.ORDERS_WRITE, action="order.change"),
    ("POST", "/api/orders/{order}/release"): Rule(Scope.ORDERS_WRITE, action="order.release"),
    ("POST", "/api/orders/{order}/revoke"): Rule(Scope.ORDERS_WRITE, action="order.revoke"),
    ("POST", "/api/orders/{order}/cancel"): Rule(Scope.ORDERS_WRITE, action="order.cancel"),
    ("GET", "/api/changes"): Rule(Scope.ORDERS_READ),
    ("GET", "/api/transports"): Rule(Scope.TRANSPORTS_CALL, by_area=True),
    ("POST", "/api/transports"): Rule(Scope.TRANSPORTS_CALL, by_area=True, action="transport.call"),
    ("GET", "/api/transports/{transport}"): Rule(Scope.TRANSPORTS_CALL, by_area=True),
    ("GET", "/api/transports/{transport}/timeline"): Rule(Scope.TRANSPORTS_CALL, by_area=True),
    ("POST", "/api/transports/{transport}/cancel"): Rule(
        Scope.TRANSPORTS_CALL, by_area=True, action="transport.cancel"
    ),
    ("POST", "/api/transports/{transport}/links"): Rule(
        Scope.ORDERS_WRITE, by_area=True, action="link.create"
    ),
    ("DELETE", "/api/transports/{transport}/links"): Rule(
        Scope.ORDERS_WRITE, by_area=True, action="link.revoke"
    ),
    ("GET", "/api/schedules"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/schedules"): Rule(Scope.FLOOR_WRITE, action="schedule.add"),
    ("POST", "/api/schedules/preview"): Rule(Scope.FACTORY_READ),
    ("GET", "/api/schedules/{schedule}"): Rule(Scope.FACTORY_READ),
    ("PATCH", "/api/schedules/{schedule}"): Rule(Scope.FLOOR_WRITE, action="schedule.change"),
    ("DELETE", "/api/schedules/{schedule}"): Rule(Scope.FLOOR_WRITE, action="schedule.remove"),
    ("GET", "/api/faults"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/faults"): Rule(Scope.FAULTS_WRITE, action="fault.begin"),
    ("DELETE", "/api/faults/{fault}"): Rule(Scope.FAULTS_WRITE, action="fault.end"),
    ("GET", "/api/scenario"): Rule(Scope.FACTORY_READ),
    ("POST", "/api/scenario/skip"): Rule(Scope.FAULTS_WRITE, action="scenario.skip"),
    ("DELETE", "/api/scenario/skip"): Rule(Scope.FAULTS_WRITE, action="scenario.skip_end"),
}
"""By method and path template, as in the routers. A websocket begins as a GET."""

QUESTIONS = frozenset(
    {("POST", "/api/orders/preview"), ("POST", "/api/closures/preview"), ("POST", "/api/schedules/preview")}
)
"""POST routes that change nothing: their question is too long for an address."""


@dataclass(frozen=True, slots=True)
class Found:
    """The row for a request.

    Attributes:
        rule: the rule.
        template: the path template of the row.
        parameters: values of the template's names in the request.
    """

    rule: Rule
    template: str
    parameters: Mapping[str, str]


def find(method: str, path: str) -> Found | None:
    """The row for a request; None if there is none, and so most likely no route either."""
    method = "GET" if method == "HEAD" else method
    plain = RULES.get((method, path))
    if plain is not None:
        return Found(plain, path, {})
    for wanted, template, pattern in _PATTERNS:
        if wanted == method and (matched := pattern.match(path)):
            return Found(RULES[method, template], template, matched.groupdict())
    return None


_PATTERNS = [(method, template, compile_path(template)[0]) for method, template in RULES if "{" in template]
