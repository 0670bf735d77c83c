"""The factory as a whole, who is shown it, and what is wrong in it by hand."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from dray.gateway.live.views.base import View
from dray.scenario_steps import ScenarioStep


class AudienceView(View, kw_only=True):
    """Who is shown the stream, and how much of it."""

    role: Literal["manager", "operator", ""]
    """Empty for other systems and the administrator."""
    name: str
    areas: tuple[str, ...] | None = None
    """Only what is in these areas is shown; None for the whole plant."""
    station: str = ""
    """The machine at which an operator works."""


class FaultView(View, kw_only=True):
    """A fault that was begun by hand in a simulated factory, and has not ended."""

    id: str
    kind: str
    fault: dict[str, Any]
    """As it was begun: its `kind` and its fields."""
    agents: tuple[str, ...]
    """Whom it is about; empty where it is about the network as a whole."""
    began_at_s: float


class StepView(View, kw_only=True):
    """A step of a scenario."""

    step: ScenarioStep
    after_s: float | None = None
    """Factory seconds after the scenario began; None as long as it has not happened."""
    expected_s: float | None = None
    """The same, by a rehearsal with the same seed and by how late the last step was; None as long as the rehearsal has not come so far."""
    agents: tuple[str, ...] = ()
    """Whom it is about."""


class ScenarioCheckView(View, kw_only=True):
    """One thing that must be so for the claim of a scenario to hold."""

    name: str
    """In English."""
    held: bool
    figure: str
    """What was seen, in English."""


class ScenarioView(View, kw_only=True):
    """The scenario that a simulated factory plays, step by step."""

    id: str
    """As in `dray up --scenario`."""
    shows: str
    """What it shows, in English."""
    steps: tuple[StepView, ...]
    """In the order in which they are expected."""
    state: Literal["playing", "held", "failed"] = "playing"
    """Whether its claim has held, when it has ended."""
    after_s: float | None = None
    """Factory seconds from its begin to its end."""
    checks: tuple[ScenarioCheckView, ...] = ()
    """Why, when it has ended."""
    began_at_s: float = 0.0
    """Wall clock."""
    skipping: bool = False
    """Whether the factory runs as fast as it can, until the next step."""


class UseView(View, kw_only=True):
    """What the fleet's time of the last hour was spent on, in parts that add up to 1."""

    moving: float
    waiting: float
    """At work, and standing: while loading and unloading, or for lack of a way."""
    charging: float
    blocked: float
    """Stopped by a person, or in error."""
    idle: float
    silent: float
    """Not heard for longer than three heartbeats of an idle agent take."""
    out_of_service: float = 0.0
    """By a person's word."""


class FactoryView(View, kw_only=True):
    """The factory as a whole."""

    orders_open: int = 0
    orders_delivered: int = 0
    on_time_frac: float | None = None
    """Of the orders delivered so far; None before the first one."""
    starved_frac: float | None = None
    """Part of the machines' time with a goal in which material was missing, over the last hour."""
    transport_p50_s: float | None = None
    """From announcement to handover, over the last 200 transports, in factory seconds."""
    transport_p95_s: float | None = None
    empty_frac: float | None = None
    """Part of the fleet's way in the last hour of factory time that was driven without a load."""
    use: UseView | None = None
    """None before the first vehicle was heard for a while, as for the two below."""
    atv_available_frac: float | None = None
    """Part of the vehicles' time of the last hour in which they were heard and neither stopped nor in error."""
    machine_available_frac: float | None = None
    """Part of the machines' time of the last hour in which they were heard and not in error."""
    commands: int = 0
    """People's commands that vehicles have obeyed in the last hour."""
    helps: int = 0
    """How often vehicles have asked for help in the last hour."""
    deliveries_per_hour: tuple[float, ...] = ()
    """Transports handed over per factory hour, in the last 12 slots of 5 factory minutes, oldest first."""
    atvs_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    machines_by_status: dict[str, int] = msgspec.field(default_factory=dict)
    speed: float = 1.0
    """Factory seconds per real second."""
    behind_s: float = 0.0
    """How old the newest is that was heard of the plant, in real seconds: who is older than that is silent."""
